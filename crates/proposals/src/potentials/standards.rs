//! The units in which networks see measurements and states.

use motes_models::{ModelError, OwnModel, OwnSteps, Seed};

/// Sequences by which units are found.
const SEQUENCES: usize = 32;

/// Places and sizes of measurements and of states, over sequences of a model.
#[derive(Debug, Clone, PartialEq)]
pub struct PotentialStandards {
    /// The middle and the spread of each entry of a measurement, `2×M`.
    pub measurement: [Vec<f64>; 2],
    /// The middle and the spread of each coordinate of a state, `2×N`.
    pub state: [Vec<f64>; 2],
}

impl PotentialStandards {
    /// Those of 32 sequences of `horizon` steps that a model draws for itself, always by the same random numbers; a sequence that leaves the numbers counts until then.
    ///
    /// # Errors
    /// [`ModelError`] for a model that cannot be simulated.
    pub fn of_model<M: OwnModel + ?Sized>(model: &M, horizon: usize) -> Result<Self, ModelError> {
        let (mut measurements, mut states) = (Vec::new(), Vec::new());
        let seed = Seed::from_u64(0).child("potential standards");
        let mut steps = OwnSteps::new(model, SEQUENCES, &seed)?.in_window(horizon);
        for _ in 0..horizon {
            let Some(step) = steps.advance() else { break };
            measurements.extend_from_slice(step.measurements);
            states.extend_from_slice(step.states);
        }
        Ok(Self::of_rows(&measurements, model.measurement_dim(), &states, model.state_dim()))
    }

    /// Those of rows of measurements (`R×M`) and states (`R×N`): the median, and half of the distance between the quantiles 0.16 and 0.84. A number that does not vary has a spread
    /// of 1.
    pub fn of_rows(measurements: &[f64], m: usize, states: &[f64], n: usize) -> Self {
        let [measurement, state] = [(measurements, m), (states, n)].map(|(rows, width)| {
            let columns = (0..width).map(|at| rows.iter().skip(at).step_by(width).copied().collect());
            let (middles, spreads) = columns.map(middle_and_spread).unzip();
            [middles, spreads]
        });
        PotentialStandards { measurement, state }
    }
}

fn middle_and_spread(mut column: Vec<f64>) -> (f64, f64) {
    column.retain(|value| value.is_finite());
    let Some(last) = column.len().checked_sub(1) else { return (0.0, 1.0) };
    column.sort_by(f64::total_cmp);
    let quantile = |share: f64| column[(last as f64 * share).round() as usize];
    let median = quantile(0.5);
    let half_width = 0.5 * (quantile(0.84) - quantile(0.16));
    let spread = match half_width > 0.0 {
        true => half_width,
        // Most values of a rare count are the same.
        false => {
            (column.iter().map(|value| (value - median).powi(2)).sum::<f64>() / column.len() as f64).sqrt()
        }
    };
    (median, if spread > 0.0 && spread.is_finite() { spread } else { 1.0 })
}
