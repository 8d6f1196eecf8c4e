//! A model of formulas.

use std::borrow::Cow;
use std::ops::Range;
use std::sync::Arc;

use motes_models::equations::{Coordinates, Equations, Scalar};

use crate::closed_form::{self, NoClosedForm};
use crate::error::{Fault, Section};
use crate::graph::build;
use crate::program::{Program, compile};
use crate::statement::{Line, Statement};
use crate::support::{Support, supports};
use crate::text::Text;
use motes_models::Step;

/// A state-space model whose equations were read from a file: see [`Equations`] for what follows from them. A clone shares them.
#[derive(Debug, Clone)]
pub struct FormulaModel(Arc<Compiled>);

#[derive(Debug)]
struct Compiled {
    file: String,
    has_lines: bool,
    statement: Statement,
    states: usize,
    measurements: usize,
    initial: Program,
    transition: Program,
    measurement: Program,
    /// Where measurements can lie, if it is the same at all times.
    supports: Option<Vec<Option<Support>>>,
    closed_form: Result<(), NoClosedForm>,
    is_linear: bool,
}

impl FormulaModel {
    /// Compiles the formulas of a file.
    pub(crate) fn new(statement: Statement, Text { file, has_lines }: Text<'_>) -> Result<Self, Fault> {
        let coordinates = |lines: &[Line]| lines.iter().map(Line::coordinates).sum();
        let states = coordinates(&statement.initial);
        let (mut closed_form, mut is_linear) = (Ok(()), true);
        let mut program = |section, lines: &[Line]| {
            let built = build(&statement, section, lines)?;
            if closed_form.is_ok() {
                closed_form = closed_form::check(file, section, lines, &built);
            }
            is_linear &= closed_form::is_linear(&built);
            Ok(compile(&built, states))
        };
        let initial = program(Section::Initial, &statement.initial)?;
        let transition = program(Section::Transition, &statement.transition)?;
        let measurement = program(Section::Measurement, &statement.measurement)?;
        Ok(FormulaModel(Arc::new(Compiled {
            states,
            measurements: coordinates(&statement.measurement),
            supports: (!measurement.depends_on_time()).then(|| supports(&measurement, 0.0)),
            initial,
            transition,
            measurement,
            closed_form,
            is_linear,
            file: file.to_string(),
            has_lines,
            statement,
        })))
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
            None => supports(&self.0.measurement, step.time).into(),
        }
    }

    /// Whether all of it is linear with constant Gaussian noise.
    pub(crate) fn is_linear(&self) -> bool {
        self.0.is_linear
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

impl Equations for FormulaModel {
    fn dimensions(&self) -> [usize; 2] {
        [self.0.states, self.0.measurements]
    }

    fn initial<S: Scalar>(&self, state: &mut impl Coordinates<S>) {
        self.0.initial.push(0.0, &[], state);
    }

    fn transition<S: Scalar>(&self, step: &Step<'_, S>, previous: &[S], state: &mut impl Coordinates<S>) {
        self.0.transition.push(step.time, previous, state);
    }

    fn measurement<S: Scalar>(&self, step: &Step<'_, S>, state: &[S], measurement: &mut impl Coordinates<S>) {
        self.0.measurement.push(step.time, state, measurement);
    }

    fn measurement_along<S: Scalar>(
        &self,
        step: &Step<'_, S>,
        state: &[S],
        along: Range<usize>,
        measurement: &mut impl Coordinates<S>,
    ) {
        self.0.measurement.push_along(step.time, state, along, measurement);
    }
}
