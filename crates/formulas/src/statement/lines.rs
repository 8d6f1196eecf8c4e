//! The formulas of a section.

use std::cell::RefCell;
use std::collections::BTreeMap;

use super::keys::Key;
use crate::document::Found;
use crate::error::{Fault, Place, Problem, Section};
use crate::syntax::{Formula, Meaning, Scope, Totals, parse};

/// The formula of a coordinate, of all coordinates of a vector, or of a definition.
#[derive(Debug, Clone)]
pub(crate) struct Line {
    pub(crate) name: String,
    /// The key as it is written: `x`, or `x[40]`.
    pub(crate) key: String,
    /// The length of a vector, or of the part of it that the line is about.
    pub(crate) length: Option<usize>,
    /// The index of the first coordinate.
    pub(crate) first: usize,
    /// The names of the arguments of a function; none of what is no function.
    pub(crate) arguments: Vec<String>,
    pub(crate) formula: Formula,
    /// The line of the file, from 1.
    pub(crate) number: usize,
    /// The byte of the file where the formula begins; where it is not written letter by letter, that of its value.
    pub(crate) at: usize,
    /// Whether the formula stands at `at` letter by letter.
    pub(crate) is_literal: bool,
}

impl Line {
    /// How many coordinates it has.
    pub(crate) fn coordinates(&self) -> usize {
        self.length.unwrap_or(1)
    }

    /// The name of a coordinate: `x`, or `x[3]`.
    pub(crate) fn coordinate(&self, number: usize) -> String {
        match self.length {
            Some(_) => format!("{}[{}]", self.name, self.first + number),
            None if !self.arguments.is_empty() => self.key.clone(),
            None => self.name.clone(),
        }
    }

    /// A problem at a byte of the formula.
    pub(crate) fn fault(&self, section: Section, byte: usize, problem: Problem) -> Fault {
        let at = if self.is_literal { self.at + byte } else { self.at };
        Fault::at(at, problem).in_section(section).of_key(&self.key)
    }
}

/// Reads formulas with these names.
pub(super) struct Reader<'a> {
    pub(super) text: &'a str,
    pub(super) names: &'a BTreeMap<String, Meaning>,
    /// Where measurements keep what they use of the sub-steps.
    pub(super) totals: Option<&'a RefCell<Totals>>,
}

impl Reader<'_> {
    /// The formulas of a section.
    pub(super) fn lines(&self, keys: &[Key<'_>], section: Section) -> Result<Vec<Line>, Fault> {
        let mut before = 0;
        let line = |key: &Key<'_>| {
            let line = self.line(key, section, before);
            before += key.coordinates();
            line
        };
        keys.iter().map(line).collect()
    }

    /// A line of a section, of whose coordinates so many come before it.
    fn line(&self, key: &Key<'_>, section: Section, before: usize) -> Result<Line, Fault> {
        let (text, inner) = match (&key.value.found, section) {
            (Found::Text { text, inner }, _) => (text, *inner),
            // A number needs no quotes.
            (Found::Number(_, written), section) if section != Section::Measurement => {
                (written, Some(key.value.at))
            }
            _ => return Err(self.no_formula(key, section)),
        };
        let totals = self.totals.map(|totals| (before, totals));
        let is_vector = key.length.is_some() && !key.has_parts;
        let (names, own, arguments) = (self.names, key.name.as_str(), key.arguments.as_slice());
        let is_of_several = is_vector && key.coordinates() > 1;
        let scope = Scope { names, section, own, is_vector, is_of_several, totals, arguments };
        let parsed = parse(text, scope).and_then(|formula| check_noise(formula, section));
        let formula = parsed.map_err(|fault| {
            let at = match (inner, fault.at) {
                (Some(inner), Some(byte)) => inner + byte,
                _ => key.value.at,
            };
            Fault { at: Some(at), ..fault }.in_section(section).of_key(key.written)
        })?;
        let at = inner.unwrap_or(key.value.at);
        Ok(Line {
            name: key.name.clone(),
            key: key.written.to_string(),
            length: key.length,
            first: key.part.unwrap_or(0),
            arguments: key.arguments.clone(),
            formula,
            number: Place::line_and_column(self.text, at)[0],
            at,
            is_literal: inner.is_some(),
        })
    }

    fn no_formula(&self, key: &Key<'_>, section: Section) -> Fault {
        let value = key.value;
        let expected = match (&value.found, section) {
            (Found::Number(_, written), _) => {
                format!("a distribution in quotes, as in \"normal({written}, 1)\"")
            }
            _ => "a formula in quotes".to_string(),
        };
        let problem = Problem::Value { found: value.words(), expected };
        Fault::at(value.at, problem).in_section(section).of_key(key.written)
    }
}

/// A measurement has a distribution.
fn check_noise(formula: Formula, section: Section) -> Result<Formula, Fault> {
    if section != Section::Measurement || formula.has_noise() {
        return Ok(formula);
    }
    let example = format!("normal({}, 0.01)", formula.text.trim());
    Err(Fault::at(0, Problem::NoNoise { example }))
}
