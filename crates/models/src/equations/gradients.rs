//! The gradients of what a model states, by numbers that carry derivatives.

use super::advance::make_state;
use super::lanes::Lanes;
use super::model::{Likelihood as OfMeasurement, Replay};
use super::statement::Equations;
use super::tiles::{rows_of, rows_of_mut, with_scalars};
use super::varied::{SIDE, Varied, put, vary};
use crate::batch::{LANES, by_widest_vectors, load, store, with_scratch};
use crate::{StateGradients, Step};

/// A log density that is asked for its derivatives.
trait Density {
    /// The step that it belongs to.
    fn step(&self) -> Step<'_>;

    /// At `point` (`N`), for the particles of a tile from `lane` on; the density may depend on `others`, a tile, and use the numbers of `own` (`N`). The state that is
    /// made of the point is `unused`.
    fn at<const E: usize>(
        &self,
        step: &Step<'_, Varied<E>>,
        point: &[Varied<E>],
        others: &[Lanes],
        lane: usize,
        own: &mut [Varied<E>],
        unused: &mut [Varied<E>],
    ) -> Varied<E>;
}

/// `p(x_0)`.
struct Initial<'a, M>(&'a M, Step<'a>);

impl<M: Equations> Density for Initial<'_, M> {
    fn step(&self) -> Step<'_> {
        self.1
    }

    #[inline(always)]
    fn at<const E: usize>(
        &self,
        step: &Step<'_, Varied<E>>,
        point: &[Varied<E>],
        _: &[Lanes],
        _: usize,
        _: &mut [Varied<E>],
        unused: &mut [Varied<E>],
    ) -> Varied<E> {
        let mut density = Replay::of(point);
        make_state(self.0, step, None, &mut density, unused);
        density.finish()
    }
}

/// `p(x_t | x_{t−1})` at points `x_{t−1}`.
struct OfPrevious<'a, M>(&'a M, Step<'a>);

impl<M: Equations> Density for OfPrevious<'_, M> {
    fn step(&self) -> Step<'_> {
        self.1
    }

    #[inline(always)]
    fn at<const E: usize>(
        &self,
        step: &Step<'_, Varied<E>>,
        point: &[Varied<E>],
        states: &[Lanes],
        lane: usize,
        now: &mut [Varied<E>],
        unused: &mut [Varied<E>],
    ) -> Varied<E> {
        vary(states, lane, states.len(), now);
        let mut density = Replay::of(now);
        make_state(self.0, step, Some(point), &mut density, unused);
        density.finish()
    }
}

/// `p(x_t | x_{t−1})` at points `x_t`.
struct OfState<'a, M>(&'a M, Step<'a>);

impl<M: Equations> Density for OfState<'_, M> {
    fn step(&self) -> Step<'_> {
        self.1
    }

    #[inline(always)]
    fn at<const E: usize>(
        &self,
        step: &Step<'_, Varied<E>>,
        point: &[Varied<E>],
        previous: &[Lanes],
        lane: usize,
        before: &mut [Varied<E>],
        unused: &mut [Varied<E>],
    ) -> Varied<E> {
        vary(previous, lane, previous.len(), before);
        let mut density = Replay::of(point);
        make_state(self.0, step, Some(&*before), &mut density, unused);
        density.finish()
    }
}

/// `p(y_t | x_t)`.
struct Likelihood<'a, M> {
    model: &'a M,
    step: Step<'a>,
    measurement: &'a [f64],
}

impl<M: Equations> Density for Likelihood<'_, M> {
    fn step(&self) -> Step<'_> {
        self.step
    }

    #[inline(always)]
    fn at<const E: usize>(
        &self,
        step: &Step<'_, Varied<E>>,
        point: &[Varied<E>],
        _: &[Lanes],
        _: usize,
        _: &mut [Varied<E>],
        _: &mut [Varied<E>],
    ) -> Varied<E> {
        let mut density = OfMeasurement::of(self.measurement);
        self.model.measurement(step, point, &mut density);
        density.finish()
    }
}

/// Fills `slopes` (`K×N`) with the derivatives of `density` at `states` (`K×N`); `others` (`K×N`, or none) are what it depends on besides.
fn fill_slopes(n: usize, states: &[f64], others: &[f64], density: &impl Density, slopes: &mut [f64]) {
    match n {
        0 => {}
        1 => along::<2>(n, states, others, density, slopes),
        // Two at a time: with four, all formulas are compiled once more, and computed little faster.
        _ => along::<3>(n, states, others, density, slopes),
    }
}

/// [`fill_slopes`] along `E − 1` coordinates at a time.
fn along<const E: usize>(
    n: usize,
    states: &[f64],
    others: &[f64],
    density: &impl Density,
    slopes: &mut [f64],
) {
    with_scratch(3 * n * LANES, |tiles| {
        // Lanes without a particle are computed, too: with numbers that are no danger.
        tiles.fill(0.0);
        let (tile, tiles) = tiles.split_at_mut(n * LANES);
        let (other, found) = tiles.split_at_mut(n * LANES);
        let step = density.step();
        step.lift(|step| {
            with_scalars::<Varied<E>, _>(3 * n, |scalars| {
                let (point, rest) = scalars.split_at_mut(n);
                let (own, unused) = rest.split_at_mut(n);
                by_widest_vectors(
                    #[inline(always)]
                    || {
                        let mut others = others.chunks(n * LANES);
                        for (states, slopes) in states.chunks(n * LANES).zip(slopes.chunks_mut(n * LANES)) {
                            load(states, n, tile);
                            if let Some(others) = others.next() {
                                load(others, n, other);
                            }
                            let (tile, other) = (rows_of(tile), rows_of(other));
                            for lane in (0..states.len() / n).step_by(SIDE) {
                                for first in (0..n).step_by(E - 1) {
                                    vary(tile, lane, first, point);
                                    let density = density.at(step, point, other, lane, own, unused);
                                    let slopes = &mut rows_of_mut(found)[first..];
                                    for (slope, derivative) in slopes.iter_mut().zip(density.derivatives()) {
                                        put(*derivative, lane, slope);
                                    }
                                }
                            }
                            store(found, n, slopes);
                        }
                    },
                );
            })
        });
    });
}

impl<M: Equations> StateGradients for M {
    fn initial_gradients(&self, step: &Step<'_>, states: &[f64], d_states: &mut [f64]) {
        fill_slopes(self.dimensions()[0], states, &[], &Initial(self, *step), d_states);
    }

    fn transition_gradients(
        &self,
        step: &Step<'_>,
        previous: &[f64],
        states: &[f64],
        d_previous: &mut [f64],
        d_states: &mut [f64],
    ) {
        let [n, _] = self.dimensions();
        fill_slopes(n, previous, states, &OfPrevious(self, *step), d_previous);
        fill_slopes(n, states, previous, &OfState(self, *step), d_states);
    }

    fn likelihood_gradients(
        &self,
        step: &Step<'_>,
        states: &[f64],
        measurement: &[f64],
        d_states: &mut [f64],
    ) {
        let density = Likelihood { model: self, step: step.end(self.inputs().len()), measurement };
        fill_slopes(self.dimensions()[0], states, &[], &density, d_states);
    }
}
