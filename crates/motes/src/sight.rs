//! Whether a linearised proposal sees the measurement at all.

use motes_models::Seed;

use crate::data::Data;
use crate::engine::Running;
use crate::model::Model;
use crate::options::{FilterOptions, ProposalName};
use crate::simulating::simulate_some;
use crate::warning::Warning;

/// Rows and particles that are tried.
const ROWS: usize = 10;
const PARTICLES: usize = 50;

/// Whether the linearised proposal is the transition: where the location of no measurement depends on the state, a filter with it is bootstrap to the last bit. It is tried on a simulated series, and not
/// so if there is none.
pub(crate) fn is_blind(model: &Model, data: Option<&Data>) -> bool {
    let Ok(drawn) = simulate_some(model, data, ROWS, 1, &Seed::from_u64(1)) else { return false };
    let Some((series, rows)) = drawn.series.first().zip(drawn.rows.first()) else { return false };
    let evidence = |proposal: ProposalName| {
        let options =
            FilterOptions { proposal, particles: PARTICLES, check: false, ..FilterOptions::default() };
        let mut running = Running::new(model, &options, 0).ok()?;
        for (measurement, row) in series.measurements.rows().zip(rows).take(ROWS) {
            let entries: Vec<Option<f64>> = measurement.iter().copied().map(Some).collect();
            running.advance_by(&row.steps, &entries).ok()?;
        }
        Some(running.log_evidence())
    };
    let [bootstrap, linearised] = [ProposalName::Bootstrap, ProposalName::Linearised].map(evidence);
    bootstrap.is_some() && bootstrap == linearised
}

/// What is to be said of `--proposal linearised` where it is the transition.
pub fn of_blind(model: &Model, data: Option<&Data>, options: &FilterOptions) -> Option<Warning> {
    (options.proposal == ProposalName::Linearised && is_blind(model, data)).then(|| {
        let text = "--proposal linearised is the transition here, as bootstrap: the location of no measurement depends on the state; motes evidence and smooth may look ahead instead";
        Warning { series: None, text: text.into() }
    })
}
