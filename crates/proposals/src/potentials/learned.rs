//! The potentials of a whole sequence by networks: their weights, and how they are made.

use motes_models::{ModelShape, OwnModel, Seed, Step};
use motes_networks::{Compute, Inference, Parameters, Workspace};
use motes_smc::{LookAhead, LookAheadError, PotentialComponent, ProposalError, RecordedStep};

use super::config::LearnedPotentialsConfig;
use super::decoded::Layout;
use super::features::{StepFeatures, count};
use super::networks::PotentialNetworks;
use super::paths::PathBatch;
use super::standards::PotentialStandards;
use super::step_memory::StepMemory;
use super::tape::{Sizes, differentiate, gain, outputs, read};
use crate::family::{Family, Parametric};
use crate::settings::{check_compute, check_shape, check_weights, check_widths, of_networks};

/// Potentials `ψ_t(x) = Σ_j w_j ψ_j(x) + w_0` of the steps of any sequence of a model, learned once: `J` Gaussian functions of the state and a constant, which networks emit once for each
/// step, whatever the number of particles.
///
/// - **Ahead**, of a recorded sequence ([`LearnedPotentials::look_ahead`]): a recurrent layer runs from the first step on and one from the last step back, over the measurements, which of
///   them are missing, and what the model makes of a few states at each step: where it moves them and how likely the measurement is there, so that times, inputs and parameters are seen.
///   A network reads both.
/// - **Now**, of a step when its measurement is there ([`OnLinePotentials`](super::OnLinePotentials)): a network sees the same of this step alone.
///
/// The evidence is unbiased whatever the weights are. They are learned from simulated sequences alone: the mean of `log ψ_t(x_t) − log Z_t(x_{t−1})` is the log-density of the proposal
/// against that of the transition.
#[derive(Clone)]
pub struct LearnedPotentials {
    config: LearnedPotentialsConfig,
    state_dim: usize,
    measurement_dim: usize,
    networks: PotentialNetworks,
    parameters: Parameters,
}

/// The matrices that are no weights, after all others: middles and spreads of measurements and states.
const STANDARDS: usize = 4;

impl LearnedPotentials {
    fn layout(&self) -> Layout {
        Layout { n: self.state_dim, components: self.config.components }
    }

    fn sizes(&self, steps: usize, sequences: usize) -> Sizes {
        let features = count(self.state_dim, self.measurement_dim);
        Sizes { steps, sequences, features, hidden: self.config.hidden }
    }

    /// The units of measurements and states of a model.
    ///
    /// # Errors
    /// [`ProposalError::Frames`] if they are found by simulation, which the model does not allow.
    pub fn standards<M: OwnModel + ?Sized>(&self, model: &M) -> Result<PotentialStandards, ProposalError> {
        if let Some(horizon) = self.config.standardising_steps {
            return PotentialStandards::of_model(model, horizon)
                .map_err(|error| ProposalError::Frames { reason: error.to_string() });
        }
        let first = self.parameters.len() - STANDARDS;
        let [a, b, c, d] = [0, 1, 2, 3].map(|at| self.parameters.host(first + at));
        Ok(PotentialStandards { measurement: [a, b], state: [c, d] })
    }

    /// From now on units are found anew for each model, by simulated sequences of `horizon` steps.
    pub fn standardise_each_model(&mut self, horizon: usize) {
        self.config.standardising_steps = Some(horizon);
    }

    /// Sets the units of measurements and states, those of one model from now on.
    ///
    /// # Errors
    /// [`ProposalError::Mismatch`] if they are not those of so many coordinates.
    pub fn set_standards(&mut self, standards: &PotentialStandards) -> Result<(), ProposalError> {
        let first = self.parameters.len() - STANDARDS;
        self.config.standardising_steps = None;
        let PotentialStandards { measurement, state } = standards;
        for (at, values) in measurement.iter().chain(state).enumerate() {
            self.parameters.set_host(first + at, values).map_err(of_networks)?;
        }
        Ok(())
    }

    /// The proposal of a recorded sequence, which the networks see once.
    ///
    /// # Errors
    /// [`LookAheadError`] if the model does not say how its states are made of noise, there is no step, or the networks fail.
    pub fn look_ahead<M: OwnModel + ?Sized>(
        &self,
        model: &M,
        recorded: &[RecordedStep],
    ) -> Result<LookAhead, LookAheadError> {
        self.look_ahead_in(&self.standards(model).map_err(failed)?, model, recorded)
    }

    /// [`LearnedPotentials::look_ahead`] where the units of the model are known, as for many sequences.
    ///
    /// # Errors
    /// As there.
    pub fn look_ahead_in<M: OwnModel + ?Sized>(
        &self,
        standards: &PotentialStandards,
        model: &M,
        recorded: &[RecordedStep],
    ) -> Result<LookAhead, LookAheadError> {
        let noise_space = model.noise_space().ok_or(LookAheadError::NoNoise)?;
        let layout = self.layout();
        let (mut features, mut of_step) = (Vec::new(), StepFeatures::default());
        let mut asked = None;
        for RecordedStep { step, measurement } in recorded {
            let step = step.step();
            if !asked.is_some_and(|asked| noise_space.are_alike(&asked, &step)) {
                of_step.ask(noise_space, &step, &standards.state);
            }
            asked = Some(step);
            of_step
                .append(model, &step, measurement, &standards.measurement, &mut features)
                .map_err(failed)?;
        }
        let sizes = self.sizes(recorded.len(), 1);
        let outputs = outputs(&self.networks, &self.parameters, sizes, layout, &features)
            .map_err(|error| LookAheadError::Networks { reason: error.to_string() })?;
        // Nothing is to be known of states after the last measurement.
        let is_measured = |row: &RecordedStep| row.measurement.iter().any(Option::is_some);
        let measured = recorded.iter().rposition(is_measured).map_or(0, |last| last + 1);
        let potentials: Vec<_> = outputs
            .chunks_exact(layout.outputs())
            .enumerate()
            .map(|(index, row)| match index < measured {
                true => layout.components(row, &standards.state),
                false => vec![Layout::flat(&standards.state[0])],
            })
            .collect();
        LookAhead::from_potentials(model, recorded, &potentials)
    }

