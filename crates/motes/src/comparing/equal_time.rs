//! Error against time: which proposal is worth its cost, and from where to where.

use std::fmt;

use super::card::{Steps, totals};
use crate::contender::Contender;

/// What rounding leaves of an error of the log-evidence: no proposal is known to be better than this.
const ROUNDING: f64 = 1e-12;

/// A contender with some particles.
#[derive(Debug, Clone, PartialEq)]
pub struct Point {
    /// The contender.
    pub contender: Contender,
    /// `K`.
    pub particles: usize,
    /// Milliseconds for a step.
    pub ms_per_step: f64,
    /// The log-evidence of each sequence less that of the reference; none if the filter collapsed.
    pub gaps: Vec<Option<f64>>,
}

impl Point {
    pub(super) fn of(contender: Contender, particles: usize, runs: &[Steps]) -> Self {
        let gaps = runs.iter().map(|run| run.log_evidence_gap).collect();
        let (times, seconds) = totals(runs);
        Point { contender, particles, ms_per_step: 1e3 * seconds / times, gaps }
    }

    /// The root mean square of the log-evidence's distance from the reference; none if a filter collapsed.
    pub fn error(&self) -> Option<f64> {
        Some(self.mean_square(None).sqrt()).filter(|error| error.is_finite())
    }

    /// The mean square of that distance, with or without one of the sequences; infinite if a filter collapsed.
    pub(super) fn mean_square(&self, left_out: Option<usize>) -> f64 {
        let gaps = self.gaps.iter().enumerate().filter(|(at, _)| Some(*at) != left_out).map(|(_, gap)| gap);
        // A distance that is no number stays none.
        let at_least = |gap: f64| if gap.abs() < ROUNDING { ROUNDING } else { gap };
        let squares: Vec<f64> =
            gaps.map(|gap| gap.map_or(f64::INFINITY, |gap| at_least(gap).powi(2))).collect();
        squares.iter().sum::<f64>() / squares.len() as f64
    }

    /// Whether all that is left of the error is rounding.
    pub(super) fn is_exact(&self) -> bool {
        self.gaps.iter().all(|gap| gap.is_some_and(|gap| gap.abs() <= ROUNDING))
    }
}

/// All points of all proposals.
#[derive(Debug, Clone, PartialEq)]
pub struct EqualTime {
    /// One after another, particles from few to many.
    pub points: Vec<Point>,
}

/// The time for a step at which a proposal has a given error.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum TimeToError {
    /// Between two numbers of particles that were timed.
    At {
        /// Milliseconds for a step.
        ms: f64,
        /// `K`, between the two in logarithms.
        particles: f64,
    },
    /// With the fewest particles that were timed, and perhaps with fewer.
    AtMost {
        /// Milliseconds for a step.
        ms: f64,
        /// `K`.
        particles: usize,
    },
    /// With none that were timed.
    Not,
}

impl TimeToError {
    /// Milliseconds for a step, where the error was reached.
    pub fn ms(self) -> Option<f64> {
        match self {
            TimeToError::At { ms, .. } | TimeToError::AtMost { ms, .. } => Some(ms),
            TimeToError::Not => None,
        }
    }
}

impl fmt::Display for TimeToError {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            TimeToError::At { ms, particles } => {
                write!(formatter, "{} ms a step (K = {particles:.0})", short(*ms))
            }
            TimeToError::AtMost { ms, particles } => {
                write!(formatter, "at most {} ms a step (K = {particles})", short(*ms))
            }
            TimeToError::Not => formatter.write_str("not reached"),
        }
    }
}

impl EqualTime {
    /// What each contender takes for an error of `error`, between its points in logarithms: the first number of particles from which on the error stays
    /// below. A filter that collapsed has an infinite error.
    pub fn reaching(&self, error: f64) -> Vec<(Contender, TimeToError)> {
        let mut names: Vec<&Contender> = self.points.iter().map(|point| &point.contender).collect();
        names.dedup();
        let reached = |name: &Contender| {
            let mut own: Vec<&Point> = self.points.iter().filter(|point| point.contender == *name).collect();
            own.sort_by_key(|point| point.particles);
            let is_below = |point: &&&Point| point.error().is_some_and(|found| found <= error);
            let below = own.iter().rev().take_while(is_below).count();
            let first = own.len() - below;
            match (first.checked_sub(1).map(|at| own[at]), own.get(first)) {
                (_, None) => TimeToError::Not,
                (None, Some(point)) => {
                    TimeToError::AtMost { ms: point.ms_per_step, particles: point.particles }
                }
                (Some(before), Some(after)) => {
                    // No line can be drawn from a point that collapsed.
                    let share = match (before.error(), after.error()) {
                        (Some(a), Some(b)) if a > b => ((a / error).ln() / (a / b).ln()).clamp(0.0, 1.0),
                        _ => 1.0,
                    };
                    let between = |a: f64, b: f64| (a.ln() + share * (b / a).ln()).exp();
                    TimeToError::At {
                        ms: between(before.ms_per_step, after.ms_per_step),
                        particles: between(before.particles as f64, after.particles as f64),
                    }
                }
            }
        };
        names.into_iter().map(|name| (name.clone(), reached(name))).collect()
    }

