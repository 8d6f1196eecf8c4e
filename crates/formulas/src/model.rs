//! A model of formulas.

use std::borrow::Cow;
use std::sync::Arc;

use motes_models::Step;

use crate::closed_form::{self, NoClosedForm};
use crate::error::{Fault, Section};
use crate::graph::build;
use crate::priors::Prior;
use crate::program::{Program, compile};
use crate::statement::{Line, Statement};
use crate::support::{Support, supports};
use crate::text::Text;

/// A state-space model whose equations were read from a file. A clone shares them.
///
/// All that follows from [`Equations`](motes_models::equations::Equations) is compiled once, in this crate. Who wants the formulas with scalars of their own asks for
/// [`FormulaModel::equations`].
#[derive(Debug, Clone)]
pub struct FormulaModel(pub(crate) Arc<Programs>);

/// The programs of a file's formulas.
#[derive(Debug)]
pub(crate) struct Programs {
    file: String,
    has_lines: bool,
    statement: Statement,
    pub(crate) states: usize,
    pub(crate) measurements: usize,
    pub(crate) initial: Program,
    pub(crate) transition: Program,
    pub(crate) measurement: Program,
    /// Where measurements can lie, if it is the same at all times.
    supports: Option<Vec<Option<Support>>>,
    closed_form: Result<(), NoClosedForm>,
    is_linear: bool,
    pub(crate) has_density: bool,
}

impl FormulaModel {
    /// Compiles the formulas of a file.
    pub(crate) fn new(statement: Statement, Text { file, has_lines }: Text<'_>) -> Result<Self, Fault> {
        let coordinates = |lines: &[Line]| lines.iter().map(Line::coordinates).sum();
        let states = coordinates(&statement.initial);
        let (mut closed_form, mut is_linear, mut has_density) = (Ok(()), true, true);
        let mut program = |section, lines: &[Line]| {
            let built = build(&statement, section)?;
            if closed_form.is_ok() {
                closed_form = closed_form::check(file, section, lines, &built);
            }
            is_linear &= closed_form::is_linear(section, &built);
            has_density &= section == Section::Measurement || closed_form::has_density(section, &built);
            Ok(compile(&built, states, section == Section::Initial))
        };
        let initial = program(Section::Initial, &statement.initial)?;
        let transition = program(Section::Transition, &statement.transition)?;
        let measurement = program(Section::Measurement, &statement.measurement)?;
        if let (Ok(()), Some(draw)) = (&closed_form, statement.draws.first()) {
            closed_form = Err(closed_form::of_draws(file, draw));
        }
        Ok(FormulaModel(Arc::new(Programs {
            states,
            measurements: coordinates(&statement.measurement),
            supports: (!measurement.depends_on_time()).then(|| supports(&measurement, [0.0; 2])),
            initial,
            transition,
            measurement,
            closed_form,
            is_linear,
            has_density,
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
            None => supports(&self.0.measurement, [step.time, step.length]).into(),
        }
    }

    /// The priors of its parameters, in the order of the file.
    pub fn priors(&self) -> &[Prior] {
        &self.statement().priors
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
