//! All measurements, one after the other, and their table.

use motes_cli::Interrupt;

use crate::args::MeasureArgs;
use crate::drive::{Contest, grow};
use crate::error::SpeedError;
use crate::report::Report;
use crate::{peak, worker, workloads};

/// Rounds of filters of growing size for each of the others: they are short, and exponents ask for more.
const GROWTH_ROUNDS: u64 = 3;

/// Measures and writes `speed.json` and `speed.md`; the table also comes back.
///
/// # Errors
/// [`SpeedError`] if work cannot be prepared, a file cannot be written or a process fails; a peer that fails at one piece of work
/// is reported in its place.
pub(crate) fn measure(args: &MeasureArgs, interrupt: &Interrupt) -> Result<String, SpeedError> {
    let MeasureArgs { out, peer_scripts: peers, .. } = args;
    std::fs::create_dir_all(out).map_err(SpeedError::system(out))?;
    let scratch = out.join("work");
    std::fs::create_dir_all(&scratch).map_err(SpeedError::system(&scratch))?;
    let scratch = scratch.canonicalize().map_err(SpeedError::system(&scratch))?;
    let python = match (&args.python, args.peers) {
        (_, false) => None,
        (Some(python), true) => Some(python.clone()),
        (None, true) => Some(worker::environment(peers, &out.join("python"))?),
    };
    let mut report = Report::new(args.rounds, peak::measure());
    for workload in workloads::all(&scratch)? {
        if interrupt.check().is_break() {
            return Err(SpeedError::Interrupted);
        }
        if !workload.name.contains(&args.only) {
            continue;
        }
        let contest = Contest { workload, python: python.as_deref(), peers, rounds: args.rounds };
        report.add(contest.run(interrupt)?);
        // What is known is kept, whatever comes after.
        report.write(out)?;
    }
    for growing in workloads::growing(&scratch)? {
        if !format!("growth {} {}", growing.method, growing.size).contains(&args.only) {
            continue;
        }
        report.add_growth(grow(growing, GROWTH_ROUNDS * args.rounds, interrupt)?);
        report.write(out)?;
    }
    Ok(report.table())
}
