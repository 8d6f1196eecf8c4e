//! How much faster one proposal is than another for the same error.

use super::equal_time::{EqualTime, Point};
use crate::contender::Contender;

/// Standard errors to either side of an interval that holds the truth in 90 of 100 cases.
const WITHIN_90: f64 = 1.645;

/// How many times as long another proposal takes for the same error of the log-evidence.
#[derive(Debug, Clone, PartialEq)]
pub struct Gain {
    /// The faster one, if the ratio is above 1.
    pub contender: Contender,
    /// The ratio of squared error times time, each with the number of particles for which it is least.
    pub ratio: f64,
    /// A 90 % interval of the ratio, by the jackknife over sequences; none where it is 0 or there is one sequence.
    pub interval: Option<[f64; 2]>,
}

impl EqualTime {
    /// The best designed filter, and the gain of every other contender over it, but for those that are a designed filter by another name; none where there is nothing to compare.
    pub fn gains(&self) -> Option<(Contender, Vec<Gain>)> {
        let mut contenders: Vec<&Contender> = self.points.iter().map(|point| &point.contender).collect();
        contenders.dedup();
        contenders.retain(|contender| contender.designed_filter().is_none());
        let of_all = |contender: &Contender| self.inefficiency(contender, None);
        let filters = contenders.iter().filter(|one| !one.looks_ahead() && !one.is_learned());
        let over = *filters.min_by(|a, b| of_all(a).total_cmp(&of_all(b)))?;
        // Where nothing is measured, nobody has an error.
        if self.points.iter().any(|point| point.contender == *over && point.is_exact()) {
            return None;
        }
        let sequences = self.points.first().map_or(0, |point| point.gaps.len());
        let gain = |contender: &Contender| {
            let log_ratio = |left_out| {
                self.inefficiency(over, left_out).ln() - self.inefficiency(contender, left_out).ln()
            };
            let ratio = log_ratio(None).exp();
            Gain {
                contender: contender.clone(),
                // Of two that collapsed nothing is known.
                ratio: if ratio.is_nan() { 0.0 } else { ratio },
                interval: interval(ratio, sequences, log_ratio),
            }
        };
        let others: Vec<Gain> = contenders.iter().filter(|one| **one != over).map(|one| gain(one)).collect();
        (!others.is_empty()).then(|| (over.clone(), others))
    }

    /// The least squared error times milliseconds of a contender, with or without one of the sequences; infinite if it collapsed with any number of particles.
    fn inefficiency(&self, contender: &Contender, left_out: Option<usize>) -> f64 {
        let own = self.points.iter().filter(|point| point.contender == *contender);
        own.map(|point| point.mean_square(left_out) * point.ms_per_step).fold(f64::INFINITY, f64::min)
    }
}

/// Whether the last of a contender's points, from few particles to many, has the least squared error for its time by a tenth or more.
pub(super) fn is_best_at_last(points: &[Point]) -> bool {
    let of = |point: &Point| point.mean_square(None) * point.ms_per_step;
    let Some((last, before)) = points.split_last() else { return false };
    before.iter().all(|point| 0.9 * of(point) > of(last)) || !of(last).is_finite()
}

fn interval(ratio: f64, sequences: usize, log_ratio: impl Fn(Option<usize>) -> f64) -> Option<[f64; 2]> {
    let count = sequences as f64;
    let without: Vec<f64> = (0..sequences).map(|at| log_ratio(Some(at))).collect();
    let mean = without.iter().sum::<f64>() / count;
    let squares: f64 = without.iter().map(|log| (log - mean).powi(2)).sum();
    let half = WITHIN_90 * ((count - 1.0) / count * squares).sqrt();
    let is_known = sequences > 1 && half.is_finite() && ratio > 0.0 && ratio.is_finite();
    is_known.then(|| [ratio / half.exp(), ratio * half.exp()])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::options::ProposalName;

    fn points(proposal: ProposalName, ms: f64, gaps: &[(usize, &[Option<f64>])]) -> Vec<Point> {
        let contender = Contender::of(&[proposal]).remove(0);
        let of_one = |(particles, gaps): &(usize, &[Option<f64>])| Point {
            contender: contender.clone(),
            particles: *particles,
            ms_per_step: ms * *particles as f64,
            gaps: gaps.to_vec(),
        };
        gaps.iter().map(of_one).collect()
    }

    #[test]
    fn gains_are_over_the_best_designed_filter_at_its_best_number_of_particles() {
        // Squared error times time: 9 and 4 of bootstrap, 8 of linearised, 1 of look-ahead.
        let mut all = points(
            ProposalName::Bootstrap,
            0.1,
            &[(10, &[Some(3.0), Some(-3.0)]), (100, &[Some(0.6), Some(-0.66)])],
        );
        all.extend(points(ProposalName::Linearised, 0.2, &[(10, &[Some(2.0), Some(2.0)])]));
        all.extend(points(ProposalName::LookAhead, 0.1, &[(10, &[Some(1.0), Some(1.0)])]));
        let (over, gains) = EqualTime { points: all }.gains().unwrap();
        assert_eq!(over.proposal(), &ProposalName::Bootstrap);
        let found: Vec<(&str, f64)> = gains.iter().map(|gain| (gain.contender.name(), gain.ratio)).collect();
        let expected = 10.0 * (0.36 + 0.4356) / 2.0;
        assert_eq!(found[0].0, "linearised");
        assert!((found[0].1 - expected / 8.0).abs() < 1e-12);
        assert!(found[1].0 == "look-ahead" && (found[1].1 - expected).abs() < 1e-12);
        // Without the first sequence the error is 0.66, without the second 0.6.
        let half = 1.645 * (0.5 * 2.0 * ((0.4356_f64 / 0.36).ln() / 2.0).powi(2)).sqrt();
        let [low, high] = gains[1].interval.unwrap();
        assert!((low * half.exp() / expected - 1.0).abs() < 1e-12 && low < expected && high > expected);
    }

    /// Catches an exact proposal whose gain is infinite, and `null` in a card.
    #[test]
    fn no_error_is_smaller_than_rounding() {
        let mut all = points(ProposalName::Bootstrap, 0.1, &[(10, &[Some(1.0), Some(1.0)])]);
        all.extend(points(ProposalName::LookAhead, 0.1, &[(10, &[Some(0.0), Some(-1e-14)])]));
        let (_, gains) = EqualTime { points: all }.gains().unwrap();
        assert!((gains[0].ratio / 1e24 - 1.0).abs() < 1e-9, "{}", gains[0].ratio);
        let exact = points(ProposalName::Bootstrap, 0.1, &[(10, &[Some(0.0); 3]), (100, &[Some(0.0); 3])]);
        assert_eq!(EqualTime { points: exact }.gains(), None);
    }

    #[test]
    fn a_collapse_is_no_gain_and_has_no_interval() {
        let mut all = points(ProposalName::Bootstrap, 0.1, &[(10, &[Some(1.0), Some(1.0)])]);
        all.extend(points(ProposalName::LookAhead, 0.1, &[(10, &[None, Some(1.0)])]));
        let (_, gains) = EqualTime { points: all.clone() }.gains().unwrap();
        assert_eq!((gains[0].ratio, gains[0].interval), (0.0, None));
        all.truncate(1);
        assert_eq!(EqualTime { points: all }.gains(), None);
        assert_eq!(EqualTime { points: vec![] }.gains(), None);
    }
}
