//! Benchmarks: report cards of proposals that are learned once, on problems whose figures others have published.
//!
//! A benchmark is a file `experiments/learned/<name>.toml`, and `reproduce learned-<name>` runs it by the functions that the command `motes` is made of.

mod check;
mod file;
mod learning;
mod outside;
mod plan;
mod recorded;
mod run;
mod tables;

pub use plan::{BenchmarkPlan, benchmark_plans, is_benchmark};
pub use run::{BenchmarkError, run_benchmark};
