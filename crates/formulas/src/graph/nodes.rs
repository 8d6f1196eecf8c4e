//! A graph of operations, each of them there once.

use std::collections::{BTreeSet, HashMap};

use motes_models::equations::Scalar;

use crate::operations::{Binary, Unary, integer_exponent};

/// A number that the graph computes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub(crate) struct Id(u32);

impl Id {
    /// Its place in the order of the graph.
    pub(crate) fn index(self) -> usize {
        self.0 as usize
    }
}

/// How a number is computed; operands come before it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(crate) enum Operation {
    /// A constant, by its bits.
    Constant(u64),
    Time,
    /// The length of a sub-step.
    Length,
    Input(u32),
    /// 1 in the first sub-step of a step, else 0.
    First,
    State(u32),
    /// What is drawn for the coordinate of that number, of which it is computed.
    Drawn(u32),
    OfOne(Unary, Id),
    /// A power with an integer exponent.
    Integer(Id, i32),
    OfTwo(Binary, Id, Id),
    /// The second where the first is not 0, else the third.
    If(Id, Id, Id),
}

impl Operation {
    /// The numbers that it is made of.
    pub(crate) fn operands(self) -> impl Iterator<Item = Id> {
        let operands = match self {
            Operation::Constant(_)
            | Operation::Time
            | Operation::Length
            | Operation::Input(_)
            | Operation::First
            | Operation::State(_)
            | Operation::Drawn(_) => [None; 3],
            Operation::OfOne(_, a) | Operation::Integer(a, _) => [Some(a), None, None],
            Operation::OfTwo(_, a, b) => [Some(a), Some(b), None],
            Operation::If(c, a, b) => [Some(c), Some(a), Some(b)],
        };
        operands.into_iter().flatten()
    }
}

/// Operations in an order in which they can be computed.
#[derive(Debug, Default)]
pub(crate) struct Graph {
    operations: Vec<Operation>,
    known: HashMap<Operation, Id>,
    /// For each, the last of the states that it depends on.
    last_states: Vec<Option<u32>>,
    /// For each, whether it is another one for each particle.
    varies: Vec<bool>,
}

/// Powers up to here are products that other operations can share.
const PRODUCTS: u32 = 16;

impl Graph {
    fn add(&mut self, operation: Operation) -> Id {
        if let Some(id) = self.known.get(&operation) {
            return *id;
        }
        let last_state = match operation {
            Operation::State(number) => Some(number),
            _ => operation.operands().filter_map(|operand| self.last_state(operand)).max(),
        };
        let id = Id(self.operations.len() as u32);
        self.operations.push(operation);
        self.last_states.push(last_state);
        let varies = matches!(operation, Operation::State(_) | Operation::Drawn(_))
            || operation.operands().any(|operand| self.varies(operand));
        self.varies.push(varies);
        self.known.insert(operation, id);
        id
    }

    pub(crate) fn operation(&self, id: Id) -> Operation {
        self.operations[id.index()]
    }

    pub(crate) fn operations(&self) -> &[Operation] {
        &self.operations
    }

    /// Whether a number depends on states, or on what is drawn.
    pub(crate) fn varies(&self, id: Id) -> bool {
        self.varies[id.index()]
    }

    /// The last of the states that a number depends on.
    pub(crate) fn last_state(&self, id: Id) -> Option<u32> {
        self.last_states[id.index()]
    }

    /// The value of what depends on nothing.
    pub(crate) fn value(&self, id: Id) -> Option<f64> {
        match self.operation(id) {
            Operation::Constant(bits) => Some(f64::from_bits(bits)),
            _ => None,
        }
    }

    pub(crate) fn constant(&mut self, value: f64) -> Id {
        self.add(Operation::Constant(value.to_bits()))
    }

    /// A number that depends on nothing but the step.
    pub(crate) fn of_step(&mut self, operation: Operation) -> Id {
        self.add(operation)
    }

    /// The inputs that numbers depend on, in ascending order.
    pub(crate) fn inputs_of(&self, numbers: impl Iterator<Item = Id>) -> Vec<u32> {
        self.leaves(numbers, |operation| match operation {
            Operation::Input(number) => Some(number),
            _ => None,
        })
    }

    pub(crate) fn drawn(&mut self, number: usize) -> Id {
        self.add(Operation::Drawn(number as u32))
    }

