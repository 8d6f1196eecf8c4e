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
    pub(super) fn choose(&mut self, uniforms: &[f64; LANES]) {
        let TileGuide { shares, mean, lower, chosen: [chosen_mean, chosen_lower], .. } = self;
        let count = shares.len() / LANES;
        let (q, entries) = (mean.len() / count, lower.len() / count);
        chosen_mean.resize(q, 0.0);
        chosen_lower.resize(entries, 0.0);
        for (lane, uniform) in uniforms.iter().enumerate() {
            let mut rest = *uniform;
            // The last is taken where rounding leaves something.
            let place = (0..count - 1).find(|place| {
                rest -= shares[place * LANES + lane];
                rest < 0.0
            });
            let place = place.unwrap_or(count - 1);
            for (chosen, all) in [(&mut *chosen_mean, &*mean), (&mut *chosen_lower, &*lower)] {
                let width = chosen.len();
                let of_lane = all[place * width..][..width].iter().skip(lane).step_by(LANES);
                chosen.iter_mut().skip(lane).step_by(LANES).zip(of_lane).for_each(|(to, from)| *to = *from);
            }
        }
    }

    /// Turns standard normal numbers (`Q × LANES`) into noise of the chosen Gaussians; some particles keep theirs, as they come from the noise's own distribution.
    pub(super) fn draw_chosen(&self, is_from_prior: &[bool; LANES], normals: &mut [f64]) {
        let [mean, lower] = self.chosen.each_ref().map(|chosen| chosen.as_chunks::<LANES>().0);
        let normals = lanes(normals);
        for i in 0..normals.len() {
            let row = &lower[at(i, 0)..=at(i, i)];
            let mut v = normals[i];
            for lane in (0..LANES).filter(|lane| !is_from_prior[*lane]) {
                let of_others = (0..i).map(|j| row[j][lane] * (normals[j].0[lane] - mean[j][lane]));
                v.0[lane] = mean[i][lane] + (v.0[lane] - of_others.sum::<f64>()) / row[i][lane];
            }
            normals[i] = v;
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