    /// The quadratics of a step by its own measurement; `memory` is worked in.
    pub(super) fn components_now<M: OwnModel + ?Sized>(
        &self,
        model: &M,
        step: &Step<'_>,
        measurement: &[Option<f64>],
        standards: &PotentialStandards,
        memory: &mut StepMemory,
    ) -> Result<Vec<PotentialComponent>, ProposalError> {
        if measurement.iter().all(Option::is_none) {
            return Ok(vec![Layout::flat(&standards.state[0])]);
        }
        let StepMemory { of_step, features, inference } = memory;
        features.clear();
        let noise_space = model.noise_space().ok_or(ProposalError::NoNoise)?;
        of_step.ask(noise_space, step, &standards.state);
        of_step.append(model, step, measurement, &standards.measurement, features)?;
        let (sizes, layout) = (self.sizes(1, 1), self.layout());
        let mut outputs = vec![0.0; layout.outputs()];
        read(&self.networks.now, &self.parameters, sizes.of_features(features), inference, &mut outputs)
            .map_err(of_networks)?;
        Ok(layout.components(&outputs, &standards.state))
    }

    /// The means of `log ψ_t(x_t) − log Z_t(x_{t−1})` over a batch, ahead and now, in nats: by how much their proposals find what was drawn more likely than the transition does.
    ///
    /// # Errors
    /// [`ProposalError`] if the networks fail.
    pub fn gains(&self, batch: &PathBatch) -> Result<[f64; 2], ProposalError> {
        let (sizes, layout) = (self.sizes(batch.steps, batch.sequences), self.layout());
        let ahead = outputs(&self.networks, &self.parameters, sizes, layout, &batch.features);
        let ahead = ahead.map_err(of_networks)?;
        let mut now = ahead.clone();
        let inputs = sizes.of_features(&batch.features);
        read(&self.networks.now, &self.parameters, inputs, &mut Inference::default(), &mut now)
            .map_err(of_networks)?;
        Ok([ahead, now].map(|outputs| gain(batch, layout, &outputs, &mut vec![0.0; outputs.len()])))
    }

    /// The gains, and the derivatives of their sum along the weights, turned round: in four parts of the networks, each in memory of its own.
    ///
    /// # Errors
    /// As [`LearnedPotentials::gains`].
    pub fn differentiate_gains(
        &self,
        batch: &PathBatch,
        memory: [Workspace; 4],
    ) -> Result<([f64; 2], [Workspace; 4]), ProposalError> {
        let sizes = self.sizes(batch.steps, batch.sequences);
        differentiate(&self.networks, &self.parameters, batch, self.layout(), sizes, memory)
            .map_err(of_networks)
    }
}

fn failed(error: ProposalError) -> LookAheadError {
    LookAheadError::Networks { reason: error.to_string() }
}

impl Parametric for LearnedPotentials {
    fn parameters(&self) -> &Parameters {
        &self.parameters
    }

    fn parameters_mut(&mut self) -> &mut Parameters {
        &mut self.parameters
    }

    fn horizon(&self) -> Option<usize> {
        None
    }

    fn state_dim(&self) -> usize {
        self.state_dim
    }

    fn measurement_dim(&self) -> usize {
        self.measurement_dim
    }
}

impl Family for LearnedPotentials {
    const NAME: &'static str = "potentials";
    const FILES: [&'static str; 2] = ["potentials.toml", "potentials.safetensors"];
    type Config = LearnedPotentialsConfig;

    /// It has no use for `horizon`.
    fn create(
        config: &LearnedPotentialsConfig,
        shape: &ModelShape,
        _horizon: usize,
        compute: Compute,
        seed: &Seed,
    ) -> Result<Self, ProposalError> {
        check_compute(compute)?;
        check_shape(shape)?;
        check_widths("the hidden width and the number of quadratics", &[config.hidden, config.components])?;
        check_weights(Self::count(config, shape, 0))?;
        let &ModelShape { state_dim: n, measurement_dim: m, .. } = shape;
        let mut parameters = Parameters::new(compute);
        let layout = Layout { n, components: config.components };
        let networks = PotentialNetworks::draw(&mut parameters, count(n, m), config.hidden, layout, seed)
            .map_err(of_networks)?;
        for (name, width) in [("measurement", m), ("state", n)] {
            parameters.add(format!("{name}.middles"), [1, width], &vec![0.0; width]);
            parameters.add(format!("{name}.spreads"), [1, width], &vec![1.0; width]);
        }
        Ok(LearnedPotentials {
            config: config.clone(),
            state_dim: n,
            measurement_dim: m,
            networks,
            parameters,
        })
    }

    fn count(config: &LearnedPotentialsConfig, shape: &ModelShape, _horizon: usize) -> Option<usize> {
        let &ModelShape { state_dim: n, measurement_dim: m, .. } = shape;
        let layout = Layout { n, components: config.components };
        let standards = n.checked_add(m)?.checked_mul(2)?;
        PotentialNetworks::count(count(n, m), config.hidden, layout)?.checked_add(standards)
    }

    fn config(&self) -> &LearnedPotentialsConfig {
        &self.config
    }
}
