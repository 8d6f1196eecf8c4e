//! From the particles of a time to those that they come from.

use motes_models::batch::{Rows, with_scratch};
use motes_models::elementary::exp;
use motes_models::{Stream, TransitionDensity};
use rand::RngExt;

use super::by_weight::ByWeight;
use super::error::SmoothingError;
use super::history::Generation;

/// Densities that [`backward_simulation`](crate::backward_simulation) computes for a path at a time: that of the filter's ancestor, and those of 15 proposals.
///
/// One proposal is enough for the error to be bounded. In five coupled coordinates, means by one have a fifth more error than means by 63, and those by 15 no
/// more; in one coordinate none of these differ.
pub const DENSITIES_PER_MOVE: usize = 16;

/// Paths whose densities are computed in one batch, and which share a stream.
pub(super) const PATHS_TOGETHER: usize = 32;

/// A time `t` and the one after it.
pub(super) struct Moves<'a> {
    pub(super) density: &'a dyn TransitionDensity,
    /// `N`.
    pub(super) width: usize,
    /// `t`.
    pub(super) time: usize,
    pub(super) generation: &'a Generation,
    /// Draws particles of `t`.
    pub(super) by_weight: ByWeight<'a>,
    /// The particles of `t + 1`.
    pub(super) next: &'a Generation,
}

impl Moves<'_> {
    /// Takes up to [`PATHS_TOGETHER`] paths from particles of `t + 1` to particles of `t`.
    pub(super) fn take(&self, paths: &mut [usize], stream: &mut Stream) -> Result<(), SmoothingError> {
        const EACH: usize = DENSITIES_PER_MOVE;
        let (width, next) = (self.width, self.next);
        let mut candidates = [[0; EACH]; PATHS_TOGETHER];
        let candidates = &mut candidates[..paths.len()];
        with_scratch(paths.len() * EACH * (1 + width), |scratch| {
            let (log_densities, states) = scratch.split_at_mut(paths.len() * EACH);
            for ((candidates, rows), path) in
                candidates.iter_mut().zip(states.chunks_exact_mut(EACH * width)).zip(&*paths)
            {
                candidates.fill_with(|| self.by_weight.draw(stream.random()));
                candidates[0] = next.ancestors[*path];
                let state = next.state(*path, width);
                rows.chunks_exact_mut(width).for_each(|row| row.copy_from_slice(state));
            }
            let from = Rows::picked(&self.generation.states, width, candidates.as_flattened());
            self.density.log_densities(&next.step.step(), Some(from), states, log_densities);
            // Where weights know what comes later, densities must not say it again.
            for (log_density, particle) in log_densities.iter_mut().zip(candidates.as_flattened()) {
                *log_density -= self.generation.log_look_ahead(*particle);
            }
            let (log_densities, _) = log_densities.as_chunks::<EACH>();
            for ((path, candidates), log_densities) in paths.iter_mut().zip(&*candidates).zip(log_densities) {
                // An infinite density is one of a model that is none, as it is for a filter.
                if log_densities.iter().any(|density| density.is_nan() || *density == f64::INFINITY) {
                    return Err(SmoothingError::NoAncestor { time: self.time });
                }
                *path = match log_densities[0] == f64::NEG_INFINITY {
                    true => self.draw_exactly(next.state(*path, width), stream)?,
                    false => candidates[metropolis(log_densities, stream)],
                };
            }
            Ok(())
        })
    }

    /// Draws the particle that a state at `t + 1` comes from, by the densities of all.
    fn draw_exactly(&self, state: &[f64], stream: &mut Stream) -> Result<usize, SmoothingError> {
        let (width, generation) = (self.width, self.generation);
        let particles = generation.log_weights.len();
        with_scratch(particles * (1 + width), |scratch| {
            let (log_weights, states) = scratch.split_at_mut(particles);
            states.chunks_exact_mut(width).for_each(|row| row.copy_from_slice(state));
            let from = Rows::all(&generation.states, width);
            self.density.log_densities(&self.next.step.step(), Some(from), states, log_weights);
            for (particle, (log_weight, own)) in
                log_weights.iter_mut().zip(&generation.log_weights).enumerate()
            {
                // A particle without weight is none, whatever its density.
                *log_weight = match *own == f64::NEG_INFINITY {
                    true => *own,
                    false => *log_weight + own - generation.log_look_ahead(particle),
                };
            }
            let by_weight =
                ByWeight::new(log_weights).ok_or(SmoothingError::NoAncestor { time: self.time })?;
            Ok(by_weight.draw(stream.random()))
        })
    }
}

/// Where a chain ends that starts at the first of some points and to which the others are proposed in turn, all drawn from one distribution: `log_densities`
/// are those of the stationary distribution with respect to it.
fn metropolis(log_densities: &[f64], stream: &mut Stream) -> usize {
    let mut at = 0;
    for (proposed, log_density) in log_densities.iter().enumerate().skip(1) {
        let uniform: f64 = stream.random();
        if uniform < exp((log_density - log_densities[at]).min(0.0)) {
            at = proposed;
        }
    }
    at
}

#[cfg(test)]
mod tests {
    use motes_models::{Seed, Step, StepRecord};

    use super::*;

