//! Distributions that are made of others, as numbers of a graph.

use super::coordinate::{Coordinate, Made, Output};
use super::nodes::{Graph, Id, Operation};
use crate::error::{ComposedProblem, Problem};
use crate::operations::{Binary, Unary};
use crate::tables::{Composition, Compound, Kind, MEASURED_CATEGORICAL, MOST_OFF, call, of_kind};

/// By how much constant probabilities may differ from 1 in sum, and entries of a covariance from each other, as a share.
const ROUNDED: f64 = 1e-9;

/// A coordinate with such a distribution.
pub(super) struct CompoundPart<'a> {
    pub(super) compound: &'static Compound,
    pub(super) arguments: &'a [Id],
    /// Which part it is, from 0.
    pub(super) part: usize,
    /// The number of the coordinate among all that formulas of the section can name.
    pub(super) number: usize,
    /// Whether it is a measurement.
    pub(super) is_measured: bool,
}

impl CompoundPart<'_> {
    /// What the coordinate is, unless constants are wrong whatever the states are.
    pub(super) fn output(&self, graph: &mut Graph) -> Result<Output, Problem> {
        let call = call(self.compound.name, self.compound.parameters);
        for (number, id) in self.arguments.iter().enumerate() {
            let range = self.compound.range(number);
            if let Some(value) = graph.value(*id).filter(|value| !range.has(*value)) {
                let name = self.compound.parameter(number);
                let (what, expected) = (format!("the {name} of {call}"), range.words().to_string());
                return Err(Problem::OutOfRange { what, value, expected });
            }
        }
        match self.compound.composition {
            Composition::EulerMultinomial => Ok(self.euler_multinomial(graph)),
            Composition::Categorical => self.categorical(graph, &call),
            Composition::Dirichlet => Ok(self.dirichlet(graph)),
            Composition::MvNormal => self.normal(graph),
            // The parser refuses it.
            Composition::Prior(_) => Ok(Output::Follows(graph.constant(f64::NAN))),
        }
    }

    /// The draw of a part before it.
    fn before(&self, graph: &mut Graph, part: usize) -> Id {
        graph.state(self.number - self.part + part)
    }

    /// Of those that did not leave by the ways before, each leaves by this one with the same probability.
    ///
    /// In a step of length `dt`, `1 − e^(−R·dt)` of all leave at the rates `r`, whose sum is `R`, and `u = r·(1 − e^(−R·dt))/R` by one way. What is left for it is
    /// `e^(−R·dt)` and the `u` of this way and of those after it: a sum of what is not negative loses no digits, and `u` is never above it, however it is rounded.
    fn euler_multinomial(&self, graph: &mut Graph) -> Output {
        let (count, rates) = (self.arguments[0], &self.arguments[1..]);
        let mut sums = rates.to_vec();
        for way in (0..rates.len().saturating_sub(1)).rev() {
            sums[way] = graph.of_two(Binary::Add, rates[way], sums[way + 1]);
        }
        let (total, dt) = (sums[0], graph.of_step(Operation::Length));
        let [zero, one, half] = [0.0, 1.0, 0.5].map(|value| graph.constant(value));
        let expected = graph.of_two(Binary::Multiply, total, dt);
        let negative = graph.of_one(Unary::Negative, expected);
        let stay = graph.of_one(Unary::Exp, negative);
        // 1 − e^(−a) is (1 + e^(−a))·tanh(a/2), with all digits.
        let half = graph.of_two(Binary::Multiply, expected, half);
        let tanh = graph.of_one(Unary::Tanh, half);
        let sum = graph.of_two(Binary::Add, stay, one);
        let leave = graph.of_two(Binary::Multiply, tanh, sum);
        let by_rate = graph.of_two(Binary::Divide, leave, total);
        let nobody_leaves = graph.of_two(Binary::Equal, total, zero);
        let by_rate = graph.choice(nobody_leaves, dt, by_rate);
        let own = graph.of_two(Binary::Multiply, rates[self.part], by_rate);
        let later = graph.of_two(Binary::Multiply, sums[self.part], by_rate);
        let left = graph.of_two(Binary::Add, stay, later);
        let p = graph.of_two(Binary::Divide, own, left);
        // Where all have left, and only ways with a rate of 0 are to come, it is 0; of a negative rate it stays negative, which no binomial takes.
        let is_none_left = graph.of_two(Binary::Equal, left, zero);
        let p = graph.choice(is_none_left, own, p);
        let n = (0..self.part).fold(count, |n, part| {
            let gone = self.before(graph, part);
            graph.of_two(Binary::Subtract, n, gone)
        });
        drawn(Kind::Binomial, vec![n, p])
    }

    /// Given the parts before it, a part is normal: with the factor L of the covariance, its mean is that of the list and `L` times the standard normal numbers `z` that
    /// those before it are made of.
    fn normal(&self, graph: &mut Graph) -> Result<Output, Problem> {
        // n means and n² entries.
        let size = self.arguments.len().isqrt();

        let mut factor: Vec<Vec<Id>> = Vec::with_capacity(self.part + 1);
        let mut scaled: Vec<Id> = Vec::with_capacity(self.part);
        let mut mean = self.arguments[0];
        for row in 0..=self.part {
            let mut own: Vec<Id> = Vec::with_capacity(row + 1);
            mean = self.arguments[row];
            for column in 0..=row {
                let mut entry = self.covariance(graph, size, [row, column])?;
                for at in 0..column {
                    let other = if column == row { own[at] } else { factor[column][at] };
                    let product = graph.of_two(Binary::Multiply, own[at], other);
                    entry = graph.of_two(Binary::Subtract, entry, product);
                }
                if column == row {
                    let is_wrong = graph.value(entry).is_some_and(|pivot| pivot.is_nan() || pivot <= 0.0);
                    if is_wrong {
                        return Err(Problem::Composed(ComposedProblem::NoCovariance));
                    }
                    own.push(graph.of_one(Unary::Sqrt, entry));
                } else {
                    own.push(graph.of_two(Binary::Divide, entry, factor[column][column]));
                    let shift = graph.of_two(Binary::Multiply, own[column], scaled[column]);
                    mean = graph.of_two(Binary::Add, mean, shift);
                }
            }
            if row < self.part {
                let value = self.before(graph, row);
                let off = graph.of_two(Binary::Subtract, value, mean);
                scaled.push(graph.of_two(Binary::Divide, off, own[row]));
            }
            factor.push(own);
        }
        Ok(drawn(Kind::Normal, vec![mean, factor[self.part][self.part]]))
    }

    /// An entry of a covariance; NaN where it is another one on the other side of the diagonal.
    fn covariance(&self, graph: &mut Graph, size: usize, [row, column]: [usize; 2]) -> Result<Id, Problem> {
        let [own, other] = [[row, column], [column, row]].map(|[i, j]| self.arguments[size + i * size + j]);
        if own == other {
            return Ok(own);
        }
        let difference = graph.of_two(Binary::Subtract, own, other);
        let [size, off] = [own, difference].map(|number| graph.of_one(Unary::Abs, number));
        let rounded = graph.constant(ROUNDED);
        let most = graph.of_two(Binary::Multiply, size, rounded);
        let is_symmetric = graph.of_two(Binary::AtMost, off, most);
        if graph.value(is_symmetric) == Some(0.0) {
            return Err(Problem::Composed(ComposedProblem::NoCovariance));
        }
        let nothing = graph.constant(f64::NAN);
        Ok(graph.choice(is_symmetric, own, nothing))
    }

    /// Of what is left by the shares before it, a share is a beta; the last one is what is left.
    fn dirichlet(&self, graph: &mut Graph) -> Output {
        let one = graph.constant(1.0);
        let left = (0..self.part).fold(one, |left, part| {
            let gone = self.before(graph, part);
            graph.of_two(Binary::Subtract, left, gone)
        });
        let later = &self.arguments[self.part + 1..];
        let Some((first, rest)) = later.split_first() else {
            let zero = graph.constant(0.0);
            return Output::Follows(graph.of_two(Binary::Max, left, zero));
        };
        let others = rest.iter().fold(*first, |sum, other| graph.of_two(Binary::Add, sum, *other));
        let mut share = Coordinate::new(of_kind(Kind::Beta), vec![self.arguments[self.part], others]);
        if self.part > 0 {
            // Where rounding leaves nothing, next to nothing is shared.
            let least = graph.constant(f64::MIN_POSITIVE);
            let left = graph.of_two(Binary::Max, left, least);
            share.multiply(graph, left);
        }
        Output::Drawn(share)
    }

    /// The number of sums of probabilities that a uniform number has reached.
    fn categorical(&self, graph: &mut Graph, call: &str) -> Result<Output, Problem> {
        let probabilities = self.arguments;
        let [zero, one] = [0.0, 1.0].map(|value| graph.constant(value));
        let mut sums = probabilities.to_vec();
        let mut least = probabilities[0];
        for at in 1..sums.len() {
            sums[at] = graph.of_two(Binary::Add, sums[at - 1], sums[at]);
            least = graph.of_two(Binary::Min, least, probabilities[at]);
        }
        let total = sums[sums.len() - 1];
        if let Some(value) = graph.value(total).filter(|total| (total - 1.0).abs() > ROUNDED) {
            let what = format!("the sum of the probabilities of {call}");
            return Err(Problem::OutOfRange { what, value, expected: "1".to_string() });
        }
        if self.is_measured {
            let (wrapper, numbers) = (&MEASURED_CATEGORICAL, probabilities.to_vec());
            return Ok(Output::Made(Made { wrapper, numbers, parts: Vec::new(), density: None }));
        }
        let drawn = graph.drawn(self.number);
        // In units of the sum, so that the last one with a probability of 0 is never reached.
        let reached = graph.of_two(Binary::Multiply, drawn, total);
        let mut value = zero;
        for &sum in &sums[..sums.len() - 1] {
            let is_beyond = graph.of_two(Binary::AtMost, sum, reached);
            value = if value == zero { is_beyond } else { graph.of_two(Binary::Add, value, is_beyond) };
        }
        let off = graph.of_two(Binary::Subtract, total, one);
        let [off, most] = [graph.of_one(Unary::Abs, off), graph.constant(MOST_OFF)];
        let adds_up = graph.of_two(Binary::AtMost, off, most);
        let none_negative = graph.of_two(Binary::AtMost, zero, least);
        let is_right = graph.of_two(Binary::And, adds_up, none_negative);
        let nothing = graph.constant(f64::NAN);
        let value = graph.choice(is_right, value, nothing);
        let uniform = Coordinate::new(of_kind(Kind::Uniform), vec![zero, one]);
        Ok(Output::Computed { coordinate: uniform, drawn, value, shares: probabilities.to_vec() })
    }
}

fn drawn(kind: Kind, parameters: Vec<Id>) -> Output {
    Output::Drawn(Coordinate::new(of_kind(kind), parameters))
}
