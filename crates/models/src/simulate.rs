//! Drawing a trajectory of states and measurements from a model.

use crate::{Measurements, ModelError, Sequence, Simulator, Stream};

/// A simulated run of a system: the hidden truth and what was measured of it.
///
/// Only what judges an estimate may look at `states`; nothing that learns takes a `Trajectory`.
#[derive(Debug, Clone, PartialEq)]
pub struct Trajectory {
    /// `x_0 … x_{T−1}`, rows of `N`.
    pub states: Sequence,
    /// `y_0 … y_{T−1}`, rows of `M`.
    pub measurements: Measurements,
}

/// Draws `horizon` states and their measurements, in order of time, so that a longer trajectory from the
/// same stream begins with the shorter one.
///
/// # Errors
/// [`ModelError::Parameter`] if `horizon` is 0; [`ModelError::Numerical`] with the time if the system overflowed.
pub fn simulate(
    model: &(impl Simulator + ?Sized),
    horizon: usize,
    stream: &mut Stream,
) -> Result<Trajectory, ModelError> {
    if horizon == 0 {
        return Err(ModelError::Parameter { name: "horizon T", value: "0".into(), expected: "at least 1" });
    }
    let (n, m) = (model.state_dim(), model.measurement_dim());
    let (mut states, mut measurements) = (vec![0.0; horizon * n], vec![0.0; horizon * m]);
    for time in 0..horizon {
        let (past, rest) = states.split_at_mut(time * n);
        let state = &mut rest[..n];
        match time {
            0 => model.sample_initial(stream, state),
            _ => model.sample_transition(time, &past[(time - 1) * n..], stream, state),
        }
        let measurement = &mut measurements[time * m..(time + 1) * m];
        model.sample_measurement(time, state, stream, measurement);
        if !state.iter().chain(measurement.iter()).all(|value| value.is_finite()) {
            let reason = format!("state {state:?}, measurement {measurement:?}");
            return Err(ModelError::Numerical { computation: "simulating the system", time, reason });
        }
    }
    Ok(Trajectory { states: Sequence::new(n, states)?, measurements: Measurements::new(m, measurements)? })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{GraphDiffusion, GraphDiffusionConfig, Seed};

    #[test]
    fn a_longer_trajectory_begins_with_the_shorter_one() {
        let seed = Seed::from_u64(2);
        let config = GraphDiffusionConfig::new(6);
        let system = GraphDiffusion::random(&config, &mut seed.child("graph").stream()).unwrap();
        let draw = |horizon| simulate(&system, horizon, &mut seed.child("data").stream()).unwrap();
        let (short, long) = (draw(5), draw(9));
        assert_eq!(short.states.values(), &long.states.values()[..5 * 6]);
        assert_eq!(short.measurements.values(), &long.measurements.values()[..5 * 4]);
        assert!(simulate(&system, 0, &mut seed.stream()).is_err());
    }
}