    /// A transition whose density is `x_t` whatever `x_{t+1}` is, so that a test can choose densities.
    struct Chosen;

    impl TransitionDensity for Chosen {
        fn log_densities(&self, _: &Step<'_>, previous: Option<Rows<'_>>, _: &[f64], out: &mut [f64]) {
            let Some(previous) = previous else { return out.fill(0.0) };
            out.iter_mut().enumerate().for_each(|(row, out)| *out = previous.row(row)[0].ln());
        }
    }

    const PATHS: usize = 1 << 18;
    const WEIGHTS: [f64; 6] = [0.15, 0.3, 0.05, 0.0, 0.1, 0.4];

    fn generation(states: Vec<f64>, weights: &[f64], ancestors: Vec<usize>) -> Generation {
        Generation {
            step: StepRecord::default(),
            states,
            log_weights: weights.iter().map(|weight| weight.ln()).collect(),
            ancestors,
            look_ahead: vec![],
        }
    }

    /// The shares of the particles that many paths come from by these densities, if `ancestor` says which the filter drew theirs from.
    fn shares(densities: [f64; 6], ancestor: &dyn Fn(f64) -> usize) -> Result<[f64; 6], SmoothingError> {
        let mut stream = Seed::from_u64(70).stream();
        let from = generation(densities.to_vec(), &WEIGHTS, vec![0; 6]);
        let ancestors = (0..PATHS).map(|_| ancestor(stream.random())).collect();
        let next = Generation {
            step: StepRecord::default(),
            states: vec![0.0; PATHS],
            log_weights: vec![],
            ancestors,
            look_ahead: vec![],
        };
        let mut log_weights = from.log_weights.clone();
        let by_weight = ByWeight::new(&mut log_weights).unwrap();
        let moves = Moves { density: &Chosen, width: 1, time: 0, generation: &from, by_weight, next: &next };
        let mut paths: Vec<usize> = (0..PATHS).collect();
        paths.chunks_mut(PATHS_TOGETHER).try_for_each(|paths| moves.take(paths, &mut stream))?;
        let mut shares = [0.0; 6];
        paths.into_iter().for_each(|particle| shares[particle] += 1.0 / PATHS as f64);
        Ok(shares)
    }

    /// `π(k) ∝ W^k` times the density.
    fn exact(densities: [f64; 6]) -> [f64; 6] {
        let mut shares = [0, 1, 2, 3, 4, 5].map(|k| WEIGHTS[k] * densities[k]);
        let total: f64 = shares.iter().sum();
        shares.iter_mut().for_each(|share| *share /= total);
        shares
    }

    /// The largest difference, in standard errors.
    fn score(found: [f64; 6], expected: [f64; 6]) -> f64 {
        found.iter().zip(expected).fold(0.0, |largest: f64, (found, p)| {
            let error = (p * (1.0 - p) / PATHS as f64).sqrt().max(1e-12);
            largest.max((found - p).abs() / error)
        })
    }

    /// What a uniform number falls on.
    fn drawn(shares: [f64; 6]) -> impl Fn(f64) -> usize {
        move |uniform| {
            let mut sum = 0.0;
            shares
                .iter()
                .position(|share| {
                    sum += share;
                    uniform < sum
                })
                .unwrap_or(5)
        }
    }

    #[test]
    fn moves_leave_the_distribution_of_ancestors_as_it_is() {
        // A proposal is rarely accepted where one density is so much larger than others.
        for densities in [[1.0, 2.0, 0.5, 9.0, 1.5, 0.8], [1e-3, 1e-4, 80.0, 9.0, 1e-2, 1e-5]] {
            let found = score(shares(densities, &drawn(exact(densities))).unwrap(), exact(densities));
            // What accepts every proposal draws by the weights.
            let planted = score(WEIGHTS, exact(densities));
            println!("moves: z = {found:.1}, planted {planted:.0}");
            assert!(found < 4.5 && planted > 20.0);
        }
    }

    #[test]
    fn moves_forget_the_ancestor_where_many_particles_lead_to_a_state() {
        let densities = [1.0, 1.4, 0.7, 9.0, 1.2, 0.8];
        let found = shares(densities, &|_| 2).unwrap();
        assert!(score(found, exact(densities)) < 4.5, "{found:?}");
    }

    #[test]
    fn an_ancestor_that_cannot_lead_there_is_drawn_exactly() {
        let densities = [1e-9, 0.0, 1e9, 5.0, 0.0, 2e8];
        let found = shares(densities, &|uniform| if uniform < 0.5 { 1 } else { 4 }).unwrap();
        assert!(score(found, exact(densities)) < 4.5, "{found:?}");
    }

    #[test]
    fn no_ancestor_and_no_number_are_refused() {
        let none = Err(SmoothingError::NoAncestor { time: 0 });
        assert_eq!(shares([0.0, 0.0, 0.0, 7.0, 0.0, 0.0], &|_| 1), none);
        assert_eq!(shares([1.0, -1.0, 1.0, 1.0, 1.0, 1.0], &|_| 0), none);
        assert_eq!(shares([1.0, f64::INFINITY, 1.0, 1.0, 1.0, 1.0], &|_| 0), none);
    }
}
