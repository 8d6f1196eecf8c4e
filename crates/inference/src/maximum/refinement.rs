//! The second round of a search by iterated filtering.

use motes_models::Seed;
use serde::{Deserialize, Serialize};

use super::swarm_shape::{factor, inverse_curvature, mean, mixed};
use super::walks::{between, variance};
use crate::likelihood::{PerturbedLikelihood, RandomWalk};

/// How far a swarm goes in the first pass of the second round and in the last one, in standard deviations of the likelihood: a pass takes it nearer to the maximum by about that share of the way.
const RATES: [f64; 2] = [0.6, 0.1];

/// A search in the second round. Its walk has the shape of the likelihood, so that coordinates of which the data say little and combinations that they trade off come as near as others.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct Refinement {
    number: usize,
    /// The inverse of the likelihood's curvature (`D×D`), as far as it is known.
    inverse_curvature: Vec<f64>,
    /// The sum of where the swarm was after each of the later passes (`D`): its mean has less noise than that of the last.
    sum: Vec<f64>,
}

impl Refinement {
    /// That of a search whose swarm was in some positions (`K×D`) after a pass by a walk with so long steps.
    pub(super) fn new(number: usize, positions: &[f64], steps: &[f64], walk: RandomWalk<'_>) -> Self {
        let d = steps.len();
        let diagonal = |of: &dyn Fn(usize) -> f64| -> Vec<f64> {
            (0..d * d).map(|at| if at / d == at % d { of(at / d) } else { 0.0 }).collect()
        };
        let steps = diagonal(&|at| steps[at] * steps[at]);
        let shown = inverse_curvature(positions, &steps, variance(walk), d);
        let inverse_curvature = shown.unwrap_or_else(|| diagonal(&|_| 1.0));
        Refinement { number, inverse_curvature, sum: vec![0.0; d] }
    }

    /// The number of the search.
    pub(super) fn number(&self) -> usize {
        self.number
    }

    /// Where the swarm is after a pass of so many more, and what is known then.
    pub(super) fn advance<E: Send>(
        &self,
        perturbed: &dyn PerturbedLikelihood<Error = E>,
        positions: &[f64],
        [pass, passes]: [usize; 2],
        seed: &Seed,
    ) -> Result<(Vec<f64>, Refinement), E> {
        let d = self.sum.len();
        let (mut positions, mut after) = (positions.to_vec(), self.clone());
        let directions = factor(&self.inverse_curvature, d);
        let walk = RandomWalk { directions: directions.as_deref(), ..between(RATES, pass, passes) };
        perturbed.pass(&mut positions, walk, seed)?;
        if let Some(shown) = inverse_curvature(&positions, &self.inverse_curvature, variance(walk), d) {
            after.inverse_curvature = mixed(&self.inverse_curvature, &shown);
        }
        if pass >= passes / 2 {
            let mean = mean(&positions, d);
            after.sum.iter_mut().zip(mean).for_each(|(sum, mean)| *sum += mean);
        }
        Ok((positions, after))
    }

    /// The mean of where it was after the later half of so many passes (`D`).
    pub(super) fn mean(&self, passes: usize) -> Vec<f64> {
        let later = (passes - passes / 2) as f64;
        self.sum.iter().map(|sum| sum / later).collect()
    }
}
