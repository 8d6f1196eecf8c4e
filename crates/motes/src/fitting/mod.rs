//! Parameters from data.

mod draws;
mod fitted;
mod free;
mod likelihood;
mod options;
mod record;
mod run;
mod trust;

pub use draws::FittedDraws;
pub(crate) use draws::{DRAWS, OF_DRAW, RECORD};
pub use fitted::{Fitted, FittedChain};
pub use free::FreeParameters;
pub use options::FitOptions;
pub use record::FitRecord;
pub use run::{FitProgress, fit, fit_from};
