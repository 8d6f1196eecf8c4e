//! Measurements that no state can give.

use thiserror::Error;

use crate::model::FormulaModel;
use crate::statement::Line;
use crate::support::{Digits, Support};
use motes_models::Step;

/// An entry of a measurement that lies outside of the support of its distribution, whatever the states are.
#[derive(Debug, Clone, PartialEq, Error)]
#[error("{} is no value of {distribution}: {support}", Digits(*value))]
pub struct Impossible {
    /// Which entry of the measurement it is, from 0.
    pub coordinate: usize,
    /// Its value.
    pub value: f64,
    /// Its distribution, as the file states it.
    pub distribution: String,
    /// What it could be.
    pub support: Support,
}

/// Distributions that are written with more letters are called by the beginning of it.
const LONGEST: usize = 60;

impl FormulaModel {
    /// The first entry of a measurement (`M`, none where one is missing) that no state can give in a step; none where there may be a state for each.
    pub fn impossible(&self, step: &Step<'_>, measurement: &[Option<f64>]) -> Option<Impossible> {
        let supports = self.supports(step);
        supports.iter().zip(measurement).enumerate().find_map(|(coordinate, (support, value))| {
            let (support, value) = ((*support)?, (*value)?);
            let distribution = || self.distribution(coordinate);
            (!support.has(value)).then(|| Impossible {
                coordinate,
                value,
                distribution: distribution(),
                support,
            })
        })
    }

    /// What the file says of an entry of the measurement, in one line.
    fn distribution(&self, coordinate: usize) -> String {
        let mut lines =
            self.statement().measurement.iter().flat_map(|line| (0..line.coordinates()).map(move |_| line));
        let of_line = |line: &Line| {
            let words: Vec<&str> = line.formula.text.split_whitespace().collect();
            words.join(" ")
        };
        let text = lines.nth(coordinate).map(of_line).unwrap_or_default();
        match text.char_indices().nth(LONGEST) {
            Some((end, _)) => format!("{}…", &text[..end]),
            None => text,
        }
    }
}
