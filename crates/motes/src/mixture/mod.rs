//! States over the posterior of parameters: filters and smoothers at draws of it, mixed.

mod filter;
mod smooth;
mod values;

pub use filter::{PosteriorEstimates, filter_draws};
pub use smooth::smooth_draws;
