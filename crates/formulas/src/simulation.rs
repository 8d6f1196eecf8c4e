//! Whether measurements can be drawn.

use thiserror::Error;

use crate::error::{Section, in_line};
use crate::model::FormulaModel;
use crate::statement::Line;
use crate::syntax::Node;
use crate::tables::Wrapping;

/// A measurement that is a density and not a way to draw from it.
#[derive(Debug, Clone, PartialEq, Error)]
#[error(
    "{file}{}, {section} {key}: log_density(f) says how likely a measurement is, not how it is drawn; the model filters data and cannot be simulated",
    in_line(*line)
)]
pub struct NoSimulation {
    /// The model file.
    pub file: String,
    /// The line, from 1; none of a text that a program wrote.
    pub line: Option<usize>,
    /// The section, as `[measurement]`.
    pub section: &'static str,
    /// The key.
    pub key: String,
}

impl FormulaModel {
    /// Whether measurements can be drawn: [`Simulator`](motes_models::Simulator) gives NaN where they cannot.
    ///
    /// # Errors
    /// [`NoSimulation`] names the first line that has a log density.
    pub fn can_be_simulated(&self) -> Result<(), NoSimulation> {
        let is_density = |node: &Node| matches!(node, Node::Wrapped(wrapper, _) if wrapper.wrapping == Wrapping::LogDensity);
        let has_density = |line: &&Line| line.formula.nodes.iter().any(is_density);
        match self.statement().measurement.iter().find(has_density) {
            None => Ok(()),
            Some(line) => Err(NoSimulation {
                file: self.file().to_string(),
                line: Some(line.number).filter(|_| self.has_lines()),
                section: Section::Measurement.title(),
                key: line.key.clone(),
            }),
        }
    }
}
