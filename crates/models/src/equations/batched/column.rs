//! Parameters of many particles.

use super::super::distribution::{Distribution, Normal};
use super::super::lanes::Lanes;
use super::super::scalar::Scalar;
use super::super::statement::{Coordinates, Draws};
use super::super::varied::{SIDE, Side, Varied};
use crate::batch::LANES;

/// A parameter: one number for all particles, or one for each, perhaps with derivatives.
#[derive(Debug, Clone, PartialEq)]
pub struct Column {
    values: Vec<f64>,
    /// `∂/∂x_j` of each particle's number, `N×K`; none where it does not change with a state.
    slopes: Vec<f64>,
}

impl Column {
    /// The same number for all particles.
    pub fn same(value: f64) -> Self {
        Column::each(vec![value])
    }

    /// A number for each particle (`K`).
    pub fn each(values: Vec<f64>) -> Self {
        Column { values, slopes: Vec::new() }
    }

    /// A number for each particle (`K`), with its derivative along each coordinate of the particle's row (`N×K`: all particles' along the first, then along the
    /// next).
    pub fn with_slopes(values: Vec<f64>, slopes: Vec<f64>) -> Self {
        Column { values, slopes }
    }

    /// The numbers: one, or as many as there are particles.
    pub fn values(&self) -> &[f64] {
        &self.values
    }

    /// Those of `W` particles from `first` on; 0 where there is no particle.
    fn at<const W: usize>(&self, values: &[f64], first: usize) -> Lanes<W> {
        if let [value] = values
            && self.values.len() == 1
        {
            return Lanes::from(*value);
        }
        let mut lanes = [0.0; W];
        let there = values.get(first..).unwrap_or_default();
        lanes.iter_mut().zip(there).for_each(|(lane, value)| *lane = *value);
        Lanes(lanes)
    }

    /// Those of a tile.
    fn tile(&self, first: usize) -> Lanes {
        self.at::<LANES>(&self.values, first)
    }

    /// Those of a few particles, with derivatives along a coordinate of their rows, if one is given.
    fn side(&self, first: usize, along: Option<usize>) -> Varied<2> {
        let count = self.values.len();
        let slopes = along.and_then(|along| self.slopes.get(along * count..(along + 1) * count));
        let slopes = slopes.map_or(Side::from(0.0), |slopes| self.at::<SIDE>(slopes, first));
        Varied::along_first(self.at::<SIDE>(&self.values, first), slopes)
    }
}

/// The distribution of a coordinate of many particles: `shift + scale·z` for `z` of a family.
#[derive(Debug, Clone, PartialEq)]
pub struct BatchDistribution {
    family: Distribution<Column>,
    scale: Option<Column>,
    shift: Option<Column>,
    /// Whether the coordinate is the mean of the family itself, and nothing is drawn.
    is_known: bool,
}

impl BatchDistribution {
    /// The distribution itself. Where a parameter is out of range for a particle, its draws and densities are NaN.
    pub fn new(family: Distribution<Column>) -> Self {
        BatchDistribution { family, scale: None, shift: None, is_known: false }
    }

    /// A coordinate of a state that is known: at the start, or because it follows from the state before. To who asks for a density it is NaN.
    pub fn known(value: Column) -> Self {
        let family = Distribution::Normal(Normal { mean: value, sd: Column::same(f64::NAN) });
        BatchDistribution { is_known: true, ..BatchDistribution::new(family) }
    }

    /// The distribution of `shift + scale·z`, for what is given of these. Counts, and what is known, can be neither scaled nor shifted.
    #[must_use]
    pub fn affine(self, scale: Option<Column>, shift: Option<Column>) -> Self {
        BatchDistribution { scale, shift, ..self }
    }

    /// With parameters of any kind of number.
    #[inline(always)]
    fn of<S: Scalar>(&self, of: impl Fn(&Column) -> S + Copy) -> Distribution<S> {
        let family = self.family.map(of).guarded();
        match (&self.scale, &self.shift) {
            (None, None) => family,
            (None, Some(shift)) => family.shifted(of(shift)),
            (Some(scale), None) => family.scaled(of(scale)),
            (Some(scale), Some(shift)) => family.scaled(of(scale)).shifted(of(shift)),
        }
    }

    /// That of the particles of a tile.
    pub(super) fn tile(&self, first: usize) -> Distribution<Lanes> {
        self.of(|column| column.tile(first))
    }

    /// That of a few particles, with derivatives along a coordinate of their rows, if one is given.
    pub(super) fn side(&self, first: usize, along: Option<usize>) -> Distribution<Varied<2>> {
        self.of(|column| column.side(first, along))
    }

    /// What is known of the particles of a tile without a draw.
    fn known_tile(&self, first: usize) -> Option<Lanes> {
        match &self.family {
            Distribution::Normal(Normal { mean, .. }) if self.is_known => Some(mean.tile(first)),
            _ => None,
        }
    }

    /// Whether it is drawn.
    pub(super) fn is_drawn(&self) -> bool {
        !self.is_known
    }

    /// That of the first particle.
    pub(super) fn first(&self) -> Distribution<f64> {
        self.row(0)
    }

    /// That of one particle.
    pub(super) fn row(&self, particle: usize) -> Distribution<f64> {
        let at = |values: &[f64]| if values.len() == 1 { 0 } else { particle };
        self.of(|column| column.values.get(at(&column.values)).copied().unwrap_or(f64::NAN))
    }
}

/// Draws each coordinate of the particles of a tile; all is NaN where another number of them is stated than there is.
pub(super) fn draw_tile(
    stated: &[BatchDistribution],
    first: usize,
    draws: &mut impl Draws<Lanes>,
    states: &mut [Lanes],
) {
    states.fill(Lanes::from(f64::NAN));
    let is_whole = stated.len() == states.len();
    for (at, distribution) in stated.iter().enumerate() {
        let known = distribution.known_tile(first);
        let drawn = known.unwrap_or_else(|| draws.draw(distribution.tile(first)));
        if is_whole {
            states[at] = drawn;
        }
    }
}

/// Pushes the distribution of each entry of the measurements of a tile.
pub(super) fn push_tile(stated: &[BatchDistribution], first: usize, sink: &mut impl Coordinates<Lanes>) {
    stated.iter().for_each(|distribution| sink.push(distribution.tile(first)));
}
