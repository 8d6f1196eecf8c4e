//! A model's steps, tile by tile, in the units of a proposal.

use motes_models::batch::{LANES, Rows, load};
use motes_models::equations::{Lanes, NoiseSpace};
use motes_models::{ModelError, OwnModel, OwnStep, Step};

use super::inputs::{Blocks, Standards};
use super::proposal::Amortised;
use super::units::{Place, Units, lanes};

/// Some particles of a step.
pub(super) struct EncodedTile<'a, M: ?Sized> {
    pub(super) place: Place<'a, M>,
    pub(super) of_units: Units<'a>,
    /// What the network sees, `F`.
    pub(super) inputs: &'a [Lanes],
    /// `u`.
    pub(super) units: &'a [Lanes],
    /// `log |det ∂u/∂x|`, or `log |det ∂u/∂v|`.
    log_determinant: Lanes,
    /// The log-density of the transition, or of the noise, with respect to `u`.
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
        let &OwnStep { step: at, previous, states, noise, measurements } = step;
        let time = at.index;
        let sizes = self.sizes(time);
        let noise_space = model.noise_without_density();
        let noise = self.noise_of(noise_space, &at, noise)?;
        let width = Blocks::of(n, m)[usize::from(time > 0)].count();
        let rows = states.len() / n;
        let q = sizes.units;
        let mut memory = vec![0.0; (sizes.rows() + sizes.scratch_rows(m) + width + n + q + m) * LANES];
        let (of_units, rest) = memory.split_at_mut(sizes.rows() * LANES);
        let (scratch, rest) = rest.split_at_mut(sizes.scratch_rows(m) * LANES);
        let (inputs, rest) = rest.split_at_mut(width * LANES);
        let (before, rest) = rest.split_at_mut(n * LANES);
        let (values, measured) = rest.split_at_mut(q * LANES);
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
            load(&noise.unwrap_or(states)[first * q..last * q], q, values);
            load(&measurements[first * m..last * m], m, measured);
            entries.clear();
            entries.extend(lanes(measured).iter().copied().map(Some));
            let previous = previous.map(|_| &*before);
            let place = Place { model, step: at, previous, is_affine, noise: noise_space };
            let mut of_units = Units::of(of_units, sizes);
            let inputs = lanes(inputs);
            of_units.find(&place, self.config.base, &entries, inputs, scratch);
            if let Some(standards) = standards {
                standards.apply(inputs);
            }
            let units = lanes(values);
            let [log_determinant, log_transition] = match noise {
                None => of_units.to_units(&place, units),
                Some(_) => of_units.noise_to_units(units),
            };
            let tile = EncodedTile { place, of_units, inputs, units, log_determinant, log_transition };
            visit(first, last - first, &tile);
        }
        Ok(())
    }

    /// The noise that the states of a step are made of, where noise is what is proposed.
    ///
    /// # Errors
    /// [`ModelError`] if it is not known, or where there are more or fewer draws than the proposal was made for.
    fn noise_of<'n>(
        &self,
        model: Option<&dyn NoiseSpace>,
        step: &Step<'_>,
        noise: Option<&'n [f64]>,
    ) -> Result<Option<&'n [f64]>, ModelError> {
        let found = model.map(|model| model.draws(step).len());
        let expected = self.draws.map(|draws| draws[usize::from(step.index > 0)]);
        if found != expected {
            let said = |draws: Option<usize>| draws.map_or("no noise".into(), |draws| draws.to_string());
            return Err(ModelError::Parameter {
                name: "the number of draws of a step",
                value: format!("{} at step {}, {} for the proposal", said(found), step.index, said(expected)),
                expected: "the same at all steps but the first, and that of the model",
            });
        }
        match (expected, noise) {
            (Some(_), None) => Err(ModelError::Parameter {
                name: "what is learned from",
                value: "states of a filter".into(),
                expected: "simulations, for a model whose states have no density",
            }),
            (expected, noise) => Ok(expected.and(noise)),
        }
    }
}
