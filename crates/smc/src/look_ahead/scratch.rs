//! What a block of particles that look ahead is computed in.

use motes_models::batch::LANES;

/// What a block of particles is computed in, tile after tile.
#[derive(Debug, Clone, Default)]
pub struct LookAheadScratch {
    /// `R×Q`.
    pub(super) noise: Vec<f64>,
    /// Of each particle, where its noise is drawn from a mixture.
    pub(super) uniforms: Vec<f64>,
    /// `N × LANES` each, of previous and new states.
    pub(super) states: [Vec<f64>; 2],
    /// `Q × LANES`.
    pub(super) normals: Vec<f64>,
    pub(super) guide: TileGuide,
}

/// What the potential of a step says of the noise of the particles of a tile: of each of its `J` quadratics a Gaussian, one after the other.
#[derive(Debug, Clone, Default)]
pub(super) struct TileGuide {
    /// `v̂`, `Q × LANES`.
    pub(super) points: Vec<f64>,
    /// What the line through `g(x', v̂)` is at `v = 0`, or of normal draws their means: `N × LANES`.
    pub(super) centres: Vec<f64>,
    /// `J` (`N × Q × LANES`), or of normal draws their standard deviations (`N × LANES`).
    pub(super) jacobian: Vec<f64>,
    /// What is computed on the way.
    pub(super) spare: Vec<f64>,
    /// The mean of the noise, `J × Q × LANES`.
    pub(super) mean: Vec<f64>,
    /// The `L` with `Λ = Lᵀ L`, `J × Q(Q+1)/2 × LANES`.
    pub(super) lower: Vec<f64>,
    /// The shares `w_j Z̃_j / Z̃` of several quadratics, `J × LANES`.
    pub(super) shares: Vec<f64>,
    /// Mean and `L` of the quadratic that each particle draws from, where there are several.
    pub(super) chosen: [Vec<f64>; 2],
}

impl LookAheadScratch {
    /// Makes room for particles of `N` coordinates and `Q` draws.
    pub(super) fn fit(&mut self, n: usize, q: usize) {
        self.states.iter_mut().for_each(|states| {
            states.clear();
            states.resize(n * LANES, 0.0);
        });
        self.normals.clear();
        self.normals.resize(q * LANES, 0.0);
    }
}
