//! Wald's sequential test of whether a filter misses mass more often than the bootstrap does.

use super::windows::Since;

/// How many times as often as the bootstrap a filter misses mass that is to be warned of.
const TIMES_AS_OFTEN: f64 = 8.0;

/// Odds from which on that is believed. Of filters that miss as often as the bootstrap, at most one in so many ever gets there.
const BELIEVED: f64 = 200.0;

/// What is assumed of the bootstrap before anything is known: it misses once in so many steps.
const STEPS_FOR_A_MISS: f64 = 100.0;

/// The odds that the filter misses mass eight times as often as the bootstrap, against as often.
///
/// How often the bootstrap does is learned on the way. The filter may have begun to miss at the start or just after any miss. The `n`-th of these beginnings
/// has the share `1/(n(n + 1))` of the odds.
#[derive(Debug, Clone)]
pub(super) struct Odds {
    steps: f64,
    misses_of_bootstrap: f64,
    beginnings: f64,
    /// The odds of all beginnings that were, together.
    odds: f64,
    likeliest: Beginning,
}

/// The beginning with the largest odds.
#[derive(Debug, Clone)]
struct Beginning {
    odds: f64,
    /// The first miss of the filter from it on.
    first_miss: Option<Since>,
}

impl Default for Odds {
    fn default() -> Self {
        let likeliest = Beginning { odds: 0.5, first_miss: None };
        Odds { steps: 0.0, misses_of_bootstrap: 0.0, beginnings: 1.0, odds: 0.5, likeliest }
    }
}

impl Odds {
    /// Takes in a step at which the filter missed nothing.
    pub(super) fn step(&mut self) {
        let rate = (1.0 + self.misses_of_bootstrap) / (STEPS_FOR_A_MISS + self.steps);
        // So that eight times as often is at most every other step.
        let rate = rate.min(0.5 / TIMES_AS_OFTEN);
        self.multiply((1.0 - TIMES_AS_OFTEN * rate) / (1.0 - rate));
    }

    /// Takes in a miss of the bootstrap.
    pub(super) fn bootstrap_missed(&mut self) {
        self.step();
        self.misses_of_bootstrap += 1.0;
        self.begin(None);
    }

    /// Takes in a miss of the filter. Where it is now believed to miss too often: the first of these misses.
    pub(super) fn filter_missed(&mut self, miss: Since) -> Option<Since> {
        self.multiply(TIMES_AS_OFTEN);
        let first = *self.likeliest.first_miss.get_or_insert(miss);
        self.begin(Some(miss));
        (self.odds >= BELIEVED).then_some(first)
    }

    fn multiply(&mut self, by: f64) {
        self.steps += 1.0;
        self.odds *= by;
        self.likeliest.odds *= by;
    }

    /// Another beginning, just after a miss, which is the first if it is the filter's.
    fn begin(&mut self, first_miss: Option<Since>) {
        self.beginnings += 1.0;
        let share = 1.0 / (self.beginnings * (self.beginnings + 1.0));
        self.odds += share;
        if share > self.likeliest.odds {
            self.likeliest = Beginning { odds: share, first_miss };
        }
    }
}

#[cfg(test)]
mod tests {
    use motes_models::Seed;
    use rand::RngExt;

    use super::*;
    use crate::second_opinion::evidence_error::EvidenceError;
    use crate::second_opinion::windows::Windows;

    fn miss_at(step: usize) -> Since {
        let errors = [EvidenceError::default(), EvidenceError::default()];
        let mut windows = Windows::default();
        windows.step(step, 0.0, &errors);
        windows.ending_now().next().unwrap().1
    }

    /// Runs the test on misses of these probabilities in each step: whether it believes, and from which step on.
    fn run(seed: &Seed, steps: usize, of_filter: impl Fn(usize) -> f64, of_bootstrap: f64) -> Option<usize> {
        let (mut odds, mut stream) = (Odds::default(), seed.stream());
        (0..steps).find_map(|step| {
            let chance = stream.random::<f64>();
            if chance < of_filter(step) {
                return odds.filter_missed(miss_at(step)).map(|first| first.step);
            }
            match chance > 1.0 - of_bootstrap {
                true => odds.bootstrap_missed(),
                false => odds.step(),
            }
            None
        })
    }

    #[test]
    fn a_filter_that_misses_as_often_as_the_bootstrap_is_hardly_ever_suspected() {
        const RUNS: u64 = 2000;
        // Up to twice as often as is assumed at first, and ten times as often, which has to be learned.
        for (rate, most) in [(0.001, 0.005), (0.005, 0.005), (0.02, 0.01), (0.1, 0.05)] {
            let suspected =
                (0..RUNS).filter(|run_| run(&Seed::from_u64(5).nth(*run_), 1000, |_| rate, rate).is_some());
            let share = suspected.count() as f64 / RUNS as f64;
            println!("misses at {rate} of steps: suspected {share}");
            let error = (most * (1.0 - most) / RUNS as f64).sqrt();
            assert!(share <= most + 4.0 * error, "{rate}: {share}");
        }
    }

    #[test]
    fn one_that_misses_often_is_found_soon_and_where_it_begins() {
        for at in [0, 700] {
            let of_filter = |step: usize| if step >= at { 0.2 } else { 0.002 };
            let found: Vec<usize> = (0..200)
                .filter_map(|seed| run(&Seed::from_u64(6).nth(seed), at + 60, of_filter, 0.002))
                .collect();
            assert!(found.len() > 190, "{} of 200 from {at} on", found.len());
            let near = found.iter().filter(|first| (at..at + 60).contains(*first)).count();
            assert!(near > 190, "{near} of 200 from {at} on");
        }
    }
}
