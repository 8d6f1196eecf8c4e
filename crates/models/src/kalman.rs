//! The Kalman filter and smoother: exact means, covariances and log-evidence of a model that is linear with Gaussian noise.

mod belief;
mod correction;
mod filter;
mod smoother;
mod system;

pub use belief::Belief;
pub use correction::{Correction, correction};
pub use filter::{Filtered, KalmanFilter, KalmanStep, filter, filter_partial};
pub use smoother::{Smoothed, smooth};
pub use system::{LinearMap, LinearSystem};
