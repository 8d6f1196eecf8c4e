//! Frames from simulations of a system.

use motes_models::{ModelError, Simulations, Spread};
use motes_smc::ProposalError;
use serde::{Deserialize, Serialize};

use super::frame::{Frame, Frames};

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

impl Frames {
    /// Frames around the given origin: one for all times for [`Origin::Mean`], else one for each time of the simulations.
    ///
    /// # Errors
    /// [`ProposalError::Frames`] if a coordinate does not vary, or trajectories are too few to tell what predicts a state.
    pub fn of(simulations: &Simulations, origin: Origin) -> Result<Frames, ProposalError> {
        let refuse = |error: ModelError| ProposalError::Frames { reason: error.to_string() };
        if origin == Origin::Mean {
            let [states, measurements] = [simulations.states(), simulations.measurements()];
            return Frame::around_mean(&states, &measurements, &states).map(Frames::Constant).map_err(refuse);
        }
        let mut previous = simulations.states_at(0);
        let mut frames = Vec::with_capacity(simulations.horizon());
        for time in 0..simulations.horizon() {
            let states = simulations.states_at(time);
            let mut frame =
                Frame::around_mean(&previous, &simulations.measurements_at(time), &states).map_err(refuse)?;
            if origin == Origin::Prediction {
                let prediction = simulations.linear_predictor_at(time).map_err(refuse)?;
                frame.output.deviations = prediction.deviations;
                (frame.by_previous, frame.by_measurement) =
                    (prediction.by_previous, prediction.by_measurement);
            }
            frames.push(frame);
            previous = states;
        }
        Ok(Frames::AtEachTime(frames))
    }
}

impl Frame {
    fn around_mean(previous: &Spread, measurement: &Spread, output: &Spread) -> Result<Frame, ModelError> {
        [previous, measurement, output].into_iter().try_for_each(Spread::check)?;
        Ok(Frame {
            previous: previous.clone(),
            measurement: measurement.clone(),
            output: output.clone(),
            by_previous: Vec::new(),
            by_measurement: Vec::new(),
        })
    }
}
