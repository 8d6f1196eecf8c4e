//! The log-evidence of data as a table and as a JSON object.

use serde::Serialize;

use super::csv::line;
use super::number::text;
use crate::data::Data;
use crate::evidence::Evidence;

#[derive(Serialize)]
struct EvidenceObject<'a> {
    log_evidence: f64,
    standard_error: Option<f64>,
    log_evidence_per_series: &'a [f64],
    standard_error_per_series: &'a [Option<f64>],
    variance_per_run: Option<f64>,
    proposal: String,
    seconds: f64,
}

/// The object of an estimate, and how long it took.
pub fn evidence_json(evidence: &Evidence, seconds: f64) -> String {
    let object = EvidenceObject {
        log_evidence: evidence.log_evidence(),
        standard_error: evidence.standard_error(),
        log_evidence_per_series: &evidence.log_evidence_per_series,
        standard_error_per_series: &evidence.standard_error_per_series,
        variance_per_run: evidence.variance_per_run(),
        proposal: evidence.proposal_names(),
        seconds,
    };
    serde_json::to_string(&object).expect("numbers and texts") + "\n"
}

/// A row for each series: its name, if the data have them, how many rows it has, and its log-evidence with the standard error, which is empty where there is none.
pub fn evidence_table(data: &Data, evidence: &Evidence) -> String {
    let column = data.columns.series().map(String::from);
    let with_name = |name: Option<String>, cells: [String; 3]| -> String {
        line(&name.into_iter().chain(cells).collect::<Vec<String>>())
    };
    let mut table = with_name(column.clone(), ["rows", "log_evidence", "standard_error"].map(String::from));
    let of_series = evidence.log_evidence_per_series.iter().zip(&evidence.standard_error_per_series);
    for (series, (log_evidence, error)) in of_series.enumerate() {
        let rows = data.of_series(series).count().to_string();
        let cells = [rows, text(*log_evidence), error.map(text).unwrap_or_default()];
        table += &with_name(column.as_ref().map(|_| data.series[series].clone()), cells);
    }
    table
}
