//! An amortised proposal: its networks, its weights, and how it is made.

use std::sync::Arc;

use motes_models::equations::Lanes;
use motes_models::{ModelShape, Seed};
use motes_networks::{Compute, HiddenReader, Networks, Parameters};
use motes_smc::ProposalError;

use super::config::{AmortisedConfig, Sees};
use super::heads::Head;
use super::hidden::Along;
use super::inputs::{Blocks, Standards};
use super::networks::AmortisedNetworks;
use super::theta::Theta;
use crate::family::{Family, Parametric};
use crate::settings::{check_compute, check_shape, check_weights, check_widths, graph_of};

/// `q(x_t | x_{t−1}, y_t)` learned once, for any sequence of a model: `x = T(x_{t−1}, b + L⁻ᵀ u)` with `u ~ h(· | θ)` and `θ` from a network.
///
/// `T` transports standard normal noise to the transition ([`motes_models::equations::Transport`]), so that draws stay inside its support. `b` and `L` are those of
/// the [`Base`](super::Base). The [`Head`] says what `h` is.
/// One network serves `t = 0`, where there is no past, and one all later times. They see `x_{t−1}`, the predicted state, `y_t` and the innovation, in standard
/// units and within ten standard deviations.
///
/// - Untrained it is the base, or a mixture around it.
/// - At a step whose measurement has gaps it is the base.
/// - It remembers nothing: for a Markov model the optimum depends on `x_{t−1}` and `y_t` alone.
#[derive(Clone)]
pub struct Amortised {
    pub(super) config: AmortisedConfig,
    pub(super) state_dim: usize,
    pub(super) measurement_dim: usize,
    pub(super) head: Arc<dyn Head>,
    pub(super) networks: AmortisedNetworks,
    pub(super) parameters: Parameters,
    pub(super) prepared: Option<Prepared>,
}

/// What all particles of a step have in common.
#[derive(Clone)]
pub(super) struct Prepared {
    pub(super) time: usize,
    /// `y_t`, the same for each particle.
    pub(super) measurement: Vec<Option<Lanes>>,
    /// Whether nothing is missing, so that the networks can be asked.
    pub(super) is_whole: bool,
    pub(super) is_affine: bool,
    pub(super) standards: Standards,
    pub(super) theta: Theta,
}

impl Amortised {
    /// Whether a draw is a differentiable function of what the networks emit.
    pub fn has_differentiable_draws(&self) -> bool {
        self.head.reparametrised().is_some()
    }

    /// The means and scales of the inputs at `t = 0`, or later.
    pub(super) fn standards(&self, time: usize) -> Standards {
        let first = self.first_standards() + if time == 0 { 0 } else { 2 };
        Standards { means: self.parameters.host(first), scales: self.parameters.host(first + 1) }
    }

    /// Sets the means and scales of the inputs at `t = 0`, or later.
    pub(super) fn set_standards(&mut self, time: usize, standards: &Standards) -> Result<(), ProposalError> {
        let first = self.first_standards() + if time == 0 { 0 } else { 2 };
        let set = self.parameters.set_host(first, &standards.means);
        set.and_then(|()| self.parameters.set_host(first + 1, &standards.scales))
            .map_err(crate::settings::of_networks)
    }

    /// How many numbers of `θ` the networks emit.
    pub(super) fn emitted(&self) -> usize {
        self.head.outputs() - self.head.shared()
    }

    /// The parameters of the head at `t = 0`, or later.
    pub(super) fn theta(&self, time: usize) -> Theta {
        let index = self.networks.shared(time);
        let shared = if self.head.shared() > 0 { self.parameters.host(index) } else { Vec::new() };
        Theta { emitted: self.emitted(), shared, index }
    }

    /// The index of the first of the matrices that are no weights: means and scales of inputs.
    fn first_standards(&self) -> usize {
        self.parameters.len() - 4
    }
}

/// The graph that hidden layers compute along.
fn along(sees: Sees, shape: &ModelShape) -> Result<Option<Along>, ProposalError> {
    let Sees::Graph { order } = sees else { return Ok(None) };
    Ok(Some((graph_of(shape)?, order)))
}

impl Parametric for Amortised {
    fn parameters(&self) -> &Parameters {
        &self.parameters
    }

    fn parameters_mut(&mut self) -> &mut Parameters {
        // What was prepared has some of them.
        self.prepared = None;
        &mut self.parameters
    }

    fn hidden_readers(&self) -> Vec<HiddenReader> {
        self.networks.hidden_readers()
    }

    /// Those of the networks: means and scales of inputs are none, nor are correlations that particles share.
    fn weight_matrices(&self) -> Vec<usize> {
        let names = self.parameters.names();
        (0..self.first_standards())
            .filter(|index| !["bias", "shared"].iter().any(|end| names[*index].ends_with(end)))
            .collect()
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

impl Family for Amortised {
    const NAME: &'static str = "amortised";
    type Config = AmortisedConfig;

    /// It has no use for `horizon`.
    fn create(
        config: &AmortisedConfig,
        shape: &ModelShape,
        _horizon: usize,
        compute: Compute,
        seed: &Seed,
    ) -> Result<Self, ProposalError> {
        check_compute(compute)?;
        check_shape(shape)?;
        check_widths("the hidden widths", &config.widths)?;
        let &ModelShape { state_dim, measurement_dim, .. } = shape;
        let head = config.head.head(state_dim)?;
        check_weights(Self::count(config, shape, 0))?;
        let mut parameters = Parameters::new(compute);
        let inputs = Blocks::of(state_dim, measurement_dim);
        let along = along(config.sees, shape)?;
        let networks = AmortisedNetworks::draw(
            &mut parameters,
            inputs,
            &config.widths,
            along.as_ref(),
            (&head.start(), head.shared()),
            seed,
        );
        for (name, count) in ["initial", "later"].into_iter().zip(inputs.map(Blocks::count)) {
            let standards = Standards::none(count);
            parameters.add(format!("{name}.inputs.means"), [1, count], &standards.means);
            parameters.add(format!("{name}.inputs.scales"), [1, count], &standards.scales);
        }
        Ok(Amortised {
            config: config.clone(),
            state_dim,
            measurement_dim,
            head: head.into(),
            networks,
            parameters,
            prepared: None,
        })
    }

    fn count(config: &AmortisedConfig, shape: &ModelShape, _horizon: usize) -> Option<usize> {
        let inputs = Blocks::of(shape.state_dim, shape.measurement_dim);
        let order = match config.sees {
            Sees::All => None,
            Sees::Graph { order } => Some(order),
        };
        let head = config.head.head(shape.state_dim).ok()?;
        let outputs = (head.outputs(), head.shared());
        let standards = inputs.map(Blocks::count).iter().sum::<usize>().checked_mul(2)?;
        AmortisedNetworks::count(inputs, &config.widths, order, outputs)?.checked_add(standards)
    }

    fn config(&self) -> &AmortisedConfig {
        &self.config
    }
}
