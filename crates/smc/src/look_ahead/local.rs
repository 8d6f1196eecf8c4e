//! A model near a single state: its map of noise and its measurement, linearised.

use motes_models::Step;
use motes_models::batch::{LANES, load, store};
use motes_models::equations::{Lanes, NoiseSpace};

/// `x ≈ x⁺ + F (x' − x̂') + G (v − v̂)` of a step.
#[derive(Debug, Clone, Default)]
pub(super) struct LocalMap {
    /// `x⁺ = g(x̂', v̂)`, `N`.
    pub(super) value: Vec<f64>,
    /// `G`, `N×Q`.
    pub(super) along_noise: Vec<f64>,
    /// `F`, `N×N`; nothing at the start.
    pub(super) along_previous: Vec<f64>,
}

/// What a measurement says of a state near by.
#[derive(Debug, Clone, Default)]
pub(super) struct LocalSite {
    /// The score `∂ log p(y | x)/∂x`, `N`.
    pub(super) slope: Vec<f64>,
    /// `R`, of which `RᵀR` is the Fisher information, `2M×N`; nothing where nothing is measured.
    pub(super) roots: Vec<f64>,
}

/// Asks a model about one state at a time.
pub(super) struct Local<'m> {
    model: &'m dyn NoiseSpace,
    n: usize,
    previous: Vec<f64>,
    noise: Vec<f64>,
    states: Vec<f64>,
    derivatives: Vec<f64>,
    measurement: Vec<Option<Lanes>>,
}

/// The same number in all lanes.
fn broadcast(values: &[f64], tile: &mut Vec<f64>) {
    tile.clear();
    tile.extend(values.iter().flat_map(|value| [*value; LANES]));
}

/// What stands in the first lane of each row.
fn first_lanes(tile: &[f64]) -> impl Iterator<Item = f64> {
    tile.iter().step_by(LANES).copied()
}

impl<'m> Local<'m> {
    /// Of a model with states of `N` coordinates.
    pub(super) fn new(model: &'m dyn NoiseSpace, n: usize) -> Self {
        let [previous, noise, states, derivatives] = [const { Vec::new() }; 4];
        Local { model, n, previous, noise, states, derivatives, measurement: Vec::new() }
    }

    /// The map near `previous` (`N`), or at the start, and `noise` (`Q`), into `map`; whether all of it is finite.
    pub(super) fn map(
        &mut self,
        step: &Step<'_>,
        previous: Option<&[f64]>,
        noise: &[f64],
        map: &mut LocalMap,
    ) -> bool {
        let (n, q) = (self.n, noise.len());
        let directions = q + previous.map_or(0, <[f64]>::len);
        broadcast(previous.unwrap_or_default(), &mut self.previous);
        broadcast(noise, &mut self.noise);
        self.states.resize(n * LANES, 0.0);
        self.derivatives.resize(n * directions * LANES, 0.0);
        let before = previous.map(|_| self.previous.as_slice());
        self.model.tile_linearised(step, before, &self.noise, 1, &mut self.states, &mut self.derivatives);
        let LocalMap { value, along_noise, along_previous } = map;
        [&mut *value, &mut *along_noise, &mut *along_previous].into_iter().for_each(Vec::clear);
        value.extend(first_lanes(&self.states));
        for row in self.derivatives.chunks_exact((directions * LANES).max(1)) {
            let (noise, previous) = row.split_at(q * LANES);
            along_noise.extend(first_lanes(noise));
            along_previous.extend(first_lanes(previous));
        }
        value.iter().chain(&*along_noise).chain(&*along_previous).all(|number| number.is_finite())
    }

    /// The scores `∂ log p(y | x)/∂x` of a measurement (`M`) at each row of `states` (`R×N`), into `scores`, alike.
    pub(super) fn scores(
        &mut self,
        step: &Step<'_>,
        states: &[f64],
        measurement: &[Option<f64>],
        scores: &mut [f64],
    ) {
        let n = self.n;
        for (rows, scores) in states.chunks(n * LANES).zip(scores.chunks_mut(n * LANES)) {
            self.states.resize(n * LANES, 0.0);
            load(rows, n, &mut self.states);
            let (slopes, _) = self.sites(step, measurement, rows.len() / n);
            store(slopes, n, scores);
        }
    }

    /// The site of a measurement (`M`) near `state` (`N`), into `site`.
    pub(super) fn site(
        &mut self,
        step: &Step<'_>,
        state: &[f64],
        measurement: &[Option<f64>],
        site: &mut LocalSite,
    ) {
        site.slope.clear();
        site.roots.clear();
        if measurement.iter().all(Option::is_none) {
            site.slope.resize(self.n, 0.0);
            return;
        }
        broadcast(state, &mut self.states);
        let (slopes, roots) = self.sites(step, measurement, 1);
        site.slope.extend(first_lanes(slopes));
        site.roots.extend(first_lanes(roots));
    }

    /// Scores and roots of the Fisher information at the first `count` of the states.
    fn sites(&mut self, step: &Step<'_>, measurement: &[Option<f64>], count: usize) -> (&[f64], &[f64]) {
        self.measurement.clear();
        self.measurement.extend(measurement.iter().map(|entry| entry.map(Lanes::from)));
        self.derivatives.resize((1 + 2 * measurement.len()) * self.n * LANES, 0.0);
        let (slopes, roots) = self.derivatives.split_at_mut(self.n * LANES);
        self.model.tile_sites(step, &self.states, &self.measurement, count, slopes, roots);
        (slopes, roots)
    }
}
