//! Trajectories that were drawn, and what they say together.

use serde::{Deserialize, Serialize};

/// `B` trajectories of `T` times given all measurements, of equal weight.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SmoothedPaths {
    /// Path after path, each `T×N`.
    pub(super) states: Vec<f64>,
    pub(super) times: usize,
    pub(super) width: usize,
    /// Of each time.
    pub(super) distinct_particles: Vec<usize>,
    pub(super) follow_ancestors: bool,
}

impl SmoothedPaths {
    /// The same trajectories without their first `times` times.
    ///
    /// # Panics
    /// If they have no more.
    #[must_use]
    pub fn without_first(self, times: usize) -> Self {
        if times == 0 {
            return self;
        }
        assert!(times < self.times, "of {} times {times} are left out", self.times);
        let rows = self.states.chunks_exact(self.times * self.width);
        let states = rows.flat_map(|path| path[times * self.width..].iter().copied()).collect();
        let distinct_particles = self.distinct_particles[times..].to_vec();
        SmoothedPaths { states, times: self.times - times, distinct_particles, ..self }
    }

    /// Trajectories (path after path, each row-major `T×N`) that were drawn independently of each other, from no particles.
    ///
    /// # Panics
    /// If `T` or `N` is 0, or the states are no whole number of paths.
    pub fn independent(states: Vec<f64>, times: usize, width: usize) -> Self {
        assert!(states.len().is_multiple_of(times * width), "each path has T×N numbers");
        let paths = states.len() / (times * width);
        SmoothedPaths {
            states,
            times,
            width,
            distinct_particles: vec![paths; times],
            follow_ancestors: false,
        }
    }

    /// `B`.
    pub fn len(&self) -> usize {
        self.states.len() / (self.times * self.width)
    }

    /// Whether there is none; there is always one at least.
    pub fn is_empty(&self) -> bool {
        self.states.is_empty()
    }

    /// `T`.
    pub fn times(&self) -> usize {
        self.times
    }

    /// The states of a path, row-major `T×N`.
    ///
    /// # Panics
    /// If there is no such path.
    pub fn path(&self, path: usize) -> &[f64] {
        let each = self.times * self.width;
        &self.states[path * each..(path + 1) * each]
    }

    /// How many different particles of the filter's at time `t` the `B` trajectories pass through, between 1 and `min(B, K)`.
    ///
    /// Where a transition is so precise that only its own ancestor leads to a state, trajectories that meet once stay together, and at early times all of them
    /// rest on a few particles (path degeneracy). Means of these times are those of so few draws then, and standard deviations are too small.
    ///
    /// # Panics
    /// If there is no such time.
    pub fn distinct_particles(&self, time: usize) -> usize {
        self.distinct_particles[time]
    }

    /// Whether trajectories follow the filter's ancestors, because the model's transition has no density to draw others by.
    pub fn follow_ancestors(&self) -> bool {
        self.follow_ancestors
    }

    /// A coordinate at a time, path by path.
    fn values(&self, time: usize, coordinate: usize) -> impl Iterator<Item = f64> {
        assert!(
            time < self.times && coordinate < self.width,
            "there are {} times and {} coordinates",
            self.times,
            self.width
        );
        self.states.iter().skip(time * self.width + coordinate).step_by(self.times * self.width).copied()
    }

    /// The estimate of `E[x_t | y_{0:T−1}]`, one coordinate of it.
    ///
    /// # Panics
    /// If there is no such time or coordinate.
    pub fn mean(&self, time: usize, coordinate: usize) -> f64 {
        self.values(time, coordinate).sum::<f64>() / self.len() as f64
    }

    /// The estimate of the standard deviation of a coordinate of `x_t` given all measurements: `√(1/B Σ_b (x_t^b − mean)²)`. It is NaN where all trajectories
    /// pass through one particle ([`SmoothedPaths::distinct_particles`]), for one draw says nothing of a spread.
    ///
    /// # Panics
    /// As [`SmoothedPaths::mean`].
    pub fn standard_deviation(&self, time: usize, coordinate: usize) -> f64 {
        let mean = self.mean(time, coordinate);
        if self.distinct_particles[time] < 2 {
            return f64::NAN;
        }
        (self.values(time, coordinate).map(|x| (x - mean) * (x - mean)).sum::<f64>() / self.len() as f64)
            .sqrt()
    }

    /// Quantiles of a coordinate of `x_t` given all measurements: for each probability `p` the smallest value that a share of at least `p` of the paths
    /// does not exceed. They are NaN where all trajectories pass through one particle, as [`SmoothedPaths::standard_deviation`].
    ///
    /// # Panics
    /// As [`SmoothedPaths::mean`], and if a probability is not between 0 and 1.
    pub fn quantiles(&self, time: usize, coordinate: usize, probabilities: &[f64]) -> Vec<f64> {
        assert!(probabilities.iter().all(|p| (0.0..=1.0).contains(p)), "a probability is between 0 and 1");
        let mut values: Vec<f64> = self.values(time, coordinate).collect();
        if self.distinct_particles[time] < 2 {
            return vec![f64::NAN; probabilities.len()];
        }
        values.sort_by(f64::total_cmp);
        let at = |p: f64| ((p * values.len() as f64).ceil() as usize).clamp(1, values.len()) - 1;
        probabilities.iter().map(|p| values[at(*p)]).collect()
    }
}
