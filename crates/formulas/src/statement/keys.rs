//! The keys of formulas: names, some with the length of a vector.

use std::collections::{BTreeMap, BTreeSet};

use super::parameters::Parameters;
use crate::document::{Entry, Found, Table, Value};
use crate::error::{ComposedProblem, Fault, Problem, Section};
use crate::names::is_name;
use crate::syntax::parts;
use crate::tables::{family, function as function_of_table, reserved};

/// How many coordinates a section may have.
const MOST: usize = 10_000;

/// The key of a formula, with the formula.
#[derive(Debug, Clone)]
pub(super) struct Key<'t> {
    /// As it is written.
    pub(super) written: &'t str,
    pub(super) name: String,
    /// The length of a vector, or of the part of it that the key is about.
    pub(super) length: Option<usize>,
    /// Where that part begins; none where it is all of it.
    pub(super) part: Option<usize>,
    /// The names of the arguments of a function; none of what is no function.
    pub(super) arguments: Vec<String>,
    /// Whether it is a vector because its distribution has parts.
    pub(super) has_parts: bool,
    pub(super) at: usize,
    pub(super) value: &'t Value,
}

impl<'t> Key<'t> {
    /// That of how an input is simulated.
    pub(super) fn of_input(name: &'t str, entry: &'t Entry) -> Self {
        let (at, value) = (entry.key_at, &entry.value);
        Key {
            written: name,
            name: name.to_string(),
            length: None,
            part: None,
            at,
            value,
            arguments: Vec::new(),
            has_parts: false,
        }
    }
}

impl Key<'_> {
    /// The same where a part of the vector stands above it, by its beginning and its length: `x[3]` is one coordinate there where three others come before it.
    fn after(self, before: Option<(usize, usize)>) -> Self {
        match (self.part, before) {
            (None, Some((before, length))) if self.length == Some(before + length) => {
                Key { part: self.length, length: Some(1), ..self }
            }
            _ => self,
        }
    }

    /// How many coordinates it has.
    pub(super) fn coordinates(&self) -> usize {
        self.length.unwrap_or(1)
    }

    /// The name with its length.
    fn full(&self) -> String {
        match (self.length, self.part) {
            (Some(_), Some(_)) => self.written.to_string(),
            (Some(length), None) => format!("{}[{length}]", self.name),
            (None, _) => self.name.clone(),
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
        let key = key(entry, section, parameters)
            .and_then(|key| with_parts(key, section))
            .map_err(|problem| Fault::at(entry.key_at, problem).in_section(section).of_key(&entry.key))?;
        if let Some(problem) = taken(&key, section) {
            return Err(key.fault(section, problem));
        }
        let goes_on = keys.last().filter(|before| before.name == key.name);
        let before = goes_on.and_then(|before| before.part.zip(before.length));
        let key = key.after(before);
        match (key.part, before) {
            (Some(_), _) if section == Section::Definitions => {
                return Err(key.fault(section, Problem::PartOfDefinition(key.name.clone())));
            }
            (Some(first), Some((before, length))) if first == before + length => {}
            (Some(first), Some((before, length))) => {
                let (found, expected) = (first, before + length);
                return Err(
                    key.fault(section, Problem::PartApart { name: key.name.clone(), found, expected })
                );
            }
            (Some(first), None) if first > 0 && !names.contains(&key.name) => {
                let name = key.name.clone();
                return Err(key.fault(section, Problem::PartApart { name, found: first, expected: 0 }));
            }
            (None, Some((before, length))) if key.length.is_some() => {
                let (found, expected, name) = (key.coordinates(), before + length, key.name.clone());
                return Err(key.fault(section, Problem::PartApart { name, found, expected }));
            }
            _ if !names.insert(key.name.clone()) => return Err(key.twice(section, section)),
            _ => {}
        }
        coordinates += key.coordinates();
        if coordinates > MOST {
            return Err(key.fault(section, Problem::TooMany(MOST)));
        }
        keys.push(key);
    }
    Ok(keys)
}

/// Why a name cannot be had in a section. A function of one's own may have the name of one that there is, in whose place it is called.
fn taken(key: &Key<'_>, section: Section) -> Option<Problem> {
    let what = match (key.name.as_str(), section) {
        ("series", Section::Initial | Section::Transition | Section::Measurement) => {
            Some("the column that tells sequences apart")
        }
        (name, _) if !key.arguments.is_empty() && function_of_table(name).is_some() => None,
        (name, _) => reserved(name),
    };
    what.map(|what| Problem::Reserved { name: key.name.clone(), what })
}

