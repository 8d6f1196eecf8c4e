//! Error against time: which proposal is worth its cost, and from where to where.

use std::fmt;

use super::card::{Steps, totals};
use crate::options::ProposalName;

/// A proposal with some particles.
#[derive(Debug, Clone, PartialEq)]
pub struct Point {
    /// The proposal.
    pub proposal: ProposalName,
    /// `K`.
    pub particles: usize,
    /// Milliseconds for a step.
    pub ms_per_step: f64,
    /// The root mean square of the log-evidence's distance from the reference; none if a filter collapsed.
    pub error: Option<f64>,
}

impl Point {
    pub(super) fn of(proposal: ProposalName, particles: usize, runs: &[Steps]) -> Self {
        let gaps: Option<Vec<f64>> = runs.iter().map(|run| run.log_evidence_gap).collect();
        let error =
            gaps.map(|gaps| (gaps.iter().map(|gap| gap * gap).sum::<f64>() / gaps.len() as f64).sqrt());
        let (times, seconds) = totals(runs);
        Point { proposal, particles, ms_per_step: 1e3 * seconds / times, error }
    }
}

/// All points of all proposals.
#[derive(Debug, Clone, PartialEq)]
pub struct EqualTime {
    /// One after another, particles from few to many.
    pub points: Vec<Point>,
}

impl EqualTime {
    /// The error of a proposal at a time for each step, between its points in logarithms; none where it has no points on both sides.
    fn error_at(&self, proposal: &ProposalName, ms: f64) -> Option<f64> {
        let mut known: Vec<(f64, f64)> = self
            .points
            .iter()
            .filter(|point| point.proposal == *proposal)
            .filter_map(|point| Some((point.ms_per_step.ln(), point.error?.max(1e-300).ln())))
            .collect();
        known.sort_by(|a, b| a.0.total_cmp(&b.0));
        let at = ms.ln();
        let pair = known.windows(2).find(|pair| pair[0].0 <= at && at <= pair[1].0)?;
        let [(x0, y0), (x1, y1)] = [pair[0], pair[1]];
        let share = if x1 > x0 { (at - x0) / (x1 - x0) } else { 0.0 };
        Some((y0 + share * (y1 - y0)).exp())
    }

    /// The ranges of time for a step in which a proposal has the least error, in order. Where one alone was timed there is nothing to say.
    pub fn best(&self) -> Vec<(ProposalName, [f64; 2])> {
        const PARTS: usize = 200;
        let times = || self.points.iter().map(|point| point.ms_per_step);
        let (low, high) =
            times().fold((f64::INFINITY, 0.0_f64), |(low, high), ms| (low.min(ms), high.max(ms)));
        let mut names: Vec<&ProposalName> = self.points.iter().map(|point| &point.proposal).collect();
        names.dedup();
        let mut found: Vec<(ProposalName, [f64; 2])> = Vec::new();
        for part in 0..=PARTS {
            let ms = low * (high / low).powf(part as f64 / PARTS as f64);
            let errors: Vec<(&ProposalName, f64)> =
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

    #[test]
    fn the_sentence_names_who_is_best_where() {
        let point = |proposal, particles, ms_per_step, error| Point {
            proposal,
            particles,
            ms_per_step,
            error: Some(error),
        };
        let (cheap, dear) = (ProposalName::Bootstrap, ProposalName::Linearised);
        let points = vec![
            point(cheap.clone(), 10, 0.01, 100.0),
            point(cheap.clone(), 1000, 1.0, 1.0),
            point(dear.clone(), 10, 0.05, 5.0),
            point(dear.clone(), 1000, 5.0, 0.5),
        ];
        let equal = EqualTime { points };
        let names: Vec<ProposalName> = equal.best().into_iter().map(|(name, _)| name).collect();
        // Below 0.05 ms and above 1 ms there is one alone.
        assert_eq!(names, [dear, cheap]);
        assert!(
            equal
                .to_string()
                .starts_with("The least error of the log-evidence at equal time: linearised from 0.05")
        );
        assert!(EqualTime { points: vec![] }.best().is_empty());
    }
}
