//! The arguments that say what kind of proposal is learned.

use clap::Args;
use motes::proposals::{Base, Covariance, HeadConfig, Sees};
use motes_cli::{integer, one_of};

#[derive(Args)]
pub(super) struct KindArgs {
    /// The designed proposal that it is built around: transition or linearised; chosen if absent
    #[arg(long, value_name = "B", value_parser = base)]
    pub(super) base: Option<Base>,
    /// What its networks emit: gaussian, kernel (the paper's), mixture or mixture:J of J Gaussians, flow or flow:K of splines with K pieces; chosen if absent
    #[arg(long, value_name = "H", value_parser = head)]
    pub(super) head: Option<HeadConfig>,
    /// The networks' hidden layers: connected fully, or graph or graph:D, by filters over D edges of the graph of what depends on what in the model
    #[arg(long, value_name = "N", default_value = "connected", value_parser = network)]
    pub(super) network: Sees,
    /// The widths of hidden layers, 64,64 if absent; of a graph, the features of each coordinate, 16,16 if absent
    #[arg(long, value_name = "W,W", value_delimiter = ',', value_parser = integer(1..=65536_usize))]
    pub(super) widths: Option<Vec<usize>>,
}

fn base(text: &str) -> Result<Base, String> {
    match text {
        "transition" => Ok(Base::Transition),
        "linearised" => Ok(Base::Linearised),
        other => Err(one_of(other, ["transition", "linearised"])),
    }
}

fn network(text: &str) -> Result<Sees, String> {
    match text.split_once(':') {
        None if text == "connected" => Ok(Sees::All),
        None if text == "graph" => Ok(Sees::Graph { order: 2 }),
        Some(("graph", order)) => match order.parse() {
            Ok(order @ 1..=100) => Ok(Sees::Graph { order }),
            _ => Err(format!("{order} is no order of graph filters; it must be an integer from 1 to 100")),
        },
        _ => Err(one_of(text, ["connected", "graph"])),
    }
}

fn head(text: &str) -> Result<HeadConfig, String> {
    let covariance = Covariance::Full;
    match text.split_once(':') {
        None if text == "gaussian" => Ok(HeadConfig::Gaussian { covariance }),
        None if text == "kernel" => Ok(HeadConfig::Kernel),
        None if text == "mixture" => Ok(HeadConfig::Mixture { components: 5, covariance }),
        Some(("mixture", count)) => match count.parse() {
            Ok(components @ 1..=100) => Ok(HeadConfig::Mixture { components, covariance }),
            _ => Err(format!("{count} is no number of components; it must be an integer from 1 to 100")),
        },
        None if text == "flow" => Ok(HeadConfig::Flow { pieces: 8, covariance }),
        Some(("flow", count)) => match count.parse() {
            Ok(pieces @ 2..=100) => Ok(HeadConfig::Flow { pieces, covariance }),
            _ => Err(format!("{count} is no number of pieces; it must be an integer from 2 to 100")),
        },
        _ => Err(one_of(text, ["gaussian", "kernel", "mixture", "flow"])),
    }
}
