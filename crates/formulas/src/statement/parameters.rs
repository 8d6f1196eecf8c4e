//! The numbers that formulas know by name.

use std::collections::BTreeMap;

use crate::document::{Entry, Found, Table, Value};
use crate::error::{ComposedProblem, Fault, Problem, Section, nearest};
use crate::names::is_name;
use crate::priors::{Law, Names, Origin, Prior, law_of};
use crate::syntax::Meaning;
use crate::tables::reserved;

/// The parameters of a file.
#[derive(Debug)]
pub(crate) struct Parameters {
    /// Numbers, and the entries of lists: `a`, `b[0]`, `c[0,1]`.
    pub(super) values: Vec<(String, f64)>,
    pub(crate) lists: Vec<List>,
    pub(super) priors: Vec<Prior>,
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
    pub(crate) fn read(table: &Table, overrides: &[(String, f64)]) -> Result<Self, Fault> {
        let mut parameters =
            Parameters { values: Vec::with_capacity(table.len()), lists: Vec::new(), priors: Vec::new() };
        for entry in table {
            let fault =
                |at, problem| Fault::at(at, problem).in_section(Section::Parameters).of_key(&entry.key);
            if !is_name(&entry.key) {
                return Err(fault(entry.key_at, Problem::BadName(entry.key.clone())));
            }
            if let Some(what) = reserved(&entry.key) {
                return Err(fault(entry.key_at, Problem::Reserved { name: entry.key.clone(), what }));
            }
            let first = parameters.values.len();
            match &entry.value.found {
                Found::Number(value, _) if value.is_finite() => {
                    parameters.values.push((entry.key.clone(), *value));
                }
                Found::List(_) => {
                    let list = List::read(&entry.key, &entry.value, first);
                    parameters.add_list(list.map_err(|(at, problem)| fault(at, problem))?);
                }
                Found::Text { .. } | Found::Table(_) => parameters
                    .add_prior(entry)
                    .map_err(|at| at.in_section(Section::Parameters).of_key(&entry.key))?,
                _ => {
                    let (found, expected) = (entry.value.words(), "a finite number".to_string());
                    return Err(fault(entry.value.at, Problem::Value { found, expected }));
                }
            }
            // Priors below it see what it is set to.
            parameters.set(first, overrides);
        }
        for (name, value) in overrides {
            if parameters.values.iter().all(|(known, _)| *known != squeezed(name)) {
                return Err(Fault::new(unknown(name, &parameters.values)));
            }
            if !value.is_finite() {
                return Err(Fault::new(Problem::ParameterNotFinite { name: name.clone(), value: *value }));
            }
        }
        Ok(parameters)
    }

    fn add_list(&mut self, list: List) {
        self.values.extend(list.names().zip(list.values.iter().copied()));
        self.lists.push(list);
    }

    /// Sets the values from a place on to those from outside.
    fn set(&mut self, first: usize, overrides: &[(String, f64)]) {
        let mut is_set = false;
        for (name, value) in &mut self.values[first..] {
            let last = overrides.iter().rfind(|(of, set)| set.is_finite() && squeezed(of) == *name);
            if let Some((_, set)) = last {
                *value = *set;
                is_set = true;
            }
        }
        let own = &self.values[first..];
        if let Some(list) = self.lists.last_mut().filter(|list| list.start == first) {
            list.values.iter_mut().zip(own).for_each(|(entry, (_, value))| *entry = *value);
        }
        if let Some(prior) = self
            .priors
            .last_mut()
            .filter(|prior| own.iter().any(|(name, _)| *name == prior.entries[0]) && is_set)
        {
            prior.start = own.iter().map(|(_, value)| *value).collect();
            prior.origin = Origin::Set;
        }
    }

    /// Adds a parameter that has a prior.
    fn add_prior(&mut self, entry: &Entry) -> Result<(), Fault> {
        let Stated { value, text, inner, start } = Stated::of(&entry.value)?;
        let at = |fault: Fault| {
            let byte = fault.at.zip(inner).map_or(value.at, |(byte, inner)| inner + byte);
            Fault { at: Some(byte), ..fault }
        };
        let not_one = || {
            let (found, expected) = (value.words(), EXPECTED.to_string());
            Fault::at(value.at, Problem::Value { found, expected })
        };
        if !text.contains('(') {
            return Err(not_one());
        }
        let law = {
            let names = self.names_for_priors(&entry.key);
            let entry = |list: usize, indices: &[f64]| self.lists[list].entry(indices);
            law_of(text, &Names { names: &names, entry: &entry }).map_err(at)?.ok_or_else(not_one)?
        };
        let origin = match (start, &law) {
            (Some(_), _) => Origin::Given,
            (None, Law::Dirichlet(_)) => Origin::Mean,
            (None, _) => Origin::Median,
        };
        let values = match start {
            Some(start) => given(start, &law)?,
            None => law.centre(),
        };
        let (name, text) = (entry.key.clone(), text.trim().to_string());
        let entries = match law {
            Law::Dirichlet(_) => {
                let start = self.values.len();
                let list =
                    List { name: name.clone(), start, lengths: vec![values.len()], values: values.clone() };
                let entries = list.names().collect();
                self.add_list(list);
                entries
            }
            _ => {
                self.values.push((name.clone(), values[0]));
                vec![name.clone()]
            }
        };
        self.priors.push(Prior { name, entries, text, start: values, origin, law });
        Ok(())
    }

