//! What a model has besides its equations: times, inputs, parameters, and what tells series apart.

use std::sync::Arc;

use motes_models::equations::{Distribution, Draws};
use motes_models::{Step, Stream};

use crate::document;
use crate::error::{Fault, FileError, Section};
use crate::graph::build;
use crate::priors::Prior;
use crate::program::{Program, compile};
use crate::schedule::MOST_SUB_STEPS;
use crate::statement::{self, InputRule, Statement, TimeRule};

/// Where equations of states use an input.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct InputUse {
    /// In `[initial]`.
    pub initial: bool,
    /// In `[draws]` or `[transition]`.
    pub transition: bool,
}

/// What must be known where an entry of the measurement is there.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub(crate) struct EntryNeeds {
    /// Whether it is of what came since the row before.
    pub(crate) step: bool,
    /// The inputs that it depends on.
    pub(crate) inputs: Vec<u32>,
}

impl EntryNeeds {
    fn has(&self, input: usize) -> bool {
        self.inputs.iter().any(|used| *used as usize == input)
    }
}

/// What a model has besides its equations: how rows are spaced, inputs, parameters with their priors, and the column that tells series apart. A clone shares it.
#[derive(Debug, Clone)]
pub struct Frame(Arc<Contents>);

#[derive(Debug)]
struct Contents {
    series: Option<String>,
    time: Option<TimeRule>,
    inputs: Vec<InputRule>,
    /// Where equations of states use each input.
    uses: Vec<InputUse>,
    /// Of functions nobody knows what they use.
    is_of_functions: bool,
    resets: Vec<usize>,
    /// What each entry of a measurement needs.
    entries: Vec<EntryNeeds>,
    /// The numbers of the inputs that are simulated, and how.
    simulated: (Vec<usize>, Program),
    parameters: Vec<(String, f64)>,
    priors: Vec<Prior>,
}

impl Contents {
    fn of(statement: &Statement, uses: Vec<InputUse>, entries: Vec<EntryNeeds>) -> Result<Self, Fault> {
        let simulated = compile(&build(statement, Section::Inputs)?, 0, false);
        Ok(Contents {
            series: statement.series.clone(),
            time: statement.time.clone(),
            inputs: statement.inputs.clone(),
            uses,
            is_of_functions: false,
            resets: statement.resets(),
            entries,
            simulated: (statement.simulated.0.clone(), simulated),
            parameters: statement.parameters.clone(),
            priors: statement.priors.clone(),
        })
    }
}

/// Samples draws.
struct Drawn<'a> {
    stream: &'a mut Stream,
}

impl Draws<f64> for Drawn<'_> {
    fn draw(&mut self, distribution: Distribution<f64>) -> f64 {
        distribution.sample(self.stream)
    }
}

impl Frame {
    /// That of a file of formulas, which use each input there.
    pub(crate) fn of(
        statement: &Statement,
        uses: Vec<InputUse>,
        entries: Vec<EntryNeeds>,
    ) -> Result<Self, Fault> {
        Ok(Frame(Arc::new(Contents::of(statement, uses, entries)?)))
    }

