//! The arguments that say what kind of proposal is learned.

use clap::Args;
use motes::proposals::{Base, HeadConfig, Sees};
use motes::{base_named, head_named, network_named};
use motes_cli::integer;

#[derive(Args)]
pub(super) struct KindArgs {
    /// The designed proposal that it is built around: transition or linearised; chosen if absent
    #[arg(long, value_name = "B", value_parser = base_named)]
    pub(super) base: Option<Base>,
    /// What its networks emit: gaussian, kernel (the paper's), mixture or mixture:J of J Gaussians, flow or flow:K of splines with K pieces; chosen if absent
    #[arg(long, value_name = "H", value_parser = head_named)]
    pub(super) head: Option<HeadConfig>,
    /// The networks' hidden layers: connected fully, or graph or graph:D, by filters over D edges of the graph of what depends on what in the model
    #[arg(long, value_name = "N", default_value = "connected", value_parser = network_named)]
    pub(super) network: Sees,
    /// The widths of hidden layers, 64,64 if absent; of a graph, the features of each coordinate, 16,16 if absent
    #[arg(long, value_name = "W,W", value_delimiter = ',', value_parser = integer(1..=65536_usize))]
    pub(super) widths: Option<Vec<usize>>,
}
