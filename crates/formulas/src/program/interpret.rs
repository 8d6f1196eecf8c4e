//! Computes a program for one particle or for many side by side.

use std::ops::Range;

use motes_models::Step;
use motes_models::batch::by_widest_vectors;
use motes_models::equations::{Coordinates, Distribution, Draws, Scalar, with_scalars};

use super::instruction::{Instruction, NoiseTerm, Output, Place, PlainStep, Program, Rule, Source};
use super::kept::with_plain;
use super::moment::Moment;
use crate::operations::choice;

impl Program {
    /// Makes the coordinates of a state at a time, after a step of a length, given the state before: draws, and what follows.
    ///
    /// # Panics
    /// If there are fewer states than the model has.
    pub(crate) fn make<S: Scalar>(
        &self,
        step: &Step<'_, S>,
        previous: &[S],
        draws: &mut impl Draws<S>,
        state: &mut [S],
    ) {
        let gives = self.in_order || !self.draws.is_empty();
        with_plain(self, Moment::of(step), step.sub_step, |plain| {
            with_scalars::<S, _>(self.registers + if gives { self.given } else { 0 }, |memory| {
                let (registers, given) = memory.split_at_mut(self.registers);
                if !gives {
                    let mut run = Run { given: previous, count: self.given, plain, registers };
                    let mut start = 0;
                    for (output, coordinate) in self.coordinates.iter().zip(state) {
                        *coordinate = run.output(&self.instructions, &mut start, output, draws);
                    }
                    return;
                }
                given[..previous.len()].copy_from_slice(previous);
                let (first, count) = (self.given - self.draws.len(), self.draws.len());
                let mut start = 0;
                // One loop over both: what an output takes of code is there once.
                for (number, output) in self.draws.iter().chain(&self.coordinates).enumerate() {
                    let mut run = Run { given, count: self.given, plain, registers: &mut *registers };
                    let value = run.output(&self.instructions, &mut start, output, draws);
                    match number.checked_sub(count) {
                        None => given[first + number] = value,
                        Some(coordinate) => {
                            if self.in_order {
                                given[coordinate] = value;
                            }
                            if let Some(place) = state.get_mut(coordinate) {
                                *place = value;
                            }
                        }
                    }
                }
            });
        });
    }

    /// Pushes the distributions of the coordinates of a measurement at a time, given the states.
    ///
    /// # Panics
    /// If there are fewer states than the model has.
    pub(crate) fn push<S: Scalar>(
        &self,
        step: &Step<'_, S>,
        states: &[S],
        coordinates: &mut impl Coordinates<S>,
    ) {
        self.push_along(step, states, 0..self.given, coordinates);
    }

    /// The same, but that coordinates that depend on none of the states in `along` are passed over, where there are any.
    ///
    /// # Panics
    /// As [`Program::push`].
    pub(crate) fn push_along<S: Scalar>(
        &self,
        step: &Step<'_, S>,
        states: &[S],
        along: Range<usize>,
        coordinates: &mut impl Coordinates<S>,
    ) {
        let is_all = along.start == 0 && along.end >= self.given;
        with_plain(self, Moment::of(step), step.sub_step, |plain| {
            with_scalars::<S, _>(self.registers, |registers| {
                let mut run = Run { given: states, count: self.given, plain, registers };
                let mut start = 0;
                for (output, depends_on) in self.coordinates.iter().zip(&self.depends_on) {
                    // What one coordinate computes others may use.
                    let instructions = &self.instructions[start..output.end];
                    start = output.end;
                    run.all(instructions);
                    match is_all || depends_on.iter().any(|state| along.contains(&(*state as usize))) {
                        true => match &output.rule {
                            Rule::Noise(term) => run.push(term, coordinates),
                            Rule::Made(term) => {
                                run.with_made(term, step, &mut |wrapped| coordinates.push_wrapped(wrapped));
                            }
                            // A measurement is always drawn.
                            Rule::Formula(_) | Rule::Computed(_) => {}
                        },
                        false => coordinates.pass_over(),
                    }
                }
            });
        });
    }

