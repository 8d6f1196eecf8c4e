//! A coordinate's distribution, whose parameters are numbers of a graph.

use super::nodes::{Graph, Id};
use crate::operations::{Binary, Unary};
use crate::tables::{Family, Wrapper};

/// `shift + scale·x` of a distribution of `x`.
#[derive(Debug, Clone)]
pub(crate) struct Coordinate {
    pub(crate) family: &'static Family,
    pub(crate) parameters: Vec<Id>,
    pub(crate) scale: Option<Id>,
    pub(crate) shift: Option<Id>,
}

/// A distribution of a measurement that is made of others.
#[derive(Debug, Clone)]
pub(crate) struct Made {
    pub(crate) wrapper: &'static Wrapper,
    /// Its arguments that are numbers, in order.
    pub(crate) numbers: Vec<Id>,
    /// Its arguments that are distributions, in order.
    pub(crate) parts: Vec<Part>,
    /// Its log density, which depends on the measurement: a state behind the others.
    pub(crate) density: Option<Id>,
}

/// What a distribution of a measurement can be made of.
#[derive(Debug, Clone)]
pub(crate) enum Part {
    Plain(Coordinate),
    Made(Made),
}

impl Part {
    /// Its numbers but for log densities.
    pub(crate) fn numbers(&self) -> Vec<Id> {
        match self {
            Part::Plain(coordinate) => coordinate.numbers().collect(),
            Part::Made(made) => made.numbers(),
        }
    }
}

impl Made {
    /// Its numbers, and those of its parts, but for log densities.
    pub(crate) fn numbers(&self) -> Vec<Id> {
        self.numbers.iter().copied().chain(self.parts.iter().flat_map(Part::numbers)).collect()
    }

    /// Its log densities and those of its parts.
    pub(crate) fn densities(&self) -> Vec<Id> {
        let of_part = |part: &Part| match part {
            Part::Plain(_) => Vec::new(),
            Part::Made(made) => made.densities(),
        };
        self.density.into_iter().chain(self.parts.iter().flat_map(of_part)).collect()
    }
}

/// What a line says of a coordinate.
#[derive(Debug, Clone)]
pub(crate) enum Output {
    /// It is drawn.
    Drawn(Coordinate),
    /// It is a measurement whose distribution is made of others.
    Made(Made),
    /// It follows, without noise.
    Follows(Id),
    /// It is computed of what is drawn for it.
    Computed {
        coordinate: Coordinate,
        /// What is drawn.
        drawn: Id,
        value: Id,
        /// What it chooses among, in proportion to these numbers.
        shares: Vec<Id>,
    },
}

impl From<Part> for Output {
    fn from(part: Part) -> Output {
        match part {
            Part::Plain(coordinate) => Output::Drawn(coordinate),
            Part::Made(made) => Output::Made(made),
        }
    }
}

impl Output {
    /// Its log densities that depend on the measurement.
    pub(crate) fn densities(&self) -> Vec<Id> {
        match self {
            Output::Made(made) => made.densities(),
            Output::Drawn(_) | Output::Follows(_) | Output::Computed { .. } => Vec::new(),
        }
    }

    /// Its numbers, those that it has, but for log densities.
    pub(crate) fn numbers(&self) -> impl Iterator<Item = Id> {
        let (made, follows) = match self {
            Output::Drawn(_) => (Vec::new(), None),
            Output::Made(made) => (made.numbers(), None),
            Output::Follows(value) => (Vec::new(), Some(*value)),
            Output::Computed { value, shares, .. } => (shares.clone(), Some(*value)),
        };
        self.drawn_from().into_iter().flat_map(Coordinate::numbers).chain(made).chain(follows)
    }

    /// The number that it is, where nothing is drawn.
    pub(super) fn value(&self) -> Option<Id> {
        match self {
            Output::Follows(value) => Some(*value),
            Output::Drawn(_) | Output::Made(_) | Output::Computed { .. } => None,
        }
    }

    /// The distribution that something is drawn from for it, if something is.
    pub(crate) fn drawn_from(&self) -> Option<&Coordinate> {
        match self {
            Output::Drawn(coordinate) | Output::Computed { coordinate, .. } => Some(coordinate),
            Output::Follows(_) | Output::Made(_) => None,
        }
    }

    /// Its distribution, if it is drawn itself.
    pub(crate) fn drawn(&self) -> Option<&Coordinate> {
        match self {
            Output::Drawn(coordinate) => Some(coordinate),
            Output::Made(_) | Output::Follows(_) | Output::Computed { .. } => None,
        }
    }
}

impl Coordinate {
    pub(super) fn new(family: &'static Family, parameters: Vec<Id>) -> Self {
        Coordinate { family, parameters, scale: None, shift: None }
    }

    /// Adds a number.
    pub(super) fn add(&mut self, graph: &mut Graph, by: Id) {
        self.shift = Some(match self.shift {
            Some(shift) => graph.of_two(Binary::Add, shift, by),
            None => by,
        });
    }

    /// Subtracts a number.
    pub(super) fn subtract(&mut self, graph: &mut Graph, by: Id) {
        self.shift = Some(match self.shift {
            Some(shift) => graph.of_two(Binary::Subtract, shift, by),
            None => graph.of_one(Unary::Negative, by),
        });
    }

    /// Changes the sign.
    pub(super) fn negate(&mut self, graph: &mut Graph) {
        self.scale = Some(match self.scale {
            Some(scale) => graph.of_one(Unary::Negative, scale),
            None => graph.constant(-1.0),
        });
        self.shift = self.shift.map(|shift| graph.of_one(Unary::Negative, shift));
    }

    /// Multiplies by a number.
    pub(super) fn multiply(&mut self, graph: &mut Graph, by: Id) {
        self.scale = Some(match self.scale {
            Some(scale) => graph.of_two(Binary::Multiply, scale, by),
            None => by,
        });
        self.shift = self.shift.map(|shift| graph.of_two(Binary::Multiply, shift, by));
    }

    /// Divides by a number.
    pub(super) fn divide(&mut self, graph: &mut Graph, by: Id) {
        let scale = self.scale.unwrap_or_else(|| graph.constant(1.0));
        self.scale = Some(graph.of_two(Binary::Divide, scale, by));
        self.shift = self.shift.map(|shift| graph.of_two(Binary::Divide, shift, by));
    }

    /// Takes shift and scale into the parameters, where the family has such.
    pub(super) fn settle(&mut self, graph: &mut Graph) {
        let Some(location) = self.family.location else { return };
        let [mut at, mut width] = [self.parameters[location], self.parameters[location + 1]];
        if let Some(scale) = self.scale.take() {
            at = graph.of_two(Binary::Multiply, at, scale);
            let size = graph.of_one(Unary::Abs, scale);
            width = graph.of_two(Binary::Multiply, width, size);
        }
        if let Some(shift) = self.shift.take() {
            // 0 + x is x.
            at = if graph.value(at) == Some(0.0) { shift } else { graph.of_two(Binary::Add, at, shift) };
        }
        self.parameters[location] = at;
        self.parameters[location + 1] = width;
    }

    /// Its numbers, those that it has.
    pub(crate) fn numbers(&self) -> impl Iterator<Item = Id> {
        self.parameters.iter().copied().chain(self.scale).chain(self.shift)
    }
}
