//! Computes a program for one particle or for many side by side.

use std::ops::Range;

use motes_models::batch::by_widest_vectors;
use motes_models::equations::{Coordinates, Scalar, with_scalars};

use super::instruction::{Instruction, Output, Place, Program, Source, Step};

impl Program {
    /// Pushes the distributions of the coordinates at a time, given the states.
    ///
    /// # Panics
    /// If there are fewer states than the model has.
    pub(crate) fn push<S: Scalar>(&self, time: f64, states: &[S], coordinates: &mut impl Coordinates<S>) {
        self.push_along(time, states, 0..self.states, coordinates);
    }

    /// The same, but that coordinates that depend on none of the states in `along` are passed over, where there are any.
    ///
    /// # Panics
    /// As [`Program::push`].
    pub(crate) fn push_along<S: Scalar>(
        &self,
        time: f64,
        states: &[S],
        along: Range<usize>,
        coordinates: &mut impl Coordinates<S>,
    ) {
        let is_all = along.start == 0 && along.end >= self.states;
        with_scalars::<f64, _>(self.constants.len() + self.steps.len(), |plain| {
            self.plain(time, plain);
            with_scalars::<S, _>(self.registers, |registers| {
                let mut run = Run { states, count: self.states, plain, registers };
                let mut start = 0;
                for (output, depends_on) in self.coordinates.iter().zip(&self.depends_on) {
                    // What one coordinate computes others may use.
                    let instructions = &self.instructions[start..output.end];
                    start = output.end;
                    run.all(instructions);
                    match is_all || depends_on.iter().any(|state| along.contains(&(*state as usize))) {
                        true => run.push(output, coordinates),
                        false => coordinates.pass_over(),
                    }
                }
            });
        });
    }

    /// Computes the numbers that are the same for all particles.
    pub(super) fn plain(&self, time: f64, plain: &mut [f64]) {
        let first = self.constants.len();
        plain[..first].copy_from_slice(&self.constants);
        for (at, step) in self.steps.iter().enumerate() {
            let value = |place: u32| plain[place as usize];
            plain[first + at] = match *step {
                Step::Time => time,
                Step::OfOne(operation, a) => operation.of(value(a)),
                Step::Integer(a, n) => value(a).powi(n),
                Step::OfTwo(operation, a, b) => operation.of(value(a), value(b)),
            };
        }
    }
}

/// The numbers that instructions work on.
struct Run<'a, S> {
    states: &'a [S],
    /// How many states the model has.
    count: usize,
    plain: &'a [f64],
    registers: &'a mut [S],
}

impl<S: Scalar> Run<'_, S> {
    #[inline(always)]
    fn varied(&self, place: Place) -> S {
        let place = place as usize;
        if place < self.count { self.states[place] } else { self.registers[place - self.count] }
    }

    #[inline(always)]
    fn plain(&self, place: u32) -> f64 {
        self.plain[place as usize]
    }

    #[inline(always)]
    fn value(&self, source: Source) -> S {
        match source {
            Source::Plain(place) => S::from(self.plain(place)),
            Source::Varied(place) => self.varied(place),
        }
    }

    /// Carries out instructions, with the widest vectors that the machine has.
    fn all(&mut self, instructions: &[Instruction]) {
        by_widest_vectors(
            #[inline(always)]
            || {
                for instruction in instructions {
                    let (out, value) = self.one(instruction);
                    self.registers[out as usize] = value;
                }
            },
        );
    }

    #[inline(always)]
    fn one(&self, instruction: &Instruction) -> (u32, S) {
        match *instruction {
            Instruction::Add(out, a, b) => (out, self.varied(a) + self.varied(b)),
            Instruction::AddPlain(out, a, b) => (out, self.varied(a) + self.plain(b)),
            Instruction::Subtract(out, a, b) => (out, self.varied(a) - self.varied(b)),
            Instruction::SubtractPlain(out, a, b) => (out, self.varied(a) - self.plain(b)),
            Instruction::SubtractFrom(out, a, b) => (out, -self.varied(a) + self.plain(b)),
            Instruction::Multiply(out, a, b) => (out, self.varied(a) * self.varied(b)),
            Instruction::MultiplyPlain(out, a, b) => (out, self.varied(a) * self.plain(b)),
            Instruction::Divide(out, a, b) => (out, self.varied(a) / self.varied(b)),
            Instruction::DividePlain(out, a, b) => (out, self.varied(a) / self.plain(b)),
            Instruction::DivideInto(out, a, b) => (out, S::from(self.plain(b)) / self.varied(a)),
            Instruction::OfOne(operation, out, a) => (out, operation.of(self.varied(a))),
            Instruction::Integer(out, a, n) => (out, self.varied(a).powi(n)),
            Instruction::OfTwo(operation, out, a, b) => (out, operation.of(self.value(a), self.value(b))),
        }
    }

    #[inline(always)]
    fn push(&self, output: &Output, coordinates: &mut impl Coordinates<S>) {
        let parameters = output.parameters.map(|source| self.value(source));
        let scale = output.scale.map(|source| self.value(source));
        let shift = output.shift.map(|source| self.value(source));
        output.kind.push(parameters, scale, shift, coordinates);
    }
}
