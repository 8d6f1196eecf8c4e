//! The report card of proposals.

use motes::output::{CardReport, card_json, card_report, card_text};
use motes::{Comparison, MotesError, pack, unpack};
use pyo3::prelude::*;
use pyo3::types::PyBytes;

use crate::errors::to_python;

/// What errors call its bytes, and the version of these.
const PACKED: (&str, u32) = ("a card", 1);

/// What came of a comparison.
#[pyclass(frozen, module = "motes._motes")]
pub(crate) struct Card(Content);

/// A card is a comparison; a copy of one is what can be read of it.
enum Content {
    Comparison(Box<Compared>),
    Pages { text: String, json: String, html: String },
}

/// A comparison, and what it was made with.
pub(crate) struct Compared {
    pub(crate) model: String,
    pub(crate) comparison: Comparison,
    pub(crate) options: motes::FilterOptions,
    pub(crate) training_seconds: Option<f64>,
}

impl Card {
    pub(crate) fn of(compared: Compared) -> Self {
        Card(Content::Comparison(Box::new(compared)))
    }
}

#[pymethods]
impl Card {
    /// That of which `__getnewargs__` gives the bytes: for pickles and copies.
    #[new]
    fn new(bytes: &[u8]) -> PyResult<Self> {
        let (text, json, html) = unpack(PACKED.0, PACKED.1, bytes).map_err(to_python)?;
        Ok(Card(Content::Pages { text, json, html }))
    }

    fn __getnewargs__<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyBytes>,)> {
        let pages = (self.text(), self.json(), self.html()?);
        let bytes = pack(PACKED.0, PACKED.1, &pages).map_err(to_python)?;
        Ok((PyBytes::new(py, &bytes),))
    }

    /// The tables that the command prints.
    fn text(&self) -> String {
        match &self.0 {
            Content::Comparison(card) => card_text(&card.comparison, card.options.particles),
            Content::Pages { text, .. } => text.clone(),
        }
    }

    /// The object that the command prints with --json.
    fn json(&self) -> String {
        match &self.0 {
            Content::Comparison(card) => card_json(&card.comparison, card.training_seconds),
            Content::Pages { json, .. } => json.clone(),
        }
    }

    /// The card as an HTML page that needs nothing else.
    fn html(&self) -> PyResult<String> {
        match &self.0 {
            Content::Comparison(card) => card.html().map_err(to_python),
            Content::Pages { html, .. } => Ok(html.clone()),
        }
    }
}

impl Compared {
    fn html(&self) -> Result<String, MotesError> {
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
            command: "Card.to_html()",
        });
        page.map_err(|error| MotesError::Report(error.to_string()))
    }
}
