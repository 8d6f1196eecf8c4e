//! The log-evidence of recorded data.

use std::time::Instant;

use motes::EvidenceOptions;
use motes::output::evidence_json;
use pyo3::prelude::*;

use crate::arguments::{integer, seed_of, threads_of};
use crate::call::ForCall;
use crate::data::Data;
use crate::errors::in_python;
use crate::model::Model;
use crate::options::ProposalArgument;
use crate::work::without_lock;

/// The log-evidence of all series by independent runs: the object that the command prints with --json, and what there is to warn of.
#[pyfunction]
#[expect(clippy::too_many_arguments, reason = "each is an argument of the Python function with its name")]
pub(crate) fn evidence(
    py: Python<'_>,
    model: &Bound<'_, Model>,
    data: &Bound<'_, Data>,
    proposal: Option<ProposalArgument<'_>>,
    particles: i64,
    runs: i64,
    seed: i128,
    threads: Option<i64>,
) -> PyResult<(String, Vec<String>)> {
    let options = EvidenceOptions {
        proposal: proposal.as_ref().map(ProposalArgument::name).transpose()?,
        particles: integer("particles", particles, 1, 1_000_000_000)?,
        runs: integer("runs", runs, 1, 1_000_000)?,
        seed: seed_of(seed)?,
        ..EvidenceOptions::default()
    };
    let call = model.get().for_call()?;
    let (ForCall { model, failure, .. }, threads) = (&call, call.threads(threads_of(threads)?));
    let (data, start) = (&data.get().0, Instant::now());
    let found = without_lock(py, threads, &failure.stop, || {
        motes::evidence(model, data, &options, || failure.asked())
    })?;
    let found = failure.or(found)?;
    let warnings = found.warnings().iter().map(|warning| in_python(&warning.to_string())).collect();
    Ok((evidence_json(&found, start.elapsed().as_secs_f64()), warnings))
}
