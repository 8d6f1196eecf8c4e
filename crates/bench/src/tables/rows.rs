//! Rows of the tables that other tables and programs are made from.

use std::path::Path;

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize, Serializer};

use crate::store::Record;

/// One number of one unit: a row of units.csv and timings.csv.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct MetricRow {
    pub(crate) figure: String,
    pub(crate) panel: String,
    pub(crate) method: String,
    pub(crate) x: usize,
    pub(crate) repetition: usize,
    pub(crate) metric: String,
    #[serde(serialize_with = "exact")]
    pub(crate) value: f64,
}

/// A unit that failed: a row of failures.csv.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct FailureRow {
    pub(crate) figure: String,
    pub(crate) panel: String,
    pub(crate) method: String,
    pub(crate) x: usize,
    pub(crate) repetition: usize,
    pub(crate) reason: String,
}

/// Rows as CSV. `header` names the columns, which would be missing where there is no row.
pub(super) fn csv(header: &[&str], rows: impl IntoIterator<Item = impl Serialize>) -> String {
    let mut writer = csv::WriterBuilder::new().has_headers(false).from_writer(Vec::new());
    let written = writer.write_record(header).and_then(|()| {
        let mut rows = rows.into_iter();
        rows.try_for_each(|row| writer.serialize(row))
    });
    written.expect("writing to memory does not fail");
    let bytes = writer.into_inner().expect("writing to memory does not fail");
    String::from_utf8(bytes).expect("everything written is UTF-8")
}

/// The rows of a file.
///
/// # Errors
/// What is wrong with the file or a row of it.
pub(crate) fn read_rows<Row: DeserializeOwned>(path: &Path) -> Result<Vec<Row>, csv::Error> {
    csv::Reader::from_path(path)?.deserialize().collect()
}

/// A number so that reading it back gives the same number, and small ones stay short.
pub(crate) fn number(value: f64) -> String {
    format!("{value:?}")
}

/// [`number`] for a field.
pub(super) fn exact<S: Serializer>(value: &f64, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_str(&number(*value))
}

/// [`number`] for a field that may be empty.
pub(super) fn exact_or_empty<S: Serializer>(value: &Option<f64>, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_str(&value.map_or(String::new(), number))
}

impl MetricRow {
    /// The row of a record's number.
    pub(super) fn of(figure: &str, record: &Record, metric: &str, value: f64) -> Self {
        let point = &record.point;
        MetricRow {
            figure: figure.into(),
            panel: point.panel.clone(),
            method: point.method.name().into(),
            x: point.x,
            repetition: point.repetition,
            metric: metric.into(),
            value,
        }
    }
}
