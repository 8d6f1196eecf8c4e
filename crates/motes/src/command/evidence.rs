//! `motes evidence`.

use std::time::Instant;

use motes::output::{Output, evidence_json, evidence_table, plus_minus};
use motes::{Evidence, MotesError, evidence, of_starts, on_threads};
use motes_cli::{Interrupt, status};

use super::evidence_args::EvidenceArgs;
use super::failure::Failure;
use super::input;
use super::say::{say_ignored, warn, write};

pub(super) fn run(args: &EvidenceArgs, interrupt: &Interrupt) -> Result<u8, Failure> {
    let model = args.model.read_beside(Some(&args.data))?;
    let output = match (&args.output, args.json) {
        (Some(path), _) => Some(Output::File(path.clone())),
        (None, false) => Some(Output::Standard),
        (None, true) => None,
    };
    if let Some(output) = &output {
        output.check().map_err(|source| MotesError::Output { file: output.name(), source })?;
    }
    let options = args.options(&model)?;
    let data = input::data(&args.data, &model, interrupt)?;
    say_ignored(&data.columns, args.model.quiet);
    let start = Instant::now();
    let found = on_threads(args.model.threads, || evidence(&model, &data, &options, || interrupt.check()))??;
    let seconds = start.elapsed().as_secs_f64();
    if let Some(output) = &output {
        write(output, &evidence_table(&data, &found))?;
    }
    if args.json {
        write(&Output::Standard, &evidence_json(&found, seconds))?;
    }
    if !args.model.quiet {
        status(&format!("motes: {}", in_one_line(&found, args.chooses())));
    }
    let warnings: Vec<_> =
        of_starts(&model).into_iter().chain(data.warnings()).chain(found.warnings()).collect();
    Ok(warn(&warnings, args.model.quiet, args.strict))
}

/// The evidence, and what it was found by.
fn in_one_line(found: &Evidence, is_chosen: bool) -> String {
    let error = match (found.is_exact(), found.standard_error()) {
        (true, _) => ", exact".to_string(),
        (false, Some(error)) => plus_minus(error),
        (false, None) => String::new(),
    };
    let runs = if found.is_exact() { String::new() } else { format!(", {} runs", found.runs.len()) };
    let choice = match (is_chosen, found.pilots.len() > 1) {
        (true, true) => {
            let pilots = found.pilots.iter().map(|pilot| match pilot.log_evidence.abs() < 1e6 {
                true => format!("{} {:.2}", pilot.proposal, pilot.log_evidence),
                false => format!("{} {:.1e}", pilot.proposal, pilot.log_evidence),
            });
            let missed = found.missed.iter().map(|missed| {
                let series = missed.series.as_ref().map_or(String::new(), |name| format!("series {name}: "));
                format!("; {series}{} missed {:.1}", missed.by, missed.nats)
            });
            format!(" (of pilots: {}{})", pilots.collect::<Vec<_>>().join(", "), missed.collect::<String>())
        }
        _ => String::new(),
    };
    format!(
        "log-evidence {:.3}{error}{runs}, proposal {}{choice}",
        found.log_evidence(),
        found.proposal_names()
    )
}
