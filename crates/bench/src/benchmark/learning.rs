//! The learned proposals of a benchmark: each is learned and kept, or read where an earlier run kept it.

use std::path::PathBuf;

use motes::{Data, LearnOptions, LearnedProposal, Model, MotesError, learn};
use motes_cli::{Interrupt, status};

use super::file::LearnedMethod;
use super::plan::BenchmarkPlan;

/// Where a proposal is kept; the folder's name is that of the method.
pub(super) fn folder(plan: &BenchmarkPlan, key: &str, method: &LearnedMethod) -> PathBuf {
    plan.folder.join("proposals").join(key).join(&method.name)
}

/// Learns what is not there, in the order of the file.
pub(super) fn proposals(
    plan: &BenchmarkPlan,
    key: &str,
    model: &Model,
    recorded: Option<&Data>,
    interrupt: &Interrupt,
) -> Result<Vec<LearnedProposal>, MotesError> {
    let methods = &plan.benchmark.learned;
    let mut all = Vec::with_capacity(methods.len());
    for method in methods {
        let folder = folder(plan, key, method);
        let own = plan.model(&method.set)?;
        if LearnedProposal::load(&folder, &own).is_err() {
            status(&format!("{}: learning {}", plan.name, method.name));
            let start =
                methods.iter().zip(&all).find(|(earlier, _)| method.from.as_ref() == Some(&earlier.name));
            let data = if method.objective.needs_recorded() { recorded } else { None };
            learned(plan, method, &own, data, start.map(|(_, proposal)| proposal), interrupt)?
                .save(&folder, &own)?;
        }
        // One that was learned with other parameters is for other filters than those that it now serves.
        all.push(match method.set.is_empty() {
            true => LearnedProposal::load(&folder, model)?,
            false => LearnedProposal::load_to_tune(&folder, model)?,
        });
    }
    Ok(all)
}

fn learned(
    plan: &BenchmarkPlan,
    method: &LearnedMethod,
    model: &Model,
    recorded: Option<&Data>,
    start: Option<&LearnedProposal>,
    interrupt: &Interrupt,
) -> Result<LearnedProposal, MotesError> {
    let usual = LearnOptions::default();
    let options = LearnOptions {
        // It learns from sequences that are no longer than those that it is judged on.
        steps: usual.steps.min(plan.profile.times),
        objective: method.objective,
        start: start.cloned(),
        base: method.base,
        head: method.head,
        dropout: method.dropout,
        weight_penalty: method.weight_penalty,
        updates: if start.is_some() { plan.profile.further_updates } else { plan.profile.updates },
        seed: plan.seed,
        ..usual
    };
    Ok(learn(model, recorded, &options, |_, _| interrupt.check())?.proposal)
}
