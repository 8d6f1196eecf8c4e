//! Fisher scoring for a block of particles: their means and the factors of their precisions.

use bytemuck::TransparentWrapper;
use motes_models::batch::LANES;
use motes_models::equations::{Lanes, Linearise};

use super::Linearised;
use super::conditional::LinearisedBatch;
use super::factor::{at, factor, solve_lower, solve_upper};
use crate::proposal::{Context, Proposal};
use crate::proposal_error::ProposalError;

/// What conditioning a block of particles computes in, tile after tile.
#[derive(Debug, Clone, Default)]
pub struct LinearisedScratch {
    /// `m + Λ⁻¹ g`, `N × LANES` of each tile.
    pub(super) means: Vec<f64>,
    /// The lower triangle of `L`, `Λ = L Lᵀ`, `N(N+1)/2 × LANES` of each tile.
    pub(super) factors: Vec<f64>,
    /// What one tile is computed in.
    pub(super) tile: Vec<f64>,
    /// `R×N`.
    pub(super) noise: Vec<f64>,
}

/// Memory of numbers lent as lanes.
pub(super) fn lanes(numbers: &mut [f64]) -> &mut [Lanes] {
    let (rows, _) = numbers.as_chunks_mut::<LANES>();
    Lanes::wrap_slice_mut(rows)
}

/// Whether the location of an entry of `measurement` depends on the state near `state`.
pub(super) fn depends_on_state(
    model: &(impl Linearise + ?Sized),
    time: usize,
    state: &[f64],
    measurement: &[f64],
) -> bool {
    let (n, m) = (state.len(), measurement.len());
    let measurement: Vec<Option<f64>> = measurement.iter().copied().map(Some).collect();
    let states: Vec<f64> = state.iter().flat_map(|value| [*value; LANES]).collect();
    let mut found = vec![0.0; (2 + n) * m * LANES];
    let (slopes, rest) = found.split_at_mut(m * LANES);
    let (information, jacobian) = rest.split_at_mut(m * LANES);
    model.tile_scores(time, &states, &measurement, slopes, information, jacobian);
    // NaN says that it depends on something.
    jacobian.iter().any(|entry| *entry != 0.0)
}

/// Leaves out, for each particle, an entry of the measurement that says nothing finite there.
#[inline(always)]
fn keep_finite(slope: &mut Lanes, information: &mut Lanes, jacobian: &mut [Lanes]) {
    let mut is_kept = [true; LANES];
    for (lane, kept) in is_kept.iter_mut().enumerate() {
        *kept = slope.0[lane].is_finite() && information.0[lane].is_finite() && information.0[lane] > 0.0;
    }
    for entry in &*jacobian {
        for (kept, entry) in is_kept.iter_mut().zip(entry.0) {
            *kept &= entry.is_finite();
        }
    }
    for values in jacobian.iter_mut().chain([slope, information]) {
        for (value, kept) in values.0.iter_mut().zip(is_kept) {
            *value = if kept { *value } else { 0.0 };
        }
    }
}

/// `m + Λ⁻¹ g` into `mean`, which holds `m`, and `L` into `lower`; `variances` become scratch.
#[inline(always)]
fn score(
    mean: &mut [Lanes],
    variances: &mut [Lanes],
    slopes: &mut [Lanes],
    information: &mut [Lanes],
    jacobian: &mut [Lanes],
    lower: &mut [Lanes],
) {
    let n = mean.len();
    lower.fill(Lanes::from(0.0));
    for (i, variance) in variances.iter().enumerate() {
        lower[at(i, i)] = Lanes::from(1.0) / *variance;
    }
    // From here on they hold g.
    variances.fill(Lanes::from(0.0));
    for ((slope, information), jacobian) in
        slopes.iter_mut().zip(information).zip(jacobian.chunks_exact_mut(n))
    {
        keep_finite(slope, information, jacobian);
        for (i, of_row) in jacobian.iter().enumerate() {
            // Most measurements depend on few coordinates.
            if of_row.0.iter().all(|entry| *entry == 0.0) {
                continue;
            }
            let weighted = *of_row * *information;
            variances[i] = variances[i] + *of_row * *slope;
            for (j, of_column) in jacobian[..=i].iter().enumerate() {
                lower[at(i, j)] = lower[at(i, j)] + weighted * *of_column;
            }
        }
    }
    factor(n, lower);
    solve_lower(n, lower, variances);
    solve_upper(n, lower, variances);
    for (mean, step) in mean.iter_mut().zip(&*variances) {
        *mean = *mean + *step;
    }
}

