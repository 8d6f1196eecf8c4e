//! An amortised proposal in a filter.

use motes_models::batch::{LANES, store};
use motes_models::equations::{Lanes, Linearise, Transport};
use motes_networks::Inputs;
use motes_smc::{Context, Proposal, ProposalError, noise_share};

use super::batch::AmortisedBatch;
use super::proposal::{Amortised, Prepared};
use super::scratch::AmortisedScratch;
use super::units::{self, Place, Units, lanes};
use crate::settings::of_networks;
use motes_models::Step;

impl<M: Linearise + Transport + ?Sized> Proposal<M> for Amortised {
    type Memory = ();
    type Scratch = AmortisedScratch;
    type Conditional<'a>
        = AmortisedBatch<'a, M>
    where
        M: 'a;

    fn initial_memory(&self, _particles: usize) {}

    fn is_for_step(&self, model: &M, step: &Step<'_>) -> bool {
        // There are more or fewer sub-steps where rows lie farther apart or nearer. A number of draws in each that differs from that which was learned for is that
        // of another model, which is refused.
        match (model.noise_without_density(), self.draws) {
            (Some(noise), Some([_, learned])) if step.index > 0 => {
                let (own, other) = (step.sub_steps.max(1), self.config.sub_steps);
                let is_of_model = noise.draws(step).len() * other == learned * own;
                own == other || !is_of_model
            }
            _ => true,
        }
    }

    fn prepare(
        &mut self,
        model: &M,
        step: &Step<'_>,
        measurement: &[Option<f64>],
    ) -> Result<bool, ProposalError> {
        ProposalError::unless_same("the state dimension N", self.state_dim, model.state_dim())?;
        ProposalError::unless_same("the measurement dimension M", self.measurement_dim, measurement.len())?;
        let time = step.index;
        let draws = model.noise_without_density().map(|model| model.draws(step));
        let counts = [draws.as_ref().map(Vec::len), self.draws.map(|_| self.sizes(time).units)];
        let [found, expected] = counts.map(|count| count.unwrap_or(self.state_dim));
        ProposalError::unless_same("the number of draws Q", expected, found)?;
        if draws.is_some() && time > 0 {
            let sub_steps = step.sub_steps.max(1);
            ProposalError::unless_same("the number of sub-steps", self.config.sub_steps, sub_steps)?;
        }
        let share = draws.map(|draws| noise_share(&draws));
        let (mut entries, kept) = match self.prepared.take() {
            Some(Prepared { time: before, measurement, is_affine, standards, theta, .. }) => {
                // None of these changes from step to step, but for t = 0.
                (measurement, (before > 0 && time > 0).then_some((is_affine, standards, theta)))
            }
            None => (Vec::new(), None),
        };
        let (is_affine, standards, theta) =
            kept.unwrap_or_else(|| (model.is_affine(), self.standards(time), self.theta(time)));
        entries.clear();
        entries.extend(measurement.iter().map(|entry| entry.map(Lanes::from)));
        let is_whole = entries.iter().all(Option::is_some);
        let is_there = entries.iter().any(Option::is_some);
        self.prepared =
            Some(Prepared { time, measurement: entries, is_whole, is_affine, share, standards, theta });
        Ok(is_there)
    }

    fn condition<'a>(
        &'a self,
        model: &'a M,
        context: Context<'a>,
        (): (),
        scratch: &'a mut AmortisedScratch,
    ) -> Result<AmortisedBatch<'a, M>, ProposalError> {
        let Context { step, previous, particles, .. } = context;
        let time = step.index;
        let prepared = self.prepared.as_ref().filter(|prepared| prepared.time == time);
        let Some(prepared) = prepared else { return Err(ProposalError::NotPrepared { time }) };
        let Prepared { measurement, is_whole, is_affine, standards, theta: of_all, .. } = prepared;
        let (sizes, m) = (self.sizes(time), measurement.len());
        let n = sizes.states;
        let noise = prepared.share.and_then(|share| Some((model.noise_without_density()?, share)));
        let (tiles, each, width) = (particles.div_ceil(LANES), sizes.rows() * LANES, standards.means.len());
        let AmortisedScratch { units, previous: kept, inputs, theta, tile, inference, .. } = &mut *scratch;
        units.resize(tiles * each, 0.0);
        inputs.resize(particles * width, 0.0);
        kept.clear();
        // Lanes without a particle are computed, too: with numbers that are no danger.
        kept.resize(tiles * n * LANES, 0.0);
        tile.clear();
        tile.resize((width + sizes.scratch_rows(m)) * LANES, 0.0);
        let (of_inputs, work) = tile.split_at_mut(width * LANES);
        if let Some(previous) = previous {
            model.foresee(&step, previous);
        }
        // Where nothing is drawn, there is nothing to condition: all particles follow from those before.
        let tiles = if sizes.units > 0 { tiles } else { 0 };
        let parts = units.chunks_exact_mut(each).zip(kept.chunks_exact_mut(n * LANES)).take(tiles);
        for (number, ((units, kept), inputs)) in parts.zip(inputs.chunks_mut(width * LANES)).enumerate() {
            let previous = previous.map(|rows| {
                rows.load(number * LANES, kept);
                &*kept
            });
            let place =
                Place { model, step, previous, is_affine: *is_affine, noise: noise.map(|(model, _)| model) };
            let of_inputs = lanes(of_inputs);
            Units::of(units, sizes).find(&place, self.config.base, measurement, of_inputs, work);
            standards.apply(of_inputs);
            store(units::flat(of_inputs), width, inputs);
        }
        let is_asked = *is_whole && sizes.units > 0;
        if is_asked {
            theta.resize(particles * of_all.emitted, 0.0);
            let inputs = Inputs { time, width, previous: Some(inputs), measurement: &[], particles };
            let found = inference.run(&self.networks, &self.parameters, &inputs, &mut [], &mut [theta]);
            found.map_err(of_networks)?;
        }
        Ok(AmortisedBatch {
            model,
            context,
            head: is_asked.then(|| self.head(time)),
            theta: of_all,
            is_affine: *is_affine,
            sizes,
            noise,
            scratch,
        })
    }
}
