//! What a file of formulas states: its names, and its formulas by section.

mod constant;
mod inputs;
mod keys;
mod lines;
mod list;
mod order;
mod parameters;
mod sections;
mod time;

use std::cell::RefCell;
use std::collections::BTreeMap;

use crate::document::{Entry, Table};
use crate::error::{Fault, Problem, Section};
use crate::names::is_name;
use crate::priors::Prior;
use crate::syntax::{Meaning, Since, Total, Totals};
use crate::tables::reserved;
use keys::Key;
use sections::Sections;

pub(crate) use constant::Constants;
pub use inputs::{Between, InputRule, InputSource};
pub(crate) use lines::Line;
pub(crate) use list::List;
pub(crate) use parameters::Parameters;
pub use time::{TimeLabel, TimeRule, TimeUnit};

/// The formulas of a model.
#[derive(Debug, Clone, Default)]
pub(crate) struct Statement {
    /// The model's name, if the file gives one.
    pub(crate) name: Option<String>,
    /// The column that tells series apart, if the file names one.
    pub(crate) series: Option<String>,
    /// How rows are spaced, if the file says so.
    pub(crate) time: Option<TimeRule>,
    pub(crate) inputs: Vec<InputRule>,
    /// How inputs are simulated: their numbers, and a line for each.
    pub(crate) simulated: (Vec<usize>, Vec<Line>),
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
    /// What measurements use of the sub-steps before: numbers of the state behind those of `initial`.
    pub(crate) totals: Vec<Total>,
    /// The parameters that each particle has of its own: numbers of the state behind those of `totals`.
    pub(crate) of_particles: Vec<String>,
    /// Whether a measurement may have a standard deviation of 0, so that only exact filters take it.
    pub(crate) may_be_exact: bool,
}

impl Statement {
    /// The names of all coordinates of a state.
    pub(crate) fn states(&self) -> Vec<String> {
        let of_line = |line: &Line| (0..line.coordinates()).map(|at| line.coordinate(at)).collect::<Vec<_>>();
        let of_total =
            |total: &Total| (0..total.coordinates()).map(|at| total.coordinate(at)).collect::<Vec<_>>();
        let states = self.initial.iter().flat_map(of_line).chain(self.totals.iter().flat_map(of_total));
        states.chain(self.of_particles.iter().cloned()).collect()
    }

    /// How many coordinates a state has.
    pub(crate) fn dimension(&self) -> usize {
        self.first_parameter() + self.of_particles.len()
    }

    /// The number of the state at which the parameters begin that each particle has of its own.
    pub(crate) fn first_parameter(&self) -> usize {
        let of_lines: usize = self.initial.iter().map(Line::coordinates).sum();
        of_lines + self.totals.iter().map(Total::coordinates).sum::<usize>()
    }

    /// The measurements, as numbers of entries, of which it matters in a step whether they were there at the row before.
    pub(crate) fn resets(&self) -> Vec<usize> {
        let mut found: Vec<usize> = Vec::new();
        for total in &self.totals {
            if let Since::Measured(entry) = total.since
                && !found.contains(&entry)
            {
                found.push(entry);
            }
        }
        found
    }

    /// The name of a number of the state, or behind those of a draw.
    pub(crate) fn name_of(&self, number: usize) -> String {
        let states = self.states();
        let mut before = states.len();
        if let Some(name) = states.into_iter().nth(number) {
            return name;
        }
        for line in &self.draws {
            if number < before + line.coordinates() {
                return line.coordinate(number - before);
            }
            before += line.coordinates();
        }
        String::new()
    }
}

/// Reads the sections of a file of formulas. Each particle has the parameters of these names of its own, those of entries of lists one by one.
pub(crate) fn read(
    text: &str,
    table: &Table,
    overrides: &[(String, f64)],
    of_particles: &[String],
) -> Result<Statement, Fault> {
    let sections = Sections::of(table)?;
    let mut parameters = Parameters::read(&sections.parameters, overrides)?;
    parameters.give_to_particles(of_particles)?;
    let constants = parameters.meanings();
    let inputs = inputs_of(&sections, Constants { names: &constants, lists: &parameters.lists })?;
    let states = keys::read(&sections.initial, Section::Initial, &parameters)?;
    let definitions = keys::read(&sections.definitions, Section::Definitions, &parameters)?;
    let draws = keys::read(&sections.draws, Section::Draws, &parameters)?;
    let moves = keys::read(&sections.transition, Section::Transition, &parameters)?;
    let measurements = keys::read(&sections.measurement, Section::Measurement, &parameters)?;
    let moves = keys::matched(&states, &moves)?;

    let mut names = meanings(&parameters, &inputs, [&states, &definitions, &draws, &measurements])?;
    let known = states.iter().map(Key::coordinates).sum();
    let measured = |names: &BTreeMap<String, Meaning>| {
        let totals = RefCell::new(Totals { states: known, ..Totals::default() });
        let reader = lines::Reader { text, names, totals: Some(&totals) };
        let lines = reader.lines(&measurements, Section::Measurement)?;
        Ok::<_, Fault>((lines, totals.into_inner()))
    };
    parameters.become_states(known, &mut names);
    let (mut measurement, totals) = measured(&names)?;
    if !of_particles.is_empty() {
        // Totals stand before them, and are known only now.
        parameters.become_states(known + totals.count(), &mut names);
        (measurement, _) = measured(&names)?;
    }
    for meaning in names.values_mut() {
        if let Meaning::Draw { first, .. } = meaning {
            *first += totals.count() + of_particles.len();
        }
    }
    let reader = lines::Reader { text, names: &names, totals: None };
    let defined = reader.lines(&definitions, Section::Definitions)?;
    let order = order::of(&defined)
        .map_err(|(number, problem)| definitions[number].fault(Section::Definitions, problem))?;
    Ok(Statement {
        definitions: defined,
        order,
        draws: reader.lines(&draws, Section::Draws)?,
        initial: reader.lines(&states, Section::Initial)?,
        transition: reader.lines(&moves, Section::Transition)?,
        measurement,
        totals: totals.all,
        of_particles: of_particles.to_vec(),
        ..around(text, &sections, &parameters, inputs)?
    })
}

