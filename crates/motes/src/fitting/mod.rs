//! Parameters from data.

mod draws;
mod fitted;
mod free;
mod likelihood;
mod maximised;
mod options;
mod record;
mod run;
mod trust;

pub use draws::FittedDraws;
pub(crate) use draws::{DRAWS, MAXIMUM, OF_DRAW, OF_MAXIMUM, RECORD};
pub use fitted::{Fitted, FittedChain};
pub use free::FreeParameters;
pub use maximised::{Maximised, MaximisedParameter, maximise};
pub use options::FitOptions;
pub use record::FitRecord;
pub use run::{FitProgress, fit, fit_from};
