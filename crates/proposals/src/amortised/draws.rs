//! Particles that a filter drew from an amortised proposal, with what its evidence says of them.

use motes_models::batch::{LANES, load, store};
use motes_models::{ModelError, OwnModel, OwnStep};

use super::inputs::Blocks;
use super::proposal::Amortised;
use super::units::{self, lanes};

/// Draws of one of the two networks.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct DrawnStage {
    /// How many inputs a row has, `F`.
    pub(super) width: usize,
    /// Inputs of the network, `R×F`.
    pub(super) inputs: Vec<f64>,
    /// The draw in units of the base, `u`, `R×N`.
    pub(super) units: Vec<f64>,
    /// `∂/∂u [log p(y_t | x_t) + log N(v; 0, I)]`, `R×N`: what the networks have no part in of the derivative of the log-weight.
    pub(super) slopes: Vec<f64>,
    /// What the derivative of a row counts, `R`.
    pub(super) shares: Vec<f64>,
}

impl DrawnStage {
    /// `R`.
    pub fn len(&self) -> usize {
        self.shares.len()
    }

    /// Whether there is no row.
    pub fn is_empty(&self) -> bool {
        self.shares.is_empty()
    }

    fn clear(&mut self) {
        for numbers in [&mut self.inputs, &mut self.units, &mut self.slopes, &mut self.shares] {
            numbers.clear();
        }
    }
}

/// What a filter drew, for each of the two networks of the proposal that it drew from.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Draws {
    /// At `t = 0`.
    pub initial: DrawnStage,
    /// At all later times.
    pub later: DrawnStage,
}

impl Draws {
    /// None any more; the memory is kept.
    pub fn clear(&mut self) {
        self.initial.clear();
        self.later.clear();
    }
}

impl Amortised {
    /// Adds particles of a filter's step to `draws`, all of which were drawn from this proposal for one whole measurement.
    ///
    /// `slopes` are `∂ log p(y_t | x_t) / ∂x_t` (`K×N`), `shares` what the derivative of each particle's log-weight counts (`K`): of `W̃_k`, the normalised weight
    /// after the step, its square. A particle that counts nothing, or whose numbers are not finite, is left out.
    ///
    /// # Errors
    /// [`ModelError`] if the proposal is not for such a model.
    pub fn add_draws(
        &self,
        model: &(impl OwnModel + ?Sized),
        step: &OwnStep<'_>,
        slopes: &[f64],
        shares: &[f64],
        draws: &mut Draws,
    ) -> Result<(), ModelError> {
        let (n, m) = (self.state_dim, self.measurement_dim);
        let width = Blocks::of(n, m)[usize::from(step.step.index > 0)].count();
        let Draws { initial, later } = draws;
        let stage = if step.step.index == 0 { initial } else { later };
        stage.width = width;
        let standards = self.standards(step.step.index);
        let mut memory = vec![0.0; 2 * n * LANES];
        let mut rows = vec![0.0; (width + 2 * n) * LANES];
        self.by_tiles(model, step, Some(&standards), |first, count, tile| {
            let (states, of_slopes) = memory.split_at_mut(n * LANES);
            load(&step.states[first * n..(first + count) * n], n, states);
            load(&slopes[first * n..(first + count) * n], n, of_slopes);
            tile.of_units.pull_to_units(&tile.place, lanes(states), tile.units, lanes(of_slopes));
            let (inputs, rest) = rows.split_at_mut(width * LANES);
            let (us, slopes) = rest.split_at_mut(n * LANES);
            store(units::flat(tile.inputs), width, &mut inputs[..count * width]);
            store(units::flat(tile.units), n, &mut us[..count * n]);
            store(of_slopes, n, &mut slopes[..count * n]);
            for lane in 0..count {
                let (share, slopes) = (shares[first + lane], &slopes[lane * n..][..n]);
                let is_finite = tile.is_inside(lane) && slopes.iter().all(|slope| slope.is_finite());
                if is_finite && share > 0.0 {
                    stage.inputs.extend_from_slice(&inputs[lane * width..][..width]);
                    stage.units.extend_from_slice(&us[lane * n..][..n]);
                    stage.slopes.extend_from_slice(slopes);
                    stage.shares.push(share);
                }
            }
        })
    }
}
