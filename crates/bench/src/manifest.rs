//! manifest.json: what a folder of results was made from.

use std::process::Command;

use serde::Serialize;

use crate::UNIT_FORMAT;
use crate::config::{Experiment, Plan, Profile};
use crate::store::Record;

/// The source revision in the current folder, with `-dirty` if there are changes; `unknown` outside a repository.
pub(crate) fn revision() -> String {
    let described =
        Command::new("git").args(["describe", "--always", "--abbrev=40", "--dirty", "--exclude=*"]).output();
    match described {
        Ok(output) if output.status.success() => String::from_utf8_lossy(&output.stdout).trim().to_string(),
        _ => "unknown".into(),
    }
}

/// The distinct revisions that computed these records, sorted.
pub(crate) fn revisions(records: &[Record]) -> Vec<String> {
    let mut revisions: Vec<String> = records.iter().map(|record| record.revision.clone()).collect();
    revisions.sort();
    revisions.dedup();
    revisions
}

#[derive(Serialize)]
struct Manifest<'a> {
    figure: &'a str,
    profile: &'a str,
    seed: u64,
    backend: &'a str,
    unit_format: u32,
    units: usize,
    configuration_hash: String,
    configuration: Configuration<'a>,
    revisions: Vec<String>,
    repetitions: usize,
    versions: Versions,
    cpu: Cpu,
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

#[derive(Serialize)]
struct Cpu {
    architecture: &'static str,
    features: Vec<&'static str>,
}

/// The manifest of a folder that holds `records`.
pub(crate) fn manifest(plan: &Plan, records: &[Record]) -> String {
    let configuration = Configuration { experiment: &plan.experiment, profile: &plan.profile };
    let json = serde_json::to_string(&configuration).expect("a configuration has only string keys");
    let manifest = Manifest {
        figure: &plan.figure,
        profile: &plan.profile_name,
        seed: plan.seed,
        backend: plan.backend.name(),
        unit_format: UNIT_FORMAT,
        units: records.len(),
        configuration_hash: blake3::hash(json.as_bytes()).to_hex().to_string(),
        configuration,
        revisions: revisions(records),
        repetitions: plan.repetitions,
        versions: Versions {
            motes: env!("CARGO_PKG_VERSION"),
            burn: motes_proposals::BURN_VERSION,
            rustc: env!("MOTES_RUSTC_VERSION"),
        },
        cpu: Cpu { architecture: std::env::consts::ARCH, features: cpu_features() },
    };
    serde_json::to_string_pretty(&manifest).expect("a manifest has only string keys") + "\n"
}

/// The vector extensions that the linear algebra chooses its kernels by: results are the same bytes where these agree.
fn cpu_features() -> Vec<&'static str> {
    #[cfg(target_arch = "x86_64")]
    {
        let found = [
            ("avx2", std::arch::is_x86_feature_detected!("avx2")),
            ("fma", std::arch::is_x86_feature_detected!("fma")),
            ("avx512f", std::arch::is_x86_feature_detected!("avx512f")),
        ];
        found.into_iter().filter(|(_, there)| *there).map(|(name, _)| name).collect()
    }
    #[cfg(not(target_arch = "x86_64"))]
    Vec::new()
}
