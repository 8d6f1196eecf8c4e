//! The numbers that formulas know by name.

use std::collections::BTreeMap;

use crate::document::{Found, Table, Value};
use crate::error::{Fault, Problem, Section, nearest};
use crate::names::is_name;
use crate::syntax::Meaning;
use crate::tables::reserved;

/// The parameters of a file.
#[derive(Debug)]
pub(super) struct Parameters {
    /// Numbers, and the entries of lists: `a`, `b[0]`, `c[0,1]`.
    pub(super) values: Vec<(String, f64)>,
    pub(super) lists: Vec<List>,
}

/// A parameter that is a list of numbers, or of lists of the same length.
#[derive(Debug, Clone)]
pub(crate) struct List {
    pub(crate) name: String,
    /// Where its entries stand among all parameters.
    start: usize,
    /// How many entries there are along each index.
    pub(crate) lengths: Vec<usize>,
    /// The last index varies first.
    pub(crate) values: Vec<f64>,
}

impl List {
    /// The entry with these indices, if there is one.
    pub(crate) fn entry(&self, indices: &[f64]) -> Option<f64> {
        let mut at = 0;
        for (index, length) in indices.iter().zip(&self.lengths) {
            if index.fract() != 0.0 || !(0.0..*length as f64).contains(index) {
                return None;
            }
            at = at * length + *index as usize;
        }
        self.values.get(at).copied()
    }

    /// The names of the entries: `a[0]`, `a[0,1]`.
    fn names(&self) -> impl Iterator<Item = String> {
        (0..self.values.len()).map(|at| {
            let (mut rest, mut indices) = (at, Vec::new());
            for length in self.lengths.iter().rev() {
                indices.push((rest % length).to_string());
                rest /= length;
            }
            indices.reverse();
            format!("{}[{}]", self.name, indices.join(","))
        })
    }

    /// Reads a list, all of whose lists have the same length.
    fn read(name: &str, value: &Value, start: usize) -> Result<List, (usize, Problem)> {
        let (mut lengths, mut values) = (Vec::new(), Vec::new());
        entries(value, 0, &mut lengths, &mut values)?;
        Ok(List { name: name.to_string(), start, lengths, values })
    }
}

/// Adds the numbers of a list that stands so deep in others.
fn entries(
    value: &Value,
    depth: usize,
    lengths: &mut Vec<usize>,
    values: &mut Vec<f64>,
) -> Result<(), (usize, Problem)> {
    let refuse = |expected: String| Err((value.at, Problem::Value { found: value.words(), expected }));
    match &value.found {
        Found::List(list) if depth < DEEPEST && !list.is_empty() => {
            if depth == lengths.len() && values.is_empty() {
                lengths.push(list.len());
            }
            match lengths.get(depth) {
                Some(length) if *length == list.len() => {}
                Some(length) => return refuse(format!("a list of {length}, as the first one")),
                None => return refuse("a finite number, as the entries before".to_string()),
            }
            list.iter().try_for_each(|value| entries(value, depth + 1, lengths, values))
        }
        Found::Number(number, _) if number.is_finite() && depth == lengths.len() => {
            values.push(*number);
            Ok(())
        }
        Found::List(list) if list.is_empty() => refuse("a list of one number or more".to_string()),
        Found::List(_) => refuse(format!("a list of numbers, or of lists, up to {DEEPEST} deep")),
        _ => refuse("a list of finite numbers".to_string()),
    }
}

/// How many parameters an error names.
const MOST_NAMED: usize = 12;

/// How deep lists of lists may be.
const DEEPEST: usize = 3;

impl Parameters {
    /// Reads them, and replaces the values of those that are set from outside; of two such values the last counts.
    pub(super) fn read(table: &Table, overrides: &[(String, f64)]) -> Result<Self, Fault> {
        let mut values = Vec::with_capacity(table.len());
        let mut lists: Vec<List> = Vec::new();
        for entry in table {
            let fault =
                |at, problem| Fault::at(at, problem).in_section(Section::Parameters).of_key(&entry.key);
            if !is_name(&entry.key) {
                return Err(fault(entry.key_at, Problem::BadName(entry.key.clone())));
            }
            if let Some(what) = reserved(&entry.key) {
                return Err(fault(entry.key_at, Problem::Reserved { name: entry.key.clone(), what }));
            }
            match &entry.value.found {
                Found::Number(value, _) if value.is_finite() => values.push((entry.key.clone(), *value)),
                Found::List(_) => {
                    let list = List::read(&entry.key, &entry.value, values.len());
                    let list = list.map_err(|(at, problem)| fault(at, problem))?;
                    values.extend(list.names().zip(list.values.iter().copied()));
                    lists.push(list);
                }
                Found::Text { .. } => {
                    let (found, expected) =
                        (entry.value.words(), "a number; formulas stand in [definitions]");
                    let problem = Problem::Value { found, expected: expected.to_string() };
                    return Err(fault(entry.value.at, problem));
                }
                _ => {
                    let (found, expected) = (entry.value.words(), "a finite number".to_string());
                    return Err(fault(entry.value.at, Problem::Value { found, expected }));
                }
            }
        }
        for (name, value) in overrides {
            let written: String = name.split_whitespace().collect();
            let Some(place) = values.iter().position(|(known, _)| *known == written) else {
                return Err(Fault::new(unknown(name, &values)));
            };
            if !value.is_finite() {
                return Err(Fault::new(Problem::ParameterNotFinite { name: name.clone(), value: *value }));
            }
            values[place].1 = *value;
        }
        for list in &mut lists {
            let of_list = &values[list.start..][..list.values.len()];
            list.values.iter_mut().zip(of_list).for_each(|(entry, (_, value))| *entry = *value);
        }
        Ok(Parameters { values, lists })
    }

    /// What their names mean.
    pub(super) fn meanings(&self) -> BTreeMap<String, Meaning> {
        // Entries of lists have names with brackets, which no formula can mean.
        let values = self.values.iter().filter(|(name, _)| !name.contains('['));
        let mut names: BTreeMap<String, Meaning> =
            values.map(|(name, value)| (name.clone(), Meaning::Parameter(*value))).collect();
        for (number, list) in self.lists.iter().enumerate() {
            names.insert(list.name.clone(), Meaning::List { number, dimensions: list.lengths.len() });
        }
        names
    }

    /// The value of a parameter.
    pub(super) fn get(&self, name: &str) -> Option<f64> {
        self.values.iter().find(|(known, _)| known == name).map(|(_, value)| *value)
    }
}

fn unknown(name: &str, values: &[(String, f64)]) -> Problem {
    let names: Vec<&str> = values.iter().map(|(name, _)| name.as_str()).collect();
    let advice = match nearest(name, names.iter().copied()) {
        Some(near) => format!("did you mean `{near}`?"),
        None if names.is_empty() => "the file has no [parameters]".to_string(),
        None if names.len() <= MOST_NAMED => format!("there are {}", names.join(", ")),
        None => format!("there are {} and more", names[..MOST_NAMED].join(", ")),
    };
    Problem::UnknownParameter { name: name.to_string(), advice }
}
