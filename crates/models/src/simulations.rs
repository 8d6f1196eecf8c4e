//! Many trajectories of a model, and what they have in common.

use faer::linalg::solvers::Solve;
use faer::{Mat, Side};

use crate::{ModelError, Seed, Sequence, Simulator, Trajectory, simulate_within};

/// Trajectories that were drawn from a model for themselves: what is known of a system before anything was measured.
///
/// No constructor takes trajectories from elsewhere. What learns may therefore see it without seeing the truth behind its data.
///
/// ```
/// use motes_models::{Epidemic, EpidemicConfig, Seed, Simulations};
///
/// let epidemic = Epidemic::new(&EpidemicConfig::paper())?;
/// let simulations = Simulations::draw(&epidemic, 50, 100, 2000.0, &Seed::from_u64(1))?;
/// let infected = simulations.states_at(20).means[1];
/// assert!(infected > 100.0);
/// # Ok::<(), motes_models::ModelError>(())
/// ```
#[derive(Debug, Clone)]
pub struct Simulations {
    trajectories: Vec<Trajectory>,
}

/// A mean and a standard deviation of each coordinate.
#[derive(Debug, Clone, PartialEq)]
pub struct Spread {
    /// The means.
    pub means: Vec<f64>,
    /// The standard deviations, over the number of values; in the units of the coordinates.
    pub deviations: Vec<f64>,
}

/// The least-squares predictor of `x_t`, linear in `x_{t−1}` and `y_t`.
#[derive(Debug, Clone, PartialEq)]
pub struct LinearPredictor {
    /// Its dependence on the standardised `x_{t−1}`, `N×N` in rows; empty at `t = 0`.
    pub by_previous: Vec<f64>,
    /// Its dependence on the standardised `y_t`, `N×M` in rows.
    pub by_measurement: Vec<f64>,
    /// The standard deviation of what it leaves of each coordinate of `x_t`.
    pub deviations: Vec<f64>,
}

/// A predictor is fitted to at least this many trajectories for each coefficient.
const TRAJECTORIES_PER_COEFFICIENT: usize = 10;

/// The least standard deviation of a coordinate, as a share of its largest value, that is more than rounding.
const LEAST_DEVIATION: f64 = 1e-9;

impl Simulations {
    /// Draws `trajectories` trajectories of `horizon` times, each by [`simulate_within`] from a child of `seed`.
    ///
    /// # Errors
    /// Those of [`simulate_within`], and [`ModelError::Parameter`] if `trajectories` is 0.
    pub fn draw(
        model: &(impl Simulator + ?Sized),
        horizon: usize,
        trajectories: usize,
        largest_state: f64,
        seed: &Seed,
    ) -> Result<Self, ModelError> {
        if trajectories == 0 {
            return Err(too_few(0, "at least 1"));
        }
        let draw = |at: usize| simulate_within(model, horizon, largest_state, &seed.nth(at as u64));
        let trajectories = (0..trajectories).map(|at| draw(at).map(|(trajectory, _)| trajectory));
        Ok(Simulations { trajectories: trajectories.collect::<Result<_, _>>()? })
    }

    /// `T`.
    pub fn horizon(&self) -> usize {
        self.trajectories[0].states.len()
    }

    /// Of states, over all trajectories and times.
    pub fn states(&self) -> Spread {
        Spread::of(self.trajectories.iter().flat_map(|trajectory| trajectory.states.rows()))
    }

    /// Of measurements, over all trajectories and times.
    pub fn measurements(&self) -> Spread {
        Spread::of(self.trajectories.iter().flat_map(|trajectory| trajectory.measurements.rows()))
    }

    /// Of states at one time, over all trajectories.
    ///
    /// # Panics
    /// If `time` is not below [`Simulations::horizon`].
    pub fn states_at(&self, time: usize) -> Spread {
        self.at(|trajectory| &trajectory.states, time)
    }

