//! The numbers that formulas know by name.

use std::collections::BTreeMap;

use crate::document::{Entry, Found, Table, Value};
use crate::error::{ComposedProblem, Fault, Problem, Section, nearest};
use crate::names::is_name;
use crate::priors::{Law, Names, Origin, Prior, law_of};
use crate::syntax::Meaning;
use crate::tables::reserved;

use super::list::List;

/// The parameters of a file.
#[derive(Debug, Default)]
pub(crate) struct Parameters {
    /// Numbers, and the entries of lists: `a`, `b[0]`, `c[0,1]`.
    pub(super) values: Vec<(String, f64)>,
    pub(crate) lists: Vec<List>,
    pub(super) priors: Vec<Prior>,
    /// Those that each particle has of its own, which are no constants.
    of_particles: Vec<String>,
}

/// How many parameters an error names.
const MOST_NAMED: usize = 12;

impl Parameters {
    /// Reads them, and replaces the values of those that are set from outside; of two such values the last counts.
    pub(crate) fn read(table: &Table, overrides: &[(String, f64)]) -> Result<Self, Fault> {
        let mut parameters = Parameters { values: Vec::with_capacity(table.len()), ..Parameters::default() };
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
                    let read = List::read(&entry.key, &entry.value, first);
                    let (list, priors) = read.map_err(|(at, problem)| fault(at, problem))?;
                    parameters.add_list(list);
                    for (at, value) in priors {
                        parameters
                            .add_prior_of_entry(&entry.key, first + at, value)
                            .map_err(|at| at.in_section(Section::Parameters).of_key(&entry.key))?;
                    }
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
        let set = |name: &str| overrides.iter().rfind(|(of, set)| set.is_finite() && squeezed(of) == name);
        let is_set = |name: &str| set(name).is_some();
        for (name, value) in &mut self.values[first..] {
            if let Some((_, set)) = set(name) {
                *value = *set;
            }
        }
        let own = &self.values[first..];
        if let Some(list) = self.lists.last_mut().filter(|list| list.start == first) {
            list.values.iter_mut().zip(own).for_each(|(entry, (_, value))| *entry = *value);
        }
        for prior in &mut self.priors {
            let place = own.iter().position(|(name, _)| *name == prior.entries[0]);
            let Some(values) = place.and_then(|at| own.get(at..at + prior.entries.len())) else { continue };
            if values.iter().any(|(name, _)| is_set(name)) {
                prior.start = values.iter().map(|(_, value)| *value).collect();
                prior.origin = Origin::Set;
            }
        }
    }

    /// Adds a parameter that has a prior, a dirichlet as a list.
    fn add_prior(&mut self, entry: &Entry) -> Result<(), Fault> {
        let prior = self.prior_of(&entry.key, &entry.value)?;
        match prior.law {
            Law::Dirichlet(_) => {
                let (start, values) = (self.values.len(), prior.start.clone());
                let list = List::new(&entry.key, start, vec![values.len()], values);
                let entries = list.names().collect();
                self.add_list(list);
                self.priors.push(Prior { entries, ..prior });
            }
            _ => {
                self.values.push((entry.key.clone(), prior.start[0]));
                self.priors.push(prior);
            }
        }
        Ok(())
    }

    /// Gives a prior to the entry of the last list that stands at this place among all parameters.
    fn add_prior_of_entry(&mut self, list: &str, at: usize, value: &Value) -> Result<(), Fault> {
        let prior = self.prior_of(list, value)?;
        if let Law::Dirichlet(_) = prior.law {
            let expected = "a prior of one number; a dirichlet is the prior of a whole list".to_string();
            return Err(Fault::at(value.at, Problem::Value { found: value.words(), expected }));
        }
        let start = prior.start[0];
        self.values[at].1 = start;
        if let Some(list) = self.lists.last_mut() {
            list.values[at - list.start] = start;
        }
        let name = self.values[at].0.clone();
        self.priors.push(Prior { entries: vec![name.clone()], name, ..prior });
        Ok(())
    }

