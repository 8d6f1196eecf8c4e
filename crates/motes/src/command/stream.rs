//! `motes filter MODEL -`: on-line, an answer to each line as it comes.

use std::fs::{File, OpenOptions};
use std::io::{ErrorKind, Write};

use motes::output::{EstimateTable, Output, filter_json};
use motes::smc::WeightReport;
use motes::{Estimate, FilterOptions, Filtered, Model, MotesError, Rows, Running, Warning};

use super::args::FilterArgs;
use super::say::{say_ignored, warn, write};

/// Filters what comes on standard input until it ends; the exit status.
pub(super) fn run(args: &FilterArgs, model: &Model, options: &FilterOptions) -> Result<u8, MotesError> {
    let start = std::time::Instant::now();
    let mut rows = Rows::new(std::io::stdin(), "standard input", model)?;
    say_ignored(rows.columns(), args.model.quiet);
    let table = EstimateTable::new(model, rows.columns(), true);
    let mut lines = args.output.table().map(Lines::to).transpose()?;
    let mut is_read = say(&mut lines, &table.header())?;
    let mut filters: Vec<(String, Running<'_>, WeightReport, usize)> = Vec::new();
    let (mut weights, mut least_ess, mut last) = (WeightReport::default(), f64::INFINITY, 0);
    while is_read {
        let Some(row) = rows.next_row()? else { break };
        if row.series == filters.len() {
            let name = rows.series().last().unwrap_or_default().to_string();
            filters.push((name, Running::new(model, options, row.series)?, WeightReport::default(), 0));
        }
        let (name, running, report, length) = &mut filters[row.series];
        let estimate = running.step(&row.measurement).map_err(|error| at_line(row.line, error))?;
        report.add(&running.diagnosis());
        weights.add(&running.diagnosis());
        least_ess = estimate.ess.map_or(least_ess, |ess| least_ess.min(ess));
        *length = row.time + 1;
        last = last.max(row.series + 1);
        is_read = say(&mut lines, &table.row(name, row.label.as_deref(), row.time, &estimate))?;
    }
    if !is_read {
        return Ok(0);
    }
    if last == 0 {
        return Err(motes::DataError::Empty { file: "standard input".into() }.into());
    }
    let (mut warnings, mut evidence) = (Vec::new(), Vec::new());
    let has_series = rows.columns().has_series();
    for (name, running, report, length) in &mut filters {
        evidence.push(running.log_evidence());
        let series = has_series.then(|| name.clone());
        warnings.extend(
            report.warnings().map(|warning| Warning { series: series.clone(), text: warning.to_string() }),
        );
        for ahead in 0..options.forecast {
            let estimate: Estimate = running.predict()?;
            is_read = is_read && say(&mut lines, &table.row(name, None, *length + ahead, &estimate))?;
        }
    }
    if args.output.json {
        let filtered = Filtered {
            estimates: vec![],
            forecasts: vec![],
            log_evidence_per_series: evidence,
            weights,
            least_ess,
            warnings: warnings.clone(),
        };
        write(&Output::Standard, &filter_json(&filtered, options, start.elapsed().as_secs_f64()))?;
    }
    Ok(warn(&warnings, args.model.quiet, args.output.strict))
}

fn at_line(line: u64, error: MotesError) -> MotesError {
    match error {
        MotesError::Filter { place, reason } => {
            MotesError::Filter { place: format!("line {line}, {place}"), reason }
        }
        error => error,
    }
}

/// Where lines go as they are made.
enum Lines {
    Standard,
    File(File, String),
}

impl Lines {
    fn to(output: Output) -> Result<Lines, MotesError> {
        match output {
            Output::Standard => Ok(Lines::Standard),
            Output::File(path) => {
                let name = path.display().to_string();
                let opened = OpenOptions::new().write(true).create(true).truncate(true).open(&path);
                match opened {
                    Ok(file) => Ok(Lines::File(file, name)),
                    Err(source) => Err(MotesError::Output { file: name, source }),
                }
            }
        }
    }
}

/// Writes a line at once; whether anybody still reads.
fn say(lines: &mut Option<Lines>, line: &str) -> Result<bool, MotesError> {
    let (written, file) = match lines {
        None => return Ok(true),
        Some(Lines::Standard) => {
            let mut standard = std::io::stdout().lock();
            let written = standard.write_all(line.as_bytes()).and_then(|()| standard.flush());
            (written, "standard output".to_string())
        }
        Some(Lines::File(file, name)) => (file.write_all(line.as_bytes()), name.clone()),
    };
    match written {
        Ok(()) => Ok(true),
        Err(error) if error.kind() == ErrorKind::BrokenPipe => Ok(false),
        Err(source) => Err(MotesError::Output { file, source }),
    }
}
