//! Noise from a mixture of Gaussians, where a potential is the sum of several quadratics.

use motes_models::batch::LANES;
use motes_models::equations::triangle::at;
use motes_models::equations::{Lanes, Scalar};

use super::component::Component;
use super::scratch::TileGuide;
use super::tile::{LEAST, exponentials, pull_of};
use crate::proposals::lanes;

impl TileGuide {
    /// Chooses a quadratic for each particle of the tile, with probability `w_j Z̃_j / Z̃`, by a uniform number of each.
    #[inline(always)]
    pub(super) fn choose(&mut self, uniforms: &[f64; LANES]) {
        let TileGuide { shares, mean, lower, chosen: [chosen_mean, chosen_lower], .. } = self;
        let count = shares.len() / LANES;
        // Shares that are passed in order; the last is taken where rounding leaves something.
        let (mut rest, mut places) = (*uniforms, [0.0; LANES]);
        for share in &lanes(shares)[..count - 1] {
            for lane in 0..LANES {
                rest[lane] -= share.0[lane];
                places[lane] += if rest[lane] < 0.0 { 0.0 } else { 1.0 };
            }
        }
        for (chosen, all) in [(chosen_mean, mean), (chosen_lower, lower)] {
            let width = all.len() / count;
            chosen.resize(width, 0.0);
            for place in 0..count {
                let of_one = &mut all[place * width..][..width];
                for (to, from) in lanes(chosen).iter_mut().zip(lanes(of_one)) {
                    for ((to, from), own) in to.0.iter_mut().zip(from.0).zip(places) {
                        *to = if own == place as f64 { from } else { *to };
                    }
                }
            }
        }
    }

    /// Turns standard normal numbers (`Q × LANES`) into noise of the chosen Gaussians; some particles keep theirs, as they come from the noise's own distribution.
    #[inline(always)]
    pub(super) fn draw_chosen(&mut self, is_from_prior: &[bool; LANES], normals: &mut [f64]) {
        let [mean, lower] = &mut self.chosen;
        let (mean, lower, normals) = (lanes(mean), lanes(lower), lanes(normals));
        for i in 0..normals.len() {
            let row = &lower[at(i, 0)..=at(i, i)];
            let mut sum = Lanes::from(0.0);
            for j in 0..i {
                sum = sum + row[j] * (normals[j] - mean[j]);
            }
            let drawn = mean[i] + (normals[i] - sum) / row[i];
            for (lane, is_from_prior) in is_from_prior.iter().enumerate() {
                let number = &mut normals[i].0[lane];
                *number = if *is_from_prior { *number } else { drawn.0[lane] };
            }
        }
    }

    /// `log ψ̃(v) = log Σ_j w_j ψ_j(c + J v)` of noise (`Q × LANES`); the centres become `c + J v`.
    #[inline(always)]
    pub(super) fn log_mixture(
        &mut self,
        components: &[Component],
        is_diagonal: bool,
        noise: &mut [f64],
    ) -> Lanes {
        let TileGuide { centres, jacobian, spare, shares, .. } = self;
        let (centres, jacobian, noise) = (lanes(centres), lanes(jacobian), lanes(noise));
        let (n, q) = (centres.len(), noise.len());
        for (i, centre) in centres.iter_mut().enumerate() {
            if is_diagonal {
                *centre = *centre + jacobian[i] * noise[i];
            } else {
                for (entry, v) in jacobian[i * q..][..q].iter().zip(&*noise) {
                    *centre = *centre + *entry * *v;
                }
            }
        }
        let (d, rest) = lanes(spare).split_at_mut(n);
        // Shares are used up.
        let logs = lanes(shares);
        for (log, Component { log_weight, potential, .. }) in logs.iter_mut().zip(components) {
            for ((d, state), reference) in d.iter_mut().zip(&*centres).zip(&potential.reference) {
                *d = *state - *reference;
            }
            *log = (pull_of(potential, d, &mut rest[..n]) + *log_weight).max(Lanes::from(LEAST));
        }
        exponentials(logs).0
    }
}