    /// Of measurements at one time, over all trajectories.
    ///
    /// # Panics
    /// If `time` is not below [`Simulations::horizon`].
    pub fn measurements_at(&self, time: usize) -> Spread {
        self.at(|trajectory| &trajectory.measurements, time)
    }

    fn at(&self, of: impl Fn(&Trajectory) -> &Sequence, time: usize) -> Spread {
        Spread::of(self.trajectories.iter().map(|trajectory| of(trajectory).row(time)))
    }

    /// The least-squares predictor of the state at `time`.
    ///
    /// # Errors
    /// [`ModelError::Parameter`] if there are fewer than ten trajectories for each coefficient, or if a coordinate hardly varies.
    ///
    /// # Panics
    /// If `time` is not below [`Simulations::horizon`].
    pub fn linear_predictor_at(&self, time: usize) -> Result<LinearPredictor, ModelError> {
        let (states, measurements) = (self.states_at(time), self.measurements_at(time));
        let previous = (time > 0).then(|| self.states_at(time - 1));
        for spread in [Some(&measurements), previous.as_ref()].into_iter().flatten() {
            spread.check()?;
        }
        let (n, m) = (states.means.len(), measurements.means.len());
        let of_previous = if time > 0 { n } else { 0 };
        let count = self.trajectories.len();
        if count < TRAJECTORIES_PER_COEFFICIENT * (of_previous + m) {
            return Err(too_few(count, "ten or more for each coordinate that predicts"));
        }
        // What predicts, in rows: the previous state if there is one, then the measurement.
        let mut known = Mat::<f64>::zeros(count, of_previous + m);
        let mut deviations = Mat::<f64>::zeros(count, n);
        for (row, trajectory) in self.trajectories.iter().enumerate() {
            let before =
                previous.iter().flat_map(|spread| spread.standardised(trajectory.states.row(time - 1)));
            let values = before.chain(measurements.standardised(trajectory.measurements.row(time)));
            values.enumerate().for_each(|(column, value)| known[(row, column)] = value);
            let state = trajectory.states.row(time);
            for (column, (value, mean)) in state.iter().zip(&states.means).enumerate() {
                deviations[(row, column)] = value - mean;
            }
        }
        let gram = known.transpose() * &known;
        let factor =
            gram.llt(Side::Lower).map_err(|_| too_few(count, "so different that they tell what predicts"))?;
        let coefficients = factor.solve(known.transpose() * &deviations);
        let left = deviations - &known * &coefficients;
        let deviation = |column: usize| {
            (left.col(column).iter().map(|value| value * value).sum::<f64>() / count as f64).sqrt()
        };
        let map = |from: usize, width: usize| -> Vec<f64> {
            let places = (0..n).flat_map(|i| (0..width).map(move |j| (i, j)));
            places.map(|(i, j)| coefficients[(from + j, i)]).collect()
        };
        let found = LinearPredictor {
            by_previous: map(0, of_previous),
            by_measurement: map(of_previous, m),
            deviations: (0..n).map(deviation).collect(),
        };
        Spread { means: states.means, deviations: found.deviations.clone() }.check()?;
        Ok(found)
    }
}

fn too_few(count: usize, expected: &'static str) -> ModelError {
    ModelError::Parameter { name: "the number of simulated trajectories", value: count.to_string(), expected }
}

