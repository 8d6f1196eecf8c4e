//! Look-ahead filters: the log-evidence of a recorded sequence by particles that know what is measured later.
//!
//! A model is a map of noise, `x_t = g(x_{t−1}, v_t)` with `v_t ~ N(0, I)`. A potential of each step,
//!
//! `ψ_t(x) = exp(−½ (x − r)ᵀ A (x − r) + bᵀ (x − r))`,
//!
//! stands for all that is measured from `t` on. Let `c + J (v − v̂)` be `g(x_{t−1}, ·)` linearised at `v̂_t`, and `ψ̃_t(v; x_{t−1})` the potential of that line, a quadratic of `v`.
//! Noise is drawn from `N(v; 0, I) ψ̃_t(v; x_{t−1}) / Z̃_t(x_{t−1})`, where `Z̃_t(x_{t−1}) = ∫ N(v; 0, I) ψ̃_t(v; x_{t−1}) dv` is a number in closed form, and the weight is
//!
//! `p(y_t | x_t) Z̃_{t+1}(x_t) / ψ̃_t(v_t; x_{t−1})`,
//!
//! with `Z̃_0` beside the first and without `Z̃` after the last. All `Z̃` cancel, so that the evidence of the whole sequence is unbiased whatever the potentials are, and exact
//! where all is linear and Gaussian. The evidence of a part of it is no such thing: it looks ahead.
//!
//! The potentials ([`LookAhead::new`]) come from a linearised smoother: Gauss and Newton's iterations for the most likely noise `v̂`, with the Fisher information of each measurement
//! and a search along each step. Sites `Λ_t = Rᵀ R`, `η_t` of the smoothed path, information and score of `p(y_t | x_t)`, are composed backwards through the linearised steps
//! `x_t ≈ x̂_t + F (x_{t−1} − x̂_{t−1}) + G (v_t − v̂_t)`: with `d = x_t − r_t` at `v_t = 0`, `Λ = I + GᵀAG` and `K = Λ⁻¹GᵀA`,
//!
//! `Z_t(d) ∝ exp(−½ dᵀMd + uᵀd)`, `M = (I − GK)ᵀA(I − GK) + KᵀK`, `u = b − KᵀGᵀb`,
//!
//! and `A_{t−1} = Λ_{t−1} + FᵀMF`. No covariance is inverted, so that coordinates without noise, known starts, gaps and steps of any number of draws need nothing of their own.
//! With these potentials smoothed states are Gaussian, and from the second iteration on sites are averages over them, `E[∂ log p/∂x]` and `−E[∂² log p/∂x²]`, where such states have a density.
//!
//! A potential may also be a sum of quadratics `ψ = Σ_j w_j ψ_j` that came from elsewhere ([`LookAhead::from_potentials`]), as from a network. Then `Z̃ = Σ_j w_j Z̃_j`, and noise is drawn
//! from the mixture of the Gaussians `N(v; 0, I) ψ̃_j / Z̃_j` with shares `w_j Z̃_j / Z̃`.
//!
//! Guarniero, Johansen and Lee, The iterated auxiliary particle filter, Journal of the American Statistical Association 112 (2017); Heng, Bishop, Deligiannidis and Doucet, Controlled
//! sequential Monte Carlo, Annals of Statistics 48 (2020). García-Fernández, Svensson and Särkkä, Iterated posterior linearization smoother, IEEE Transactions on Automatic Control 62
//! (2017).

mod ahead;
mod averages;
mod backward;
mod batch;
mod component;
mod dense;
mod error;
mod local;
mod mixture;
mod one_step;
mod path;
mod potential;
mod proposal;
mod recorded;
mod rollout;
mod runs;
mod scratch;
mod smoother;
mod start;
mod tile;

pub use batch::LookAheadBatch;
pub use component::PotentialComponent;
pub use error::LookAheadError;
pub use one_step::{ByPotential, StepPotentials};
pub use proposal::LookAhead;
pub use recorded::RecordedStep;
pub use scratch::LookAheadScratch;
