//! Whether a learned proposal is worth anything: filters with it and with designed ones, on validation sequences.

use motes_models::Seed;

use super::options::LearnOptions;
use crate::engine::Running;
use crate::error::MotesError;
use crate::learned::LearnedProposal;
use crate::model::Model;
use crate::options::{DEFENSIVE_SHARE, FilterOptions, ProposalName};
use crate::simulating::simulate_some;

/// Validation sequences, and the particles of the filters on them.
const SEQUENCES: usize = 20;
const PARTICLES: usize = 100;

/// A difference of log-evidence counts where it is larger than so many standard errors, and than so many nats.
const STANDARD_ERRORS: f64 = 2.0;
const LEAST_DIFFERENCE: f64 = 0.1;

/// The designed proposal with the same particles whose log-evidence is higher on validation sequences, if there is one.
///
/// The evidence of a filter is right in the mean, so that its logarithm is too low in the mean, by more where the filter is worse. One that collapsed
/// lost all.
pub(super) fn worse_than(
    model: &Model,
    learned: &LearnedProposal,
    options: &LearnOptions,
    seed: &Seed,
) -> Result<Option<String>, MotesError> {
    let drawn = simulate_some(model, options.steps, SEQUENCES, seed)?;
    let evidence = |proposal: ProposalName| -> Result<Vec<f64>, MotesError> {
        let filter = FilterOptions {
            proposal,
            particles: PARTICLES,
            check: false,
            defensive: Some(DEFENSIVE_SHARE),
            seed: options.seed,
            ..FilterOptions::default()
        };
        let of_one = |(number, trajectory): (usize, &motes_models::Trajectory)| {
            let mut running = Running::new(model, &filter, number)?;
            for measurement in trajectory.measurements.rows() {
                let entries: Vec<Option<f64>> = measurement.iter().copied().map(Some).collect();
                match running.advance(&entries) {
                    Ok(()) => {}
                    Err(MotesError::Filter { .. }) => return Ok(LOST),
                    Err(error) => return Err(error),
                }
            }
            Ok(running.log_evidence())
        };
        drawn.series.iter().enumerate().map(of_one).collect()
    };
    let of_learned = evidence(ProposalName::Learned(learned.clone()))?;
    let mut worst: Option<(f64, String)> = None;
    for designed in [ProposalName::Bootstrap, ProposalName::Linearised] {
        let name = designed.to_string();
        let ahead: Vec<f64> = evidence(designed)?.iter().zip(&of_learned).map(|(a, b)| a - b).collect();
        let n = ahead.len() as f64;
        let mean = ahead.iter().sum::<f64>() / n;
        let variance = ahead.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / (n - 1.0).max(1.0);
        let is_better = mean > LEAST_DIFFERENCE && mean > STANDARD_ERRORS * (variance / n).sqrt();
        if is_better && worst.as_ref().is_none_or(|(most, _)| mean > *most) {
            worst = Some((mean, name));
        }
    }
    Ok(worst.map(|(_, name)| name))
}

/// The log-evidence of a filter that collapsed, for means to be taken of.
const LOST: f64 = -1e9;