impl Spread {
    /// Of rows of equal width, one or more.
    fn of<'a>(rows: impl Iterator<Item = &'a [f64]>) -> Spread {
        let rows: Vec<&[f64]> = rows.collect();
        let (count, width) = (rows.len() as f64, rows.first().map_or(0, |row| row.len()));
        let (mut means, mut squares) = (vec![0.0; width], vec![0.0; width]);
        for row in &rows {
            means.iter_mut().zip(*row).for_each(|(mean, value)| *mean += value / count);
        }
        for row in rows {
            for ((square, value), mean) in squares.iter_mut().zip(row).zip(&means) {
                *square += (value - mean).powi(2) / count;
            }
        }
        Spread { means, deviations: squares.into_iter().map(f64::sqrt).collect() }
    }

    /// Refuses coordinates whose deviation may be nothing but rounding.
    ///
    /// # Errors
    /// [`ModelError::Parameter`] with the deviation.
    pub fn check(&self) -> Result<(), ModelError> {
        let mut all = self.means.iter().zip(&self.deviations);
        match all.find(|(mean, deviation)| !(**deviation > LEAST_DEVIATION * mean.abs() && **deviation > 0.0))
        {
            None => Ok(()),
            Some((_, deviation)) => Err(ModelError::Parameter {
                name: "the standard deviation of a simulated coordinate",
                value: deviation.to_string(),
                expected: "larger than what rounding makes of a constant",
            }),
        }
    }

    /// `(value − mean) / deviation` of each number of rows (`K×N`).
    pub fn standardised(&self, rows: &[f64]) -> impl Iterator<Item = f64> {
        let scales = self.means.iter().zip(&self.deviations).cycle();
        rows.iter().zip(scales).map(|(value, (mean, deviation))| (value - mean) / deviation)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Gaussian, LinearGaussian};
    use faer::mat;

    fn draw(model: &LinearGaussian, count: usize) -> Simulations {
        Simulations::draw(model, 3, count, 1e9, &Seed::from_u64(9)).unwrap()
    }

    #[test]
    fn the_predictor_of_a_linear_system_is_the_conditional_mean() {
        // x' = 0.9 x + v, y = x' + w, all variances 1: given x and y, x' has mean 0.45 x + 0.5 y and variance ½.
        let initial = Gaussian::new("P_0", vec![2.0], mat![[1.0]]).unwrap();
        let model = LinearGaussian::new(initial, mat![[0.9]], mat![[1.0]], mat![[1.0]], mat![[1.0]]).unwrap();
        let simulations = draw(&model, 40_000);
        let found = simulations.linear_predictor_at(2).unwrap();
        let [previous, measurement] = [simulations.states_at(1), simulations.measurements_at(2)];
        // The standard error of a coefficient is that of the noise over √40000.
        assert!((found.by_previous[0] / previous.deviations[0] - 0.45).abs() < 0.02);
        assert!((found.by_measurement[0] / measurement.deviations[0] - 0.5).abs() < 0.02);
        assert!((found.deviations[0] - 0.5_f64.sqrt()).abs() < 0.02);
        assert!((simulations.states_at(1).means[0] - 1.8).abs() < 0.03);
        assert!(simulations.linear_predictor_at(0).unwrap().by_previous.is_empty());
    }

    #[test]
    fn over_all_times_is_over_all_rows() {
        let initial = Gaussian::new("P_0", vec![5.0], mat![[1.0]]).unwrap();
        let model =
            LinearGaussian::new(initial, mat![[1.0]], mat![[1e-4]], mat![[1.0]], mat![[1.0]]).unwrap();
        let simulations = draw(&model, 500);
        let mean = (0..3).map(|time| simulations.states_at(time).means[0] / 3.0).sum::<f64>();
        assert!((simulations.states().means[0] - mean).abs() < 1e-9);
        assert_eq!(simulations.horizon(), 3);
    }

    #[test]
    fn what_does_not_vary_and_what_is_too_few_is_refused() {
        let model = |variance: f64| {
            let initial = Gaussian::new("P_0", vec![997.3], mat![[variance]]).unwrap();
            LinearGaussian::new(initial, mat![[1.0]], mat![[1e-24]], mat![[1.0]], mat![[1.0]]).unwrap()
        };
        let error = draw(&model(1e-24), 100).linear_predictor_at(1).unwrap_err().to_string();
        assert!(error.contains("standard deviation"), "{error}");
        let error = draw(&model(1.0), 19).linear_predictor_at(1).unwrap_err().to_string();
        assert!(error.contains("ten or more"), "{error}");
        let error = Simulations::draw(&model(1.0), 3, 0, 1e9, &Seed::from_u64(1)).unwrap_err().to_string();
        assert!(error.contains("at least 1"), "{error}");
    }
}
