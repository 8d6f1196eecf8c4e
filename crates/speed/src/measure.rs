//! All measurements, one after the other, and their table.

use motes_cli::Interrupt;

use crate::args::MeasureArgs;
use crate::drive::{Contest, grow};
use crate::error::SpeedError;
use crate::report::Report;
use crate::workloads::Growing;
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
    let (all, growing) = (workloads::all(&scratch)?, workloads::growing(&scratch)?);
    let names: Vec<String> =
        all.iter().map(|workload| workload.name.clone()).chain(growing.iter().map(growth_name)).collect();
    let is_asked = |name: &String| name.contains(&args.only);
    if !names.iter().any(is_asked) {
        return Err(SpeedError::Only { only: args.only.clone(), names: names.join(", ") });
    }
    let mut report = Report::new(args.rounds, peak::measure());
    for workload in all.into_iter().filter(|workload| is_asked(&workload.name)) {
        if interrupt.check().is_break() {
            return Err(SpeedError::Interrupted);
        }
        let contest = Contest { workload, python: python.as_deref(), peers, rounds: args.rounds };
        report.add(contest.run(interrupt)?);
        // What is known is kept, whatever comes after.
        report.write(out)?;
    }
    for growing in growing.into_iter().filter(|growing| is_asked(&growth_name(growing))) {
        report.add_growth(grow(growing, GROWTH_ROUNDS * args.rounds, interrupt)?);
        report.write(out)?;
    }
    Ok(report.table())
}

fn growth_name(growing: &Growing) -> String {
    format!("growth {} {}", growing.method, growing.size)
}
