//! Resampling: which particles survive, how often each, and when it happens at all.

mod descent;
mod ranks;
mod schemes;
mod when;

pub use schemes::Resampling;
pub use when::ResampleWhen;
