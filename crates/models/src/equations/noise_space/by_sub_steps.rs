//! States of steps with several sub-steps near a point: each sub-step is linearised alone, and their derivatives are multiplied.

use super::linearised::{Linearisation, Near, varied};
use crate::Step;
use crate::batch::{LANES, by_widest_vectors};
use crate::equations::lanes::Lanes;
use crate::equations::statement::Equations;
use crate::equations::tiles::with_scalars;
use crate::equations::varied::{SIDE, Side, Varied, put, side};

/// A sub-step near a point, of particles side by side.
struct Part<'a> {
    /// The states before it, and after it, `N` each.
    before: &'a mut [Side],
    after: &'a mut [Side],
    /// Its derivatives along the states before it, `N×N`, and along its draws, `N×Q` of all draws of the step.
    along_states: &'a mut [Side],
    along_noise: &'a mut [Side],
}

impl<M: Equations> Linearisation<'_, M> {
    /// As [`Linearisation::along`], by `(N + Q/S)/(E − 1)` evaluations for each of `S` sub-steps where all at once take `(N + Q)/(E − 1)`.
    pub(super) fn by_sub_steps<const E: usize>(&mut self, previous: &[Lanes]) {
        let Linearisation { model, step, noise, particles, directions, states, jacobian, .. } = self;
        let ([n, _], q, directions) = (model.dimensions(), noise.len(), *directions);
        let sides = (*particles).min(LANES).next_multiple_of(SIDE);
        step.lift(|step| {
            with_scalars::<Varied<E>, _>(2 * n, |scalars| {
                with_scalars::<Side, _>(n * (2 + n + q), |numbers| {
                    let (before, numbers) = numbers.split_at_mut(n);
                    let (after, numbers) = numbers.split_at_mut(n);
                    let (along_states, along_noise) = numbers.split_at_mut(n * n);
                    let mut part = Part { before, after, along_states, along_noise };
                    for lane in (0..sides).step_by(SIDE) {
                        part.before.iter_mut().zip(previous).for_each(|(to, from)| *to = side(from, lane));
                        let mut drawn = 0;
                        for sub_step in 0..step.sub_steps {
                            let noise = &noise[drawn..];
                            let near = |first| Near { noise, lane, of_noise: n, first, drawn: 0 };
                            let count = part.linearise(*model, step, sub_step, near, scalars);
                            part.compose(jacobian, lane, directions, [sub_step, drawn, count, q]);
                            drawn += count;
                            std::mem::swap(&mut part.before, &mut part.after);
                        }
                        // A number that no draw took is as wrong as one that is missing.
                        let is_whole = drawn == q;
                        for (state, found) in states.iter_mut().zip(&*part.before) {
                            put(if is_whole { *found } else { Side::from(f64::NAN) }, lane, state);
                        }
                    }
                });
            });
        });
    }
}

impl Part<'_> {
    /// Linearises a sub-step; how many numbers it draws.
    fn linearise<'n, const E: usize>(
        &mut self,
        model: &impl Equations,
        step: &Step<'_, Varied<E>>,
        sub_step: usize,
        near: impl Fn(usize) -> Near<'n>,
        scalars: &mut [Varied<E>],
    ) -> usize {
        let n = self.before.len();
        let (before, now) = scalars.split_at_mut(n);
        let part = step.part(sub_step, model.inputs().len());
        let (mut first, mut drawn) = (0, 0);
        // How many draws there are is known after the first evaluation.
        while first < n + drawn {
            by_widest_vectors(
                #[inline(always)]
                || {
                    for (j, (varied_state, value)) in before.iter_mut().zip(&*self.before).enumerate() {
                        *varied_state = varied(*value, j, first);
                    }
                    let mut near = near(first);
                    model.transition(&part, &*before, &mut near, now);
                    drawn = near.drawn;
                },
            );
            let most = self.along_noise.len() / n;
            for (i, found) in now.iter().enumerate() {
                self.after[i] = found.value();
                for (direction, derivative) in (first..).zip(found.derivatives()) {
                    match direction.checked_sub(n) {
                        None => self.along_states[i * n + direction] = *derivative,
                        Some(draw) if draw < drawn => self.along_noise[i * most + draw] = *derivative,
                        Some(_) => {}
                    }
                }
            }
            first += E - 1;
        }
        drawn
    }

    /// Multiplies the derivatives of all before by those along states, and puts in those along the draws of this sub-step.
    fn compose(
        &self,
        jacobian: &mut [Lanes],
        lane: usize,
        directions: usize,
        [sub_step, drawn, count, q]: [usize; 4],
    ) {
        let n = self.before.len();
        let most = self.along_noise.len() / n;
        by_widest_vectors(
            #[inline(always)]
            || {
                with_scalars::<Side, _>(n, |column| {
                    for direction in (0..drawn).chain(q..directions) {
                        if sub_step == 0 {
                            // The states themselves.
                            for i in 0..n {
                                put(
                                    self.along_states[i * n + direction - q],
                                    lane,
                                    &mut jacobian[i * directions + direction],
                                );
                            }
                            continue;
                        }
                        for (j, entry) in column.iter_mut().enumerate() {
                            *entry = side(&jacobian[j * directions + direction], lane);
                        }
                        for i in 0..n {
                            let row = &self.along_states[i * n..][..n];
                            let mut sum = Side::from(0.0);
                            for (factor, entry) in row.iter().zip(&*column) {
                                sum = sum + *factor * *entry;
                            }
                            put(sum, lane, &mut jacobian[i * directions + direction]);
                        }
                    }
                    for i in 0..n {
                        for draw in 0..count {
                            let place = &mut jacobian[i * directions + drawn + draw];
                            put(self.along_noise[i * most + draw], lane, place);
                        }
                    }
                });
            },
        );
    }
}
