//! Whether a filter misses mass more often than a bootstrap filter beside it.

use serde::{Deserialize, Serialize};

use super::windows::Since;

/// How many misses of the filter there must be for each of the bootstrap and one more.
const FOR_EACH_OF_BOOTSTRAP: usize = 7;

/// Misses so far.
///
/// A filter that misses as often as the bootstrap is suspected with a probability of at most about `2⁻⁷`: its first seven misses would all have to come
/// before the first one of the bootstrap, or something as unlikely later on.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub(super) struct Misses {
    of_filter: usize,
    of_bootstrap: usize,
    first: Option<Since>,
}

impl Misses {
    /// Takes in a miss of the bootstrap.
    pub(super) fn bootstrap_missed(&mut self) {
        self.of_bootstrap += 1;
    }

    /// Takes in a miss of the filter. Where it is now believed to miss too often: its first miss.
    pub(super) fn filter_missed(&mut self, miss: Since) -> Option<Since> {
        self.of_filter += 1;
        let first = *self.first.get_or_insert(miss);
        (self.of_filter >= FOR_EACH_OF_BOOTSTRAP * (self.of_bootstrap + 1)).then_some(first)
    }
}

#[cfg(test)]
mod tests {
    use motes_models::Seed;
    use rand::RngExt;

    use super::*;
    use crate::evidence::AncestryVariance;
    use crate::second_opinion::windows::Windows;

    fn miss_at(step: usize) -> Since {
        let errors = [AncestryVariance::default(), AncestryVariance::default()];
        let mut windows = Windows::default();
        windows.step(step, 0.0, &errors);
        windows.ending_now().next().unwrap().1
    }

    /// Runs it on misses of these probabilities in each step: from which step on it believes that there are too many.
    fn run(seed: &Seed, steps: usize, of_filter: f64, of_bootstrap: f64) -> Option<usize> {
        let (mut misses, mut stream) = (Misses::default(), seed.stream());
        (0..steps).find_map(|step| {
            let chance = stream.random::<f64>();
            if chance < of_filter {
                return misses.filter_missed(miss_at(step)).map(|first| first.step);
            }
            if chance > 1.0 - of_bootstrap {
                misses.bootstrap_missed();
            }
            None
        })
    }

    #[test]
    fn a_filter_that_misses_as_often_as_the_bootstrap_is_hardly_ever_suspected() {
        const RUNS: u64 = 2000;
        for rate in [0.001, 0.005, 0.02, 0.1, 0.4] {
            let suspected =
                (0..RUNS).filter(|number| run(&Seed::from_u64(5).nth(*number), 1000, rate, rate).is_some());
            let share = suspected.count() as f64 / RUNS as f64;
            // 2⁻⁷ and four standard errors of its estimate.
            assert!(share <= 0.0078 + 4.0 * (0.0078_f64 / RUNS as f64).sqrt(), "{rate}: {share}");
        }
    }

    #[test]
    fn one_that_misses_often_is_found_from_its_first_miss_on() {
        let found: Vec<usize> =
            (0..200).filter_map(|number| run(&Seed::from_u64(6).nth(number), 100, 0.2, 0.002)).collect();
        assert!(found.len() > 190, "{} of 200", found.len());
        assert!(found.iter().filter(|first| **first < 30).count() > 190);
    }
}
