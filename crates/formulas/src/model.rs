//! A model of formulas.

use std::sync::Arc;

use motes_models::equations::{Coordinates, Equations, Scalar};

use crate::error::{Fault, Section};
use crate::graph::build;
use crate::program::{Program, compile};
use crate::statement::{Line, Statement};

/// A state-space model whose equations were read from a file: see [`Equations`] for what follows from them.
#[derive(Debug, Clone)]
pub struct FormulaModel {
    pub(crate) statement: Arc<Statement>,
    states: usize,
    measurements: usize,
    initial: Program,
    transition: Program,
    measurement: Program,
}

impl FormulaModel {
    pub(crate) fn new(statement: Statement) -> Result<Self, Fault> {
        let coordinates = |lines: &[Line]| lines.iter().map(Line::coordinates).sum();
        let states = coordinates(&statement.initial);
        let program =
            |section, lines: &[Line]| build(&statement, section, lines).map(|built| compile(&built, states));
        Ok(FormulaModel {
            states,
            measurements: coordinates(&statement.measurement),
            initial: program(Section::Initial, &statement.initial)?,
            transition: program(Section::Transition, &statement.transition)?,
            measurement: program(Section::Measurement, &statement.measurement)?,
            statement: Arc::new(statement),
        })
    }
}

impl Equations for FormulaModel {
    fn dimensions(&self) -> [usize; 2] {
        [self.states, self.measurements]
    }

    fn initial<S: Scalar>(&self, state: &mut impl Coordinates<S>) {
        self.initial.push(0, &[], state);
    }

    fn transition<S: Scalar>(&self, time: usize, previous: &[S], state: &mut impl Coordinates<S>) {
        self.transition.push(time, previous, state);
    }

    fn measurement<S: Scalar>(&self, time: usize, state: &[S], measurement: &mut impl Coordinates<S>) {
        self.measurement.push(time, state, measurement);
    }
}
