//! Many independent particle filters on the same measurements, advanced as one batch.

mod draw;
mod filter_bank;
mod filters;
mod read;
mod scratches;
mod settings;
mod snapshot;
mod step;
mod stored_failure;

pub use filter_bank::FilterBank;
pub use settings::FilterSettings;
pub use snapshot::BankSnapshot;
