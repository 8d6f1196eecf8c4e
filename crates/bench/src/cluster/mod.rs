//! Sweeps as Slurm job arrays on a shared folder.
//!
//! A submission deals the units that are missing to the tasks of an array; each task does its share and leaves a part file for every unit. A
//! job after the array makes tables, figures and verdicts. Nobody trusts the scheduler: what counts is a whole unit on disk, and the same
//! command submits again what has none.

mod deal;
mod error;
mod finish;
mod probe;
mod project;
mod scripts;
mod sign;
mod slurm;
mod status;
mod submission;
mod submit;
mod work;

pub use error::ClusterError;
pub use finish::finish;
pub use project::project;
pub use status::show_status;
pub use submit::{SubmitOutcome, dry_run, submit};
pub use work::work;
