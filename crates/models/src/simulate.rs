//! Drawing a trajectory of states and measurements from a model.

use std::ops::ControlFlow;
use std::slice::from_mut;

use crate::batch::{Rows, there_is_memory_for};
use crate::{Measurements, ModelError, Seed, Sequence, Simulator, Stream, check_model};

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
/// [`ModelError::Parameter`] if `horizon`, `N` or `M` is 0, or there is no memory for the trajectory; [`ModelError::Numerical`] with the time if the system overflowed.
pub fn simulate(
    model: &(impl Simulator + ?Sized),
    horizon: usize,
    stream: &mut Stream,
) -> Result<Trajectory, ModelError> {
    let whole = simulate_while(model, horizon, stream, || ControlFlow::Continue(()))?;
    Ok(whole.expect("nobody said to stop"))
}

/// Times between two of which it is asked whether to go on.
const ASKS_EVERY: usize = 1024;

/// [`simulate`] as long as `proceed`, which is asked now and then, says to go on; none where it said to stop.
///
/// # Errors
/// As [`simulate`].
pub fn simulate_while(
    model: &(impl Simulator + ?Sized),
    horizon: usize,
    stream: &mut Stream,
    mut proceed: impl FnMut() -> ControlFlow<()>,
) -> Result<Option<Trajectory>, ModelError> {
    if horizon == 0 {
        return Err(ModelError::Parameter { name: "horizon T", value: "0".into(), expected: "at least 1" });
    }
    check_model(model)?;
    let (n, m) = (model.state_dim(), model.measurement_dim());
    if !n.checked_add(m).and_then(|width| width.checked_mul(horizon)).is_some_and(there_is_memory_for) {
        let (value, expected) = (horizon.to_string(), "as many times as there is memory for");
        return Err(ModelError::Parameter { name: "horizon T", value, expected });
    }
    let (mut states, mut measurements) = (vec![0.0; horizon * n], vec![0.0; horizon * m]);
    for time in 0..horizon {
        if time % ASKS_EVERY == ASKS_EVERY - 1 && proceed().is_break() {
            return Ok(None);
        }
        let step = model.step_of_index(time);
        let (past, rest) = states.split_at_mut(time * n);
        let (state, streams) = (&mut rest[..n], from_mut(&mut *stream));
        let previous = (time > 0).then(|| Rows::all(&past[(time - 1) * n..], n));
        model.sample_states(&step, previous, streams, state);
        let measurement = &mut measurements[time * m..(time + 1) * m];
        model.sample_measurements(&step, state, streams, measurement);
        if !state.iter().chain(measurement.iter()).all(|value| value.is_finite()) {
            let reason = format!("state {state:?}, measurement {measurement:?}");
            return Err(ModelError::Numerical { computation: "simulating the system", time, reason });
        }
    }
    let (states, measurements) = (Sequence::new(n, states)?, Measurements::new(m, measurements)?);
    Ok(Some(Trajectory { states, measurements }))
}

/// How many trajectories [`simulate_within`] draws before it gives up.
const MOST_DRAWS: usize = 10_000;

/// Draws trajectories until all state coordinates of one are at most `largest` in size, and says how many were rejected before it.
///
/// Each trajectory has a stream of its own. This is for systems that diverge now and then.
///
/// # Errors
/// As [`simulate`] for a `horizon` of 0; [`ModelError::Parameter`] if `largest` is so small that none of 10,000 stays within it.
pub fn simulate_within(
    model: &(impl Simulator + ?Sized),
    horizon: usize,
    largest: f64,
    seed: &Seed,
) -> Result<(Trajectory, usize), ModelError> {
    for rejected in 0..MOST_DRAWS {
        match simulate(model, horizon, &mut seed.nth(rejected as u64).stream()) {
            Ok(trajectory) if trajectory.states.values().iter().all(|value| value.abs() <= largest) => {
                return Ok((trajectory, rejected));
            }
            // It overflowed, which is beyond any bound.
            Ok(_) | Err(ModelError::Numerical { .. }) => {}
            Err(error) => return Err(error),
        }
    }
    Err(ModelError::Parameter {
        name: "the largest state of a trajectory",
        value: largest.to_string(),
        expected: "large enough for one of 10,000 trajectories",
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Epidemic, EpidemicConfig, GraphDiffusion, GraphDiffusionConfig, Seed};

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
        // More than there is memory for is refused, and does not end the process.
        for horizon in [usize::MAX, usize::MAX / 160, 1 << 50] {
            let refused = simulate(&system, horizon, &mut seed.stream());
            assert!(matches!(refused, Err(ModelError::Parameter { .. })), "{horizon}");
        }
    }

    #[test]
    fn trajectories_that_diverge_are_drawn_again() {
        let epidemic = Epidemic::new(&EpidemicConfig::paper()).unwrap();
        let rejections: Vec<usize> = (0..20)
            .map(|at| {
                let (kept, rejected) =
                    simulate_within(&epidemic, 200, 2000.0, &Seed::from_u64(3).nth(at)).unwrap();
                assert!(kept.states.values().iter().all(|value| value.abs() <= 2000.0));
                rejected
            })
            .collect();
        assert!(rejections.iter().any(|count| *count > 0) && rejections.contains(&0), "{rejections:?}");
        assert!(simulate_within(&epidemic, 5, 1.0, &Seed::from_u64(3)).is_err());
    }
}
