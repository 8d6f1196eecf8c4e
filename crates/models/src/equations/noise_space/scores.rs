//! What a measurement says of the noise: derivatives of its locations along draws.

use crate::Step;
use crate::batch::{LANES, by_widest_vectors};
use crate::equations::advance::make_state;
use crate::equations::distribution::Distribution;
use crate::equations::lanes::Lanes;
use crate::equations::linearise::Scores;
use crate::equations::scalar::Scalar;
use crate::equations::statement::{Draws, Equations};
use crate::equations::tiles::with_scalars;
use crate::equations::varied::{SIDE, Side, Varied, side};

/// Answers draws with `mean + sd·v` at `v = 0`, with derivatives along some of `v` from `first` on.
struct Around {
    first: usize,
    drawn: usize,
}

impl<const E: usize> Draws<Varied<E>> for Around {
    #[inline(always)]
    fn draw(&mut self, distribution: Distribution<Varied<E>>) -> Varied<E> {
        let [mean, variance] = distribution.moments();
        let direction = self.drawn.checked_sub(self.first).filter(|direction| *direction < E - 1);
        self.drawn += 1;
        match direction {
            None => mean,
            // At v = 0 the derivative of sd does not count; that of a root at 0 is no number.
            Some(direction) => {
                let sd = Varied::constant(variance.value().sqrt());
                mean + sd * Varied::variable(Side::from(0.0), direction)
            }
        }
    }
}

/// What [`NoiseSpace::tile_noise_scores`](super::NoiseSpace::tile_noise_scores) is asked.
pub(super) struct NoiseScores<'a, M> {
    pub(super) model: &'a M,
    pub(super) step: &'a Step<'a>,
    pub(super) previous: Option<&'a [Lanes]>,
    pub(super) draws: usize,
    pub(super) measurement: &'a [Option<Lanes>],
    pub(super) slopes: &'a mut [Lanes],
    pub(super) information: &'a mut [Lanes],
    pub(super) jacobian: &'a mut [Lanes],
}

impl<M: Equations> NoiseScores<'_, M> {
    /// Finds it along `E − 1` draws at a time.
    pub(super) fn along<const E: usize>(&mut self) {
        let NoiseScores { model, step, previous, draws, measurement, slopes, information, jacobian } = self;
        let ([n, _], q) = (model.dimensions(), *draws);
        step.lift(|step| {
            let end = step.end(model.inputs().len());
            with_scalars::<Varied<E>, _>(2 * n, |scalars| {
                let (before, now) = scalars.split_at_mut(n);
                by_widest_vectors(
                    #[inline(always)]
                    || {
                        for lane in (0..LANES).step_by(SIDE) {
                            if let Some(previous) = previous {
                                for (before, value) in before.iter_mut().zip(*previous) {
                                    *before = Varied::constant(side(value, lane));
                                }
                            }
                            for first in (0..q).step_by(E - 1) {
                                let mut around = Around { first, drawn: 0 };
                                let before = previous.map(|_| &*before);
                                make_state(*model, step, before, &mut around, now);
                                let (slopes, information, jacobian) =
                                    (&mut **slopes, &mut **information, &mut **jacobian);
                                let mut scores = Scores {
                                    measurement,
                                    lane,
                                    first,
                                    n: q,
                                    slopes,
                                    information,
                                    jacobian,
                                    at: 0,
                                };
                                model.measurement(&end, &*now, &mut scores);
                            }
                        }
                    },
                );
            })
        });
    }
}
