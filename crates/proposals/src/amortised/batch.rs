//! The distributions of a block of particles: draws and densities.

use motes_models::batch::{LANES, load, particles_by_stream, store};
use motes_models::equations::{Lanes, NoiseSpace, Transport};
use motes_models::{Stream, fill_standard_normal, fill_uniform};
use motes_smc::{Conditional, Context};

use super::heads::Head;
use super::scratch::AmortisedScratch;
use super::theta::Theta;
use super::units::{self, Place, Sizes, Units, lanes, log_standard_normal};

/// What an [`Amortised`](super::Amortised) proposal conditions to: a head's density for each particle, in units of its base.
pub struct AmortisedBatch<'a, M: ?Sized> {
    pub(super) model: &'a M,
    pub(super) context: Context<'a>,
    /// None where it is the base itself.
    pub(super) head: Option<&'a dyn Head>,
    pub(super) theta: &'a Theta,
    pub(super) is_affine: bool,
    pub(super) sizes: Sizes,
    /// The model in the space of its noise and the share of the noise's own distribution, where states have no density.
    pub(super) noise: Option<(&'a dyn NoiseSpace, f64)>,
    pub(super) scratch: &'a mut AmortisedScratch,
}

/// What a tile of a block is computed in.
pub(super) struct Tile<'t> {
    pub(super) values: &'t mut [Lanes],
    pub(super) theta: &'t mut [Lanes],
    pub(super) uniforms: &'t mut [Lanes],
    pub(super) head: &'t mut [Lanes],
}

impl<'t> Tile<'t> {
    /// How many rows there are.
    fn rows(units: usize, head: Option<&dyn Head>) -> usize {
        units + head.map_or(0, |head| head.outputs() + head.uniforms() + head.scratch())
    }

    fn of(memory: &'t mut [f64], units: usize, head: Option<&dyn Head>) -> Self {
        let [outputs, uniforms] = head.map_or([0, 0], |head| [head.outputs(), head.uniforms()]);
        let (values, rest) = lanes(memory).split_at_mut(units);
        let (theta, rest) = rest.split_at_mut(outputs);
        let (uniforms, head) = rest.split_at_mut(uniforms);
        Tile { values, theta, uniforms, head }
    }
}

impl<M: Transport + ?Sized> AmortisedBatch<'_, M> {
    /// Shows each tile of particles to `work`: its number, where it is, its units, and what it is computed in, with `θ` loaded.
    pub(super) fn by_tiles(
        &mut self,
        mut work: impl FnMut(usize, &Place<'_, M>, &Units<'_>, Tile<'_>, [&[f64]; 2]),
    ) {
        let (sizes, head) = (self.sizes, self.head);
        let Sizes { states: n, units: q } = sizes;
        let Context { step, previous, particles, .. } = self.context;
        let AmortisedScratch { units, previous: kept, theta, tile, noise, uniforms, .. } = &mut *self.scratch;
        tile.clear();
        tile.resize(Tile::rows(q, head) * LANES, 0.0);
        let emitted = if head.is_some() { self.theta.emitted } else { 0 };
        self.theta.place_shared(Tile::of(tile, q, head).theta);
        let parts = units.chunks_exact_mut(sizes.rows() * LANES).zip(kept.chunks_exact(n * LANES));
        for (number, (units, kept)) in parts.enumerate() {
            let (first, last) = (number * LANES, ((number + 1) * LANES).min(particles));
            let tile = Tile::of(tile, q, head);
            if emitted > 0 {
                self.theta.load(&theta[first * emitted..last * emitted], tile.theta);
            }
            let place = Place {
                model: self.model,
                step,
                previous: previous.map(|_| kept),
                is_affine: self.is_affine,
                noise: self.noise.map(|(model, _)| model),
            };
            work(number, &place, &Units::of(units, sizes), tile, [noise, uniforms]);
        }
    }
}

impl<M: Transport + ?Sized> AmortisedBatch<'_, M> {
    /// Draws the standard normal numbers of each particle's units, and so many uniform ones.
    pub(super) fn draw_noise(&mut self, streams: &mut [Stream], extra: usize) {
        let (units, particles) = (self.sizes.units, self.context.particles);
        let AmortisedScratch { noise, uniforms, .. } = &mut *self.scratch;
        noise.resize(particles * units, 0.0);
        for (stream, noise) in particles_by_stream(streams, noise, units, particles) {
            fill_standard_normal(stream, noise);
        }
        uniforms.resize(particles * extra, 0.0);
        if extra > 0 {
            for (stream, uniforms) in particles_by_stream(streams, uniforms, extra, particles) {
                fill_uniform(stream, uniforms);
            }
        }
    }

    /// Draws states, and writes their densities if they are asked for.
    fn draw_states(
        &mut self,
        streams: &mut [Stream],
        states: &mut [f64],
        mut log_densities: Option<&mut [f64]>,
    ) {
        let (n, head, particles) = (self.sizes.states, self.head, self.context.particles);
        let extra = head.map_or(0, |head| head.uniforms());
        self.draw_noise(streams, extra);
        self.by_tiles(|number, place, units, tile, [noise, uniforms]| {
            let (first, last) = (number * LANES, ((number + 1) * LANES).min(particles));
            let Tile { values, theta, uniforms: of_tile, head: scratch } = tile;
            load(&noise[first * n..last * n], n, units::flat_mut(values));
            if let Some(head) = head {
                if extra > 0 {
                    load(&uniforms[first * extra..last * extra], extra, units::flat_mut(of_tile));
                }
                head.draw(theta, of_tile, values);
            }
            match &mut log_densities {
                None => units.to_states(place, values, None),
                Some(log_densities) => {
                    let mut log_density = match head {
                        None => log_standard_normal(values),
                        Some(head) => head.log_density(theta, values, scratch),
                    };
                    units.to_states(place, values, Some(&mut log_density));
                    log_densities[first..last].copy_from_slice(&log_density.0[..last - first]);
                }
            }
            store(units::flat(values), n, &mut states[first * n..last * n]);
        });
    }
}

impl<M: Transport + ?Sized> Conditional for AmortisedBatch<'_, M> {
    fn sample(&mut self, streams: &mut [Stream], states: &mut [f64], log_densities: &mut [f64]) {
        self.draw_states(streams, states, Some(log_densities));
    }

    fn sample_states(&mut self, streams: &mut [Stream], states: &mut [f64], _unasked: &mut [f64]) {
        self.draw_states(streams, states, None);
    }

    fn sample_by_noise(
        &mut self,
        share: Option<f64>,
        streams: &mut [Stream],
        states: &mut [f64],
        log_ratios: &mut [f64],
    ) -> bool {
        let Some((model, own)) = self.noise else { return false };
        self.draw_by_noise(model, share.unwrap_or(own), streams, states, log_ratios);
        true
    }

    fn is_transition(&self) -> bool {
        self.sizes.units == 0
    }

    fn log_density(&mut self, states: &[f64], log_densities: &mut [f64]) {
        let (n, head, particles) = (self.sizes.states, self.head, log_densities.len());
        self.by_tiles(|number, place, units, tile, _| {
            let (first, last) = (number * LANES, ((number + 1) * LANES).min(particles));
            let Tile { values, theta, head: scratch, .. } = tile;
            load(&states[first * n..last * n], n, units::flat_mut(values));
            let [log_determinant, _] = units.to_units(place, values);
            let of_head = match head {
                None => log_standard_normal(values),
                Some(head) => head.log_density(theta, values, scratch),
            };
            let log_density = of_head + log_determinant;
            log_densities[first..last].copy_from_slice(&log_density.0[..last - first]);
        });
    }
}
