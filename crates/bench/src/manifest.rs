//! manifest.json: what a folder of results was made from.

use std::collections::BTreeSet;

use motes_proposals::Backend;
use serde::Serialize;

use crate::config::{Experiment, Plan, Profile};
use crate::store::Record;
use crate::unit::UNIT_FORMAT;

/// The distinct revisions that computed these records, sorted.
pub(crate) fn revisions(records: &[Record]) -> BTreeSet<&str> {
    records.iter().map(|record| record.revision.as_str()).collect()
}

/// The distinct kinds of processors that computed these records, sorted.
pub(crate) fn processors(records: &[Record]) -> BTreeSet<&str> {
    records.iter().map(|record| record.processor.as_deref().unwrap_or("not recorded")).collect()
}

#[derive(Serialize)]
struct Manifest<'a> {
    figure: &'a str,
    profile: &'a str,
    seed: u64,
    backend: Backend,
    unit_format: u32,
    units: usize,
    configuration_hash: String,
    configuration: Configuration<'a>,
    revisions: BTreeSet<&'a str>,
    processors: BTreeSet<&'a str>,
    repetitions: usize,
    versions: Versions,
}

#[derive(Serialize)]
struct Versions {
    motes: &'static str,
    burn: &'static str,
    rustc: &'static str,
}

#[derive(Serialize)]
struct Configuration<'a> {
    experiment: &'a Experiment,
    profile: &'a Profile,
}

/// The manifest of a folder that holds `records`.
pub(crate) fn manifest(plan: &Plan, records: &[Record]) -> String {
    let configuration = Configuration { experiment: &plan.experiment, profile: &plan.profile };
    let json = serde_json::to_string(&configuration).expect("a configuration has only string keys");
    let manifest = Manifest {
        figure: &plan.figure,
        profile: &plan.profile_name,
        seed: plan.seed,
        backend: plan.backend,
        unit_format: UNIT_FORMAT,
        units: records.len(),
        configuration_hash: blake3::hash(json.as_bytes()).to_hex().to_string(),
        configuration,
        revisions: revisions(records),
        processors: processors(records),
        repetitions: plan.repetitions,
        versions: Versions {
            motes: env!("CARGO_PKG_VERSION"),
            burn: motes_proposals::networks::BURN_VERSION,
            rustc: env!("MOTES_RUSTC_VERSION"),
        },
    };
    serde_json::to_string_pretty(&manifest).expect("a manifest has only string keys") + "\n"
}
