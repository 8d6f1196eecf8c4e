//! The networks: one for `t = 0`, one for all later times, each with a linear path beside its hidden layers.

use motes_models::Seed;
use motes_networks::{Activation, Arithmetic, HiddenReader, Known, Networks, Outputs, Parameters};

use super::hidden::{Along, Hidden};
use super::inputs::Blocks;

/// `θ = z W + f W_f + b` with the last hidden layer `z` and the inputs `f`.
///
/// What is linear in the inputs needs no hidden unit. `W` and `W_f` begin at 0: an untrained network emits `b`.
#[derive(Clone)]
struct Network {
    hidden: Hidden,
    outputs: usize,
}

impl Network {
    /// The index of what all particles share, where they share something.
    fn shared(&self) -> usize {
        self.outputs + 3
    }

    fn hidden_readers(&self) -> Vec<HiddenReader> {
        self.hidden.readers(self.outputs)
    }

    fn forward<A: Arithmetic>(&self, arithmetic: &mut A, inputs: &A::Rows) -> A::Rows {
        let values = self.hidden.forward(arithmetic, inputs);
        let at = self.outputs;
        arithmetic.affine(&[(&values, at), (inputs, at + 1)], Some(at + 2), Activation::Linear)
    }
}

/// One network for `t = 0`, where there is no past, and one for all later times.
#[derive(Clone)]
pub(super) struct AmortisedNetworks {
    initial: Network,
    later: Network,
}

impl AmortisedNetworks {
    /// Adds their weights: `inputs` are those at `t = 0` and later, and `starts` what `b` begins as, but for the last of it, so many numbers that no network emits.
    pub(super) fn draw(
        parameters: &mut Parameters,
        inputs: [Blocks; 2],
        widths: &[usize],
        along: Option<&Along>,
        starts: [(Vec<f64>, usize); 2],
        seed: &Seed,
    ) -> Self {
        let mut draw = |name: &str, inputs: Blocks, (start, shared): (Vec<f64>, usize)| {
            let (start, of_all) = start.split_at(start.len() - shared);
            let hidden = Hidden::draw(parameters, name, inputs, widths, along, seed);
            let outputs = parameters.len();
            parameters.draw(format!("{name}.outputs.weight"), [hidden.width(widths), start.len()], 0.0, seed);
            parameters.draw(format!("{name}.outputs.linear"), [inputs.count(), start.len()], 0.0, seed);
            parameters.add(format!("{name}.outputs.bias"), [1, start.len()], start);
            if !of_all.is_empty() {
                parameters.add(format!("{name}.outputs.shared"), [1, of_all.len()], of_all);
            }
            Network { hidden, outputs }
        };
        let ([initial, later], [of_initial, of_later]) = (inputs, starts);
        AmortisedNetworks {
            initial: draw("initial", initial, of_initial),
            later: draw("later", later, of_later),
        }
    }

    /// How many numbers their weights are; `None` if they cannot be counted.
    pub(super) fn count(
        inputs: [Blocks; 2],
        widths: &[usize],
        order: Option<usize>,
        outputs: [(usize, usize); 2],
    ) -> Option<usize> {
        inputs.into_iter().zip(outputs).try_fold(0_usize, |sum, (inputs, (outputs, shared))| {
            let [hidden, last] = Hidden::count(inputs, widths, order)?;
            let rows = last.checked_add(inputs.count())?.checked_add(1)?;
            sum.checked_add(hidden)?.checked_add(rows.checked_mul(outputs - shared)?)?.checked_add(shared)
        })
    }
}

impl AmortisedNetworks {
    /// The index of what all particles share at `t = 0`, or later.
    pub(super) fn shared(&self, time: usize) -> usize {
        if time == 0 { self.initial.shared() } else { self.later.shared() }
    }
}

impl Networks for AmortisedNetworks {
    fn horizon(&self) -> Option<usize> {
        None
    }

    /// All hidden layers of both networks; the linear path reads inputs alone.
    fn hidden_readers(&self) -> Vec<HiddenReader> {
        [self.initial.hidden_readers(), self.later.hidden_readers()].concat()
    }

    /// The inputs of the particles come in the place of `x_{t−1}`; the measurement is among them.
    fn forward<A: Arithmetic>(
        &self,
        arithmetic: &mut A,
        time: usize,
        known: Known<'_, A::Rows>,
    ) -> Outputs<A::Rows> {
        let network = if time == 0 { &self.initial } else { &self.later };
        Outputs::new([network.forward(arithmetic, &known.previous)], [])
    }
}
