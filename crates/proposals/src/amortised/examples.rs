//! Steps that a model drew for itself, in the units and with the inputs of an amortised proposal.

use motes_models::batch::{LANES, store};
use motes_models::{ModelError, OwnModel, OwnStep};

use super::inputs::Standards;
use super::proposal::Amortised;
use super::units;
use motes_smc::ProposalError;

/// Rows of one of the two networks: what it sees, and what it should have said likely.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Stage {
    /// How many inputs a row has, `F`.
    pub(super) width: usize,
    /// Inputs of the network, `R×F`.
    pub(super) inputs: Vec<f64>,
    /// The state, or the noise that it is made of, in units of the base, `u`, `R×N` or `R×Q`.
    pub(super) units: Vec<f64>,
    /// The log-density of the transition with respect to `u`, `R`.
    pub(super) log_transition: Vec<f64>,
}

impl Stage {
    /// `R`.
    pub fn len(&self) -> usize {
        self.log_transition.len()
    }

    /// Whether there is no row.
    pub fn is_empty(&self) -> bool {
        self.log_transition.is_empty()
    }

    /// What the network sees of each row, `R×F`, in standard units.
    pub fn inputs(&self) -> &[f64] {
        &self.inputs
    }

    /// The state of each row, or the noise that it is made of, in units of the base, `R×N` or `R×Q`: what should be found likely.
    pub fn units(&self) -> &[f64] {
        &self.units
    }

    /// The log-density of the transition with respect to `u`, `R`.
    pub fn log_transition(&self) -> &[f64] {
        &self.log_transition
    }

    /// Replaces the rows by those of `from` that `picked` names.
    ///
    /// # Panics
    /// If there is no such row.
    pub fn pick(&mut self, from: &Stage, picked: &[usize]) {
        let (width, n) = (from.width, from.units.len() / from.len().max(1));
        self.width = width;
        self.inputs.clear();
        self.units.clear();
        self.log_transition.clear();
        for &row in picked {
            self.inputs.extend_from_slice(&from.inputs[row * width..][..width]);
            self.units.extend_from_slice(&from.units[row * n..][..n]);
            self.log_transition.push(from.log_transition[row]);
        }
    }
}

/// What an amortised proposal is learned from: steps of a model, for each of its two networks.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Examples {
    /// Of `t = 0`.
    pub initial: Stage,
    /// Of all later times.
    pub later: Stage,
    /// States that their own transition could not have drawn, but for rounding; they are left out.
    pub outside: usize,
}

impl Amortised {
    /// Adds the sequences' present step, in the units of this proposal.
    ///
    /// # Errors
    /// [`ModelError`] if the proposal is not for such a model.
    pub fn encode(
        &self,
        model: &(impl OwnModel + ?Sized),
        step: &OwnStep<'_>,
        examples: &mut Examples,
    ) -> Result<(), ModelError> {
        self.encode_by(model, step, Some(&self.standards(step.step.index)), examples)
    }

    fn encode_by(
        &self,
        model: &(impl OwnModel + ?Sized),
        step: &OwnStep<'_>,
        standards: Option<&Standards>,
        examples: &mut Examples,
    ) -> Result<(), ModelError> {
        let (n, m) = (self.state_dim, self.measurement_dim);
        let width = super::inputs::Blocks::of(n, m)[usize::from(step.step.index > 0)].count();
        let n = self.sizes(step.step.index).units;
        if n == 0 {
            // A start that is known.
            return Ok(());
        }
        let Examples { initial, later, outside } = examples;
        let stage = if step.step.index == 0 { initial } else { later };
        stage.width = width;
        let (mut rows_of_inputs, mut rows_of_units) = (vec![0.0; LANES * width], vec![0.0; LANES * n]);
        self.by_tiles(model, step, standards, |_, count, tile| {
            store(units::flat(tile.inputs), width, &mut rows_of_inputs[..count * width]);
            store(units::flat(tile.units), n, &mut rows_of_units[..count * n]);
            for lane in 0..count {
                let (u, log) = (&rows_of_units[lane * n..][..n], tile.log_transition.0[lane]);
                if !tile.is_inside(lane) {
                    *outside += 1;
                    continue;
                }
                stage.inputs.extend_from_slice(&rows_of_inputs[lane * width..][..width]);
                stage.units.extend_from_slice(u);
                stage.log_transition.push(log);
            }
        })
    }

    /// Brings the inputs of the networks to standard units: the median becomes 0, half the distance between the quantiles 0.16 and 0.84 becomes 1.
    ///
    /// `steps` are steps that the model drew, as many as it takes to know those quantiles.
    ///
    /// # Errors
    /// As [`Amortised::encode`].
    pub fn fit_inputs(
        &mut self,
        model: &(impl OwnModel + ?Sized),
        mut steps: impl FnMut(&mut dyn FnMut(&OwnStep<'_>) -> Result<(), ModelError>) -> Result<(), ModelError>,
    ) -> Result<(), ProposalError> {
        let mut examples = Examples::default();
        let drawn = steps(&mut |step| self.encode_by(model, step, None, &mut examples));
        drawn.map_err(|error| ProposalError::Frames { reason: error.to_string() })?;
        for (time, stage) in [&examples.initial, &examples.later].into_iter().enumerate() {
            if !stage.is_empty() {
                self.set_standards(time, &standards_of(stage))?;
            }
        }
        Ok(())
    }
}

/// The median of each input and 1 over its spread; 0 where it does not vary.
fn standards_of(stage: &Stage) -> Standards {
    let count = stage.len();
    let mut column = vec![0.0; count];
    let mut standards = Standards::none(stage.width);
    for input in 0..stage.width {
        let values = stage.inputs.iter().skip(input).step_by(stage.width);
        column.iter_mut().zip(values).for_each(|(place, value)| *place = *value);
        column.sort_by(f64::total_cmp);
        let quantile = |share: f64| column[((count - 1) as f64 * share).round() as usize];
        let median = quantile(0.5);
        let half_width = 0.5 * (quantile(0.84) - quantile(0.16));
        // Most values of a rare count are the same.
        let spread = match half_width > LEAST_SPREAD * median.abs() {
            true => half_width,
            false => (column.iter().map(|value| (value - median).powi(2)).sum::<f64>() / count as f64).sqrt(),
        };
        standards.means[input] = median;
        let varies = spread.is_finite() && spread > LEAST_SPREAD * median.abs();
        standards.scales[input] = if varies { 1.0 / spread } else { 0.0 };
    }
    standards
}

/// The least spread of an input, as a share of its size, that is more than rounding.
const LEAST_SPREAD: f64 = 1e-9;