    /// The error of a contender at a time for each step, between its points in logarithms; none where it has no points on both sides.
    fn error_at(&self, contender: &Contender, ms: f64) -> Option<f64> {
        let mut known: Vec<(f64, f64)> = self
            .points
            .iter()
            .filter(|point| point.contender == *contender)
            .filter_map(|point| Some((point.ms_per_step.ln(), point.error()?.ln())))
            .collect();
        known.sort_by(|a, b| a.0.total_cmp(&b.0));
        let at = ms.ln();
        let pair = known.windows(2).find(|pair| pair[0].0 <= at && at <= pair[1].0)?;
        let [(x0, y0), (x1, y1)] = [pair[0], pair[1]];
        let share = if x1 > x0 { (at - x0) / (x1 - x0) } else { 0.0 };
        Some((y0 + share * (y1 - y0)).exp())
    }

    /// The ranges of time for a step in which a proposal has the least error, in order. Where one alone was timed there is nothing to say.
    pub fn best(&self) -> Vec<(Contender, [f64; 2])> {
        const PARTS: usize = 200;
        let times = || self.points.iter().map(|point| point.ms_per_step);
        let (low, high) =
            times().fold((f64::INFINITY, 0.0_f64), |(low, high), ms| (low.min(ms), high.max(ms)));
        let mut names: Vec<&Contender> = self.points.iter().map(|point| &point.contender).collect();
        names.dedup();
        names.retain(|contender| contender.designed_filter().is_none());
        let mut found: Vec<(Contender, [f64; 2])> = Vec::new();
        for part in 0..=PARTS {
            let ms = low * (high / low).powf(part as f64 / PARTS as f64);
            let errors: Vec<(&Contender, f64)> =
                names.iter().filter_map(|name| Some((*name, self.error_at(name, ms)?))).collect();
            let best = errors.iter().min_by(|a, b| a.1.total_cmp(&b.1)).filter(|_| errors.len() > 1);
            let Some((best, _)) = best else { continue };
            match found.last_mut() {
                Some((name, range)) if name == *best => range[1] = ms,
                _ => found.push(((*best).clone(), [ms, ms])),
            }
        }
        found
    }
}

impl fmt::Display for EqualTime {
    /// One sentence.
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let best = self.best();
        if best.is_empty() {
            return formatter.write_str("No two proposals were timed at the same time for a step.");
        }
        formatter.write_str("The least error of the log-evidence at equal time:")?;
        for (at, (name, [from, to])) in best.iter().enumerate() {
            let comma = if at > 0 { "," } else { "" };
            write!(formatter, "{comma} {name} from {} to {} ms a step", short(*from), short(*to))?;
        }
        formatter.write_str(".")
    }
}

/// A number with two digits that count.
fn short(value: f64) -> String {
    let digits = (1.0 - value.abs().max(1e-300).log10().floor()).clamp(0.0, 8.0) as usize;
    format!("{value:.digits$}")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::options::ProposalName;

    #[test]
    fn the_sentence_names_who_is_best_where() {
        let point = |contender, particles, ms_per_step, error| Point {
            contender,
            particles,
            ms_per_step,
            gaps: vec![Some(error)],
        };
        let [cheap, dear] = [ProposalName::Bootstrap, ProposalName::Linearised].map(Contender::on_line);
        let points = vec![
            point(cheap.clone(), 10, 0.01, 100.0),
            point(cheap.clone(), 1000, 1.0, 1.0),
            point(dear.clone(), 10, 0.05, 5.0),
            point(dear.clone(), 1000, 5.0, 0.5),
        ];
        let equal = EqualTime { points };
        let names: Vec<Contender> = equal.best().into_iter().map(|(name, _)| name).collect();
        // Below 0.05 ms and above 1 ms there is one alone.
        assert_eq!(names, [dear, cheap]);
        assert!(
            equal
                .to_string()
                .starts_with("The least error of the log-evidence at equal time: linearised from 0.05")
        );
        assert!(EqualTime { points: vec![] }.best().is_empty());
    }

    #[test]
    fn an_error_is_reached_between_two_points_from_which_on_it_stays() {
        let point = |particles, error| Point {
            contender: Contender::on_line(ProposalName::Bootstrap),
            particles,
            ms_per_step: particles as f64 / 100.0,
            gaps: vec![error],
        };
        let reached = |errors: [Option<f64>; 4]| {
            let points = [10, 100, 1000, 10_000].into_iter().zip(errors).map(|(k, error)| point(k, error));
            EqualTime { points: points.collect() }.reaching(1.0)[0].1
        };
        let TimeToError::At { ms, particles } = reached([Some(100.0), Some(10.0), Some(0.1), Some(0.05)])
        else {
            panic!("between the second and the third")
        };
        // Half way in logarithms.
        assert!((particles / 316.2 - 1.0).abs() < 1e-3 && (ms / 3.162 - 1.0).abs() < 1e-3);
        assert_eq!(
            reached([Some(0.5), Some(0.4), Some(0.3), Some(0.2)]),
            TimeToError::AtMost { ms: 0.1, particles: 10 }
        );
        assert_eq!(reached([Some(9.0), Some(0.9), Some(2.0), Some(1.1)]), TimeToError::Not);
        // Luck with few particles is not enough, and a collapse is no error of 1.
        let TimeToError::At { particles, .. } = reached([Some(0.9), None, Some(0.5), Some(0.1)]) else {
            panic!()
        };
        assert!((particles - 1000.0).abs() < 1e-6);
    }
}
