//! States as a map of noise near a point: their values and their derivatives along noise and previous states.

use crate::Step;
use crate::batch::{LANES, by_widest_vectors};
use crate::equations::advance::make_state;
use crate::equations::distribution::Distribution;
use crate::equations::lanes::Lanes;
use crate::equations::scalar::Scalar;
use crate::equations::statement::{Draws, Equations};
use crate::equations::tiles::with_scalars;
use crate::equations::varied::{SIDE, Side, Varied, put, side};

/// Answers draws with what their noise is transported to, with derivatives along directions from `first` on.
pub(super) struct Near<'a> {
    pub(super) noise: &'a [Lanes],
    pub(super) lane: usize,
    /// The direction of the first draw.
    pub(super) of_noise: usize,
    pub(super) first: usize,
    pub(super) drawn: usize,
}

impl<const E: usize> Draws<Varied<E>> for Near<'_> {
    #[inline(always)]
    fn draw(&mut self, distribution: Distribution<Varied<E>>) -> Varied<E> {
        let Some(v) = self.noise.get(self.drawn) else { return Varied::from(f64::NAN) };
        let v = varied(side(v, self.lane), self.of_noise + self.drawn, self.first);
        self.drawn += 1;
        distribution.near(v)
    }
}

/// A number that is one of the directions from `first` on, if it is among them.
#[inline(always)]
pub(super) fn varied<const E: usize>(value: Side, direction: usize, first: usize) -> Varied<E> {
    match direction.checked_sub(first).filter(|direction| *direction < E - 1) {
        Some(direction) => Varied::variable(value, direction),
        None => Varied::constant(value),
    }
}

impl<const E: usize> Distribution<Varied<E>> {
    /// `T(v)` with derivatives along `v` and along parameters; what only shapes change keeps its standardised value. Of a count `mean + sd·v`.
    #[inline(always)]
    fn near(&self, v: Varied<E>) -> Varied<E> {
        match self.formula(v) {
            Some([value, _]) => value,
            None => self.near_by_lanes(v),
        }
    }

    #[inline(never)]
    fn near_by_lanes(&self, v: Varied<E>) -> Varied<E> {
        let [mean, variance] = self.moments();
        // The derivative of a root at 0 is no number.
        let sd = variance.where_positive(variance.sqrt(), Varied::from(0.0));
        if self.is_discrete() {
            return mean + sd * v;
        }
        let (mut values, mut slopes) = ([0.0; SIDE], [0.0; SIDE]);
        for (lane, (value, slope)) in values.iter_mut().zip(&mut slopes).enumerate() {
            let [x, log_slope] = self.map(|parameter| parameter.value().0[lane]).transport(v.value().0[lane]);
            (*value, *slope) = (x, log_slope.exp());
        }
        let depth = (Lanes(values) - mean.value()) / sd.value();
        let moved = v - Varied::constant(v.value());
        mean + sd * Varied::constant(depth) + moved * Varied::constant(Lanes(slopes))
    }
}

/// What [`NoiseSpace::tile_linearised`](super::NoiseSpace::tile_linearised) is asked.
pub(super) struct Linearisation<'a, M> {
    pub(super) model: &'a M,
    pub(super) step: &'a Step<'a>,
    pub(super) previous: Option<&'a [Lanes]>,
    pub(super) noise: &'a [Lanes],
    pub(super) particles: usize,
    /// `Q`, `Q + N`, or 0.
    pub(super) directions: usize,
    pub(super) states: &'a mut [Lanes],
    pub(super) jacobian: &'a mut [Lanes],
}

impl<M: Equations> Linearisation<'_, M> {
    /// Finds it along `E − 1` directions at a time.
    pub(super) fn along<const E: usize>(&mut self) {
        let ([n, _], sub_steps) = (self.model.dimensions(), self.step.sub_steps);
        // Products of derivatives take their time, too.
        let of_one = n + self.noise.len().div_ceil(sub_steps.max(1));
        match self.previous {
            Some(previous) if sub_steps > 1 && self.directions > 2 * of_one => {
                self.by_sub_steps::<E>(previous)
            }
            _ => self.at_once::<E>(),
        }
    }

    fn at_once<const E: usize>(&mut self) {
        let Linearisation { model, step, previous, noise, particles, directions, states, jacobian } = self;
        let ([n, _], q, directions) = (model.dimensions(), noise.len(), *directions);
        let sides = (*particles).min(LANES).next_multiple_of(SIDE);
        step.lift(|step| {
            with_scalars::<Varied<E>, _>(2 * n, |scalars| {
                let (before, now) = scalars.split_at_mut(n);
                by_widest_vectors(
                    #[inline(always)]
                    || {
                        for lane in (0..sides).step_by(SIDE) {
                            for first in (0..directions.max(1)).step_by(E - 1) {
                                if let Some(previous) = previous {
                                    for (j, (before, value)) in before.iter_mut().zip(*previous).enumerate() {
                                        *before = varied(side(value, lane), q + j, first);
                                    }
                                }
                                let mut near = Near { noise, lane, of_noise: 0, first, drawn: 0 };
                                let before = previous.map(|_| &*before);
                                make_state(*model, step, before, &mut near, now);
                                // A number that no draw took is as wrong as one that is missing.
                                let is_whole = near.drawn == q;
                                for (i, (state, found)) in states.iter_mut().zip(&*now).enumerate() {
                                    let value = if is_whole { found.value() } else { Side::from(f64::NAN) };
                                    put(value, lane, state);
                                    let Some(row) =
                                        jacobian.get_mut(i * directions + first..(i + 1) * directions)
                                    else {
                                        continue;
                                    };
                                    for (place, derivative) in row.iter_mut().zip(found.derivatives()) {
                                        put(*derivative, lane, place);
                                    }
                                }
                            }
                        }
                    },
                );
            })
        });
    }
}
