//! States over the posterior of parameters: filters and smoothers at draws of it, mixed.

mod draw;
mod filter;
mod smooth;
mod values;

pub(crate) use draw::options_of_draw;
pub use filter::{PosteriorEstimates, filter_draws};
pub use smooth::smooth_draws;
