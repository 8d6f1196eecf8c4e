//! The file of a benchmark: every key known and typed.

use std::collections::BTreeMap;
use std::path::PathBuf;

use motes::train::LearnObjective;
use motes_proposals::{Base, HeadConfig};
use serde::{Deserialize, Serialize};

/// A whole file, `experiments/learned/<name>.toml`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Benchmark {
    /// What is compared.
    pub title: String,
    /// The model file, beside this file or by a path from there.
    pub model: PathBuf,
    /// Parameters of the model that have other values here.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub set: BTreeMap<String, f64>,
    /// Resample where the effective sample size is below this share of K; at each step where it is 1.
    pub resample_below: f64,
    /// The share of the transition in all filters; that of the command if absent, which gives learned proposals a tenth.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub defensive: Option<f64>,
    /// The designed proposals: bootstrap, linearised, optimal, look-ahead.
    pub designed: Vec<String>,
    /// The learned ones, in the order in which they are learned.
    pub learned: Vec<LearnedMethod>,
    /// Sequences that somebody recorded, where they are not the model's own simulations.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub recorded: Option<RecordedData>,
    /// What others found, printed beside.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub outside: Vec<Outside>,
    /// How much of it smoke, quick and paper runs do.
    pub profiles: BTreeMap<String, BenchmarkProfile>,
}

/// A proposal that is learned for the model.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LearnedMethod {
    /// Its name on the card.
    pub name: String,
    /// Parameters of the model that it is learned for, where they are other than those of the filters.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub set: BTreeMap<String, f64>,
    /// What is maximised.
    #[serde(default)]
    pub objective: LearnObjective,
    /// The name of the one that it is learned further from.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub from: Option<String>,
    /// The designed proposal that it is built around; chosen if absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub base: Option<Base>,
    /// What its networks emit; chosen if absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub head: Option<HeadConfig>,
    /// The share of hidden units that an update leaves out.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub dropout: f64,
    /// λ of a penalty λ/2 Σ w² over the weights.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub weight_penalty: f64,
}

fn is_zero(value: &f64) -> bool {
    *value == 0.0
}

/// Where recorded sequences come from. The first part is learned from, the rest is what all are judged on.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RecordedData {
    /// A CSV file, beside this file or by a path from there; its first half is learned from.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub data: Option<PathBuf>,
    /// The same model with other values of these parameters, which draws sequences where there is no file.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub set: BTreeMap<String, f64>,
    /// Sequences that are drawn to be learned from.
    #[serde(default)]
    pub sequences: usize,
}

/// A figure that others found.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Outside {
    /// Where it stands.
    pub source: String,
    /// What they call the method.
    pub method: String,
    /// The key of the figure on the card.
    pub figure: String,
    /// Its value.
    pub value: f64,
}

/// How much a run does.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BenchmarkProfile {
    /// Gradient steps of a learned proposal.
    pub updates: usize,
    /// Gradient steps of one that is learned further.
    pub further_updates: usize,
    /// Times of a sequence that is filtered.
    pub times: usize,
    /// Sequences that all are judged on.
    pub sequences: usize,
    /// K of the card.
    pub particles: usize,
    /// K at which error is held against time; none if empty.
    pub equal_time: Vec<usize>,
    /// Particles of each reference filter.
    pub reference_particles: usize,
    /// Reference filters for each sequence, whose evidence is averaged.
    pub reference_filters: usize,
    /// The standard error that a sequence's log-evidence may have: by filters that look ahead, or by more of these filters. Nothing is asked of it if absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reference_error: Option<f64>,
}
