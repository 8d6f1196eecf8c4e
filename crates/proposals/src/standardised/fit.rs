//! Frames from simulations of a model.

use faer::linalg::solvers::Solve;
use faer::{Mat, Side};
use motes_models::{Seed, Sequence, Simulator, Trajectory, simulate_within};
use motes_smc::ProposalError;
use serde::{Deserialize, Serialize};

use super::frame::{Frame, Frames, Scale};

/// What networks speak relative to.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Origin {
    /// The mean of each coordinate over all trajectories and times, in units of its standard deviation over both.
    Mean,
    /// The mean of each coordinate over all trajectories, at each time, in units of its standard deviation at that time.
    MeanAtEachTime,
    /// The linear function of `x_{t−1}` and `y_t` that is nearest to `x_t` in squared error over all trajectories, at each time,
    /// in units of the standard deviation of what is left.
    Prediction,
}

/// How frames are found.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FrameSettings {
    /// What networks speak relative to.
    pub origin: Origin,
    /// How many trajectories of the model are simulated.
    pub trajectories: usize,
    /// The largest size of a state coordinate in a trajectory: one that goes beyond is drawn again.
    pub largest_state: f64,
}

impl Frames {
    /// Frames for `horizon` times, from trajectories that are simulated here, by `model` alone.
    ///
    /// # Errors
    /// [`ProposalError::Setting`] if there are no trajectories, or none that stay within the bound; if a coordinate does not vary; or if
    /// they are too few, or too much alike, to tell what predicts a state.
    pub fn simulated(
        model: &(impl Simulator + ?Sized),
        horizon: usize,
        settings: &FrameSettings,
        seed: &Seed,
    ) -> Result<Frames, ProposalError> {
        let FrameSettings { origin, trajectories, largest_state } = *settings;
        let simulated: Vec<Trajectory> = (0..trajectories)
            .map(|at| simulate_within(model, horizon, largest_state, &seed.nth(at as u64)))
            .map(|drawn| drawn.map(|(trajectory, _)| trajectory))
            .collect::<Result<_, _>>()
            .map_err(|error| setting("a simulation for the frames", error.to_string(), "possible"))?;
        if simulated.is_empty() {
            return Err(setting("the number of trajectories for the frames", "0".into(), "at least 1"));
        }
        let frames = match origin {
            Origin::Mean => {
                let states = simulated.iter().flat_map(|trajectory| trajectory.states.rows());
                let measurements = simulated.iter().flat_map(|trajectory| trajectory.measurements.rows());
                let states = Scale::of(states);
                Frames::constant(Frame::around_mean(states.clone(), Scale::of(measurements), states))
            }
            Origin::MeanAtEachTime | Origin::Prediction => {
                let at = |of: fn(&Trajectory) -> &Sequence, time: usize| {
                    Scale::of(simulated.iter().map(move |trajectory| of(trajectory).row(time)))
                };
                let mut previous = at(|trajectory| &trajectory.states, 0);
                let mut frames = Vec::with_capacity(horizon);
                for time in 0..horizon {
                    let states = at(|trajectory| &trajectory.states, time);
                    let measurements = at(|trajectory| &trajectory.measurements, time);
                    let mut frame = Frame::around_mean(previous, measurements, states.clone());
                    if origin == Origin::Prediction {
                        frame = frame.around_prediction(&simulated, time)?;
                    }
                    frames.push(frame);
                    previous = states;
                }
                Frames::unrolled(frames)
            }
        };
        let (n, m) = (model.state_dim(), model.measurement_dim());
        frames.check(n, m, horizon)?;
        Ok(frames)
    }
}

fn setting(name: &'static str, value: String, expected: &'static str) -> ProposalError {
    ProposalError::Setting { name, value, expected }
}

impl Scale {
    /// Of rows of equal width, one or more.
    fn of<'a>(rows: impl Iterator<Item = &'a [f64]>) -> Scale {
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
        Scale { means, deviations: squares.into_iter().map(f64::sqrt).collect() }
    }
}

impl Frame {
    fn around_mean(previous: Scale, measurement: Scale, output: Scale) -> Frame {
        Frame { previous, measurement, output, by_previous: Vec::new(), by_measurement: Vec::new() }
    }

    /// The same inputs, and outputs around the linear prediction of the state at `time`.
    fn around_prediction(self, simulated: &[Trajectory], time: usize) -> Result<Frame, ProposalError> {
        let (n, m) = (self.output.means.len(), self.measurement.means.len());
        let of_previous = if time > 0 { n } else { 0 };
        // What predicts, in rows: the previous state if there is one, then the measurement.
        let count = simulated.len();
        let mut known = Mat::<f64>::zeros(count, of_previous + m);
        let mut deviations = Mat::<f64>::zeros(count, n);
        for (row, Trajectory { states, measurements }) in simulated.iter().enumerate() {
            let previous = (time > 0).then(|| states.row(time - 1));
            let previous = previous.into_iter().flat_map(|state| self.previous.standardised(state));
            let values = previous.chain(self.measurement.standardised(measurements.row(time)));
            values.enumerate().for_each(|(column, value)| known[(row, column)] = value);
            for (column, (value, mean)) in states.row(time).iter().zip(&self.output.means).enumerate() {
                deviations[(row, column)] = value - mean;
            }
        }
        let gram = known.transpose() * &known;
        let factor = gram.llt(Side::Lower).map_err(|_| {
            setting(
                "the number of trajectories for the frames",
                count.to_string(),
                "enough to predict a state by",
            )
        })?;
        let coefficients = factor.solve(known.transpose() * &deviations);
        let left = deviations - &known * &coefficients;
        let deviation = |column: usize| {
            (left.col(column).iter().map(|value| value * value).sum::<f64>() / count as f64).sqrt()
        };
        let map = |from: usize, width: usize| -> Vec<f64> {
            (0..n)
                .flat_map(|i| (0..width).map(move |j| (i, j)))
                .map(|(i, j)| coefficients[(from + j, i)])
                .collect()
        };
        Ok(Frame {
            output: Scale { means: self.output.means.clone(), deviations: (0..n).map(deviation).collect() },
            by_previous: map(0, of_previous),
            by_measurement: map(of_previous, m),
            ..self
        })
    }
}