/// Reads the sections that a model has whose equations are functions; `names` are those of its coordinates.
pub(crate) fn read_frame(
    text: &str,
    table: &Table,
    names: &[&str],
    overrides: &[(String, f64)],
) -> Result<Statement, Fault> {
    let sections = Sections::of_functions(table)?;
    let parameters = Parameters::read(&sections.parameters, overrides)?;
    let constants = parameters.meanings();
    let inputs = inputs_of(&sections, Constants { names: &constants, lists: &parameters.lists })?;
    meanings(&parameters, &inputs, [&[], &[], &[], &[]])?;
    for (section, table) in [(Section::Inputs, &sections.inputs), (Section::Parameters, &sections.parameters)]
    {
        if let Some(entry) = table.iter().find(|entry| names.contains(&entry.key.as_str())) {
            let problem = Problem::Twice { name: entry.key.clone(), other: "the coordinates" };
            return Err(Fault::at(entry.key_at, problem).in_section(section).of_key(&entry.key));
        }
    }
    around(text, &sections, &parameters, inputs)
}

/// What a file states besides equations.
fn around(
    text: &str,
    sections: &Sections,
    parameters: &Parameters,
    inputs: Vec<inputs::Read<'_>>,
) -> Result<Statement, Fault> {
    let constants = parameters.meanings();
    let constants = Constants { names: &constants, lists: &parameters.lists };
    Ok(Statement {
        name: sections.name.clone(),
        series: series_column(&sections.series)?,
        time: sections.has_time.then(|| time::read(&sections.time, constants)).transpose()?,
        simulated: simulated(text, &inputs, constants)?,
        inputs: inputs.into_iter().map(|input| input.rule).collect(),
        parameters: parameters.values.clone(),
        lists: parameters.lists.clone(),
        priors: parameters.priors.clone(),
        ..Statement::default()
    })
}

/// The column that `[series]` names.
fn series_column(table: &Table) -> Result<Option<String>, Fault> {
    let mut column = None;
    for entry in table {
        if entry.key != "by" {
            let problem = Problem::UnknownKey { name: entry.key.clone(), advice: "it has by".to_string() };
            return Err(Fault::at(entry.key_at, problem).in_section(Section::Series));
        }
        let text = entry.value.text("by").map_err(|fault| fault.in_section(Section::Series))?;
        column = Some(text.trim().to_string());
    }
    Ok(column)
}

/// The inputs, whose names are names.
fn inputs_of<'t>(sections: &'t Sections, constants: Constants<'_>) -> Result<Vec<inputs::Read<'t>>, Fault> {
    let of = |entry: &'t Entry| {
        let fault = |problem| Fault::at(entry.key_at, problem).in_section(Section::Inputs).of_key(&entry.key);
        if !is_name(&entry.key) {
            return Err(fault(Problem::BadName(entry.key.clone())));
        }
        if let Some(what) = reserved(&entry.key) {
            return Err(fault(Problem::Reserved { name: entry.key.clone(), what }));
        }
        inputs::read(entry, constants)
    };
    sections.inputs.iter().map(of).collect()
}

/// How inputs are simulated.
fn simulated(
    text: &str,
    inputs: &[inputs::Read<'_>],
    constants: Constants<'_>,
) -> Result<(Vec<usize>, Vec<Line>), Fault> {
    let (mut numbers, mut keys) = (Vec::new(), Vec::new());
    for (number, input) in inputs.iter().enumerate() {
        if let Some(entry) = input.simulate {
            numbers.push(number);
            keys.push(Key::of_input(&input.rule.name, entry));
        }
    }
    let reader = lines::Reader { text, names: constants.names, totals: None };
    Ok((numbers, reader.lines(&keys, Section::Inputs)?))
}

/// What each name means; none can mean two things.
fn meanings(
    parameters: &Parameters,
    inputs: &[inputs::Read<'_>],
    [states, definitions, draws, measurements]: [&[Key<'_>]; 4],
) -> Result<BTreeMap<String, Meaning>, Fault> {
    let mut names = parameters.meanings();
    let mut sections: BTreeMap<String, Section> =
        names.keys().map(|name| (name.clone(), Section::Parameters)).collect();
    for (number, input) in inputs.iter().enumerate() {
        let name = &input.rule.name;
        if let Some(other) = sections.insert(name.clone(), Section::Inputs) {
            let problem = Problem::Twice { name: name.clone(), other: other.title() };
            return Err(Fault::new(problem).in_section(Section::Inputs).of_key(name));
        }
        names.insert(name.clone(), Meaning::Input(number));
    }
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
