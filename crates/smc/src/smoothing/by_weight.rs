//! Particles drawn by their weights.

use motes_models::elementary::exp;

/// Draws the number of a particle with a probability in proportion to its weight.
#[derive(Debug, Clone, Copy)]
pub(super) struct ByWeight<'a> {
    /// Running sums of the weights.
    sums: &'a [f64],
    /// The last particle with any weight.
    last: usize,
}

impl<'a> ByWeight<'a> {
    /// For particles with these logarithms of weights, in whose place the sums are kept; none if all weights are 0 or one is not a number.
    pub(super) fn new(log_weights: &'a mut [f64]) -> Option<Self> {
        let largest = log_weights.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        if !largest.is_finite() || log_weights.iter().any(|weight| weight.is_nan()) {
            return None;
        }
        let mut total = 0.0;
        for weight in &mut *log_weights {
            total += exp(*weight - largest);
            *weight = total;
        }
        let last = log_weights.partition_point(|sum| *sum < total);
        Some(ByWeight { sums: log_weights, last })
    }

    /// The particle that a uniform number in `[0, 1)` falls on.
    pub(super) fn draw(&self, uniform: f64) -> usize {
        let level = uniform * self.sums[self.last];
        // Rounding may leave a level at the very end.
        self.sums.partition_point(|sum| *sum <= level).min(self.last)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_particle_has_its_share_and_one_without_weight_none() {
        let weights = [0.0, 0.5, 0.0, 0.125, 0.375, 0.0];
        let mut log_weights = weights.map(|weight: f64| weight.ln() - 900.0);
        let by_weight = ByWeight::new(&mut log_weights).unwrap();
        let mut drawn = [0.0; 6];
        (0..8000).for_each(|at| drawn[by_weight.draw((f64::from(at) + 0.5) / 8000.0)] += 1.0 / 8000.0);
        assert!(drawn.iter().zip(weights).all(|(share, weight)| (share - weight).abs() < 1e-9), "{drawn:?}");
        assert_eq!(by_weight.draw(1.0), 4);
    }

    #[test]
    fn without_weights_nothing_can_be_drawn() {
        assert!(ByWeight::new(&mut []).is_none());
        assert!(ByWeight::new(&mut [f64::NEG_INFINITY; 3]).is_none());
        assert!(ByWeight::new(&mut [0.0, f64::NAN]).is_none());
        assert!(ByWeight::new(&mut [0.0, f64::INFINITY]).is_none());
    }
}
