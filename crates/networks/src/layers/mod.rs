//! Layers and small networks, written once for every backend: views of consecutive matrices among some [`crate::Parameters`].

mod cell;
mod graph_network;
mod mlp;

pub use cell::{Cell, RecurrentLayer};
pub use graph_network::GraphNetwork;
pub use mlp::Mlp;
