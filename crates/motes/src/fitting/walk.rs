//! A random walk of positions.

use motes_models::{Stream, fill_standard_normal};

use super::free::FreeParameters;

/// A position is no farther from 0 than this: beyond it a quantile of a prior is its end.
const FARTHEST: f64 = 5.0;

/// Of a uniform prior it is nearer: 2·10⁻⁴ of it lie beyond at each end.
const FARTHEST_IN_BOX: f64 = 3.5;

/// A step near the end of a uniform prior is no longer than by this factor.
const LONGEST: f64 = 20.0;

/// The standard deviation of a uniform number over the density of a standard normal one at 0.
const OF_UNIFORM: f64 = 0.723_6;

/// A random walk of a swarm's positions. Those of a uniform prior walk evenly in the parameter: near an end it hardly changes with its normal quantile, and a swarm that has drifted there would not come
/// back.
pub(super) struct Walk {
    /// For each coordinate, whether its prior is uniform.
    are_uniform: Vec<bool>,
    noise: Vec<f64>,
    stream: Stream,
}

impl Walk {
    /// One of so many numbers.
    pub(super) fn new(free: &FreeParameters, numbers: usize, stream: Stream) -> Self {
        Walk { are_uniform: are_uniform(free), noise: vec![0.0; numbers], stream }
    }

    /// Moves positions (`K×D`) by steps with a standard deviation for each coordinate, or along directions `L` (`D×D`).
    pub(super) fn step(
        &mut self,
        positions: &mut [f64],
        directions: Option<&[f64]>,
        spread: impl Fn(usize) -> f64,
    ) {
        fill_standard_normal(&mut self.stream, &mut self.noise);
        match directions {
            Some(lower) => self.step_along(positions, lower, spread),
            None => self.step_apart(positions, spread),
        }
    }

    fn step_apart(&self, positions: &mut [f64], spread: impl Fn(usize) -> f64) {
        let d = self.are_uniform.len();
        for (coordinate, is_uniform) in self.are_uniform.iter().enumerate() {
            let sd = spread(coordinate);
            if sd == 0.0 {
                continue;
            }
            let steps = positions.iter_mut().zip(&self.noise).skip(coordinate).step_by(d);
            match is_uniform {
                false => steps.for_each(|(v, noise)| *v = (*v + sd * noise).clamp(-FARTHEST, FARTHEST)),
                true => steps.for_each(|(v, noise)| *v = reflected(*v + sd * of_uniform(*v) * noise)),
            }
        }
    }

    fn step_along(&self, positions: &mut [f64], lower: &[f64], spread: impl Fn(usize) -> f64) {
        let d = self.are_uniform.len();
        let spreads: Vec<f64> = (0..d).map(spread).collect();
        for (position, noise) in positions.chunks_exact_mut(d).zip(self.noise.chunks_exact(d)) {
            for (coordinate, v) in position.iter_mut().enumerate().filter(|(at, _)| spreads[*at] != 0.0) {
                let row = &lower[coordinate * d..][..=coordinate];
                let step: f64 = row.iter().zip(noise).map(|(entry, noise)| entry * noise).sum();
                let moved = *v + spreads[coordinate] * step;
                *v = match self.are_uniform[coordinate] {
                    true => reflected(moved),
                    false => moved.clamp(-FARTHEST, FARTHEST),
                };
            }
        }
    }
}

/// For each coordinate, whether its prior is uniform.
pub(super) fn are_uniform(free: &FreeParameters) -> Vec<bool> {
    let priors = free.priors().iter();
    priors.flat_map(|prior| vec![prior.is_uniform(); prior.entries().len()]).collect()
}

/// How far a position of a uniform prior goes where its parameter goes by a standard deviation.
pub(super) fn of_uniform(v: f64) -> f64 {
    (OF_UNIFORM * (0.5 * v * v).exp()).min(LONGEST)
}

/// A position within the ends of a uniform prior.
fn reflected(v: f64) -> f64 {
    let beyond = v.abs() - FARTHEST_IN_BOX;
    if beyond > 0.0 { v.signum() * (FARTHEST_IN_BOX - beyond).max(0.0) } else { v }
}
