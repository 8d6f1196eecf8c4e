//! The graph that a system lives on, for proposals that compute along its edges.

use faer::Mat;

use crate::StateSpaceModel;

/// A graph whose nodes are the coordinates of a state.
#[derive(Debug, Clone, PartialEq)]
pub struct SystemGraph {
    /// `S` (`N×N`): entry `(i, j)` weighs what node `i` hears from node `j`; zero where there is no edge.
    pub shift: Mat<f64>,
    /// `N×M`: which nodes a measurement belongs to, and how much of it each gets.
    pub adapter: Mat<f64>,
}

/// A model that lives on a graph, which is what a graph network asks of it.
pub trait GraphModel: StateSpaceModel {
    /// The graph.
    fn graph(&self) -> SystemGraph;
}
