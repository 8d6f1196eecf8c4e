//! Distributions of measurements that are made of others, with the numbers of particles.

use motes_models::Step;
use motes_models::equations::{Distribution, Draws, Scalar, Wrapped, with_scalars};

use super::instruction::{MadeTerm, NoiseTerm, PartTerm, Program};
use super::interpret::Run;
use crate::tables::Wrapping;

/// What takes a distribution.
type Taker<'t, S> = &'t mut dyn FnMut(&Wrapped<'_, S>);

impl<S: Scalar> Run<'_, S> {
    /// Makes a distribution of others, on the stack, and gives it to `take`.
    #[inline(never)]
    pub(super) fn with_made(&self, term: &MadeTerm, step: &Step<'_, S>, take: Taker<'_, S>) {
        let [a, b] = term.numbers;
        let part = |at: usize, take: Taker<'_, S>| match term.parts.get(at) {
            Some(PartTerm::Plain(plain)) => take(&Wrapped::Plain(self.plain_part(plain))),
            Some(PartTerm::Made(made)) => self.with_made(made, step, take),
            None => {}
        };
        match term.wrapping {
            Wrapping::VonMises => take(&Wrapped::VonMises { mu: self.value(a), kappa: self.value(b) }),
            Wrapping::Rounded => part(0, &mut |of| take(&Wrapped::Rounded(of))),
            Wrapping::Censored => {
                let (low, high) = (self.value(a), self.value(b));
                part(0, &mut |of| take(&Wrapped::Censored { low, high, of }));
            }
            Wrapping::Truncated => {
                let (low, high) = (self.value(a), self.value(b));
                part(0, &mut |of| take(&Wrapped::Truncated { low, high, of }));
            }
            Wrapping::ZeroInflated => {
                let p = self.value(a);
                part(0, &mut |of| take(&Wrapped::ZeroInflated { p, of }));
            }
            Wrapping::Mixture => {
                let weight = self.value(a);
                part(0, &mut |first| {
                    part(1, &mut |second| take(&Wrapped::Mixture { weight, first, second }));
                });
            }
            Wrapping::Floored => {
                let floor = self.value(a);
                part(0, &mut |of| take(&Wrapped::Floored { floor, of }));
            }
            Wrapping::Categorical => with_scalars::<S, _>(term.shares.len(), |shares| {
                shares.iter_mut().zip(&term.shares).for_each(|(share, source)| *share = self.value(*source));
                take(&Wrapped::Categorical(shares));
            }),
            Wrapping::LogDensity => {
                let nothing = S::from(f64::NAN);
                let formula =
                    |y: S| term.density.as_ref().map_or(nothing, |program| self.density(program, step, y));
                take(&Wrapped::LogDensity(&formula));
            }
        }
    }

    fn plain_part(&self, term: &NoiseTerm) -> Distribution<S> {
        let parameters = term.parameters.map(|source| self.value(source));
        let [scale, shift] = [term.scale, term.shift].map(|by| by.map(|source| self.value(source)));
        term.family.kind.moved(parameters, scale, shift)
    }

    /// A log density where the measurement is `y`.
    fn density(&self, program: &Program, step: &Step<'_, S>, y: S) -> S {
        with_scalars::<S, _>(program.given, |given| {
            let states = program.given - 1;
            given[..states].copy_from_slice(&self.given[..states]);
            given[states] = y;
            let mut found = [S::from(f64::NAN)];
            program.make(step, given, &mut Nothing, &mut found);
            found[0]
        })
    }
}

/// Draws that a log density does not ask for.
struct Nothing;

impl<S: Scalar> Draws<S> for Nothing {
    fn draw(&mut self, _: Distribution<S>) -> S {
        S::from(f64::NAN)
    }
}