    /// That of a text with no other sections than `[time]`, `[inputs]`, `[parameters]` and `[series]`, for a model whose equations are functions: each may use any input. `names` are those
    /// of states and measurements, which nothing else has; errors call the text `name`, and `overrides` replace the values of parameters.
    ///
    /// ```
    /// use motes_formulas::Frame;
    ///
    /// let text = "[inputs]\nu = \"hold\"\n[parameters]\nq = \"half_normal(1)\"\n";
    /// let frame = Frame::parse(text, "walk", ["x", "y"], &[("q".into(), 0.5)])?;
    /// assert_eq!((frame.inputs().len(), frame.parameters()), (1, &[("q".to_string(), 0.5)][..]));
    /// assert!(Frame::parse("[initial]\nx = 1\n", "walk", ["x", "y"], &[]).is_err());
    /// # Ok::<(), motes_formulas::FileError>(())
    /// ```
    ///
    /// # Errors
    /// [`FileError::Refused`] for another section, for what is wrong in one of these, and for an override that is no parameter.
    pub fn parse<'n>(
        text: &str,
        name: &str,
        names: impl IntoIterator<Item = &'n str>,
        overrides: &[(String, f64)],
    ) -> Result<Self, FileError> {
        let names: Vec<&str> = names.into_iter().collect();
        let read = document::read(text)
            .and_then(|table| Frame::of_functions(&statement::read_frame(text, &table, &names, overrides)?));
        // Nobody sees the lines of a text that a program wrote.
        read.map_err(|fault| Fault { at: None, ..fault }.in_file(name, text))
    }

    fn of_functions(statement: &Statement) -> Result<Self, Fault> {
        let uses = vec![InputUse { initial: false, transition: true }; statement.inputs.len()];
        let contents = Contents::of(statement, uses, Vec::new())?;
        Ok(Frame(Arc::new(Contents { is_of_functions: true, ..contents })))
    }

    /// The column of data that tells series apart, if one is named; else it is `series`.
    pub fn series_column(&self) -> Option<&str> {
        self.0.series.as_deref()
    }

    /// How the rows of data are spaced, if that is said.
    pub fn time_rule(&self) -> Option<&TimeRule> {
        self.0.time.as_ref()
    }

    /// Whether a step between two rows can have several sub-steps.
    pub fn has_sub_steps(&self) -> bool {
        self.time_rule().is_some_and(|time| time.step.is_some())
    }

    /// How many sub-steps a gap of 1 has.
    pub fn sub_steps_of_unit(&self) -> usize {
        let unit = self.time_rule().map_or(1.0, |time| time.sub_steps(1.0));
        unit.min(MOST_SUB_STEPS as f64) as usize
    }

    /// The inputs that data have, in the order of a step's. Behind them a step has one for each entry of [`Frame::resets`].
    pub fn inputs(&self) -> &[InputRule] {
        &self.0.inputs
    }

    /// `U`, the number of inputs of a sub-step: [`Frame::inputs`] and [`Frame::resets`].
    pub fn input_dim(&self) -> usize {
        self.0.inputs.len() + self.0.resets.len()
    }

    /// The entries of a measurement of which a step says whether they were there at the row before: 1 where they were, and else 0.
    pub fn resets(&self) -> &[usize] {
        &self.0.resets
    }

    /// Where equations of states use an input.
    pub fn input_use(&self, input: usize) -> InputUse {
        self.0.uses.get(input).copied().unwrap_or_default()
    }

    /// Whether equations are functions: those of `x_0` are then given each input that is known, and NaN for others.
    pub fn is_of_functions(&self) -> bool {
        self.0.is_of_functions
    }

    /// Whether an entry of the measurement is made of what came since the row before, so that there must be a step before it.
    pub fn needs_step(&self, entry: usize) -> bool {
        self.0.entries.get(entry).is_some_and(|needs| needs.step)
    }

    /// Whether an input must be known where an entry of the measurement is there. Functions may use any.
    pub fn needs_input(&self, entry: usize, input: usize) -> bool {
        self.0.is_of_functions || self.0.entries.get(entry).is_some_and(|needs| needs.has(input))
    }

    /// Whether any entry of the measurement needs an input.
    pub fn is_measured_by(&self, input: usize) -> bool {
        self.0.is_of_functions || self.0.entries.iter().any(|needs| needs.has(input))
    }

    /// Draws the inputs that are simulated, for a step that ends at a time: their numbers, and values.
    pub fn simulate_inputs(&self, time: f64, stream: &mut Stream) -> Vec<(usize, f64)> {
        let (numbers, program) = &self.0.simulated;
        let mut values = vec![0.0; numbers.len()];
        program.make(&Step { time, ..Step::of_index(0) }, &[], &mut Drawn { stream }, &mut values);
        numbers.iter().copied().zip(values).collect()
    }

    /// The parameters with their values, lists entry by entry.
    pub fn parameters(&self) -> &[(String, f64)] {
        &self.0.parameters
    }

    /// The priors of parameters that have one, in the order of the file.
    pub fn priors(&self) -> &[Prior] {
        &self.0.priors
    }
}
