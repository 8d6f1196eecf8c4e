//! A model of formulas.

use std::borrow::Cow;
use std::sync::{Arc, OnceLock};

use motes_models::Step;
use motes_models::equations::Draw;

use crate::closed_form::{self, NoClosedForm};
use crate::error::{Fault, Section};
use crate::frame::{EntryNeeds, Frame, InputUse};
use crate::graph::build;
use crate::program::{Program, compile};
use crate::schedule::Schedule;
use crate::statement::{Line, Statement};
use crate::support::{Support, supports};
use crate::text::Text;

/// A state-space model whose equations were read from a file. A clone shares them.
///
/// All that follows from [`Equations`](motes_models::equations::Equations) is compiled once, in this crate. Who wants the formulas with scalars of their own asks for
/// [`FormulaModel::equations`].
#[derive(Debug, Clone)]
pub struct FormulaModel(pub(crate) Arc<Programs>, pub(crate) Option<Arc<Schedule>>);

/// The programs of a file's formulas.
#[derive(Debug)]
pub(crate) struct Programs {
    file: String,
    has_lines: bool,
    statement: Statement,
    pub(crate) states: usize,
    /// As many as there are: no number, so that none can be forgotten.
    pub(crate) inputs: Vec<f64>,
    frame: Frame,
    pub(crate) measurements: usize,
    pub(crate) initial: Program,
    pub(crate) transition: Program,
    pub(crate) measurement: Program,
    /// For each parameter that particles have of their own, whether `x_0` alone depends on it.
    only_initial: Vec<bool>,
    /// Where measurements can lie, if it is the same at all times.
    supports: Option<Vec<Option<Support>>>,
    closed_form: Result<(), NoClosedForm>,
    is_linear: bool,
    is_finite: bool,
    pub(crate) has_density: bool,
    /// The first entry of a measurement that is without error.
    exact_entry: Option<usize>,
    /// The draws of the start, and of each sub-step, when they were asked for: no state, time or input changes them.
    pub(crate) draws: [OnceLock<Vec<Draw>>; 2],
}

impl Programs {
    /// Whether particles have parameters of their own.
    pub(crate) fn has_parameters_of_particles(&self) -> bool {
        !self.only_initial.is_empty()
    }
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
        let mut inputs_of_entries = Vec::new();
        let first_parameter = statement.first_parameter();
        let mut only_initial = vec![true; states - first_parameter];
        let mut program = |section, lines: &[Line]| {
            let built = build(&statement, section)?;
            if closed_form.is_ok() {
                closed_form = closed_form::check(file, section, lines, &built);
            }
            is_linear &= closed_form::is_linear(&built);
            match section {
                Section::Measurement => {
                    exact_entry = closed_form::without_noise(&built);
                    inputs_of_entries = built.inputs_of_coordinates();
                }
                _ => {
                    is_finite &= closed_form::is_finite(&built);
                    for number in built.inputs() {
                        let InputUse { initial, transition } = &mut uses[number as usize];
                        *(if section == Section::Initial { initial } else { transition }) = true;
                    }
                }
            }
            if section != Section::Initial && !only_initial.is_empty() {
                // Of a transition those behind are the parameters themselves.
                let end = if section == Section::Transition { first_parameter } else { usize::MAX };
                let states = built.states_before(end).into_iter().map(|state| state as usize);
                for number in states.filter_map(|state| state.checked_sub(first_parameter)) {
                    // Draws stand behind them.
                    if let Some(is_only_initial) = only_initial.get_mut(number) {
                        *is_only_initial = false;
                    }
                }
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
        let known: usize = statement.initial.iter().map(Line::coordinates).sum();
        let need_step = measurement.depend_on_states_from(known).into_iter();
        let entries = need_step.zip(inputs_of_entries).map(|(step, inputs)| EntryNeeds { step, inputs });
        let frame = Frame::of(&statement, uses, entries.collect())?;
        let has_sub_steps = frame.has_sub_steps();
        if let (Ok(()), Some(line), true) = (&closed_form, statement.transition.first(), has_sub_steps) {
            closed_form = Err(closed_form::of_sub_steps(file, line));
        }
        Ok(FormulaModel(
            Arc::new(Programs {
                states,
                inputs: vec![f64::NAN; inputs],
                frame,
                measurements: coordinates(&statement.measurement),
                supports: (!measurement.depends_on_step())
                    .then(|| supports(&measurement, &Step::of_index(0))),
                initial,
                transition,
                measurement,
                only_initial,
                closed_form,
                is_linear,
                is_finite,
                has_density: has_density && !has_sub_steps,
                exact_entry,
                draws: Default::default(),
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

    /// Its times, inputs and parameters.
    pub fn frame(&self) -> &Frame {
        &self.0.frame
    }

    /// For each parameter that particles have of their own ([`crate::ModelFile::with_parameters_of_particles`]), whether `x_0` alone depends on it.
    pub fn only_initial(&self) -> &[bool] {
        &self.0.only_initial
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