    pub(crate) fn choice(&mut self, condition: Id, then: Id, otherwise: Id) -> Id {
        match self.value(condition) {
            // NaN is computed on.
            Some(known) if known != 0.0 && !known.is_nan() => then,
            Some(0.0) => otherwise,
            _ => self.add(Operation::If(condition, then, otherwise)),
        }
    }

    /// The states that numbers depend on, in ascending order.
    pub(crate) fn states_of(&self, numbers: impl Iterator<Item = Id>) -> Vec<u32> {
        self.leaves(numbers, |operation| match operation {
            Operation::State(number) => Some(number),
            _ => None,
        })
    }

    /// What `of` finds in the operations that numbers are made of, in ascending order.
    fn leaves(&self, numbers: impl Iterator<Item = Id>, of: impl Fn(Operation) -> Option<u32>) -> Vec<u32> {
        let (mut seen, mut found) = (BTreeSet::new(), BTreeSet::new());
        let mut waiting: Vec<Id> = numbers.collect();
        while let Some(id) = waiting.pop() {
            if seen.insert(id) {
                let operation = self.operation(id);
                found.extend(of(operation));
                waiting.extend(operation.operands());
            }
        }
        found.into_iter().collect()
    }

    pub(crate) fn state(&mut self, number: usize) -> Id {
        self.add(Operation::State(number as u32))
    }

    pub(crate) fn of_one(&mut self, operation: Unary, a: Id) -> Id {
        if let Some(value) = self.value(a) {
            return self.constant(operation.of(value));
        }
        match (operation, self.operation(a)) {
            (Unary::Negative, Operation::OfOne(Unary::Negative, inner)) => inner,
            _ => self.add(Operation::OfOne(operation, a)),
        }
    }

    /// Only what leaves every bit of the result as it is is simplified.
    pub(crate) fn of_two(&mut self, operation: Binary, a: Id, b: Id) -> Id {
        match (operation, self.value(a), self.value(b)) {
            (Binary::Power, Some(base), Some(exponent)) => {
                let power = integer_exponent(exponent);
                self.constant(power.map_or_else(|| base.pow(exponent), |exponent| base.powi(exponent)))
            }
            (_, Some(a), Some(b)) => self.constant(operation.of(a, b)),
            (Binary::Power, _, Some(exponent)) if integer_exponent(exponent).is_some() => {
                self.integer_power(a, integer_exponent(exponent).unwrap_or_default())
            }
            (Binary::Multiply, Some(1.0), _) => b,
            (Binary::Multiply | Binary::Divide, _, Some(1.0)) => a,
            (Binary::Divide, _, Some(divisor)) if is_power_of_two(divisor) => {
                let inverse = self.constant(1.0 / divisor);
                self.of_two(Binary::Multiply, a, inverse)
            }
            // In one order, so that a + b is b + a.
            (Binary::Add | Binary::Multiply, ..) => self.add(Operation::OfTwo(operation, a.max(b), a.min(b))),
            _ => self.add(Operation::OfTwo(operation, a, b)),
        }
    }

    /// `aⁿ`, by the products that [`Scalar::powi`] takes.
    fn integer_power(&mut self, a: Id, n: i32) -> Id {
        if n == 0 {
            return self.constant(1.0);
        }
        if n.unsigned_abs() > PRODUCTS {
            return self.add(Operation::Integer(a, n));
        }
        let (mut result, mut factor, mut left) = (None, a, n.unsigned_abs());
        while left > 0 {
            if left & 1 == 1 {
                result = Some(result.map_or(factor, |result| self.of_two(Binary::Multiply, result, factor)));
            }
            left >>= 1;
            if left > 0 {
                factor = self.of_two(Binary::Multiply, factor, factor);
            }
        }
        let result = result.unwrap_or(factor);
        if n > 0 {
            return result;
        }
        let one = self.constant(1.0);
        self.of_two(Binary::Divide, one, result)
    }
}

/// Whether dividing by it is multiplying with its inverse, to the last bit.
fn is_power_of_two(divisor: f64) -> bool {
    const FRACTION: u64 = (1 << 52) - 1;
    divisor.is_normal() && (1.0 / divisor).is_normal() && divisor.to_bits() & FRACTION == 0
}
