//! Models stated once: three formulas, from which draws, densities, gradients and marginals follow.

mod advance;
mod batched;
mod check;
mod density;
mod distribution;
mod draw;
mod dual;
mod functions;
mod gradients;
mod lanes;
mod lift;
mod linearise;
mod model;
mod moments;
mod noise_space;
mod quantile;
mod sample;
mod scalar;
mod statement;
mod tile_states;
mod tiles;
mod transport;
pub mod triangle;
mod varied;

pub use batched::{BatchDistribution, BatchEquations, Batched, Column};
pub use distribution::{
    Distribution, bernoulli, binomial, exponential, gamma, laplace, log_normal, negative_binomial, normal,
    poisson, student_t, uniform,
};
pub use dual::{Dual, Plain};
pub use lanes::Lanes;
pub use linearise::Linearise;
pub(crate) use linearise::moments_of_states;
pub use moments::Score;
pub use noise_space::{Draw, Guide, NoiseSpace};
pub use scalar::Scalar;
pub use statement::{Coordinates, Draws, Equations};
pub(crate) use tile_states::TileStates;
pub use tiles::with_scalars;
pub(crate) use tiles::{rows_of, rows_of_mut};
pub use transport::Transport;
