//! What a network needs to know of a model before it is made.

use crate::equations::Linearise;
use crate::{GraphModel, Seed, Simulator, StateSpaceModel, SystemGraph};

/// All that a proposal's networks are made from: the sizes of a model, and its graph where one is used.
///
/// ```
/// use motes_models::{GraphDiffusion, GraphDiffusionConfig, ModelShape, Seed};
///
/// let system = GraphDiffusion::random(&GraphDiffusionConfig::new(6), &mut Seed::from_u64(1).stream())?;
/// assert_eq!(ModelShape::of(&system).graph, None);
/// assert_eq!(ModelShape::on_graph(&system).graph.map(|graph| graph.shift.nrows()), Some(6));
/// # Ok::<(), motes_models::ModelError>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct ModelShape {
    /// `N`, the number of coordinates of a state.
    pub state_dim: usize,
    /// `M`, the number of coordinates of a measurement.
    pub measurement_dim: usize,
    /// `Q_0` and `Q`, the numbers of draws that `x_0` and `x_1` are made of, where states have no density, so that their noise is proposed.
    pub draws: Option<[usize; 2]>,
    /// The graph whose nodes are the coordinates of a state; graph networks need one.
    pub graph: Option<SystemGraph>,
}

impl ModelShape {
    /// The sizes of a model, without a graph.
    pub fn of(model: &(impl StateSpaceModel + ?Sized)) -> Self {
        let (state_dim, measurement_dim) = (model.state_dim(), model.measurement_dim());
        let noise_space = model.noise_without_density();
        let draws =
            noise_space.map(|noise| [0, 1].map(|index| noise.draws(&model.step_of_index(index)).len()));
        ModelShape { state_dim, measurement_dim, draws, graph: None }
    }

    /// The sizes of a model, and the graph of what depends on what in it ([`SystemGraph::of_dependences`]).
    pub fn on_dependences(model: &(impl Linearise + Simulator + ?Sized), seed: &Seed) -> Self {
        ModelShape { graph: Some(SystemGraph::of_dependences(model, seed)), ..ModelShape::of(model) }
    }

    /// The sizes of a model and its graph.
    pub fn on_graph(model: &(impl GraphModel + ?Sized)) -> Self {
        ModelShape { graph: Some(model.graph()), ..ModelShape::of(model) }
    }
}
