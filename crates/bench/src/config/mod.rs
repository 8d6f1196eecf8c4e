//! What a run does: command-line arguments and experiment files, checked until nothing can surprise the runner.
//!
//! `xtask` compiles this module too, from this very file, so that it refuses bad input before it builds anything and
//! without linking a network library. It therefore depends on nothing else in this crate.

mod args;
mod check;
mod error;
mod load;
mod methods;
mod plan;
mod schema;

pub use args::{BenchArgs, Parsed, ReproduceArgs, VerifyArgs, parse};
pub use error::{ConfigError, one_of};
pub use methods::{Adapter, Cell, Fcnn, Gnn, Method, Origin, Proposals, Psi, Rnn, Sizes, Standardised};
pub use plan::{Backend, Plan, Point, check_output, plans, whole_figure};
pub use schema::{
    Axis, Densities, Drift, Epidemic, Experiment, Filter, Gradient, Noise, Objective, Panel, Profile,
    Reference, Resampling, SeriesFigure, System, Training,
};