/// A draw, or a start, with as many coordinates as its distribution has parts.
fn with_parts(key: Key<'_>, section: Section) -> Result<Key<'_>, Problem> {
    let parts = match &key.value.found {
        Found::Text { text, .. } => parts(text, section),
        _ => None,
    };
    match (parts, key.length) {
        (None, _) => Ok(key),
        (Some(_), Some(_)) => Err(Problem::Composed(ComposedProblem::VectorOfParts(key.name))),
        (Some(parts), None) => Ok(Key { length: Some(parts), has_parts: true, ..key }),
    }
}

/// The name of a function and those of its arguments: `f(x, y)`.
fn function(written: &str, section: Section) -> Result<(&str, Vec<String>), Problem> {
    let bad = || Problem::Composed(ComposedProblem::BadFunction(written.to_string()));
    let (name, rest) = written.split_once('(').ok_or_else(bad)?;
    let inside = rest.strip_suffix(')').ok_or_else(bad)?;
    if section != Section::Definitions {
        return Err(Problem::Composed(ComposedProblem::FunctionElsewhere(written.to_string())));
    }
    let name = name.trim_end();
    if family(name).is_some() {
        return Err(Problem::Reserved { name: name.to_string(), what: "a distribution" });
    }
    let arguments: Vec<String> = inside.split(',').map(|name| name.trim().to_string()).collect();
    for (number, argument) in arguments.iter().enumerate() {
        if !is_name(argument) || arguments[..number].contains(argument) {
            return Err(bad());
        }
        if let Some(what) = reserved(argument) {
            return Err(Problem::Reserved { name: argument.clone(), what });
        }
    }
    Ok((name, arguments))
}

/// `x` or `x[40]`, or a part of a vector: `x[0]`, its first coordinate, or `x[1..4]`, those from 1 on and before 4. A function is `f(x)`.
fn key<'t>(entry: &'t Entry, section: Section, parameters: &Parameters) -> Result<Key<'t>, Problem> {
    let written = entry.key.as_str();
    let mut arguments = Vec::new();
    let (name, length, part) = match written.split_once('[') {
        None if written.contains('(') => {
            let (name, names) = function(written, section)?;
            arguments = names;
            (name, None, None)
        }
        None => (written, None, None),
        Some((name, rest)) => {
            let Some(inside) = rest.strip_suffix(']') else {
                return Err(Problem::BadName(written.to_string()));
            };
            let integer = |text: &str, least: f64| {
                let number = text.trim().parse().ok().or_else(|| parameters.get(text.trim()));
                let number = number.filter(|number: &f64| number.fract() == 0.0);
                let number = number.filter(|number| (least..=MOST as f64).contains(number));
                let bad = || Problem::BadLength { length: text.trim().to_string(), longest: MOST };
                number.map(|number| number as usize).ok_or_else(bad)
            };
            let (length, part) = match inside.split_once("..") {
                None if inside.trim() == "0" => (1, Some(0)),
                None => (integer(inside, 1.0)?, None),
                Some((first, end)) => {
                    let (first, end) = (integer(first, 0.0)?, integer(end, 1.0)?);
                    let empty = || Problem::EmptyPart { first, end };
                    (end.checked_sub(first).filter(|length| *length > 0).ok_or_else(empty)?, Some(first))
                }
            };
            (name.trim_end(), Some(length), part)
        }
    };
    if !is_name(name) {
        return Err(Problem::BadName(name.to_string()));
    }
    let (name, at) = (name.to_string(), entry.key_at);
    Ok(Key { written, name, length, part, arguments, has_parts: false, at, value: &entry.value })
}

/// The names of keys with the lengths of their vectors, of which parts are put together.
pub(super) fn wholes<'k, 't>(keys: &'k [Key<'t>]) -> impl Iterator<Item = (&'k Key<'t>, Option<usize>)> {
    keys.chunk_by(|a, b| a.name == b.name).map(|parts| {
        let length = parts[0].length.map(|_| parts.iter().map(Key::coordinates).sum());
        (&parts[0], length)
    })
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
    let parts = moves.chunk_by(|a, b| a.name == b.name);
    let by_name: BTreeMap<&str, &[Key<'t>]> = parts.map(|parts| (parts[0].name.as_str(), parts)).collect();
    let mut ordered = Vec::with_capacity(moves.len());
    for (state, length) in wholes(states) {
        let Some(&found) = by_name.get(state.name.as_str()) else {
            return Err(one_sided(state, Section::Initial, Section::Transition));
        };
        let sum = found[0].length.map(|_| found.iter().map(Key::coordinates).sum::<usize>());
        if sum != length {
            let whole = length.map_or(state.name.clone(), |length| format!("{}[{length}]", state.name));
            let has_parts = found[0].part.is_some();
            let expected = if has_parts { format!("{whole} with all its parts") } else { whole };
            let last = &found[found.len() - 1];
            return Err(last.fault(Section::Transition, Problem::OtherLength { expected }));
        }
        ordered.extend(found.iter().cloned());
    }
    Ok(ordered)
}
