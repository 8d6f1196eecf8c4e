//! How fast filters and training are: measured alone, or in turns with other libraries on equal work.
//!
//! Every contestant is a process of its own that takes tasks and answers on its pipes ([`serve`] is ours), so that all are
//! driven, timed and weighed alike.

mod drive;
mod equal;
mod folder;
mod peak;
mod report;
mod serve;
mod small;
mod task;
mod worker;
mod workloads;

pub use serve::serve;
pub use small::{SMALL_WORK, count_instructions, small_work};

use std::path::Path;

use thiserror::Error;

use crate::Interrupt;
use crate::config::BenchArgs;
use drive::Contest;
use report::Report;

/// Rounds of filters of growing size for each of the others: they are short, and exponents ask for more.
const GROWTH_ROUNDS: u64 = 3;

/// Why there is no measurement.
#[derive(Debug, Error)]
pub enum SpeedError {
    /// A file or a process could not be had.
    #[error("{what}: {source}")]
    System {
        /// Which one.
        what: String,
        /// What the system says.
        source: std::io::Error,
    },
    /// A process did not do what it was asked for.
    #[error("{who}: {reason}")]
    Worker {
        /// Which one.
        who: String,
        /// What it said.
        reason: String,
    },
    /// Our own work could not be prepared.
    #[error("{0}")]
    Prepare(String),
    /// A signal came.
    #[error("interrupted")]
    Interrupted,
}

impl SpeedError {
    fn system(what: impl AsRef<Path>) -> impl FnOnce(std::io::Error) -> SpeedError {
        move |source| SpeedError::System { what: what.as_ref().display().to_string(), source }
    }
}

/// Measures and writes `speed.json` and `speed.md`; the table also comes back.
///
/// # Errors
/// [`SpeedError`] if work cannot be prepared, a file cannot be written or a process fails; a peer that fails at one piece of work
/// is reported in its place.
pub fn measure(args: &BenchArgs, interrupt: &Interrupt) -> Result<String, SpeedError> {
    let (out, peers) = (args.out(), args.peer_scripts());
    std::fs::create_dir_all(&out).map_err(SpeedError::system(&out))?;
    let scratch = out.join("work");
    std::fs::create_dir_all(&scratch).map_err(SpeedError::system(&scratch))?;
    let scratch = scratch.canonicalize().map_err(SpeedError::system(&scratch))?;
    let python = match (&args.python, args.peers) {
        (_, false) => None,
        (Some(python), true) => Some(python.clone()),
        (None, true) => Some(worker::environment(&peers, &out.join("python"))?),
    };
    let mut report = Report::new(args.rounds, peak::measure());
    for workload in workloads::all(&scratch)? {
        if interrupt.check().is_break() {
            return Err(SpeedError::Interrupted);
        }
        if !workload.name.contains(&args.only) {
            continue;
        }
        let contest = Contest { workload, python: python.as_deref(), peers: &peers, rounds: args.rounds };
        report.add(contest.run(interrupt)?);
        // What is known is kept, whatever comes after.
        report.write(&out)?;
    }
    for growing in workloads::growing(&scratch)? {
        if !format!("growth {} {}", growing.method, growing.size).contains(&args.only) {
            continue;
        }
        report.add_growth(drive::grow(growing, GROWTH_ROUNDS * args.rounds, interrupt)?);
        report.write(&out)?;
    }
    Ok(report.table())
}
