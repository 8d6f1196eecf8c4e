//! Rows from recorded measurements: where a filter with the present weights says that the states were.

use motes_models::{OwnModel, OwnStep, PartialMeasurements, Seed};
use motes_proposals::{Amortised, Examples};
use motes_smc::{FilterSettings, ParticleFilter};
use rand::RngExt;

use crate::TrainError;

/// Particles of the filter, and the share of them that is drawn from the transition.
const PARTICLES: usize = 200;
const DEFENSIVE: f64 = 0.1;

/// How much is taken of a series.
#[derive(Clone, Copy)]
pub(super) struct Share {
    /// States that are drawn from the filter at each time.
    pub(super) draws: usize,
    /// How many of its first times.
    pub(super) times: usize,
}

/// Filters recorded measurements and adds a few of its weighted particles of each time, with the states that they were drawn from: `(x_{t−1}, x_t, y_t)`
/// as they are likely given the measurements so far (neural adaptive sequential Monte Carlo, Gu, Ghahramani and Turner 2015).
///
/// Times whose measurement has gaps are left out. Where the filter collapses, what follows is left out.
pub(super) fn add_recorded(
    proposal: &Amortised,
    model: &(impl OwnModel + ?Sized),
    measurements: &PartialMeasurements,
    Share { draws, times }: Share,
    seed: &Seed,
    examples: &mut Examples,
) -> Result<(), TrainError> {
    let n = model.state_dim();
    let settings = FilterSettings { defensive_weight: Some(DEFENSIVE), ..FilterSettings::new(PARTICLES) };
    let failed = |error: motes_smc::FilterError| TrainError::Recorded { reason: error.to_string() };
    let filter = ParticleFilter::new(model, proposal.clone(), settings, seed.child("filter").stream());
    let mut filter = filter.map_err(failed)?;
    let mut stream = seed.child("draws").stream();
    let (mut previous, mut states) = (Vec::new(), Vec::new());
    for (time, row) in measurements.rows().enumerate().take(times) {
        if filter.step_at(&model.step_of_index(time), row).is_err() {
            break;
        }
        let Some(whole) = row.iter().copied().collect::<Option<Vec<f64>>>() else { continue };
        previous.clear();
        states.clear();
        let weights = filter.weights().normalised();
        // Systematic draws of particles by their weights.
        let (mut sum, mut at) = (weights[0], 0);
        let offset: f64 = stream.random();
        for draw in 0..draws {
            let point = (draw as f64 + offset) / draws as f64;
            while sum < point && at + 1 < PARTICLES {
                at += 1;
                sum += weights[at];
            }
            states.extend_from_slice(&filter.particles()[at * n..][..n]);
            if let Some(all) = filter.previous_particles() {
                previous.extend_from_slice(&all[filter.ancestors()[at] * n..][..n]);
            }
        }
        let measurements = whole.repeat(draws);
        let before = (time > 0).then_some(previous.as_slice());
        let step = model.step_of_index(time);
        let step =
            OwnStep { step, previous: before, states: &states, noise: None, measurements: &measurements };
        proposal.encode(model, &step, examples)?;
    }
    Ok(())
}