impl<M: Linearise + ?Sized> Proposal<M> for Linearised {
    type Memory = ();
    type Scratch = LinearisedScratch;
    type Conditional<'a>
        = LinearisedBatch<'a, M>
    where
        M: 'a;

    fn initial_memory(&self, _particles: usize) {}

    fn prepare(&mut self, model: &M, time: usize, measurement: &[f64]) -> Result<(), ProposalError> {
        ProposalError::unless_same(
            "the measurement dimension M",
            model.measurement_dim(),
            measurement.len(),
        )?;
        self.measurement.clear();
        self.measurement.extend(measurement.iter().copied().map(Some));
        self.prepared = Some(time);
        Ok(())
    }

    fn prepare_partial(
        &mut self,
        model: &M,
        time: usize,
        measurement: &[Option<f64>],
    ) -> Result<bool, ProposalError> {
        ProposalError::unless_same(
            "the measurement dimension M",
            model.measurement_dim(),
            measurement.len(),
        )?;
        self.measurement.clear();
        self.measurement.extend_from_slice(measurement);
        self.prepared = Some(time);
        Ok(measurement.iter().any(Option::is_some))
    }

    fn condition<'a>(
        &'a self,
        model: &'a M,
        context: Context<'a>,
        (): (),
        scratch: &'a mut LinearisedScratch,
    ) -> Result<LinearisedBatch<'a, M>, ProposalError> {
        let time = context.time;
        if self.prepared != Some(time) {
            return Err(ProposalError::NotPrepared { time });
        }
        let sees_measurements = self.sees_measurements;
        let (n, m) = (model.state_dim(), self.measurement.len());
        let (tiles, triangle) = (context.particles.div_ceil(LANES), n * (n + 1) / 2);
        if sees_measurements {
            let LinearisedScratch { means, factors, tile, .. } = &mut *scratch;
            means.resize(tiles * n * LANES, 0.0);
            factors.resize(tiles * triangle * LANES, 0.0);
            // Lanes without a particle are computed, too: with numbers that are no danger.
            tile.clear();
            tile.resize((2 * n + (2 + n) * m) * LANES, 0.0);
            let (previous, rest) = tile.split_at_mut(n * LANES);
            let (variances, rest) = rest.split_at_mut(n * LANES);
            let (slopes, rest) = rest.split_at_mut(m * LANES);
            let (information, jacobian) = rest.split_at_mut(m * LANES);
            let places = means.chunks_exact_mut(n * LANES).zip(factors.chunks_exact_mut(triangle * LANES));
            for (number, (mean, lower)) in places.enumerate() {
                let before = context.previous.map(|rows| {
                    rows.load(number * LANES, previous);
                    &*previous
                });
                model.tile_moments(time, before, mean, variances);
                model.tile_scores(time, mean, &self.measurement, slopes, information, jacobian);
                pulp::Arch::new().dispatch(
                    #[inline(always)]
                    || {
                        score(
                            lanes(mean),
                            lanes(variances),
                            lanes(slopes),
                            lanes(information),
                            lanes(jacobian),
                            lanes(lower),
                        );
                    },
                );
            }
        }
        Ok(LinearisedBatch { model, context, scratch, sees_measurements })
    }
}