    /// Reads a prior of a parameter.
    fn prior_of(&self, name: &str, stated: &Value) -> Result<Prior, Fault> {
        let PriorText { value, text, inner, start } = PriorText::of(stated)?;
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
            let names = self.names_for_priors(name);
            let entry = |list: usize, indices: &[f64]| self.lists[list].entry(indices);
            law_of(text, &Names { names: &names, entry: &entry }).map_err(at)?.ok_or_else(not_one)?
        };
        let origin = match (start, &law) {
            (Some(_), _) => Origin::Given,
            (None, Law::Dirichlet(_)) => Origin::Mean,
            (None, _) => Origin::Median,
        };
        let start = match start {
            Some(start) => given(start, &law)?,
            None => law.centre(),
        };
        let (name, text) = (name.to_string(), text.trim().to_string());
        Ok(Prior { entries: vec![name.clone()], name, text, start, origin, law })
    }

    /// What a prior knows: parameters above it, and that those with priors are none for it.
    fn names_for_priors(&self, own: &str) -> BTreeMap<String, Meaning> {
        let mut names = self.meanings();
        // A list of which an entry has one is none as a whole.
        let of_list = |prior: &'_ Prior| prior.name.split('[').next().unwrap_or_default().to_string();
        let priors = self.priors.iter().map(of_list).chain([own.to_string()]);
        names.extend(priors.map(|name| (name, Meaning::Prior)));
        names
    }

    /// What their names mean.
    pub(crate) fn meanings(&self) -> BTreeMap<String, Meaning> {
        // Entries of lists have names with brackets, which no formula can mean.
        let is_constant = |name: &String| !self.of_particles.contains(name);
        let values = self.values.iter().filter(|(name, _)| !name.contains('[') && is_constant(name));
        let mut names: BTreeMap<String, Meaning> =
            values.map(|(name, value)| (name.clone(), Meaning::Parameter(*value))).collect();
        for (number, list) in
            self.lists.iter().enumerate().filter(|(_, list)| list.names().all(|name| is_constant(&name)))
        {
            names.insert(list.name.clone(), Meaning::List { number, lengths: list.lengths.clone() });
        }
        names
    }

    /// Gives each particle parameters of its own, of which nothing else can be made than formulas.
    pub(super) fn give_to_particles(&mut self, names: &[String]) -> Result<(), Fault> {
        if let Some(name) = names.iter().find(|name| self.values.iter().all(|(known, _)| known != *name)) {
            return Err(Fault::new(unknown(name, &self.values)));
        }
        self.of_particles = names.to_vec();
        Ok(())
    }

    /// Makes the parameters of particles numbers of the state from `first` on, in `names` and in lists.
    pub(super) fn become_states(&mut self, first: usize, names: &mut BTreeMap<String, Meaning>) {
        for (number, name) in self.of_particles.iter().enumerate() {
            let Some(place) = self.values.iter().position(|(known, _)| known == name) else { continue };
            let (state, mut lists) = (first + number, self.lists.iter_mut().enumerate());
            match lists.find(|(_, list)| list.has(place)) {
                Some((number, list)) => {
                    list.states[place - list.start] = Some(state);
                    names.insert(list.name.clone(), Meaning::List { number, lengths: list.lengths.clone() });
                }
                None => {
                    names.insert(name.clone(), Meaning::State { first: state, length: None });
                }
            }
        }
    }

    /// The value of a parameter.
    pub(super) fn get(&self, name: &str) -> Option<f64> {
        let of_name = self.values.iter().find(|(known, _)| known == name);
        of_name.filter(|(name, _)| !self.of_particles.contains(name)).map(|(_, value)| *value)
    }
}

/// The name of an entry of a list as errors and files have it: without spaces.
fn squeezed(name: &str) -> String {
    name.split_whitespace().collect()
}

/// What a text may be instead of a formula.
const EXPECTED: &str = "a number, or a prior as in \"normal(0, 1)\"; formulas stand in [definitions]";

/// A prior as the file states it.
struct PriorText<'t> {
    value: &'t Value,
    text: &'t str,
    /// The byte where the text begins, if it stands there letter by letter.
    inner: Option<usize>,
    start: Option<&'t Value>,
}

impl<'t> PriorText<'t> {
    /// `"normal(0, 1)"`, or `{ prior = "normal(0, 1)", start = 0.5 }`.
    fn of(value: &'t Value) -> Result<Self, Fault> {
        let mut stated = PriorText { value, text: "", inner: None, start: None };
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
            Found::Text { text, inner } => Ok(PriorText { text, inner: *inner, ..stated }),
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
            let (list, priors) = List::read("", start, 0).map_err(|(at, problem)| Fault::at(at, problem))?;
            Some(list.values).filter(|values| values.len() == length && priors.is_empty())
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
