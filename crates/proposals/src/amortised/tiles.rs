//! A model's steps, tile by tile, in the units of a proposal.

use motes_models::batch::{LANES, Rows, load};
use motes_models::equations::Lanes;
use motes_models::{ModelError, OwnModel, OwnStep};

use super::inputs::{Blocks, Standards};
use super::proposal::Amortised;
use super::units::{self, Place, Units, lanes};

/// Some particles of a step.
pub(super) struct EncodedTile<'a, M: ?Sized> {
    pub(super) place: Place<'a, M>,
    pub(super) of_units: Units<'a>,
    /// What the network sees, `F`.
    pub(super) inputs: &'a [Lanes],
    /// `u`, `N`.
    pub(super) units: &'a [Lanes],
    /// `log |det ∂u/∂x|`.
    log_determinant: Lanes,
    /// The log-density of the transition with respect to `u`.
    pub(super) log_transition: Lanes,
}

impl<M: ?Sized> EncodedTile<'_, M> {
    /// Whether the transition could have drawn the state of a particle, but for rounding.
    pub(super) fn is_inside(&self, lane: usize) -> bool {
        self.log_determinant.0[lane].is_finite()
            && self.log_transition.0[lane].is_finite()
            && self.units.iter().all(|u| u.0[lane].is_finite())
    }
}

impl Amortised {
    /// Shows each tile of `step` to `visit`, with the number of its first particle and how many there are; inputs are brought to standard units if they are given.
    ///
    /// # Errors
    /// [`ModelError`] if the proposal is not for such a model.
    pub(super) fn by_tiles<M: OwnModel + ?Sized>(
        &self,
        model: &M,
        step: &OwnStep<'_>,
        standards: Option<&Standards>,
        mut visit: impl FnMut(usize, usize, &EncodedTile<'_, M>),
    ) -> Result<(), ModelError> {
        let (n, m) = (self.state_dim, self.measurement_dim);
        for (name, found, expected) in [
            ("the proposal's state dimension N", n, model.state_dim()),
            ("the proposal's measurement dimension M", m, model.measurement_dim()),
        ] {
            if found != expected {
                let value = found.to_string();
                return Err(ModelError::Parameter { name, value, expected: "that of the model" });
            }
        }
        let &OwnStep { time, previous, states, measurements } = step;
        let at = model.step_of_index(time);
        let width = Blocks::of(n, m)[usize::from(time > 0)].count();
        let rows = states.len() / n;
        let mut memory = vec![0.0; (units::rows(n) + units::scratch_rows(n, m) + width + 2 * n + m) * LANES];
        let (of_units, rest) = memory.split_at_mut(units::rows(n) * LANES);
        let (scratch, rest) = rest.split_at_mut(units::scratch_rows(n, m) * LANES);
        let (inputs, rest) = rest.split_at_mut(width * LANES);
        let (before, rest) = rest.split_at_mut(n * LANES);
        let (values, measured) = rest.split_at_mut(n * LANES);
        let mut entries: Vec<Option<Lanes>> = Vec::with_capacity(m);
        let is_affine = model.is_affine();
        if let Some(previous) = previous {
            model.foresee(&at, Rows::all(previous, n));
        }
        for first in (0..rows).step_by(LANES) {
            let last = (first + LANES).min(rows);
            if let Some(previous) = previous {
                load(&previous[first * n..last * n], n, before);
            }
            load(&states[first * n..last * n], n, values);
            load(&measurements[first * m..last * m], m, measured);
            entries.clear();
            entries.extend(lanes(measured).iter().copied().map(Some));
            let place = Place { model, step: at, previous: previous.map(|_| &*before), is_affine };
            let mut of_units = Units::of(of_units, n);
            let inputs = lanes(inputs);
            of_units.find(&place, self.config.base, &entries, inputs, scratch);
            if let Some(standards) = standards {
                standards.apply(inputs);
            }
            let units = lanes(values);
            let [log_determinant, log_transition] = of_units.to_units(&place, units);
            let tile = EncodedTile { place, of_units, inputs, units, log_determinant, log_transition };
            visit(first, last - first, &tile);
        }
        Ok(())
    }
}
