//! A coordinate's distribution, whose parameters are numbers of a graph.

use super::nodes::{Graph, Id};
use crate::operations::{Binary, Unary};
use crate::tables::Family;

/// `shift + scale·x` of a distribution of `x`.
#[derive(Debug, Clone)]
pub(crate) struct Coordinate {
    pub(crate) family: &'static Family,
    pub(crate) parameters: Vec<Id>,
    pub(crate) scale: Option<Id>,
    pub(crate) shift: Option<Id>,
}

/// What a line says of a coordinate.
#[derive(Debug, Clone)]
pub(crate) enum Output {
    /// It is drawn.
    Drawn(Coordinate),
    /// It follows, without noise.
    Follows(Id),
    /// It is computed of what is drawn for it.
    Computed {
        coordinate: Coordinate,
        /// What is drawn.
        drawn: Id,
        value: Id,
    },
}

impl Output {
    /// Its numbers, those that it has.
    pub(crate) fn numbers(&self) -> impl Iterator<Item = Id> {
        let follows = match self {
            Output::Drawn(_) => None,
            Output::Follows(value) | Output::Computed { value, .. } => Some(*value),
        };
        self.drawn_from().into_iter().flat_map(Coordinate::numbers).chain(follows)
    }

    /// The number that it is, where nothing is drawn.
    pub(super) fn value(&self) -> Option<Id> {
        match self {
            Output::Follows(value) => Some(*value),
            Output::Drawn(_) | Output::Computed { .. } => None,
        }
    }

    /// The distribution that something is drawn from for it, if something is.
    pub(crate) fn drawn_from(&self) -> Option<&Coordinate> {
        match self {
            Output::Drawn(coordinate) | Output::Computed { coordinate, .. } => Some(coordinate),
            Output::Follows(_) => None,
        }
    }

    /// Its distribution, if it is drawn itself.
    pub(crate) fn drawn(&self) -> Option<&Coordinate> {
        match self {
            Output::Drawn(coordinate) => Some(coordinate),
            Output::Follows(_) | Output::Computed { .. } => None,
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
