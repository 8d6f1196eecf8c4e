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
use super::units::Sizes;
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
/// - Where states have no density, it is the noise `v` of all draws of a step that is proposed: `x = g(x_{t−1}, b + L⁻ᵀ u)` ([`motes_models::equations::NoiseSpace`]).
///   Where some draw is not normal it has a share of 0.1 of `N(0, I)` unless the filter says another ([`motes_smc::noise_share`]).
/// - It remembers nothing: for a Markov model the optimum depends on `x_{t−1}` and `y_t` alone.
#[derive(Clone)]
pub struct Amortised {
    pub(super) config: AmortisedConfig,
    pub(super) state_dim: usize,
    pub(super) measurement_dim: usize,
    /// `Q_0` and `Q`, where it is the noise of states that is proposed.
    pub(super) draws: Option<[usize; 2]>,
    /// At `t = 0`, and later.
    pub(super) heads: [Arc<dyn Head>; 2],
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
    /// The share of the noise's own distribution, where states have no density.
    pub(super) share: Option<f64>,
    pub(super) standards: Standards,
    pub(super) theta: Theta,
}

impl Amortised {
    /// Whether a draw is a differentiable function of what the networks emit.
    pub fn has_differentiable_draws(&self) -> bool {
        self.heads[1].reparametrised().is_some()
    }

    /// What the network of these times emits the parameters of.
    pub(super) fn head(&self, time: usize) -> &dyn Head {
        &*self.heads[usize::from(time > 0)]
    }

    /// How many numbers states and units have at a time.
    pub(super) fn sizes(&self, time: usize) -> Sizes {
        let states = self.state_dim;
        Sizes { states, units: self.draws.map_or(states, |draws| draws[usize::from(time > 0)]) }
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

    /// The parameters of the head at `t = 0`, or later.
    pub(super) fn theta(&self, time: usize) -> Theta {
        let (index, head) = (self.networks.shared(time), self.head(time));
        let shared = if head.shared() > 0 { self.parameters.host(index) } else { Vec::new() };
        Theta { emitted: head.outputs() - head.shared(), shared, index }
    }

    /// The index of the first of the matrices that are no weights: means and scales of inputs.
    fn first_standards(&self) -> usize {
        self.parameters.len() - 4
    }
}

/// The heads at `t = 0` and later. Where there is nothing to draw there is one of a number that nobody asks for.
fn heads(config: &AmortisedConfig, shape: &ModelShape) -> Result<[Arc<dyn Head>; 2], ProposalError> {
    if shape.draws.is_some_and(|[_, later]| later == 0) {
        return Err(ProposalError::Setting {
            name: "the number of draws of a transition",
            value: "0".into(),
            expected: "at least 1: a state without noise needs no proposal",
        });
    }
    let [initial, later] =
        shape.draws.unwrap_or([shape.state_dim; 2]).map(|count| config.head.head(count.max(1)));
    Ok([initial?.into(), later?.into()])
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
        let heads = heads(config, shape)?;
        check_weights(Self::count(config, shape, 0))?;
        let mut parameters = Parameters::new(compute);
        let inputs = Blocks::of(state_dim, measurement_dim);
        let along = along(config.sees, shape)?;
        let networks = AmortisedNetworks::draw(
            &mut parameters,
            inputs,
            &config.widths,
            along.as_ref(),
            heads.each_ref().map(|head| (head.start(), head.shared())),
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
            draws: shape.draws,
            heads,
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
        let outputs = heads(config, shape).ok()?.map(|head| (head.outputs(), head.shared()));
        let standards = inputs.map(Blocks::count).iter().sum::<usize>().checked_mul(2)?;
        AmortisedNetworks::count(inputs, &config.widths, order, outputs)?.checked_add(standards)
    }

    fn config(&self) -> &AmortisedConfig {
        &self.config
    }
}
