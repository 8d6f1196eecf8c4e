//! The keys of formulas: names, some with the length of a vector.

use std::collections::{BTreeMap, BTreeSet};

use super::parameters::Parameters;
use crate::document::{Entry, Table, Value};
use crate::error::{Fault, Problem, Section};
use crate::names::is_name;
use crate::tables::reserved;

/// How many coordinates a section may have.
const MOST: usize = 10_000;

/// The key of a formula, with the formula.
#[derive(Debug, Clone)]
pub(super) struct Key<'t> {
    /// As it is written.
    pub(super) written: &'t str,
    pub(super) name: String,
    /// The length of a vector.
    pub(super) length: Option<usize>,
    pub(super) at: usize,
    pub(super) value: &'t Value,
}

impl Key<'_> {
    /// How many coordinates it has.
    pub(super) fn coordinates(&self) -> usize {
        self.length.unwrap_or(1)
    }

    /// The name with its length.
    fn full(&self) -> String {
        match self.length {
            Some(length) => format!("{}[{length}]", self.name),
            None => self.name.clone(),
        }
    }

    /// A problem at the key.
    pub(super) fn fault(&self, section: Section, problem: Problem) -> Fault {
        Fault::at(self.at, problem).in_section(section).of_key(self.written)
    }

    /// The fault of a name that another section has, too.
    pub(super) fn twice(&self, section: Section, other: Section) -> Fault {
        self.fault(section, Problem::Twice { name: self.name.clone(), other: other.title() })
    }
}

/// The keys of a section.
pub(super) fn read<'t>(
    table: &'t Table,
    section: Section,
    parameters: &Parameters,
) -> Result<Vec<Key<'t>>, Fault> {
    let mut keys: Vec<Key<'t>> = Vec::with_capacity(table.len());
    let (mut names, mut coordinates) = (BTreeSet::new(), 0);
    for entry in table {
        let key = key(entry, parameters)
            .map_err(|problem| Fault::at(entry.key_at, problem).in_section(section).of_key(&entry.key))?;
        if let Some(problem) = taken(&key.name, section) {
            return Err(key.fault(section, problem));
        }
        if !names.insert(key.name.clone()) {
            return Err(key.twice(section, section));
        }
        coordinates += key.coordinates();
        if coordinates > MOST {
            return Err(key.fault(section, Problem::TooMany(MOST)));
        }
        keys.push(key);
    }
    Ok(keys)
}

/// Why a name cannot be had in a section.
fn taken(name: &str, section: Section) -> Option<Problem> {
    let what = match (name, section) {
        ("series", Section::Initial | Section::Transition | Section::Measurement) => {
            Some("the column that tells sequences apart")
        }
        _ => reserved(name),
    };
    what.map(|what| Problem::Reserved { name: name.to_string(), what })
}

/// `x` or `x[40]`.
fn key<'t>(entry: &'t Entry, parameters: &Parameters) -> Result<Key<'t>, Problem> {
    let written = entry.key.as_str();
    let (name, length) = match written.split_once('[') {
        None => (written, None),
        Some((name, rest)) => {
            let Some(length) = rest.strip_suffix(']') else {
                return Err(Problem::BadName(written.to_string()));
            };
            let bad = || Problem::BadLength { length: length.trim().to_string(), longest: MOST };
            let number = length.trim().parse().ok().or_else(|| parameters.get(length.trim()));
            let number = number.filter(|number: &f64| number.fract() == 0.0).ok_or_else(bad)?;
            if !(1.0..=MOST as f64).contains(&number) {
                return Err(bad());
            }
            (name.trim_end(), Some(number as usize))
        }
    };
    if !is_name(name) {
        return Err(Problem::BadName(name.to_string()));
    }
    Ok(Key { written, name: name.to_string(), length, at: entry.key_at, value: &entry.value })
}

/// The keys of [transition] in the order of those of [initial], which must be the same.
pub(super) fn matched<'t>(states: &[Key<'_>], moves: &[Key<'t>]) -> Result<Vec<Key<'t>>, Fault> {
    let one_sided = |key: &Key<'_>, present: Section, absent: Section| {
        let (present_title, absent_title) = (present.title(), absent.title());
        let problem = Problem::OneSided { name: key.full(), present: present_title, absent: absent_title };
        key.fault(present, problem)
    };
    let names: BTreeSet<&str> = states.iter().map(|state| state.name.as_str()).collect();
    if let Some(surplus) = moves.iter().find(|key| !names.contains(key.name.as_str())) {
        return Err(one_sided(surplus, Section::Transition, Section::Initial));
    }
    let by_name: BTreeMap<&str, &Key<'t>> = moves.iter().map(|key| (key.name.as_str(), key)).collect();
    let mut ordered = Vec::with_capacity(states.len());
    for state in states {
        let Some(&found) = by_name.get(state.name.as_str()) else {
            return Err(one_sided(state, Section::Initial, Section::Transition));
        };
        if found.length != state.length {
            return Err(found.fault(Section::Transition, Problem::OtherLength { expected: state.full() }));
        }
        ordered.push(found.clone());
    }
    Ok(ordered)
}
