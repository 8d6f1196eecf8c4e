//! Why a formula gives no number: which operation left its domain, and at which values.

mod distribution;
mod domain_error;
mod evaluate;
mod trace;

pub use domain_error::DomainError;

use evaluate::{Place, Point};
use trace::Origin;

use motes_models::Step;
use motes_models::equations::{LARGEST_BINOMIAL, LARGEST_POISSON};

use crate::error::Section;
use crate::model::FormulaModel;
use crate::operations::Binary;
use crate::statement::Line;
use crate::syntax::{Formula, Node, NodeId};
use crate::tables::{Argument, Composition, Kind, MOST_OFF, Range, Wrapper, Wrapping};

/// How a number can be out of range.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Fault {
    /// NaN, or a number that a distribution does not take: draws and densities are NaN.
    NotANumber,
    /// A parameter for which counts are larger than floating point has them: draws are NaN.
    Uncountable,
    /// Infinite.
    Infinite,
}

impl Fault {
    fn is_in(self, value: f64, range: Range) -> bool {
        match self {
            Fault::NotANumber => !value.is_infinite() && !range.has(value),
            Fault::Uncountable => false,
            Fault::Infinite => value.is_infinite(),
        }
    }
}

/// Which parameter of a family says how large its counts are, and the largest for which they are drawn.
fn largest(kind: Kind) -> Option<(usize, f64)> {
    match kind {
        Kind::Poisson | Kind::NegativeBinomial => Some((0, LARGEST_POISSON)),
        Kind::Binomial => Some((0, LARGEST_BINOMIAL)),
        _ => None,
    }
}

impl FormulaModel {
    /// Which operation of which formula left its domain, with the values that it had; none where all formulas are fine.
    ///
    /// Looked at are the formulas of `p(x_t | x_{t−1})` at `previous` (`N`), or of `p(x_0)` where there is none, and those of `p(y_t | x_t)` at
    /// `state` (`N`), where it is given. What is NaN comes before what is infinite, and the draw of a count that floating point does not have before what follows from it.
    pub fn explain(
        &self,
        step: &Step<'_>,
        previous: Option<&[f64]>,
        state: Option<&[f64]>,
    ) -> Option<DomainError> {
        let (statement, inputs) = (self.statement(), self.0.inputs.len());
        let of_state = match previous {
            None => vec![(Section::Initial, &statement.initial, None)],
            Some(_) => vec![
                (Section::Draws, &statement.draws, previous),
                (Section::Transition, &statement.transition, previous),
            ],
        };
        let of_measurement = state.map(|_| (Section::Measurement, &statement.measurement, state));
        let points: Vec<_> = of_state
            .into_iter()
            .chain(of_measurement)
            .map(|(section, lines, states)| {
                let step =
                    if section == Section::Measurement { step.end(inputs) } else { step.part(0, inputs) };
                (section, lines, Point::new(statement, step, states))
            })
            .collect();
        let (drawn, all) = (&points[..points.len() - usize::from(state.is_some())], &points[..]);
        let faults = [
            (Fault::NotANumber, drawn),
            (Fault::Uncountable, drawn),
            (Fault::NotANumber, all),
            (Fault::Infinite, all),
        ];
        let mut found = faults.into_iter().filter_map(|(fault, points)| {
            points.iter().find_map(|(section, lines, point)| in_section(*section, lines, point, fault))
        });
        found.next().map(|error| DomainError {
            file: self.file().to_string(),
            line: error.line.filter(|_| self.has_lines()),
            ..error
        })
    }
}

/// For each node, whether it stands inside of the distribution of a `floored(d, eps)`.
fn floored(formula: &Formula) -> Vec<bool> {
    let mut floored = vec![false; formula.nodes.len()];
    for node in &formula.nodes {
        if let Node::Wrapped(Wrapper { wrapping: Wrapping::Floored, .. }, arguments) = node {
            let outer = &formula.spans[arguments[0]];
            for (floored, at) in floored.iter_mut().zip(&formula.spans) {
                *floored |= outer.start <= at.start && at.end <= outer.end;
            }
        }
    }
    floored
}

fn in_section(section: Section, lines: &[Line], point: &Point<'_>, fault: Fault) -> Option<DomainError> {
    lines.iter().find_map(|line| {
        let mut coordinates = 0..line.coordinates();
        coordinates.find_map(|number| in_coordinate(section, line, number, point, fault))
    })
}

/// Whether what follows the means is symmetric and positive definite: by its factor.
fn is_covariance(numbers: &[f64]) -> bool {
    let size = numbers.len().isqrt();
    let entry = |row: usize, column: usize| numbers[size + row * size + column];
    let mut factor = vec![vec![0.0_f64; size]; size];
    for row in 0..size {
        for column in 0..=row {
            let sum: f64 = (0..column).map(|at| factor[row][at] * factor[column][at]).sum();
            let left = entry(row, column) - sum;
            factor[row][column] = if row == column { left.sqrt() } else { left / factor[column][column] };
            let off = (entry(row, column) - entry(column, row)).abs();
            let is_symmetric = off <= 1e-9 * entry(row, column).abs();
            let is_positive = row != column || left > 0.0;
            if !is_symmetric || !is_positive {
                return false;
            }
        }
    }
    true
}

