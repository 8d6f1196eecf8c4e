//! Trained proposals on disk: weights as safetensors, and beside them a description that people can read.
//!
//! A saved proposal is a folder with `proposal.toml` and `weights.safetensors`. The description says which family it is, its
//! settings and sizes, how it was trained, and for which system. Its first line is a hash of all the rest, weights included:
//! [`load`] refuses what was damaged or changed, and what does not fit the call. Potentials that were learned beside it lie there as `potentials.toml` and `potentials.safetensors`.

mod description;
mod error;
mod files;
mod fingerprint;
mod load;
mod save;
mod seal;
mod weights;

pub use description::SAVED_FORMAT;
pub use error::SavedError;
pub use files::SavedFiles;
pub use fingerprint::{Fingerprint, OtherSystem};
pub use load::{holds, load, load_to_tune, notes};
pub use save::{save, save_both};
