//! The networks: a recurrent layer in each direction of time and one that reads both, and one of a single step.

use motes_models::Seed;
use motes_networks::layers::{Cell, Mlp, RecurrentLayer};
use motes_networks::{Arithmetic, Known, NetworkError, Networks, Outputs, Parameters};

use super::decoded::Layout;
use crate::settings::count_affine;

/// A recurrent layer that emits its hidden state. Its first step, without rows, makes the state that a sequence begins with.
#[derive(Clone)]
pub(super) struct OneWay {
    layer: RecurrentLayer,
}

impl Networks for OneWay {
    fn horizon(&self) -> Option<usize> {
        None
    }

    fn hidden_widths(&self) -> Vec<usize> {
        self.layer.carried_widths()
    }

    fn forward<A: Arithmetic>(
        &self,
        arithmetic: &mut A,
        _: usize,
        known: Known<'_, A::Rows>,
    ) -> Outputs<A::Rows> {
        let carried = self.layer.forward(arithmetic, &known.previous, known.hidden);
        Outputs::new(carried.first().cloned(), carried)
    }
}

/// What reads the hidden states of both directions and the features of a step, or its features alone, and emits its potential.
#[derive(Clone)]
pub(super) struct Reader {
    network: Mlp,
}

impl Networks for Reader {
    fn horizon(&self) -> Option<usize> {
        None
    }

    fn forward<A: Arithmetic>(
        &self,
        arithmetic: &mut A,
        _: usize,
        known: Known<'_, A::Rows>,
    ) -> Outputs<A::Rows> {
        Outputs::new([self.network.forward(arithmetic, known.previous)], [])
    }
}

/// All of them, in one set of weights.
#[derive(Clone)]
pub(super) struct PotentialNetworks {
    /// From the first step on, and from the last step back.
    pub(super) ways: [OneWay; 2],
    pub(super) reader: Reader,
    /// Of a step alone.
    pub(super) now: Reader,
}

impl PotentialNetworks {
    /// Adds their weights for `features` of each step.
    pub(super) fn draw(
        parameters: &mut Parameters,
        features: usize,
        hidden: usize,
        layout: Layout,
        seed: &Seed,
    ) -> Result<Self, NetworkError> {
        let ways = ["forwards", "backwards"].map(|name| OneWay {
            layer: RecurrentLayer::draw(parameters, name, Cell::Gru, [features, hidden], seed),
        });
        let mut reader = |name: &str, widths: &[usize]| -> Result<Reader, NetworkError> {
            let network = Mlp::draw(parameters, name, widths, seed);
            // At the beginning quadratics lie side by side.
            let bias = parameters.len() - 1;
            parameters.set_host(bias, &layout.start())?;
            Ok(Reader { network })
        };
        let [of_both, alone] = widths(features, hidden, layout);
        Ok(PotentialNetworks { ways, reader: reader("reader", &of_both)?, now: reader("now", &alone)? })
    }

    /// The number of their weights.
    pub(super) fn count(features: usize, hidden: usize, layout: Layout) -> Option<usize> {
        let way = Cell::Gru.count([features, hidden])?;
        hidden.checked_mul(2)?.checked_add(features)?;
        let [of_both, alone] = widths(features, hidden, layout);
        let readers = count_affine(&of_both, 1)?.checked_add(count_affine(&alone, 1)?)?;
        way.checked_mul(2)?.checked_add(readers)
    }
}

/// The widths of what reads both directions, and of what sees a step alone.
fn widths(features: usize, hidden: usize, layout: Layout) -> [Vec<usize>; 2] {
    let outputs = layout.outputs();
    [vec![2 * hidden + features, hidden, outputs], vec![features, hidden, hidden, outputs]]
}
