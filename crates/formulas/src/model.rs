//! A model of formulas.

use std::borrow::Cow;
use std::sync::Arc;

use motes_models::equations::{Distribution, Draws};
use motes_models::{Step, Stream};

use crate::closed_form::{self, NoClosedForm};
use crate::error::{Fault, Section};
use crate::graph::build;
use crate::priors::Prior;
use crate::program::{Program, compile};
use crate::schedule::{MOST_SUB_STEPS, Schedule};
use crate::statement::{InputRule, Line, Statement, TimeRule};
use crate::support::{Support, supports};
use crate::text::Text;

/// A state-space model whose equations were read from a file. A clone shares them.
///
/// All that follows from [`Equations`](motes_models::equations::Equations) is compiled once, in this crate. Who wants the formulas with scalars of their own asks for
/// [`FormulaModel::equations`].
#[derive(Debug, Clone)]
pub struct FormulaModel(pub(crate) Arc<Programs>, pub(crate) Option<Arc<Schedule>>);

/// Where formulas use an input.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct InputUse {
    /// In `[initial]`.
    pub initial: bool,
    /// In `[draws]` or `[transition]`.
    pub transition: bool,
    /// In `[measurement]`.
    pub measurement: bool,
}

impl InputUse {
    fn of_mut(&mut self, section: Section) -> &mut bool {
        match section {
            Section::Initial => &mut self.initial,
            Section::Measurement => &mut self.measurement,
            _ => &mut self.transition,
        }
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

/// The programs of a file's formulas.
#[derive(Debug)]
pub(crate) struct Programs {
    file: String,
    has_lines: bool,
    statement: Statement,
    pub(crate) states: usize,
    /// As many as there are: no number, so that none can be forgotten.
    pub(crate) inputs: Vec<f64>,
    /// How many sub-steps a gap of 1 has.
    pub(crate) sub_steps_of_unit: usize,
    /// Where formulas use each input.
    uses: Vec<InputUse>,
    /// Whether an entry of a measurement is of what came since the row before.
    needs_step: Vec<bool>,
    simulated: Program,
    pub(crate) measurements: usize,
    pub(crate) initial: Program,
    pub(crate) transition: Program,
    pub(crate) measurement: Program,
    /// Where measurements can lie, if it is the same at all times.
    supports: Option<Vec<Option<Support>>>,
    closed_form: Result<(), NoClosedForm>,
    is_linear: bool,
    is_finite: bool,
    pub(crate) has_density: bool,
    /// The first entry of a measurement that is without error.
    exact_entry: Option<usize>,
}

impl FormulaModel {
    /// Compiles the formulas of a file.
    pub(crate) fn new(statement: Statement, Text { file, has_lines }: Text<'_>) -> Result<Self, Fault> {
        let coordinates = |lines: &[Line]| lines.iter().map(Line::coordinates).sum();
        let states = statement.dimension();
        let inputs = statement.inputs.len() + statement.resets().len();
        let mut uses = vec![InputUse::default(); inputs];
        let (mut closed_form, mut is_linear, mut has_density) = (Ok(()), true, true);
        let (mut exact_entry, mut is_finite) = (None, true);
        let mut program = |section, lines: &[Line]| {
            let built = build(&statement, section)?;
            if closed_form.is_ok() {
                closed_form = closed_form::check(file, section, lines, &built);
            }
            is_linear &= closed_form::is_linear(&built);
            match section {
                Section::Measurement => exact_entry = closed_form::without_noise(&built),
                _ => is_finite &= closed_form::is_finite(&built),
            }
            for (number, input) in uses.iter_mut().enumerate() {
                *input.of_mut(section) |= built.inputs().contains(&(number as u32));
            }
            has_density &= section == Section::Measurement || closed_form::has_density(section, &built);
            Ok(compile(&built, states, section == Section::Initial))
        };
        let initial = program(Section::Initial, &statement.initial)?;
        let transition = program(Section::Transition, &statement.transition)?;
        let measurement = program(Section::Measurement, &statement.measurement)?;
        if let (Ok(()), Some(draw)) = (&closed_form, statement.draws.first()) {
            closed_form = Err(closed_form::of_draws(file, draw));
        }
        let has_sub_steps = statement.time.as_ref().is_some_and(|time| time.step.is_some());
        if let (Ok(()), Some(line), true) = (&closed_form, statement.transition.first(), has_sub_steps) {
            closed_form = Err(closed_form::of_sub_steps(file, line));
        }
        let simulated = compile(&build(&statement, Section::Inputs)?, 0, false);
        let unit = statement.time.as_ref().map_or(1.0, |time| time.sub_steps(1.0));
        let known: usize = statement.initial.iter().map(Line::coordinates).sum();
        Ok(FormulaModel(
            Arc::new(Programs {
                states,
                inputs: vec![f64::NAN; inputs],
                sub_steps_of_unit: unit.min(MOST_SUB_STEPS as f64) as usize,
                uses,
                needs_step: measurement.depend_on_states_from(known),
                simulated,
                measurements: coordinates(&statement.measurement),
                supports: (!measurement.depends_on_step())
                    .then(|| supports(&measurement, &Step::of_index(0))),
                initial,
                transition,
                measurement,
                closed_form,
                is_linear,
                is_finite,
                has_density: has_density && !has_sub_steps,
                exact_entry,
                file: file.to_string(),
                has_lines,
                statement,
            }),
            None,
        ))
    }

    /// The same model with the steps of a sequence: its own from then on, where nobody gives others.
    #[must_use]
    pub fn along(&self, schedule: Schedule) -> Self {
        FormulaModel(Arc::clone(&self.0), Some(Arc::new(schedule)))
    }

    /// The column of data that tells series apart, if the file names one; else it is `series`.
    pub fn series_column(&self) -> Option<&str> {
        self.0.statement.series.as_deref()
    }

    /// How the rows of data are spaced, if the file says so.
    pub fn time_rule(&self) -> Option<&TimeRule> {
        self.0.statement.time.as_ref()
    }

    /// The inputs that data have, in the order of a step's. Behind them a step has one for each entry of [`FormulaModel::resets`].
    pub fn inputs(&self) -> &[InputRule] {
        &self.0.statement.inputs
    }

    /// The entries of a measurement of which a step says whether they were there at the row before: 1 where they were, and else 0.
    pub fn resets(&self) -> Vec<usize> {
        self.0.statement.resets()
    }

    /// Where formulas use an input.
    pub fn input_use(&self, input: usize) -> InputUse {
        self.0.uses.get(input).copied().unwrap_or_default()
    }

    /// Whether an entry of the measurement is made of what came since the row before, so that there must be a step before it.
    pub fn needs_step(&self, entry: usize) -> bool {
        self.0.needs_step.get(entry).copied().unwrap_or_default()
    }

    /// Draws the inputs that are simulated, for a step that ends at a time: their numbers, and values.
    pub fn simulate_inputs(&self, time: f64, stream: &mut Stream) -> Vec<(usize, f64)> {
        let mut drawn = Drawn { stream };
        let lines = self.0.statement.simulated.0.len();
        let mut unused = vec![0.0; lines];
        self.0.simulated.make(&Step { time, ..Step::of_index(0) }, &[], &mut drawn, &mut unused);
        self.0.statement.simulated.0.iter().copied().zip(unused).collect()
    }

    /// What the file states.
    pub(crate) fn statement(&self) -> &Statement {
        &self.0.statement
    }

    /// The file's name.
    pub(crate) fn file(&self) -> &str {
        &self.0.file
    }

    /// Whether errors say in which line something stands.
    pub(crate) fn has_lines(&self) -> bool {
        self.0.has_lines
    }

    /// Where each of the `M` entries of a measurement can lie at a time, whatever the states are; none where it depends on them, or where it can be any number.
    pub fn supports(&self, step: &Step<'_>) -> Cow<'_, [Option<Support>]> {
        match &self.0.supports {
            Some(supports) => supports.into(),
            None => supports(&self.0.measurement, &step.end(self.0.inputs.len())).into(),
        }
    }

    /// The priors of its parameters, in the order of the file.
    pub fn priors(&self) -> &[Prior] {
        &self.statement().priors
    }

    /// The first entry of a measurement that is without error, so that no particle meets it: only exact filters take it.
    pub fn measured_exactly(&self) -> Option<usize> {
        self.0.exact_entry
    }

    /// Whether `p(x_t | x_{t−1})` and `p(y_t | x_t)` are the same in all steps, as long as these have no sub-steps.
    pub fn is_time_invariant(&self) -> bool {
        !self.0.transition.depends_on_step() && !self.0.measurement.depends_on_step()
    }

    /// Whether all of it is linear with Gaussian noise.
    pub(crate) fn is_linear(&self) -> bool {
        self.0.is_linear
    }

    /// Whether all that states are made of is drawn from distributions of finitely many values.
    pub(crate) fn is_finite(&self) -> bool {
        self.0.is_finite
    }

    /// Whether `p(x_t | x_{t−1}, y_t)` is Gaussian: `p(x_0)` and `p(x_t | x_{t−1})` are normal, and `p(y_t | x_t)` is normal with a mean that is linear in the
    /// states, and a standard deviation without them.
    ///
    /// # Errors
    /// [`NoClosedForm`] names the first line that is otherwise.
    pub fn closed_form(&self) -> Result<(), NoClosedForm> {
        let without_line = |error: &NoClosedForm| NoClosedForm {
            line: error.line.filter(|_| self.0.has_lines),
            ..error.clone()
        };
        self.0.closed_form.as_ref().copied().map_err(without_line)
    }
}
