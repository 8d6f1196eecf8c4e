//! The maximum of a likelihood as a table, as JSON and for a person.

use serde::Serialize;
use serde_json::{Map, Value};

use super::text::digits;
use crate::fitting::{MaximumFit, MaximumProfilePoint, OF_MAXIMUM};
use crate::output::csv::line;
use crate::output::number::text;
use crate::output::table::{Table, markdown};

/// A line for each parameter: `parameter`, `estimate`, `low`, `high`.
pub fn maximum_table(found: &MaximumFit) -> String {
    let rows = found.names.iter().zip(&found.parameters).map(|(name, of)| {
        let ends = [of.low, of.high].map(|end| end.map(text).unwrap_or_default());
        line(&[vec![name.clone(), text(of.estimate)], ends.to_vec()].concat())
    });
    std::iter::once(line(&OF_MAXIMUM.map(String::from))).chain(rows).collect()
}

/// The profiles: a line for each point, `parameter`, `value`, `log_likelihood`, `standard_error`.
pub fn profile_table(found: &MaximumFit) -> String {
    let of_parameter = |(name, points): (&String, &Vec<MaximumProfilePoint>)| {
        let of_point = |point: &MaximumProfilePoint| {
            let figures = [point.value, point.log_likelihood, point.standard_error].map(text);
            line(&[vec![name.clone()], figures.to_vec()].concat())
        };
        points.iter().map(of_point).collect::<String>()
    };
    let header = line(&["parameter", "value", "log_likelihood", "standard_error"].map(String::from));
    header + &found.names.iter().zip(&found.profiles).map(of_parameter).collect::<String>()
}

/// The maximum for a person.
pub fn maximum_text(found: &MaximumFit) -> String {
    markdown(&maximum_figures(found))
}

/// The same as cells.
pub(in crate::output) fn maximum_figures(found: &MaximumFit) -> Table {
    let percent = 100.0 * found.level;
    let mut header =
        vec!["".to_string(), "estimate".into(), format!("{percent:.0} % interval from"), "to".into()];
    // Columns of intervals where there is one.
    if found.parameters.iter().all(|of| of.low.is_none()) {
        header.truncate(2);
    }
    let rows = found.names.iter().zip(&found.parameters).map(|(name, of)| {
        let of_value = |value: Option<f64>| value.map(digits).unwrap_or_default();
        let cells = std::iter::once(name.clone()).chain([Some(of.estimate), of.low, of.high].map(of_value));
        cells.take(header.len()).collect()
    });
    Table { rows: rows.collect(), header }
}

/// The figures of the whole search, a name and a value each.
pub fn maximum_summary(found: &MaximumFit) -> Vec<(String, String)> {
    let error = match found.log_likelihood_error {
        0.0 => ", exact".to_string(),
        error => format!(" ± {error:.3}"),
    };
    let likelihood = match found.proposal.as_str() {
        "exact" => "exact".to_string(),
        proposal => format!("{} particles, {proposal}", found.particles),
    };
    let (searches, agreeing) = (found.search_log_likelihoods.len(), found.agreeing);
    let by =
        found.passes.map_or(String::new(), |passes| format!(" by {passes} passes of iterated filtering"));
    let figures = [
        ("log-likelihood", format!("{:.3}{error}", found.log_likelihood)),
        ("AIC", format!("{:.2}", found.aic())),
        ("searches", format!("{agreeing} of {searches} came as high{by}")),
        ("likelihood", likelihood),
    ];
    figures.map(|(name, value)| (name.to_string(), value)).to_vec()
}

#[derive(Serialize)]
struct MaximumObject<'a> {
    parameters: Map<String, Value>,
    level: f64,
    log_likelihood: f64,
    log_likelihood_error: f64,
    aic: f64,
    searches: usize,
    agreeing: usize,
    search_log_likelihoods: &'a [f64],
    #[serde(skip_serializing_if = "Option::is_none")]
    passes: Option<usize>,
    proposal: &'a str,
    particles: usize,
    warnings: Vec<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    seconds: Option<f64>,
}

/// The object of a maximum: each parameter with its interval, the log-likelihood, how it was found, and how long it took if that is said.
pub fn maximum_json(found: &MaximumFit, seconds: Option<f64>) -> String {
    let of_parameter = |of: &_| serde_json::to_value(of).unwrap_or(Value::Null);
    let object = MaximumObject {
        parameters: found.names.iter().cloned().zip(found.parameters.iter().map(of_parameter)).collect(),
        level: found.level,
        log_likelihood: found.log_likelihood,
        log_likelihood_error: found.log_likelihood_error,
        aic: found.aic(),
        searches: found.search_log_likelihoods.len(),
        agreeing: found.agreeing,
        search_log_likelihoods: &found.search_log_likelihoods,
        passes: found.passes,
        proposal: &found.proposal,
        particles: found.particles,
        warnings: found.warnings.iter().map(ToString::to_string).collect(),
        seconds,
    };
    serde_json::to_string(&object).expect("numbers and texts") + "\n"
}
