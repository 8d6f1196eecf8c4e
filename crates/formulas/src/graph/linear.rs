//! How numbers of a graph depend on the states.

use super::nodes::{Graph, Operation};
use crate::operations::{Binary, Unary};

/// How a number depends on the states.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Degree {
    /// Not at all.
    Zero,
    /// Linearly.
    One,
    /// In another way.
    Other,
}

impl Graph {
    /// The degree of each number.
    pub(crate) fn degrees(&self) -> Vec<Degree> {
        let mut degrees: Vec<Degree> = Vec::with_capacity(self.operations().len());
        for operation in self.operations() {
            let degree = match *operation {
                Operation::Constant(_)
                | Operation::Time
                | Operation::Length
                | Operation::Input(_)
                | Operation::First => Degree::Zero,
                Operation::State(_) => Degree::One,
                Operation::Drawn(_) => Degree::Other,
                Operation::OfOne(Unary::Negative, a) => degrees[a.index()],
                Operation::OfOne(_, a) | Operation::Integer(a, _) => other(degrees[a.index()]),
                // Whichever of two is known without states.
                Operation::If(c, a, b) if degrees[c.index()] == Degree::Zero => {
                    degrees[a.index()].max(degrees[b.index()])
                }
                Operation::If(_, _, _) => Degree::Other,
                Operation::OfTwo(operation, a, b) => {
                    let (a, b) = (degrees[a.index()], degrees[b.index()]);
                    match (operation, a.min(b)) {
                        (Binary::Add | Binary::Subtract, _) => a.max(b),
                        (Binary::Multiply, Degree::Zero) => a.max(b),
                        (Binary::Divide, _) if b == Degree::Zero => a,
                        _ => other(a.max(b)),
                    }
                }
            };
            degrees.push(degree);
        }
        degrees
    }
}

/// That of a function of a number.
fn other(degree: Degree) -> Degree {
    if degree == Degree::Zero { Degree::Zero } else { Degree::Other }
}
