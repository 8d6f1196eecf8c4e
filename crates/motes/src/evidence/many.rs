//! The log-evidence of data at many values of parameters.

use std::ops::ControlFlow;

use motes_inference::map_on_threads;

use super::log_evidence::log_evidence;
use crate::data::Data;
use crate::error::MotesError;
use crate::model::Model;
use crate::options::FilterOptions;

/// The estimate of `log p(y | θ)` at each of many `θ`, on all threads: `values` has a row (`D`) for each of them, `names` say which parameters these are, and others stay as
/// they are in the model. Each is that of [`log_evidence`] of the model with these parameters and the same options, to the last bit: all have the same random numbers.
///
/// It is −∞ where no particle explains a measurement, and where the model is none: a negative variance gives no data.
///
/// ```
/// use motes::{Data, FilterOptions, Model, log_evidence_at};
/// use std::ops::ControlFlow;
///
/// let text = "[parameters]\nsd = 1\n[initial]\nx = \"normal(0, 1)\"\n[transition]\nx = \"normal(x, sd)\"\n[measurement]\ny = \"normal(x, 1)\"\n";
/// let model = Model::parse(text, "walk", &[])?;
/// let data = Data::read("y\n0\n3\n".as_bytes(), "y.csv", &model)?;
/// let options = FilterOptions::default();
/// let found = log_evidence_at(&model, &data, &options, &["sd".into()], &[0.1, 3.0, -1.0], &|| ControlFlow::Continue(()))?;
/// assert!(found[0] < found[1] && found[2] == f64::NEG_INFINITY);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`MotesError::Setting`] if there is no such parameter, or values make no rows of `D`; as [`log_evidence`].
pub fn log_evidence_at(
    model: &Model,
    data: &Data,
    options: &FilterOptions,
    names: &[String],
    values: &[f64],
    proceed: &(dyn Fn() -> ControlFlow<()> + Sync),
) -> Result<Vec<f64>, MotesError> {
    let there: Vec<&str> = model.parameters().iter().map(|(name, _)| name.as_str()).collect();
    if let Some(unknown) = names.iter().find(|name| !there.contains(&name.as_str())) {
        let reason = match there.is_empty() {
            true => format!("{} has none", model.name()),
            false => format!("there are {}", there.join(", ")),
        };
        return Err(MotesError::Setting(format!("parameters: there is no {unknown}; {reason}")));
    }
    if names.is_empty() || !values.len().is_multiple_of(names.len()) {
        let reason = format!("{} values for {} parameters are no rows", values.len(), names.len());
        return Err(MotesError::Setting(format!("parameters: {reason}")));
    }
    let rows: Vec<&[f64]> = values.chunks(names.len()).collect();
    let found = map_on_threads(&rows, |_, row| {
        let named: Vec<(String, f64)> = names.iter().cloned().zip(row.iter().copied()).collect();
        match model.with_parameters(&named) {
            Ok(model) => log_evidence(&model, data, options, |_| proceed()).map(|found| found.value),
            Err(_) => Ok(f64::NEG_INFINITY),
        }
    });
    found.into_iter().collect()
}
