//! What is to be timed, and against whom.

use std::path::PathBuf;

use clap::Args;
use motes_cli::integer;

/// The arguments of `measure`.
#[derive(Debug, Clone, Args)]
pub(crate) struct MeasureArgs {
    /// Run the same work in other libraries as well, in turns with ours; needs Python 3 and the network
    #[arg(long)]
    pub(crate) peers: bool,
    /// How many times each piece of work is timed
    #[arg(long, default_value_t = 5, value_parser = integer(1..=1000_u64))]
    pub(crate) rounds: u64,
    /// Only work whose name contains this, as "filter bootstrap", "train rnn K=50" or "growth"
    #[arg(long, default_value = "")]
    pub(crate) only: String,
    /// A Python that has the other libraries; without it one is built from a pinned list
    #[arg(long)]
    pub(crate) python: Option<PathBuf>,
    /// The folder for speed.json and speed.md
    #[arg(long, default_value = "runs/speed")]
    pub(crate) out: PathBuf,
    /// The folder with the scripts that run other libraries
    #[arg(long, default_value = "crates/speed/peers")]
    pub(crate) peer_scripts: PathBuf,
}
