//! Draws of the noise that states are made of, where they have no density.

use motes_models::Stream;
use motes_models::batch::{LANES, load, store, with_scratch};
use motes_models::equations::{Lanes, NoiseSpace, Transport};
use motes_smc::weigh_with_share;

use super::batch::{AmortisedBatch, Tile};
use super::units::{Sizes, flat, flat_mut, lanes, log_standard_normal};

impl<M: Transport + ?Sized> AmortisedBatch<'_, M> {
    /// Draws the noise of each particle from `(1 − α) q + α N(0, I)`, writes the states that it makes into `states` (`R×N`), and `log N(v; 0, I)` minus the log-density
    /// of the mixture into `log_ratios` (`R`); `α` is the `share`.
    pub(super) fn draw_by_noise(
        &mut self,
        model: &dyn NoiseSpace,
        share: f64,
        streams: &mut [Stream],
        states: &mut [f64],
        log_ratios: &mut [f64],
    ) {
        let (head, particles) = (self.head, self.context.particles);
        let Sizes { states: n, units: q } = self.sizes;
        let of_head = head.map_or(0, |head| head.uniforms());
        // The last uniform number of a particle chooses from the mixture.
        let extra = of_head + usize::from(share > 0.0);
        self.draw_noise(streams, extra);
        with_scratch((n + 2 * q + extra) * LANES, |memory| {
            memory.fill(0.0);
            let (now, rest) = lanes(memory).split_at_mut(n);
            let (prior, rest) = rest.split_at_mut(q);
            let (noise_of_tile, uniforms_of_tile) = rest.split_at_mut(q);
            self.by_tiles(|number, place, units, tile, [noise, uniforms]| {
                let (first, last) = (number * LANES, ((number + 1) * LANES).min(particles));
                let Tile { values, theta, head: scratch, .. } = tile;
                load(&noise[first * q..last * q], q, flat_mut(values));
                if extra > 0 {
                    load(&uniforms[first * extra..last * extra], extra, flat_mut(uniforms_of_tile));
                }
                let (uniforms_of_head, choice) = uniforms_of_tile.split_at(of_head);
                let mut is_from_prior = [false; LANES];
                for (is_from_prior, uniform) in
                    is_from_prior.iter_mut().zip(choice.iter().flat_map(|row| row.0))
                {
                    *is_from_prior = uniform < share;
                }
                prior.copy_from_slice(values);
                if let Some(head) = head {
                    head.draw(theta, uniforms_of_head, values);
                }
                noise_of_tile.copy_from_slice(values);
                units.to_noise(noise_of_tile);
                if is_from_prior.contains(&true) {
                    for (v, z) in noise_of_tile.iter_mut().zip(&*prior) {
                        choose(v, z, &is_from_prior);
                    }
                    let _ = units.noise_to_units(prior);
                    for (u, of_prior) in values.iter_mut().zip(&*prior) {
                        choose(u, of_prior, &is_from_prior);
                    }
                }
                let of_units = match head {
                    None => log_standard_normal(values),
                    Some(head) => head.log_density(theta, values, scratch),
                };
                let ratio = of_units + units.log_determinant() - log_standard_normal(noise_of_tile);
                log_ratios[first..last].copy_from_slice(&ratio.0[..last - first]);
                model.tile_states(&place.step, place.previous, flat(noise_of_tile), flat_mut(now));
                store(flat(now), n, &mut states[first * n..last * n]);
            });
        });
        weigh_with_share(log_ratios, share);
    }
}

/// Takes the other number where a lane is chosen.
fn choose(value: &mut Lanes, other: &Lanes, is_chosen: &[bool; LANES]) {
    for ((value, other), _) in value.0.iter_mut().zip(other.0).zip(is_chosen).filter(|(_, chosen)| **chosen) {
        *value = other;
    }
}
