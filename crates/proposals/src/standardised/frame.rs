//! The units and origins in which a proposal's networks see and speak.

use motes_models::Spread;
use motes_models::batch::Rows;
use motes_smc::ProposalError;
use serde::{Deserialize, Serialize};

/// How a [`Spread`] is written: the models know no format.
#[derive(Serialize, Deserialize)]
#[serde(remote = "Spread", deny_unknown_fields)]
struct WrittenSpread {
    means: Vec<f64>,
    deviations: Vec<f64>,
}

/// `ξ_{t−1} = (x_{t−1} − m) / s` and `υ_t = (y_t − m_y) / s_y` go in; of what comes out, `ξ`, the state is
/// `x_t = o + P ξ_{t−1} + B υ_t + r ξ` (divisions and the product with `r` by coordinates).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Frame {
    /// `m` and `s`; not looked at at `t = 0`.
    #[serde(with = "WrittenSpread")]
    pub previous: Spread,
    /// `m_y` and `s_y`.
    #[serde(with = "WrittenSpread")]
    pub measurement: Spread,
    /// `o` and `r`.
    #[serde(with = "WrittenSpread")]
    pub output: Spread,
    /// `P`, `N×N` in rows, or empty for none.
    pub by_previous: Vec<f64>,
    /// `B`, `N×M` in rows, or empty for none.
    pub by_measurement: Vec<f64>,
}

/// A frame for each time, or one for all of them.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Frames {
    /// One for all times.
    Constant(Frame),
    /// Those of `t = 0, 1, …`.
    AtEachTime(Vec<Frame>),
}

impl Frames {
    /// How many times there are frames for; `None` if any number.
    pub fn horizon(&self) -> Option<usize> {
        match self {
            Frames::Constant(_) => None,
            Frames::AtEachTime(frames) => Some(frames.len()),
        }
    }

    /// The frame at `time`.
    ///
    /// # Errors
    /// [`ProposalError::PastHorizon`] if there is none.
    pub fn at(&self, time: usize) -> Result<&Frame, ProposalError> {
        match self {
            Frames::Constant(frame) => Ok(frame),
            Frames::AtEachTime(frames) => {
                frames.get(time).ok_or(ProposalError::PastHorizon { horizon: frames.len(), time })
            }
        }
    }

    /// Refuses frames that do not fit states and measurements of `N` and `M` coordinates at `horizon` times.
    ///
    /// # Errors
    /// [`ProposalError::Mismatch`] or [`ProposalError::Setting`] with what does not fit.
    pub(super) fn check(&self, n: usize, m: usize, horizon: usize) -> Result<(), ProposalError> {
        match self {
            Frames::Constant(frame) => frame.check(n, m),
            Frames::AtEachTime(frames) if frames.len() < horizon => Err(ProposalError::Setting {
                name: "the number of frames",
                value: frames.len().to_string(),
                expected: "one for each time",
            }),
            Frames::AtEachTime(frames) => frames.iter().try_for_each(|frame| frame.check(n, m)),
        }
    }
}

impl Frame {
    fn check(&self, n: usize, m: usize) -> Result<(), ProposalError> {
        let scales = [
            ("the coordinates of a frame's previous state", &self.previous, n),
            ("the coordinates of a frame's measurement", &self.measurement, m),
            ("the coordinates of a frame's output", &self.output, n),
        ];
        for (what, scale, expected) in scales {
            ProposalError::unless_same(what, scale.means.len(), expected)?;
            ProposalError::unless_same(what, scale.deviations.len(), expected)?;
            if let Some(deviation) = scale.deviations.iter().find(|d| !(**d > 0.0 && d.is_finite())) {
                return Err(ProposalError::Setting {
                    name: "a standard deviation of a frame",
                    value: deviation.to_string(),
                    expected: "positive and finite",
                });
            }
        }
        let matrices = [
            ("the entries of a frame's map of the previous state", &self.by_previous, n * n),
            ("the entries of a frame's map of the measurement", &self.by_measurement, n * m),
        ];
        for (what, matrix, expected) in matrices {
            if !matrix.is_empty() {
                ProposalError::unless_same(what, matrix.len(), expected)?;
            }
        }
        let mut others = scales
            .iter()
            .flat_map(|(_, scale, _)| &scale.means)
            .chain(&self.by_previous)
            .chain(&self.by_measurement);
        match others.find(|value| !value.is_finite()) {
            None => Ok(()),
            Some(value) => Err(ProposalError::Setting {
                name: "a number of a frame",
                value: value.to_string(),
                expected: "finite",
            }),
        }
    }

    /// `Σ log r`: what log densities of states are less by than those of outputs.
    pub(super) fn log_volume(&self) -> f64 {
        self.output.deviations.iter().map(|deviation| deviation.ln()).sum()
    }

    /// `υ_t`, and `o + B υ_t`.
    pub(super) fn of_measurement(&self, measurement: &[f64]) -> (Vec<f64>, Vec<f64>) {
        let measurement: Vec<f64> = self.measurement.standardised(measurement).collect();
        let mut origin = self.output.means.clone();
        add_product(&mut origin, &self.by_measurement, &measurement);
        (measurement, origin)
    }

    /// `ξ_{t−1}` of each particle into `inputs`, and `origin + P ξ_{t−1}` into `origins` (`R×N` each); `inputs` are empty at `t = 0`.
    pub(super) fn of_previous(
        &self,
        previous: Option<Rows<'_>>,
        particles: usize,
        origin: &[f64],
        (inputs, origins): (&mut Vec<f64>, &mut Vec<f64>),
    ) {
        inputs.clear();
        origins.clear();
        let n = origin.len();
        for row in 0..particles {
            origins.extend_from_slice(origin);
            if let Some(previous) = previous {
                inputs.extend(self.previous.standardised(previous.row(row)));
                add_product(&mut origins[row * n..], &self.by_previous, &inputs[row * n..]);
            }
        }
    }

    /// `x = origin + r ξ`, in place.
    pub(super) fn leave(&self, origins: &[f64], outputs: &mut [f64]) {
        let deviations = self.output.deviations.iter().cycle();
        for ((output, origin), deviation) in outputs.iter_mut().zip(origins).zip(deviations) {
            *output = origin + deviation * *output;
        }
    }

    /// Adds what flows back into `ξ_{t−1}` by way of the origins, and turns the whole into derivatives with respect to `x_{t−1}`.
    pub(super) fn pull_back(&self, d_states: &[f64], d_previous: &mut [f64]) {
        let n = self.output.means.len();
        for (d_state, d_previous) in d_states.chunks_exact(n).zip(d_previous.chunks_exact_mut(n)) {
            for (row, d_state) in self.by_previous.chunks_exact(n).zip(d_state) {
                d_previous.iter_mut().zip(row).for_each(|(d, entry)| *d += entry * d_state);
            }
            d_previous.iter_mut().zip(&self.previous.deviations).for_each(|(d, deviation)| *d /= deviation);
        }
    }
}

/// `into += matrix · vector`; nothing where there is no matrix.
fn add_product(into: &mut [f64], matrix: &[f64], vector: &[f64]) {
    for (into, row) in into.iter_mut().zip(matrix.chunks_exact(vector.len())) {
        *into += row.iter().zip(vector).map(|(entry, value)| entry * value).sum::<f64>();
    }
}
