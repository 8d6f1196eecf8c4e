//! Recorded series, split into what is learned from and what it is judged by.

use motes_models::{OwnModel, PartialMeasurements, Seed};
use motes_proposals::Amortised;
use motes_smc::{FilterBank, FilterError, FilterSettings};

use crate::TrainError;

/// One part in so many is held out: of the series, or of the times of the only one.
const ONE_IN: usize = 4;

/// A single series has at least so many times.
const LEAST_TIMES: usize = 8;

/// Particles of a filter that judges, how many such filters there are, and the share that is drawn from the transition as a user's filter does.
const PARTICLES: usize = 100;
const FILTERS: usize = 8;
const DEFENSIVE: f64 = 0.1;

/// Recorded series, and which of their times are held out.
pub(super) struct HeldOut<'a> {
    /// What is learned from: a series, and how many of its first times.
    pub(super) learned: Vec<(&'a PartialMeasurements, usize)>,
    /// What it is judged by: a series, and from which time on.
    judged: Vec<(&'a PartialMeasurements, usize)>,
}

impl<'a> HeldOut<'a> {
    /// Holds out the last series, one in four, or the last quarter of the only one.
    ///
    /// # Errors
    /// [`TrainError::Recorded`] for a single series that is too short.
    pub(super) fn of(recorded: &'a [PartialMeasurements]) -> Result<Self, TrainError> {
        if let [one] = recorded {
            if one.len() < LEAST_TIMES {
                let reason = format!(
                    "the only series has {} times; {LEAST_TIMES} are needed to hold some out",
                    one.len()
                );
                return Err(TrainError::Recorded { reason });
            }
            let from = one.len() - one.len() / ONE_IN;
            return Ok(HeldOut { learned: vec![(one, from)], judged: vec![(one, from)] });
        }
        let first = recorded.len() - (recorded.len() / ONE_IN).max(1);
        let (learned, judged) = recorded.split_at(first);
        Ok(HeldOut {
            learned: learned.iter().map(|series| (series, series.len())).collect(),
            judged: judged.iter().map(|series| (series, 0)).collect(),
        })
    }

    /// The mean log-evidence per held-out time, of a few filters with the present weights; −∞ if one of them collapses.
    ///
    /// The same seed makes two proposals comparable.
    pub(super) fn log_evidence(
        &self,
        proposal: &Amortised,
        model: &(impl OwnModel + ?Sized),
        seed: &Seed,
    ) -> Result<f64, TrainError> {
        let settings = FilterSettings { defensive_weight: Some(DEFENSIVE), ..FilterSettings::new(PARTICLES) };
        let (mut sum, mut times) = (0.0, 0);
        for (number, (series, from)) in self.judged.iter().enumerate() {
            let seed = seed.nth(number as u64);
            let failed = |error: FilterError| TrainError::Recorded { reason: error.to_string() };
            let bank = FilterBank::new(model, proposal.clone(), settings, FILTERS, &seed);
            let mut bank = bank.map_err(failed)?;
            for (time, row) in series.rows().enumerate() {
                if time == *from {
                    sum -= (0..FILTERS).map(|filter| bank.log_evidence(filter)).sum::<f64>();
                }
                if bank.step_at(&model.step_of_index(time), row).is_err() {
                    return Ok(f64::NEG_INFINITY);
                }
            }
            sum += (0..FILTERS).map(|filter| bank.log_evidence(filter)).sum::<f64>();
            times += series.len() - from;
        }
        Ok(sum / (FILTERS * times) as f64)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_time_that_is_judged_by_is_learned_from() {
        let series = |times: usize| PartialMeasurements::new(1, vec![Some(0.0); times]).unwrap();
        let one = [series(10)];
        let HeldOut { learned, judged } = HeldOut::of(&one).unwrap();
        assert_eq!((learned[0].1, judged[0].1), (8, 8));
        for count in 2..12 {
            let all: Vec<PartialMeasurements> = (0..count).map(|at| series(3 + at)).collect();
            let HeldOut { learned, judged } = HeldOut::of(&all).unwrap();
            assert!(!learned.is_empty() && !judged.is_empty());
            assert_eq!(learned.len() + judged.len(), count);
            assert!(learned.iter().all(|(one, _)| judged.iter().all(|(other, _)| one.len() != other.len())));
        }
        assert!(HeldOut::of(&[series(7)]).is_err());
    }
}
