//! Draws whose noise comes from a Gaussian, one given those before it.

use crate::batch::LANES;
use crate::equations::distribution::Distribution;
use crate::equations::lanes::Lanes;
use crate::equations::quantile::GuidedNoise;
use crate::equations::scalar::Scalar;
use crate::equations::statement::Draws;
use crate::equations::triangle::at;

/// The Gaussian of each particle's noise: `N(m, Λ⁻¹)`, `Λ = Lᵀ L`.
#[derive(Debug, Clone, Copy)]
pub struct Guide<'a> {
    /// `m`, `Q`.
    pub means: &'a [Lanes],
    /// `L`, its lower triangle, row after row: `Q(Q+1)/2`.
    pub lower: &'a [Lanes],
    /// Which particles draw from `N(0, I)` instead; their densities are still those of the Gaussian.
    pub is_from_prior: &'a [bool; LANES],
}

/// Answers each draw with what its noise is transported to, and adds up `log q − log p`; NaN where there are more draws than noise.
pub(super) struct GuidedDraws<'a> {
    guide: Guide<'a>,
    /// Standard normal numbers; of the draws so far `v − m`.
    noise: &'a mut [Lanes],
    drawn: usize,
    log_ratio: Lanes,
}

impl<'a> GuidedDraws<'a> {
    pub(super) fn new(guide: Guide<'a>, noise: &'a mut [Lanes]) -> Self {
        GuidedDraws { guide, noise, drawn: 0, log_ratio: Lanes::from(0.0) }
    }

    /// Of all draws; NaN where some number was not drawn.
    pub(super) fn log_ratio(&self) -> Lanes {
        if self.drawn == self.noise.len() { self.log_ratio } else { Lanes::from(f64::NAN) }
    }
}

impl Draws<Lanes> for GuidedDraws<'_> {
    #[inline(always)]
    fn draw(&mut self, distribution: Distribution<Lanes>) -> Lanes {
        let i = self.drawn;
        self.drawn += 1;
        if i >= self.noise.len() {
            return Lanes::from(f64::NAN);
        }
        let (before, now) = self.noise.split_at_mut(i);
        let row = &self.guide.lower[at(i, 0)..=at(i, i)];
        let (mean, scale) = (self.guide.means[i], row[i]);
        let mut sum = Lanes::from(0.0);
        for (entry, deviation) in row.iter().zip(&*before) {
            sum = sum + *entry * *deviation;
        }
        let centre = mean - sum / scale;
        let mut z = now[0];
        let mut v = centre + z / scale;
        for (lane, _) in
            self.guide.is_from_prior.iter().enumerate().filter(|(_, is_from_prior)| **is_from_prior)
        {
            v.0[lane] = z.0[lane];
            z.0[lane] = (v.0[lane] - centre.0[lane]) * scale.0[lane];
        }
        if distribution.is_discrete() {
            let noise = GuidedNoise {
                v: &v.0,
                centre: &centre.0,
                scale: &scale.0,
                is_from_prior: self.guide.is_from_prior,
            };
            let [count, log_ratio, likely] = distribution.guided_counts(&noise);
            self.log_ratio = self.log_ratio + log_ratio;
            now[0] = likely - mean;
            return count;
        }
        self.log_ratio = self.log_ratio + scale.ln() + (v * v - z * z) * 0.5;
        now[0] = v - mean;
        distribution.tile_from_normal(v)
    }
}

impl Distribution<Lanes> {
    /// What the noise of each particle is transported to.
    #[inline(always)]
    pub(super) fn tile_from_normal(&self, v: Lanes) -> Lanes {
        match self.formula(v) {
            Some([value, _]) => value,
            None => self.lane_by_lane(v, |of_lane, v| [of_lane.from_normal(v), 0.0])[0],
        }
    }
}
