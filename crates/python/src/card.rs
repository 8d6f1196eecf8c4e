//! The report card of proposals.

use motes::output::{CardReport, card_json, card_report, card_text};
use motes::{Comparison, MotesError};
use pyo3::prelude::*;

use crate::errors::to_python;

/// What came of a comparison.
#[pyclass(frozen, module = "motes._motes")]
pub(crate) struct Card {
    pub(crate) model: String,
    pub(crate) comparison: Comparison,
    pub(crate) options: motes::FilterOptions,
    pub(crate) training_seconds: Option<f64>,
}

#[pymethods]
impl Card {
    /// The tables that the command prints.
    fn text(&self) -> String {
        card_text(&self.comparison, self.options.particles)
    }

    /// The object that the command prints with --json.
    fn json(&self) -> String {
        card_json(&self.comparison, self.training_seconds)
    }

    /// The card as an HTML page that needs nothing else; `call` is what made it.
    fn html(&self, call: &str) -> PyResult<String> {
        let settings = [
            ("model".to_string(), self.model.clone()),
            ("particles".into(), self.options.particles.to_string()),
            ("seed".into(), self.options.seed.to_string()),
        ];
        let page = card_report(&CardReport {
            title: &format!("Proposals of {}", self.model),
            comparison: &self.comparison,
            particles: self.options.particles,
            notes: &[],
            warnings: &[],
            settings: &settings,
            command: call,
        });
        page.map_err(|error| to_python(MotesError::Report(error.to_string())))
    }
}