/// What is wrong with the distribution of a coordinate.
fn in_coordinate(
    section: Section,
    line: &Line,
    number: usize,
    point: &Point<'_>,
    fault: Fault,
) -> Option<DomainError> {
    let (formula, values) = (&line.formula, point.values(&line.formula, line.first + number, &[]));
    let place = Place { section, line, number };
    let known = point.are_known(section, formula);
    let origin = |node: NodeId| trace::origin(place, node, &values, point);
    let of_parameter = |node: NodeId, name: &str, expected: &str| {
        if !values[node].is_finite() {
            return origin(node);
        }
        Origin::of_parameter(place, node, &values, [name.to_string(), expected.to_string()])
    };
    let floored = floored(formula);
    let found = formula.nodes.iter().enumerate().find_map(|(at, node)| match node {
        // There what is out of range is fine.
        _ if floored[at] => None,
        Node::Wrapped(wrapper, arguments) => {
            let numbers = arguments.iter().zip(wrapper.parameters).zip(wrapper.arguments);
            let is_wrong = |value: f64, argument: &Argument| match (argument, fault) {
                (Argument::Number(range), _) => fault.is_in(value, *range),
                (Argument::End, Fault::NotANumber) => value.is_nan(),
                _ => false,
            };
            let mut wrong =
                numbers.filter(|((node, _), argument)| known[**node] && is_wrong(values[**node], argument));
            if let Some(((node, name), argument)) = wrong.next() {
                return Some(of_parameter(*node, name, argument.words()));
            }
            let [low, high] = wrapper.ends()?.map(|end| arguments[end]);
            let is_wrong =
                known[low] && known[high] && values[low] >= values[high] && fault == Fault::NotANumber;
            is_wrong.then(|| of_parameter(high, "high", &format!("above low, which is {}", values[low])))
        }
        Node::Random(family, arguments) => {
            let parameters = arguments.iter().zip(family.parameters).zip(family.ranges);
            let mut wrong =
                parameters.filter(|((node, _), range)| known[**node] && fault.is_in(values[**node], **range));
            if let Some(((node, name), range)) = wrong.next() {
                return Some(of_parameter(*node, name, range.words()));
            }
            if let (Fault::Uncountable, Some((number, most))) = (fault, largest(family.kind)) {
                let node = arguments[number];
                let expected = format!("at most {most:.1e}, beyond which counts are not drawn");
                let is_larger = known[node] && values[node] > most;
                return is_larger.then(|| of_parameter(node, family.parameters[number], &expected));
            }
            match (family.kind, arguments.as_slice(), fault) {
                (Kind::Uniform, [low, high], Fault::NotANumber)
                    if known[*low] && known[*high] && values[*low] >= values[*high] =>
                {
                    Some(of_parameter(*high, "high", &format!("above low, which is {}", values[*low])))
                }
                _ => None,
            }
        }
        Node::Compound(compound, arguments) => {
            let wrong = |(number, node): &(usize, &NodeId)| {
                known[**node] && fault.is_in(values[**node], compound.range(*number))
            };
            if let Some((number, node)) = arguments.iter().enumerate().find(wrong) {
                let expected = compound.range(number).words();
                return Some(of_parameter(*node, compound.parameter(number), expected));
            }
            let sum: f64 = arguments.iter().map(|node| values[*node]).sum();
            let is_off = compound.composition == Composition::Categorical
                && arguments.iter().all(|node| known[*node])
                && fault == Fault::NotANumber
                && (sum - 1.0).abs() > MOST_OFF;
            let all: Vec<f64> = arguments.iter().map(|node| values[*node]).collect();
            if compound.composition == Composition::MvNormal
                && arguments.iter().all(|node| known[*node])
                && fault == Fault::NotANumber
                && !is_covariance(&all)
            {
                let words = ["the covariance".to_string(), "symmetric and positive definite".to_string()];
                return Some(Origin::of_parameter(place, at, &values, words));
            }
            is_off.then(|| {
                let mut values = values.clone();
                values[at] = sum;
                let words = ["the sum of the probabilities".to_string(), "1".to_string()];
                Origin::of_parameter(place, at, &values, words)
            })
        }
        // What the distribution is shifted or scaled by.
        Node::OfTwo(operation, a, b) if formula.is_random[at] => {
            let by = if formula.is_random[*a] { *b } else { *a };
            if !known[by] {
                return None;
            }
            let is_zero = *operation == Binary::Multiply && values[by] == 0.0 && fault == Fault::NotANumber;
            if is_zero {
                return Some(of_parameter(by, "the factor", "another number than 0"));
            }
            fault.is_in(values[by], Range::Any).then(|| origin(by))
        }
        _ => None,
    });
    let root = formula.root();
    let follows = || {
        let is_wrong = !formula.has_noise() && known[root] && fault.is_in(values[root], Range::Any);
        is_wrong.then(|| origin(root))
    };
    found.or_else(follows).map(|origin| origin.error(point))
}
