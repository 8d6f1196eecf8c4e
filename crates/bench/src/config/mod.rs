//! What a run does: command-line arguments and experiment files, checked until nothing can surprise the runner.

mod args;
mod check;
mod checks;
mod cluster;
mod densities;
mod error;
mod learning;
mod load;
mod method;
mod plan;
mod proposals;
mod schema;
mod time_limit;

pub use args::{ReproduceArgs, VerifyArgs};
pub(crate) use checks::Checks;
pub use cluster::{ClusterArgs, Engine};
pub use densities::Densities;
pub use error::ConfigError;
pub use learning::{Elbo, Learning};
pub(crate) use load::{figures, read_toml};
pub use method::Method;
pub use plan::{Plan, Point, check_output, plans, whole_figure};
pub use proposals::{Fcnn, Gnn, Proposals, Psi, Rnn, ShortSteps, Sizes, Standardised};
pub use schema::{
    Axis, Epidemic, Estimand, Experiment, Filter, Gradient, Panel, Profile, Reference, SeriesFigure, System,
    Training,
};
pub use time_limit::TimeLimit;
