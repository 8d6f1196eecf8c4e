//! Models stated once: three formulas, from which draws, densities, gradients and marginals follow.

mod density;
mod distribution;
mod draw;
mod dual;
mod functions;
mod gradients;
mod lanes;
mod linearise;
mod model;
mod moments;
mod quantile;
mod sample;
mod scalar;
mod statement;
mod tiles;
mod transport;
pub mod triangle;
mod varied;

pub use distribution::{
    Distribution, bernoulli, binomial, exponential, gamma, laplace, log_normal, negative_binomial, normal,
    poisson, student_t, uniform,
};
pub use dual::{Dual, Plain};
pub use lanes::Lanes;
pub use linearise::Linearise;
pub use moments::Score;
pub use scalar::Scalar;
pub use statement::{Coordinates, Equations};
pub use tiles::with_scalars;
pub use transport::Transport;
