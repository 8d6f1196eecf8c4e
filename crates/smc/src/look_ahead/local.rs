//! A model near states: its map of noise and its measurement, linearised.

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

/// Asks a model about states of alike steps, a tile at a time.
pub(super) struct Local<'m> {
    model: &'m dyn NoiseSpace,
    n: usize,
    pub(super) tiles: LocalTiles,
}

/// What the answers of a model are computed in.
#[derive(Debug, Clone, Default)]
pub(super) struct LocalTiles {
    previous: Vec<f64>,
    noise: Vec<f64>,
    states: Vec<f64>,
    derivatives: Vec<f64>,
    measurement: Vec<Option<Lanes>>,
}

/// A row of each state, up to a tile of them, into a tile.
fn fill_tile(rows: &[f64], count: usize, tile: &mut Vec<f64>) {
    let width = rows.len() / count;
    tile.resize(width * LANES, 0.0);
    load(rows, width, tile);
}

/// What stands in one lane of each row.
fn lane(tile: &[f64], lane: usize) -> impl Iterator<Item = f64> {
    tile.iter().skip(lane).step_by(LANES).copied()
}

impl<'m> Local<'m> {
    /// Of a model with states of `N` coordinates.
    pub(super) fn new(model: &'m dyn NoiseSpace, n: usize, tiles: LocalTiles) -> Self {
        Local { model, n, tiles }
    }

    /// The maps of alike steps, up to a tile of them, near each row of `previous` (`R×N`), or at the start, and of `noise` (`R×Q`), into `maps` (`R`). The first that is not finite, if
    /// one is.
    pub(super) fn maps(
        &mut self,
        step: &Step<'_>,
        previous: Option<&[f64]>,
        noise: &[f64],
        maps: &mut [LocalMap],
    ) -> Option<usize> {
        let (n, count) = (self.n, maps.len());
        let q = noise.len() / count;
        let directions = q + previous.map_or(0, |_| n);
        let LocalTiles { previous: befores, noise: noises, states, derivatives, .. } = &mut self.tiles;
        fill_tile(previous.unwrap_or_default(), count, befores);
        fill_tile(noise, count, noises);
        states.resize(n * LANES, 0.0);
        derivatives.resize(n * directions * LANES, 0.0);
        let before = previous.map(|_| befores.as_slice());
        self.model.tile_linearised(step, before, noises, count, states, derivatives);
        for (at, LocalMap { value, along_noise, along_previous }) in maps.iter_mut().enumerate() {
            [&mut *value, &mut *along_noise, &mut *along_previous].into_iter().for_each(Vec::clear);
            value.extend(lane(states, at));
            for row in derivatives.chunks_exact((directions * LANES).max(1)) {
                let (noise, previous) = row.split_at(q * LANES);
                along_noise.extend(lane(noise, at));
                along_previous.extend(lane(previous, at));
            }
        }
        let is_finite = |map: &LocalMap| {
            let LocalMap { value, along_noise, along_previous } = map;
            value.iter().chain(along_noise).chain(along_previous).all(|number| number.is_finite())
        };
        maps.iter().position(|map| !is_finite(map))
    }

    /// The scores `∂ log p(y | x)/∂x` of measurements (`M`) of alike steps, one for each row of `states` (`R×N`), into `scores`, alike. All have the same entries.
    pub(super) fn scores<'y>(
        &mut self,
        step: &Step<'_>,
        states: &[f64],
        measurement: impl Fn(usize) -> &'y [Option<f64>],
        scores: &mut [f64],
    ) {
        let n = self.n;
        for (tile, (rows, scores)) in states.chunks(n * LANES).zip(scores.chunks_mut(n * LANES)).enumerate() {
            let count = rows.len() / n;
            let (slopes, _) = self.tile(step, rows, count, |row| measurement(tile * LANES + row));
            store(slopes, n, scores);
        }
    }

    /// The sites of measurements (`M`) of alike steps, up to a tile of them, one near each row of `states` (`R×N`), into `sites` (`R`). All have the same entries.
    pub(super) fn sites<'y>(
        &mut self,
        step: &Step<'_>,
        states: &[f64],
        measurement: impl Fn(usize) -> &'y [Option<f64>],
        sites: &mut [LocalSite],
    ) {
        let (n, count) = (self.n, sites.len());
        for LocalSite { slope, roots } in &mut *sites {
            slope.clear();
            roots.clear();
        }
        if measurement(0).iter().all(Option::is_none) {
            return sites.iter_mut().for_each(|site| site.slope.resize(n, 0.0));
        }
        let (slopes, roots) = self.tile(step, states, count, measurement);
        for (at, site) in sites.iter_mut().enumerate() {
            site.slope.extend(lane(slopes, at));
            site.roots.extend(lane(roots, at));
        }
    }

    /// Scores and roots of the Fisher information at each row of `states`, up to a tile of them.
    fn tile<'y>(
        &mut self,
        step: &Step<'_>,
        states: &[f64],
        count: usize,
        measurement: impl Fn(usize) -> &'y [Option<f64>],
    ) -> (&[f64], &[f64]) {
        let LocalTiles { states: tile, derivatives, measurement: measured, .. } = &mut self.tiles;
        fill_tile(states, count, tile);
        measured.clear();
        measured.extend(measurement(0).iter().map(|entry| entry.map(Lanes::from)));
        for row in 1..count {
            let entries = measured.iter_mut().zip(measurement(row));
            for (lanes, entry) in entries.filter_map(|(lanes, entry)| lanes.as_mut().zip(*entry)) {
                lanes.0[row] = entry;
            }
        }
        derivatives.resize((1 + 2 * measured.len()) * self.n * LANES, 0.0);
        let (slopes, roots) = derivatives.split_at_mut(self.n * LANES);
        self.model.tile_sites(step, tile, measured, count, slopes, roots);
        (slopes, roots)
    }
}
