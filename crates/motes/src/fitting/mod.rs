//! Parameters from data.

mod budget;
mod draws;
mod free;
mod likelihood;
mod maximum_fit;
mod options;
mod perturbed;
mod perturbed_model;
mod posterior_fit;
mod record;
mod run;
mod trust;
mod walk;

pub use draws::FitParameters;
pub(crate) use draws::{DRAWS, MAXIMUM, OF_DRAW, OF_MAXIMUM, SUMMARY};
pub use free::FreeParameters;
pub use maximum_fit::{MaximumFit, MaximumParameter, MaximumProfilePoint, SearchProgress, maximise};
pub use options::FitOptions;
pub use posterior_fit::{PosteriorChain, PosteriorFit};
pub use record::FitRecord;
pub(crate) use record::RECORD;
pub use run::{FitProgress, fit, fit_from};
