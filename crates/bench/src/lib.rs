//! Experiments: from a configuration file to tables and a figure.
//!
//! The `motes-bench` program reads `experiments/<figure>.toml`, runs each unit of work (panel, x, method, repetition) on a
//! thread of its own (or on several, where there are fewer units than threads), stores it as soon as it is finished, and makes
//! tables and a figure of all units in its folder. A run that was interrupted continues where it stopped.

mod benchmark;
mod checkpoint;
pub mod cluster;
mod computed_once;
pub mod config;
mod diffusion_equations;
mod durable;
mod estimate;
mod evaluate;
mod figure;
mod key;
mod learned_once;
mod manifest;
mod method_config;
mod metric;
mod metrics;
mod outputs;
mod problem;
mod progress;
mod provenance;
mod record_units;
mod recorded_series;
mod reference;
mod regression;
mod reproduce;
mod runner;
mod series;
mod standing;
mod statistics;
mod store;
mod tables;
mod threads;
mod unit;
mod unit_error;
mod verify;
mod warnings;

pub use benchmark::{BenchmarkError, BenchmarkPlan, benchmark_plans, is_benchmark, run_benchmark};
pub use estimate::Estimator;
pub use evaluate::{Evaluation, Evaluator};
pub use method_config::{FrameSettings, LearnedUnit, MethodConfig};
pub use metric::Metric;
pub use regression::{RegressionError, regress};
pub use reproduce::{RunOutcome, paper_estimate, reproduce};
pub use series::{Series, StateSeries};
pub use store::{Contents, Outcome, Record, Store, StoreError};
pub use unit::{UNIT_FORMAT, UnitConfig, UnitSystem};
pub use unit_error::UnitError;
pub use verify::{VerifyError, verify};
pub use warnings::{StudyError, is_study, run_study};
