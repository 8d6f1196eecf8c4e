//! Twisted particle filters: the log-evidence of a whole sequence, by particles that look ahead.
//!
//! A filter knows `y_{0:t}` when it draws `x_t`. Where a state is felt only many times later, as in a chaotic system that is measured in part, nearly all of its
//! particles turn out to be useless. A twisted filter draws from `q_t ∝ N(x_t; m, P) φ_t(x_t)` instead. `N(m, P)` is the Gaussian with the moments of
//! `p(x_t | x_{t−1})`, and `φ_t(x_t)` stands for all that is measured from `t` on. `V_t(x_t) = ∫ N(x_{t+1}; m, P) φ_{t+1}(x_{t+1}) dx_{t+1}`, and 1 at the last time. Its
//! weights are
//!
//! `p(y_t | x_t) V_t(x_t) · p(x_t | x_{t−1}) / (V_{t−1}(x_{t−1}) q_t(x_t | x_{t−1}))`.
//!
//! All `V` cancel, so the evidence of the whole sequence is unbiased whatever `φ` is. With Gaussian transitions and `φ_t(x_t) = p(y_{t:T−1} | x_t)` it would be
//! exact. Where a transition has heavy tails, weights may have no variance.
//!
//! [`Twisting`] learns `log φ_t` as a quadratic, backwards in time, from the particles of a filter before: `log φ_t ≈ log p(y_t | x_t) + log V_t(x_t)` by least
//! squares. Heng, Bishop, Deligiannidis and Doucet, Controlled sequential Monte Carlo, Annals of Statistics 48 (2020); Guarniero, Johansen and Lee, The
//! iterated auxiliary particle filter, Journal of the American Statistical Association 112 (2017).

mod error;
mod filter;
mod fit;
mod learn;
mod model;
mod proposal;
mod quadratic;

pub use error::TwistingError;
pub use learn::Twisting;
