//! What a network needs to know of a model before it is made.

use crate::{StateSpaceModel, SystemGraph};

/// The sizes of a model, and the graph that it lives on if it lives on one: all that a proposal's networks are made from.
#[derive(Debug, Clone, PartialEq)]
pub struct ModelShape {
    /// `N`, the number of coordinates of a state.
    pub state_dim: usize,
    /// `M`, the number of coordinates of a measurement.
    pub measurement_dim: usize,
    /// The graph whose nodes are the coordinates of a state.
    pub graph: Option<SystemGraph>,
}

impl ModelShape {
    /// The shape of a model.
    pub fn of(model: &(impl StateSpaceModel + ?Sized)) -> Self {
        ModelShape {
            state_dim: model.state_dim(),
            measurement_dim: model.measurement_dim(),
            graph: model.graph(),
        }
    }
}
