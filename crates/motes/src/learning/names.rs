//! Kinds of learned proposals by their names.

use motes_cli::one_of;
use motes_proposals::{Base, Covariance, HeadConfig, Sees};

/// The base of that name: transition or linearised.
///
/// # Errors
/// Which names there are.
pub fn base_named(text: &str) -> Result<Base, String> {
    match text {
        "transition" => Ok(Base::Transition),
        "linearised" => Ok(Base::Linearised),
        other => Err(one_of(other, ["transition", "linearised"])),
    }
}

/// What the units of hidden layers see: connected, or graph or graph:D.
///
/// # Errors
/// Which names there are, or which D.
pub fn network_named(text: &str) -> Result<Sees, String> {
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

/// What networks emit: gaussian, kernel, mixture or mixture:J, flow or flow:K.
///
/// # Errors
/// Which names there are, or which J or K.
pub fn head_named(text: &str) -> Result<HeadConfig, String> {
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
