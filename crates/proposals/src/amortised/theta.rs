//! The parameters of a head: those that a network emits for each particle, and those that all particles share.

use motes_models::batch::load;
use motes_models::equations::Lanes;
use motes_networks::Gradients;

use super::units::flat_mut;

/// `θ` of the particles of one time: first what the network emits, then what is the same for all.
#[derive(Clone)]
pub(super) struct Theta {
    /// How many numbers the network emits for a particle.
    pub(super) emitted: usize,
    /// Those that all particles share.
    pub(super) shared: Vec<f64>,
    /// Where these stand among the parameters.
    pub(super) index: usize,
}

impl Theta {
    /// Writes what all particles share; it stays there when [`Theta::load`] writes what is a particle's own.
    pub(super) fn place_shared(&self, theta: &mut [Lanes]) {
        for (place, value) in theta.iter_mut().skip(self.emitted).zip(&self.shared) {
            *place = Lanes::from(*value);
        }
    }

    /// Writes what the network emitted for a tile of particles.
    pub(super) fn load(&self, rows: &[f64], theta: &mut [Lanes]) {
        load(rows, self.emitted, flat_mut(&mut theta[..self.emitted]));
    }

    /// Room for the derivative along what is shared.
    pub(super) fn no_slopes(&self) -> Vec<f64> {
        vec![0.0; self.shared.len()]
    }

    /// Adds the derivatives along what is shared, of the first `particles` of a tile.
    pub(super) fn add_slopes(&self, d_theta: &[Lanes], particles: usize, slopes: &mut [f64]) {
        for (slope, d) in slopes.iter_mut().zip(&d_theta[self.emitted..]) {
            *slope += d.0[..particles].iter().sum::<f64>();
        }
    }

    /// Hands the derivatives along what is shared to those of the weights.
    pub(super) fn hand_over(&self, slopes: &[f64], gradients: &mut Gradients) {
        if !slopes.is_empty() {
            gradients.add_wide(self.index, slopes);
        }
    }
}
