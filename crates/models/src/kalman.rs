//! The Kalman filter and smoother: exact means, covariances and log-evidence of a linear Gaussian model.

mod belief;
mod correction;
mod filter;
mod smoother;

pub use belief::Belief;
pub use correction::{Correction, correction};
pub use filter::{Filtered, KalmanFilter, KalmanStep, filter, filter_partial};
pub use smoother::{Smoothed, smooth};
