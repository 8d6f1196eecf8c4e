//! Which estimator of the likelihood costs the least, and with how many particles.

use motes_models::Seed;

use crate::likelihood::{Estimator, Likelihood};
use crate::population::{FEWEST_PARTICLES, mean_variance};

/// The variance of `log ẑ` that is aimed at: between 1 and 3 the work for an independent draw is about the least (Doucet, Pitt, Deligiannidis and Kohn, 2015;
/// Sherlock, Thiery, Roberts and Rosenthal, 2015).
const VARIANCE: f64 = 1.5;

/// Estimates of each position.
const ESTIMATES: usize = 10;

/// Attempts to come near that variance: it falls as 1/K only where particles are many.
const ATTEMPTS: usize = 6;

/// The fewest and the most particles.
const PARTICLES: [f64; 2] = [FEWEST_PARTICLES as f64, 1e6];

/// A change of particles by more than this factor is not trusted at once.
const MOST_CHANGE: f64 = 8.0;

/// An estimator that was tuned.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Tuned {
    pub(crate) estimator: Estimator,
    /// The variance of `log ẑ` at the positions that were asked; 0 where it is exact.
    pub(crate) variance: f64,
}

/// Whether a variance is near enough to what is aimed at.
fn is_near(variance: f64) -> bool {
    (0.5..=2.0).contains(&(variance / VARIANCE))
}

/// The estimator of least cost at some positions in the bulk of the posterior; `before` is the one that served until now.
pub(crate) fn tune<L: Likelihood>(
    likelihood: &L,
    positions: &[&[f64]],
    before: Estimator,
    seed: &Seed,
) -> Result<Tuned, L::Error> {
    let costs = likelihood.estimators();
    if let Some(index) = costs.iter().position(|cost| cost.is_exact) {
        return Ok(Tuned { estimator: Estimator { index, ..before }, variance: 0.0 });
    }
    let mut best: Option<(f64, Tuned)> = None;
    // The one that is known to be affordable bounds what others may cost.
    let others = (0..costs.len()).filter(|index| *index != before.index);
    for index in [before.index].into_iter().chain(others) {
        let cost = costs[index];
        // No more particles than would cost as much as the best one so far.
        let most = best.map_or(PARTICLES[1], |(least, _)| (least - cost.fixed) / cost.per_particle);
        if most < PARTICLES[0] {
            continue;
        }
        let particles = match index == before.index {
            true => before.particles,
            // Where nothing is known of it, at most what the other costs.
            false => cost
                .particles_for(costs[before.index].of(before.particles))
                .clamp(FEWEST_PARTICLES, most as usize),
        };
        let seed = seed.nth(index as u64);
        let Some(tuned) = tune_one(likelihood, positions, Estimator { index, particles }, most, &seed)?
        else {
            continue;
        };
        let work = cost.of(tuned.estimator.particles);
        if best.is_none_or(|(least, _)| work < least) {
            best = Some((work, tuned));
        }
    }
    let most = Estimator { index: 0, particles: PARTICLES[1] as usize };
    Ok(best.map_or(Tuned { estimator: most, variance: f64::NAN }, |(_, tuned)| tuned))
}

/// The number of particles at which an estimator has about the variance; none where it would need more than `most`.
fn tune_one<L: Likelihood>(
    likelihood: &L,
    positions: &[&[f64]],
    mut estimator: Estimator,
    most: f64,
    seed: &Seed,
) -> Result<Option<Tuned>, L::Error> {
    let mut found = None;
    for attempt in 0..ATTEMPTS {
        let seed = seed.nth(attempt as u64);
        let variance = mean_variance(likelihood, positions, estimator, ESTIMATES, &seed)?;
        let factor = (variance / VARIANCE).clamp(1.0 / MOST_CHANGE, MOST_CHANGE);
        let particles = (estimator.particles as f64 * factor).clamp(PARTICLES[0], PARTICLES[1]).round();
        found = Some(Tuned { estimator, variance });
        if is_near(variance) || particles as usize == estimator.particles {
            break;
        }
        if particles > most {
            return Ok(None);
        }
        estimator.particles = particles as usize;
        // What was asked last is what is handed out, with the variance that it is expected to have.
        found = Some(Tuned { estimator, variance: variance / factor });
    }
    Ok(found.filter(|tuned| tuned.estimator.particles as f64 <= most))
}
