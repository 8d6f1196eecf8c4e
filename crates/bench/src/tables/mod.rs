//! From finished units to tables: every number in long form, medians with deviations, and Markdown to paste.

mod markdown;
mod redrawn;
mod series;
mod summary;
mod units;

pub(crate) use markdown::markdown;
pub(crate) use redrawn::redrawn;
pub(crate) use series::series_csv;
pub(crate) use summary::{Row, summarise, summary_csv};
pub(crate) use units::{failures_csv, timings_csv, units_csv};

use crate::config::Plan;
use crate::store::Record;

/// A number so that reading it back gives the same number, and small ones stay short.
pub(crate) fn number(value: f64) -> String {
    format!("{value:?}")
}

/// Sorts records as tables show them: by panel and method in the experiment's order, then x, then repetition.
pub(crate) fn sort(plan: &Plan, records: &mut [Record]) {
    let experiment = &plan.experiment;
    records.sort_by_key(|record| {
        let point = &record.point;
        let panel = experiment.panels.iter().position(|panel| panel.name == point.panel);
        let method = experiment.methods.iter().position(|method| *method == point.method);
        (panel, method, point.x, point.repetition)
    });
}

/// Rows of text as CSV.
fn csv<const COLUMNS: usize>(
    header: [&str; COLUMNS],
    rows: impl Iterator<Item = [String; COLUMNS]>,
) -> String {
    let mut writer = csv::Writer::from_writer(Vec::new());
    let written = writer.write_record(header).and_then(|()| {
        let mut rows = rows;
        rows.try_for_each(|row| writer.write_record(&row))
    });
    written.expect("writing to memory does not fail");
    let bytes = writer.into_inner().expect("writing to memory does not fail");
    String::from_utf8(bytes).expect("everything written is UTF-8")
}