    /// Computes the numbers that are the same for all particles.
    pub(super) fn plain(&self, moment: Moment<'_>, plain: &mut [f64]) {
        let first = self.constants.len();
        plain[..first].copy_from_slice(&self.constants);
        for (at, step) in self.steps.iter().enumerate() {
            let value = |place: u32| plain[place as usize];
            plain[first + at] = match *step {
                PlainStep::Time => moment.time,
                PlainStep::Length => moment.length,
                PlainStep::Input(number) => moment.inputs[number as usize],
                PlainStep::First => f64::from(moment.is_first),
                PlainStep::OfOne(operation, a) => operation.of(value(a)),
                PlainStep::Integer(a, n) => value(a).powi(n),
                PlainStep::OfTwo(operation, a, b) => operation.of(value(a), value(b)),
                PlainStep::If(c, a, b) => choice(value(c), value(a), value(b)),
            };
        }
    }
}

/// The numbers that instructions work on.
pub(super) struct Run<'a, S> {
    pub(super) given: &'a [S],
    /// How many numbers are given.
    count: usize,
    plain: &'a [f64],
    registers: &'a mut [S],
}

impl<S: Scalar> Run<'_, S> {
    #[inline(always)]
    fn varied(&self, place: Place) -> S {
        let place = place as usize;
        if place < self.count { self.given[place] } else { self.registers[place - self.count] }
    }

    #[inline(always)]
    fn plain(&self, place: u32) -> f64 {
        self.plain[place as usize]
    }

    #[inline(always)]
    pub(super) fn value(&self, source: Source) -> S {
        match source {
            Source::Plain(place) => S::from(self.plain(place)),
            Source::Varied(place) => self.varied(place),
        }
    }

    /// Carries out instructions, with the widest vectors that the machine has. It is compiled for each scalar, and not again for each use of what a program makes.
    #[inline(never)]
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
            Instruction::If(out, c, a, b) => (out, choice(self.value(c), self.value(a), self.value(b))),
        }
    }

    /// The value of the next output, drawn if it is not known.
    #[inline(always)]
    fn output(
        &mut self,
        instructions: &[Instruction],
        start: &mut usize,
        output: &Output,
        draws: &mut impl Draws<S>,
    ) -> S {
        self.all(&instructions[*start..output.end]);
        *start = output.end;
        let (term, computed) = match &output.rule {
            Rule::Formula(source) => return self.value(*source),
            // Measurements alone are made of other distributions.
            Rule::Made(_) => return S::from(f64::NAN),
            Rule::Noise(term) => (term, None),
            Rule::Computed(computed) => (&computed.term, Some(computed)),
        };
        if let Some(computed) = computed {
            draws.among(computed.shares.len(), |share| self.value(computed.shares[share]));
        }
        let drawn = self.drawn(term, draws);
        let Some(computed) = computed else { return drawn };
        self.registers[computed.register as usize] = drawn;
        self.all(&instructions[*start..computed.end]);
        *start = computed.end;
        self.value(computed.value)
    }

    /// What is drawn from a distribution.
    #[inline(always)]
    fn drawn(&mut self, term: &NoiseTerm, draws: &mut impl Draws<S>) -> S {
        let mut one = OneDraw { draws, drawn: S::from(f64::NAN) };
        self.push(term, &mut one);
        one.drawn
    }

    #[inline(always)]
    fn push(&self, term: &NoiseTerm, coordinates: &mut impl Coordinates<S>) {
        let parameters = term.parameters.map(|source| self.value(source));
        let scale = term.scale.map(|source| self.value(source));
        let shift = term.shift.map(|source| self.value(source));
        term.family.kind.push(parameters, scale, shift, coordinates);
    }
}

/// Draws from the distribution that it is told.
struct OneDraw<'a, D, S> {
    draws: &'a mut D,
    drawn: S,
}

impl<S, D: Draws<S>> Coordinates<S> for OneDraw<'_, D, S> {
    #[inline(always)]
    fn push(&mut self, distribution: Distribution<S>) {
        self.drawn = self.draws.draw(distribution);
    }
}
