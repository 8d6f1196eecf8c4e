//! The networks: one for `t = 0`, one for all later times, each with a linear path beside its hidden layers.

use motes_models::Seed;
use motes_networks::{Activation, Arithmetic, Known, Networks, Outputs, Parameters, fan_in_bound};

/// `θ = z_L W + f W_f + b` with `z_ℓ = tanh(z_{ℓ−1} W_ℓ + b_ℓ)` and the inputs `z_0 = f`.
///
/// What is linear in the inputs needs no hidden unit. `W` and `W_f` begin at 0: an untrained network emits `b`.
#[derive(Debug, Clone, Copy)]
struct Network {
    first: usize,
    hidden: usize,
}

impl Network {
    /// Adds the weights of a network with the given widths, inputs first; `b` begins as `start`.
    fn draw(parameters: &mut Parameters, name: &str, widths: &[usize], start: &[f64], seed: &Seed) -> Self {
        let network = Network { first: parameters.len(), hidden: widths.len() - 1 };
        for (layer, pair) in widths.windows(2).enumerate() {
            let bound = fan_in_bound(pair[0]);
            parameters.draw(format!("{name}.{layer}.weight"), [pair[0], pair[1]], bound, seed);
            parameters.draw(format!("{name}.{layer}.bias"), [1, pair[1]], bound, seed);
        }
        let last = widths[widths.len() - 1];
        parameters.draw(format!("{name}.outputs.weight"), [last, start.len()], 0.0, seed);
        parameters.draw(format!("{name}.outputs.linear"), [widths[0], start.len()], 0.0, seed);
        parameters.add(format!("{name}.outputs.bias"), [1, start.len()], start);
        network
    }

    fn forward<A: Arithmetic>(self, arithmetic: &mut A, inputs: &A::Rows) -> A::Rows {
        let mut values = inputs.clone();
        for layer in 0..self.hidden {
            let at = self.first + 2 * layer;
            values = arithmetic.affine(&[(&values, at)], Some(at + 1), Activation::Tanh);
        }
        let at = self.first + 2 * self.hidden;
        arithmetic.affine(&[(&values, at), (inputs, at + 1)], Some(at + 2), Activation::Linear)
    }
}

/// One network for `t = 0`, where there is no past, and one for all later times.
#[derive(Debug, Clone, Copy)]
pub(super) struct AmortisedNetworks {
    initial: Network,
    later: Network,
}

impl AmortisedNetworks {
    /// Adds their weights: `inputs` are the numbers of inputs at `t = 0` and later.
    pub(super) fn draw(
        parameters: &mut Parameters,
        inputs: [usize; 2],
        widths: &[usize],
        start: &[f64],
        seed: &Seed,
    ) -> Self {
        let [initial, later] = inputs.map(|inputs| [&[inputs], widths].concat());
        AmortisedNetworks {
            initial: Network::draw(parameters, "initial", &initial, start, seed),
            later: Network::draw(parameters, "later", &later, start, seed),
        }
    }

    /// How many numbers their weights are; `None` if they cannot be counted.
    pub(super) fn count(inputs: [usize; 2], widths: &[usize], outputs: usize) -> Option<usize> {
        inputs.into_iter().try_fold(0_usize, |sum, inputs| {
            let widths = [&[inputs], widths].concat();
            let hidden = crate::settings::count_affine(&widths, 1)?;
            let rows = widths.last()?.checked_add(inputs)?.checked_add(1)?;
            sum.checked_add(hidden)?.checked_add(rows.checked_mul(outputs)?)
        })
    }
}

impl Networks for AmortisedNetworks {
    fn horizon(&self) -> Option<usize> {
        None
    }

    /// The inputs of the particles come in the place of `x_{t−1}`; the measurement is among them.
    fn forward<A: Arithmetic>(
        &self,
        arithmetic: &mut A,
        time: usize,
        known: Known<'_, A::Rows>,
    ) -> Outputs<A::Rows> {
        let network = if time == 0 { self.initial } else { self.later };
        Outputs::new([network.forward(arithmetic, &known.previous)], [])
    }
}
