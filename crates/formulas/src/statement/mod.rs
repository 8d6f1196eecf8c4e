//! What a file of formulas states: its names, and its formulas by section.

mod keys;
mod lines;
mod order;
mod parameters;
mod sections;

use std::collections::BTreeMap;

use crate::document::Table;
use crate::error::{Fault, Section};
use crate::priors::Prior;
use crate::syntax::Meaning;
use keys::Key;
use parameters::Parameters;
use sections::Sections;

pub(crate) use lines::Line;
pub(crate) use parameters::List;

/// The formulas of a model.
#[derive(Debug, Clone)]
pub(crate) struct Statement {
    /// The model's name, if the file gives one.
    pub(crate) name: Option<String>,
    pub(crate) parameters: Vec<(String, f64)>,
    /// Parameters that are lists.
    pub(crate) lists: Vec<List>,
    pub(crate) priors: Vec<Prior>,
    /// In the order of the file.
    pub(crate) definitions: Vec<Line>,
    /// The numbers of the definitions, each after those that it uses.
    pub(crate) order: Vec<usize>,
    /// In the order in which they are drawn.
    pub(crate) draws: Vec<Line>,
    /// One for each state.
    pub(crate) initial: Vec<Line>,
    /// In the order of `initial`.
    pub(crate) transition: Vec<Line>,
    pub(crate) measurement: Vec<Line>,
}

impl Statement {
    /// The name of a state, or behind those of a draw.
    pub(crate) fn name_of(&self, number: usize) -> String {
        let mut before = 0;
        for line in self.initial.iter().chain(&self.draws) {
            if number < before + line.coordinates() {
                return line.coordinate(number - before);
            }
            before += line.coordinates();
        }
        String::new()
    }
}

/// Reads the sections of a file of formulas.
pub(crate) fn read(text: &str, table: &Table, overrides: &[(String, f64)]) -> Result<Statement, Fault> {
    let sections = Sections::of(table)?;
    let parameters = Parameters::read(&sections.parameters, overrides)?;
    let states = keys::read(&sections.initial, Section::Initial, &parameters)?;
    let definitions = keys::read(&sections.definitions, Section::Definitions, &parameters)?;
    let draws = keys::read(&sections.draws, Section::Draws, &parameters)?;
    let moves = keys::read(&sections.transition, Section::Transition, &parameters)?;
    let measurements = keys::read(&sections.measurement, Section::Measurement, &parameters)?;
    let moves = keys::matched(&states, &moves)?;

    let names = meanings(&parameters, &states, &definitions, &draws, &measurements)?;
    let reader = lines::Reader { text, names: &names };
    let defined = reader.lines(&definitions, Section::Definitions)?;
    let order = order::of(&defined)
        .map_err(|(number, problem)| definitions[number].fault(Section::Definitions, problem))?;
    Ok(Statement {
        name: sections.name.clone(),
        parameters: parameters.values.clone(),
        lists: parameters.lists.clone(),
        priors: parameters.priors.clone(),
        definitions: defined,
        order,
        draws: reader.lines(&draws, Section::Draws)?,
        initial: reader.lines(&states, Section::Initial)?,
        transition: reader.lines(&moves, Section::Transition)?,
        measurement: reader.lines(&measurements, Section::Measurement)?,
    })
}

/// What each name means; none can mean two things.
fn meanings(
    parameters: &Parameters,
    states: &[Key<'_>],
    definitions: &[Key<'_>],
    draws: &[Key<'_>],
    measurements: &[Key<'_>],
) -> Result<BTreeMap<String, Meaning>, Fault> {
    let mut names = BTreeMap::new();
    // Entries of lists have names with brackets, which no formula can mean.
    let values = parameters.values.iter().filter(|(name, _)| !name.contains('['));
    names.extend(values.map(|(name, value)| (name.clone(), Meaning::Parameter(*value))));
    for (number, list) in parameters.lists.iter().enumerate() {
        names.insert(list.name.clone(), Meaning::List { number, lengths: list.lengths.clone() });
    }
    let mut sections: BTreeMap<String, Section> =
        names.keys().map(|name| (name.clone(), Section::Parameters)).collect();
    let mut add = |key: &Key<'_>, section, meaning| {
        if let Some(other) = sections.insert(key.name.clone(), section) {
            return Err(key.twice(section, other));
        }
        names.insert(key.name.clone(), meaning);
        Ok(())
    };
    let mut first = 0;
    for (key, length) in keys::wholes(states) {
        add(key, Section::Initial, Meaning::State { first, length })?;
        first += length.unwrap_or(1);
    }
    for (key, length) in keys::wholes(draws) {
        add(key, Section::Draws, Meaning::Draw { first, length })?;
        first += length.unwrap_or(1);
    }
    for (number, key) in definitions.iter().enumerate() {
        let meaning = match key.arguments.as_slice() {
            [] => Meaning::Definition { number, length: key.length },
            arguments => Meaning::Function { number, arguments: arguments.to_vec() },
        };
        add(key, Section::Definitions, meaning)?;
    }
    for (key, _) in keys::wholes(measurements) {
        add(key, Section::Measurement, Meaning::Measurement)?;
    }
    Ok(names)
}
