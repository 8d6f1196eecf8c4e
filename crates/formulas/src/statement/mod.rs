//! What a file of formulas states: its names, and its formulas by section.

mod keys;
mod lines;
mod order;
mod parameters;
mod sections;

use std::collections::BTreeMap;

use crate::document::Table;
use crate::error::{Fault, Section};
use crate::syntax::Meaning;
use keys::Key;
use parameters::Parameters;
use sections::Sections;

pub(crate) use lines::Line;

/// The formulas of a model.
#[derive(Debug, Clone)]
pub(crate) struct Statement {
    /// The model's name, if the file gives one.
    pub(crate) name: Option<String>,
    pub(crate) parameters: Vec<(String, f64)>,
    /// In the order of the file.
    pub(crate) definitions: Vec<Line>,
    /// The numbers of the definitions, each after those that it uses.
    pub(crate) order: Vec<usize>,
    /// One for each state.
    pub(crate) initial: Vec<Line>,
    /// In the order of `initial`.
    pub(crate) transition: Vec<Line>,
    pub(crate) measurement: Vec<Line>,
}

/// Reads the sections of a file of formulas.
pub(crate) fn read(text: &str, table: &Table, overrides: &[(String, f64)]) -> Result<Statement, Fault> {
    let sections = Sections::of(table)?;
    let parameters = Parameters::read(&sections.parameters, overrides)?;
    let states = keys::read(&sections.initial, Section::Initial, &parameters)?;
    let definitions = keys::read(&sections.definitions, Section::Definitions, &parameters)?;
    let moves = keys::read(&sections.transition, Section::Transition, &parameters)?;
    let measurements = keys::read(&sections.measurement, Section::Measurement, &parameters)?;
    let moves = keys::matched(&states, &moves)?;

    let mut names = meanings(&parameters, &states, &definitions, &measurements)?;
    let reader = lines::Reader { text, names: &names };
    let defined = reader.lines(&definitions, Section::Definitions)?;
    let order = order::of(&defined)
        .map_err(|(number, problem)| definitions[number].fault(Section::Definitions, problem))?;
    order::mark_states(&order, &defined, &mut names);
    let reader = lines::Reader { text, names: &names };
    Ok(Statement {
        name: sections.name.clone(),
        parameters: parameters.values.clone(),
        definitions: defined,
        order,
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
    measurements: &[Key<'_>],
) -> Result<BTreeMap<String, Meaning>, Fault> {
    let mut names = BTreeMap::new();
    let values = parameters.values.iter();
    names.extend(values.map(|(name, value)| (name.clone(), Meaning::Parameter(*value))));
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
    for key in states {
        add(key, Section::Initial, Meaning::State { first, length: key.length })?;
        first += key.coordinates();
    }
    for (number, key) in definitions.iter().enumerate() {
        let meaning = Meaning::Definition { number, length: key.length, needs_states: false };
        add(key, Section::Definitions, meaning)?;
    }
    for key in measurements {
        add(key, Section::Measurement, Meaning::Measurement)?;
    }
    Ok(names)
}