    /// What a prior knows: parameters above it, and that those with priors are none for it.
    fn names_for_priors(&self, own: &str) -> BTreeMap<String, Meaning> {
        let mut names = self.meanings();
        let priors = self.priors.iter().map(|prior| prior.name.as_str()).chain([own]);
        names.extend(priors.map(|name| (name.to_string(), Meaning::Prior)));
        names
    }

    /// What their names mean.
    pub(crate) fn meanings(&self) -> BTreeMap<String, Meaning> {
        // Entries of lists have names with brackets, which no formula can mean.
        let values = self.values.iter().filter(|(name, _)| !name.contains('['));
        let mut names: BTreeMap<String, Meaning> =
            values.map(|(name, value)| (name.clone(), Meaning::Parameter(*value))).collect();
        for (number, list) in self.lists.iter().enumerate() {
            names.insert(list.name.clone(), Meaning::List { number, lengths: list.lengths.clone() });
        }
        names
    }

    /// The value of a parameter.
    pub(super) fn get(&self, name: &str) -> Option<f64> {
        self.values.iter().find(|(known, _)| known == name).map(|(_, value)| *value)
    }
}

/// The name of an entry of a list as errors and files have it: without spaces.
fn squeezed(name: &str) -> String {
    name.split_whitespace().collect()
}

/// What a text may be instead of a formula.
const EXPECTED: &str = "a number, or a prior as in \"normal(0, 1)\"; formulas stand in [definitions]";

/// A prior as the file states it.
struct Stated<'t> {
    value: &'t Value,
    text: &'t str,
    /// The byte where the text begins, if it stands there letter by letter.
    inner: Option<usize>,
    start: Option<&'t Value>,
}

impl<'t> Stated<'t> {
    /// `"normal(0, 1)"`, or `{ prior = "normal(0, 1)", start = 0.5 }`.
    fn of(value: &'t Value) -> Result<Self, Fault> {
        let mut stated = Stated { value, text: "", inner: None, start: None };
        let mut prior = Some(value);
        if let Found::Table(table) = &value.found {
            prior = None;
            for entry in table {
                match entry.key.as_str() {
                    "prior" => prior = Some(&entry.value),
                    "start" => stated.start = Some(&entry.value),
                    other => {
                        let advice = "a parameter has prior and start".to_string();
                        let problem = Problem::UnknownKey { name: other.to_string(), advice };
                        return Err(Fault::at(entry.key_at, problem));
                    }
                }
            }
        }
        let missing =
            Problem::Missing { name: "prior", example: "{ prior = \"uniform(0, 1)\", start = 0.5 }" };
        stated.value = prior.ok_or_else(|| Fault::at(value.at, missing))?;
        match &stated.value.found {
            Found::Text { text, inner } => Ok(Stated { text, inner: *inner, ..stated }),
            _ => {
                let (found, expected) = (stated.value.words(), "a distribution in quotes".to_string());
                Err(Fault::at(stated.value.at, Problem::Value { found, expected }))
            }
        }
    }
}

/// The start that a file gives: a number, or for a dirichlet a list.
fn given(start: &Value, law: &Law) -> Result<Vec<f64>, Fault> {
    let length = law.centre().len();
    let values = match (&start.found, law) {
        (Found::List(_), Law::Dirichlet(_)) => {
            let list = List::read("", start, 0).map_err(|(at, problem)| Fault::at(at, problem))?;
            Some(list.values).filter(|values| values.len() == length)
        }
        (Found::Number(value, _), law) if !matches!(law, Law::Dirichlet(_)) => Some(vec![*value]),
        _ => None,
    };
    let Some(values) = values else {
        let expected =
            if length > 1 { format!("a list of {length} numbers") } else { "a finite number".into() };
        return Err(Fault::at(start.at, Problem::Value { found: start.words(), expected }));
    };
    match values.iter().all(|value| value.is_finite()) && law.log_density(&values) > f64::NEG_INFINITY {
        true => Ok(values),
        false => Err(Fault::at(start.at, Problem::Composed(ComposedProblem::StartOutside(values[0])))),
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
