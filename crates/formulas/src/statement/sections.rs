//! The top level of a file of formulas.

use crate::document::{Found, Table, Value};
use crate::error::{Fault, Problem, Section, nearest};

/// What a file of formulas has.
#[derive(Debug, Default)]
pub(super) struct Sections {
    pub(super) name: Option<String>,
    pub(super) series: Table,
    pub(super) time: Table,
    pub(super) has_time: bool,
    pub(super) inputs: Table,
    pub(super) parameters: Table,
    pub(super) initial: Table,
    pub(super) definitions: Table,
    pub(super) draws: Table,
    pub(super) transition: Table,
    pub(super) measurement: Table,
}

/// What a model has whose equations are functions.
const OF_FUNCTIONS: [Section; 4] = [Section::Time, Section::Inputs, Section::Parameters, Section::Series];

/// A line that each of the needed sections may have.
fn example(section: Section) -> &'static str {
    match section {
        Section::Initial => "a line for each coordinate of the state, as x = \"normal(0, 1)\"",
        Section::Transition => "a line for each coordinate of the state, as x = \"normal(0.9*x, 1)\"",
        _ => "a line for each measurement, as y = \"normal(x, 1)\"",
    }
}

impl Sections {
    /// Sorts the sections of a model whose equations are functions; it has none for equations.
    pub(super) fn of_functions(table: &Table) -> Result<Self, Fault> {
        let mut sections = Sections::default();
        for entry in table {
            let fault = |problem| Fault::at(entry.key_at, problem);
            let section = Section::ALL.into_iter().find(|section| section.name() == entry.key);
            match section {
                Some(section) if OF_FUNCTIONS.contains(&section) => {
                    *sections.of_mut(section) = lines(&entry.value, section)?.clone();
                    sections.has_time |= section == Section::Time;
                }
                Some(section) => return Err(fault(Problem::OfFunctions(section.title()))),
                None => {
                    let advice = match nearest(&entry.key, OF_FUNCTIONS.map(Section::name)) {
                        Some(near) => format!("did you mean `{near}`?"),
                        None => {
                            let all = OF_FUNCTIONS.map(Section::title).join(", ");
                            format!("beside functions it has {all}")
                        }
                    };
                    return Err(fault(Problem::UnknownKey { name: entry.key.clone(), advice }));
                }
            }
        }
        Ok(sections)
    }

    /// Sorts the keys of a file.
    pub(super) fn of(table: &Table) -> Result<Self, Fault> {
        let mut sections = Sections::default();
        for entry in table {
            let fault = |problem| Fault::at(entry.key_at, problem);
            let section = Section::ALL.into_iter().find(|section| section.name() == entry.key);
            match (section, entry.key.as_str()) {
                (Some(section), _) => {
                    *sections.of_mut(section) = lines(&entry.value, section)?.clone();
                    sections.has_time |= section == Section::Time;
                }
                (None, "name") => sections.name = Some(entry.value.text("name")?.to_string()),
                (None, "kind") => {}
                (None, key) => {
                    let known = Section::ALL.map(Section::name).into_iter().chain(["name", "kind"]);
                    let advice = match nearest(key, known) {
                        Some(near) => format!("did you mean `{near}`?"),
                        None => {
                            let all = Section::ALL.map(Section::title).join(", ");
                            format!("it has name, kind, {all}")
                        }
                    };
                    return Err(fault(Problem::UnknownKey { name: key.to_string(), advice }));
                }
            }
        }
        for section in [Section::Initial, Section::Transition, Section::Measurement] {
            if sections.of_mut(section).is_empty() {
                let problem = Problem::Missing { name: section.title(), example: example(section) };
                return Err(Fault::new(problem));
            }
        }
        Ok(sections)
    }

    fn of_mut(&mut self, section: Section) -> &mut Table {
        match section {
            Section::Series => &mut self.series,
            Section::Time => &mut self.time,
            Section::Inputs => &mut self.inputs,
            Section::Parameters => &mut self.parameters,
            Section::Initial => &mut self.initial,
            Section::Definitions => &mut self.definitions,
            Section::Draws => &mut self.draws,
            Section::Transition => &mut self.transition,
            Section::Measurement => &mut self.measurement,
        }
    }
}

fn lines(value: &Value, section: Section) -> Result<&Table, Fault> {
    match &value.found {
        Found::Table(table) => Ok(table),
        _ => {
            let expected = format!("a section: a line {}, and lines below it", section.title());
            let problem = Problem::Value { found: value.words(), expected };
            Err(Fault::at(value.at, problem).of_key(section.name()))
        }
    }
}
