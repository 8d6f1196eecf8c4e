//! Iterated filtering: swarms of parameters that go uphill while they filter (Ionides, Nguyen, Atchadé, Stoev and King, 2015).

use motes_models::{Seed, fill_standard_normal};
use serde::{Deserialize, Serialize};

use super::height::height;
use super::point::Maximum;
use super::refinement::Refinement;
use super::settings::IteratedSettings;
use super::swarm_shape::mean;
use super::walks::{SPREADS, between};
use crate::error::FitError;
use crate::likelihood::{Estimator, Likelihood, PerturbedLikelihood};
use crate::parallel::map_on_threads;
use crate::prior_draw::PriorDraw;

/// The likelihood at the end of each round is that of so many estimates, with particles by such a factor.
const ESTIMATES: [(usize, usize); 2] = [(1, 16), (4, 8)];

/// Swarms under way, all of which have made as many passes: a first round by all of them, and a second one by the better half.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Swarms {
    /// Positions (`K×D`) of each that goes on; nothing before the first pass, and where all is done.
    positions: Vec<Vec<f64>>,
    /// Those of this round and of the one before.
    passes: usize,
    /// The second round; none before the first has ended.
    second: Option<Vec<Refinement>>,
}

/// The number of passes of each round.
fn rounds(settings: IteratedSettings) -> [usize; 2] {
    [settings.passes.div_ceil(2), settings.passes / 2]
}

/// So many of as many searches make a second round.
fn better_half(count: usize, settings: IteratedSettings) -> usize {
    if rounds(settings)[1] == 0 { 0 } else { count.div_ceil(2) }
}

impl Swarms {
    /// Pieces of work that are done, and of all.
    pub(super) fn progress(&self, count: usize, settings: IteratedSettings) -> (usize, usize) {
        let second = better_half(count, settings);
        let ended = if self.second.is_some() { count } else { 0 } + if self.are_done() { second } else { 0 };
        (self.passes + ended, settings.passes + count + second)
    }

    /// Whether no piece of work is left.
    pub(super) fn are_done(&self) -> bool {
        self.second.is_some() && self.positions.is_empty()
    }

    /// Takes each swarm through the data once more, the first time from draws of the prior; after the last pass of a round, finds how high they have come. `found` is where each search has ended, and empty
    /// before the end of the first round.
    pub(super) fn advance<L: Likelihood>(
        &mut self,
        likelihood: &L,
        perturbed: &dyn PerturbedLikelihood<Error = L::Error>,
        settings: IteratedSettings,
        found: &mut Vec<Maximum>,
        count: usize,
        seed: &Seed,
    ) -> Result<(), FitError<L::Error>> {
        let d = likelihood.dimension();
        let [first, second] = rounds(settings);
        let estimator = Estimator { index: perturbed.estimator(), particles: settings.particles };
        let end = |v: Vec<f64>, round: usize, seed: &Seed| {
            let (log_likelihood, standard_error) = height(likelihood, &v, estimator, ESTIMATES[round], seed)?;
            Ok(Maximum { v, log_likelihood, standard_error, spread: Vec::new(), estimator })
        };
        match &mut self.second {
            None if self.passes < first => {
                self.first_round(perturbed, settings, [count, d], seed)?;
                self.passes += 1;
            }
            None => {
                let seed = seed.child("height");
                let ends = self.positions.iter().enumerate();
                let ends = ends.map(|(at, positions)| end(mean(positions, d), 0, &seed.nth(at as u64)));
                *found = ends.collect::<Result<Vec<Maximum>, L::Error>>()?;
                refuse_impossible(found, &seed.nth(0))?;
                let refinements = self.refinements(perturbed, settings, found);
                self.positions = refinements.iter().map(|of| self.positions[of.number()].clone()).collect();
                self.second = Some(refinements);
            }
            Some(refinements) if self.passes < first + second => {
                let pass = self.passes - first;
                let moved = map_on_threads(&self.positions, |at, positions| {
                    let seed = seed.nth(refinements[at].number() as u64).child("second").nth(pass as u64);
                    refinements[at].advance(perturbed, positions, [pass, second], &seed)
                });
                let moved = moved.into_iter().collect::<Result<Vec<_>, L::Error>>()?;
                (self.positions, *refinements) = moved.into_iter().unzip();
                self.passes += 1;
            }
            Some(refinements) => {
                let seed = seed.child("second height");
                let ends = refinements
                    .iter()
                    .map(|refinement| end(refinement.mean(second), 1, &seed.nth(refinement.number() as u64)));
                let ends = ends.collect::<Result<Vec<Maximum>, L::Error>>()?;
                refinements.iter().zip(ends).for_each(|(of, end)| found[of.number()] = end);
                self.positions.clear();
            }
        }
        Ok(())
    }

    /// One pass more of the first round.
    fn first_round<E: Send>(
        &mut self,
        perturbed: &dyn PerturbedLikelihood<Error = E>,
        settings: IteratedSettings,
        [count, d]: [usize; 2],
        seed: &Seed,
    ) -> Result<(), E> {
        if self.positions.is_empty() {
            let numbers = settings.particles * d;
            self.positions = (0..count).map(|number| of_prior(numbers, &seed.nth(number as u64))).collect();
        }
        let walk = between(SPREADS, self.passes, rounds(settings)[0]);
        let moved = map_on_threads(&self.positions, |number, positions| {
            let mut positions = positions.clone();
            let seed = seed.nth(number as u64).child("pass").nth(self.passes as u64);
            perturbed.pass(&mut positions, walk, &seed).map(|()| positions)
        });
        self.positions = moved.into_iter().collect::<Result<Vec<Vec<f64>>, E>>()?;
        Ok(())
    }

    /// The better half of searches, whose swarms show the shape of the likelihood where they are.
    fn refinements<E: Send>(
        &self,
        perturbed: &dyn PerturbedLikelihood<Error = E>,
        settings: IteratedSettings,
        found: &[Maximum],
    ) -> Vec<Refinement> {
        let mut best: Vec<usize> = (0..found.len()).collect();
        best.sort_by(|a, b| found[*b].log_likelihood.total_cmp(&found[*a].log_likelihood));
        best.truncate(better_half(found.len(), settings));
        best.sort_unstable();
        let first = rounds(settings)[0];
        let last = between(SPREADS, first - 1, first);
        let refinement = |number: usize| {
            let steps = perturbed.steps(&found[number].v);
            Refinement::new(number, &self.positions[number], &steps, last)
        };
        best.into_iter().map(refinement).collect()
    }
}

/// So many standard normal numbers, in whose coordinates priors are standard normal.
fn of_prior(numbers: usize, seed: &Seed) -> Vec<f64> {
    let mut positions = vec![0.0; numbers];
    fill_standard_normal(&mut seed.child("prior").stream(), &mut positions);
    positions
}

/// An error where the likelihood is 0 at the ends of all searches.
fn refuse_impossible<E>(ends: &[Maximum], seed: &Seed) -> Result<(), FitError<E>> {
    match ends.first() {
        Some(first) if ends.iter().all(|end| end.log_likelihood == f64::NEG_INFINITY) => {
            let draw = PriorDraw { v: first.v.clone(), estimator: first.estimator, seed: seed.nth(0).nth(0) };
            Err(FitError::Impossible(Box::new(draw)))
        }
        _ => Ok(()),
    }
}
