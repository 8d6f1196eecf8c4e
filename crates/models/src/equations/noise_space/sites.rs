//! What a measurement says of a state: its score and its Fisher information, by locations and by scales.

use crate::Step;
use crate::batch::{LANES, by_widest_vectors};
use crate::equations::distribution::Distribution;
use crate::equations::family::Score;
use crate::equations::lanes::Lanes;
use crate::equations::scalar::Scalar;
use crate::equations::statement::{Coordinates, Equations};
use crate::equations::tiles::with_scalars;
use crate::equations::varied::{SIDE, Side, Varied, put, side, vary};
use crate::equations::wrapped::Wrapped;

/// Rows of `R` for each entry of a measurement: of its location, and of its scale.
const ROWS: usize = 2;

/// Adds up scores of particles from `lane` on along some coordinates from `first` on, and keeps roots of information.
struct Sites<'a> {
    measurement: &'a [Option<Lanes>],
    lane: usize,
    first: usize,
    n: usize,
    slopes: &'a mut [Lanes],
    roots: &'a mut [Lanes],
    at: usize,
}

/// What an entry says.
struct EntryTerms<const E: usize> {
    density: Varied<E>,
    /// Whether the density has no derivatives to go by, as where its range alone depends on the state.
    is_flat: bool,
    score: Score<Varied<E>>,
    spread: Option<[Varied<E>; 2]>,
}

/// A number that is finite, or 0.
#[inline(always)]
fn finite(value: Side) -> Side {
    Lanes(value.0.map(|value| if value.is_finite() { value } else { 0.0 }))
}

impl Sites<'_> {
    /// Keeps what the next entry says.
    #[inline(always)]
    fn keep<const E: usize>(&mut self, of: impl FnOnce(Varied<E>) -> EntryTerms<E>) {
        let (at, lane) = (self.at, self.lane);
        self.at += 1;
        let Some(entry) = self.measurement.get(at) else { return };
        let (begin, end) = (self.first, (self.first + E - 1).min(self.n));
        let [location, scale] = [ROWS * at, ROWS * at + 1].map(|row| row * self.n + begin);
        let zero = Side::from(0.0);
        let Some(y) = entry else {
            for row in [location, scale] {
                self.roots[row..row + end - begin].iter_mut().for_each(|place| put(zero, lane, place));
            }
            return;
        };
        let EntryTerms { density, is_flat, score, spread } = of(Varied::constant(side(y, lane)));
        let information = finite(score.information.value()).max(zero).sqrt();
        let (log_scale, of_scale) = match spread {
            Some([log_scale, information]) => (log_scale, information.value().sqrt()),
            None => (Varied::from(0.0), zero),
        };
        // Where the measurement is impossible, a score leads back.
        let impossible = density.value().0.map(|density| is_flat || density == f64::NEG_INFINITY);
        for (k, coordinate) in (begin..end).enumerate() {
            let along = score.location.derivatives()[k];
            let by_score = finite(score.slope.value() * along);
            let mut slope = finite(density.derivatives()[k]);
            for (slope, (by_score, impossible)) in slope.0.iter_mut().zip(by_score.0.iter().zip(impossible)) {
                *slope = if impossible { *by_score } else { *slope };
            }
            let sum = side(&self.slopes[coordinate], lane) + slope;
            put(sum, lane, &mut self.slopes[coordinate]);
            put(finite(information * along), lane, &mut self.roots[location + k]);
            put(finite(of_scale * log_scale.derivatives()[k]), lane, &mut self.roots[scale + k]);
        }
    }
}

impl<const E: usize> Coordinates<Varied<E>> for Sites<'_> {
    #[inline(always)]
    fn push(&mut self, distribution: Distribution<Varied<E>>) {
        self.keep(|y| EntryTerms {
            density: distribution.log_density(y),
            is_flat: matches!(distribution, Distribution::Uniform(_)),
            score: distribution.score(y),
            spread: distribution.spread(),
        });
    }

    #[inline(never)]
    fn push_wrapped(&mut self, wrapped: &Wrapped<'_, Varied<E>>) {
        self.keep(|y| EntryTerms {
            density: wrapped.log_density(y),
            is_flat: false,
            score: wrapped.score(y),
            spread: None,
        });
    }

    /// Along these coordinates it says nothing.
    #[inline(always)]
    fn pass_over(&mut self) {
        let (at, lane) = (self.at, self.lane);
        self.at += 1;
        let (begin, end) = (self.first, (self.first + E - 1).min(self.n));
        for row in [ROWS * at, ROWS * at + 1].map(|row| row * self.n + begin) {
            let Some(places) = self.roots.get_mut(row..row + end - begin) else { return };
            places.iter_mut().for_each(|place| put(Side::from(0.0), lane, place));
        }
    }
}

/// What [`NoiseSpace::tile_sites`](super::NoiseSpace::tile_sites) is asked.
pub(super) struct SiteQuery<'a, M> {
    pub(super) model: &'a M,
    /// The end of the step.
    pub(super) step: &'a Step<'a>,
    pub(super) states: &'a [Lanes],
    pub(super) measurement: &'a [Option<Lanes>],
    pub(super) particles: usize,
    pub(super) slopes: &'a mut [Lanes],
    pub(super) roots: &'a mut [Lanes],
}

impl<M: Equations> SiteQuery<'_, M> {
    /// Finds it along `E − 1` coordinates at a time.
    pub(super) fn along<const E: usize>(&mut self) {
        let SiteQuery { model, step, states, measurement, particles, slopes, roots } = self;
        let n = states.len();
        let sides = (*particles).min(LANES).next_multiple_of(SIDE);
        step.lift(|step| {
            with_scalars::<Varied<E>, _>(n, |point| {
                by_widest_vectors(
                    #[inline(always)]
                    || {
                        for lane in (0..sides).step_by(SIDE) {
                            slopes.iter_mut().for_each(|slope| put(Side::from(0.0), lane, slope));
                            for first in (0..n).step_by(E - 1) {
                                vary(states, lane, first, point);
                                let (slopes, roots) = (&mut **slopes, &mut **roots);
                                let mut sites = Sites { measurement, lane, first, n, slopes, roots, at: 0 };
                                let along = first..(first + E - 1).min(n);
                                model.measurement_along(step, &*point, along, &mut sites);
                            }
                        }
                    },
                );
            })
        });
    }
}
