//! Resampling: which particles survive, how often each, and when it happens at all.

mod descent;
mod memory;
mod ranks;
mod schemes;
mod when;

pub use memory::ParticleMemory;
pub use schemes::Resampling;
pub use when::ResampleWhen;
