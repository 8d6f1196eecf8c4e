//! Whether a learned proposal is worth anything: filters with it and with designed ones, on validation sequences.

use motes_models::Seed;

use super::options::LearnOptions;
use crate::comparing::designed;
use crate::data::Data;
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
    data: Option<&Data>,
    options: &LearnOptions,
    seed: &Seed,
) -> Result<Option<String>, MotesError> {
    let drawn = simulate_some(model, data, options.steps, SEQUENCES, seed)?;
    let evidence = |proposal: ProposalName| -> Result<Vec<f64>, MotesError> {
        let filter = FilterOptions {
            proposal,
            particles: PARTICLES,
            check: false,
            defensive: Some(DEFENSIVE_SHARE),
            seed: options.seed,
            ..FilterOptions::default()
        };
        let of_one = |number: usize| {
            let mut running = Running::new(model, &filter, number)?;
            let rows = drawn.series[number].measurements.rows().zip(&drawn.rows[number]);
            for (measurement, row) in rows {
                let entries: Vec<Option<f64>> = measurement.iter().copied().map(Some).collect();
                match running.advance_by(&row.steps, &entries) {
                    Ok(()) => {}
                    Err(MotesError::Filter { .. }) => return Ok(LOST),
                    Err(error) => return Err(error),
                }
            }
            Ok(running.log_evidence())
        };
        (0..drawn.series.len()).map(of_one).collect()
    };
    let of_learned = evidence(ProposalName::Learned(learned.clone()))?;
    let mut worst: Option<(f64, String)> = None;
    let there = designed(model, &FilterOptions::default());
    for designed in there.into_iter().filter(|name| *name != ProposalName::Optimal) {
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

#[cfg(test)]
mod tests {
    use std::ops::ControlFlow;

    use motes_models::ModelShape;
    use motes_proposals::{
        Amortised, AmortisedConfig, Backend, Base, Covariance, Family, HeadConfig, Parametric, Sees,
    };

    use super::*;
    use crate::comparing::{CompareOptions, compare};
    use crate::learned::learnable;
    use crate::learned_notes::Notes;

    /// The growth model, and a Gaussian that collapsed on one of its two modes.
    fn collapsed() -> (Model, LearnedProposal) {
        let text = "[initial]\nx = \"normal(0, sqrt(5))\"\n[transition]\nx = \"normal(x/2 + 25*x/(1 + x^2) + 8*cos(1.2*t), sqrt(10))\"\n\
                    [measurement]\ny = \"normal(x^2/20, 1)\"\n";
        let model = Model::parse(text, "growth", &[]).unwrap();
        let head = HeadConfig::Gaussian { covariance: Covariance::Full };
        let config = AmortisedConfig {
            widths: vec![4],
            sees: Sees::All,
            base: Base::Transition,
            head,
            ..AmortisedConfig::gaussian()
        };
        let shape = ModelShape::of(learnable(&model).unwrap());
        let mut proposal =
            Amortised::create(&config, &shape, 0, Backend::Native.into(), &Seed::from_u64(1)).unwrap();
        for index in 0..proposal.parameters().len() {
            if proposal.parameters().names()[index].ends_with("outputs.bias") {
                // Above the predicted state, with an eighth of its deviation.
                proposal.parameters_mut().set_host(index, &[0.8, 2.0]).unwrap();
            }
        }
        let notes = Notes { choice: "planted".into(), updates: 0, seconds: 0.0, worse_than: None };
        let learned =
            LearnedProposal::new("learned".into(), Some(proposal), notes, learnable(&model).unwrap());
        (model, learned)
    }

    #[test]
    fn a_proposal_that_collapsed_is_not_handed_out_as_better() {
        let (model, learned) = collapsed();
        let options = LearnOptions { steps: 50, ..LearnOptions::default() };
        let found = worse_than(&model, &learned, None, &options, &Seed::from_u64(2)).unwrap();
        assert!(found.is_some(), "no designed proposal is found to be better");
    }

    #[test]
    fn its_card_shows_how_much_evidence_it_misses() {
        let (model, learned) = collapsed();
        let options = CompareOptions {
            inputs: None,
            proposals: vec![ProposalName::Bootstrap, ProposalName::Learned(learned)],
            filter: FilterOptions { particles: 100, defensive: Some(0.0), ..FilterOptions::default() },
            particles: vec![],
            sequences: 4,
            steps: 40,
            particles_up_to: None,
            reference_particles: 5000,
            reference_filters: 1,
            reference_error: None,
            references: None,
            timed_threads: 1,
        };
        let card = compare(&model, None, &options, |_| ControlFlow::Continue(())).unwrap().cards;
        let of_learned = &card[1].1;
        let gap = of_learned.log_evidence_gap.map(|gap| gap.mean);
        // By more than a nat at each of 40 times, where it did not lose all weight.
        assert!(
            of_learned.lost > 0 || gap.is_some_and(|gap| gap < -40.0),
            "{gap:?}, {} lost",
            of_learned.lost
        );
    }
}
