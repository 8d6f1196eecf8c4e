//! What the numbers that a network emits for a step mean.

use motes_models::equations::triangle::at;
use motes_smc::PotentialComponent;

/// Bounds of the logarithms of a root's diagonal: a quadratic is neither flatter nor sharper, in spreads of the state.
pub(super) const LOG_ROOT: [f64; 2] = [-6.0, 8.0];

/// Where quadratics stand among the outputs: `J` of them, each with its log-weight, its centre `r` (`N`) and its root `L` (`N(N+1)/2`, the logarithms of its diagonal); then the
/// log-weight of the flat one.
#[derive(Debug, Clone, Copy)]
pub(super) struct Layout {
    pub(super) n: usize,
    pub(super) components: usize,
}

impl Layout {
    /// How many numbers a quadratic has.
    pub(super) fn width(self) -> usize {
        1 + self.n + at(self.n, 0)
    }

    /// How many numbers there are.
    pub(super) fn outputs(self) -> usize {
        self.components * self.width() + 1
    }

    /// Quadratics as wide as states vary, spread over where these are, with a small share of the flat one.
    pub(super) fn start(self) -> Vec<f64> {
        let mut outputs = vec![0.0; self.outputs()];
        for (number, of_one) in outputs.chunks_exact_mut(self.width()).take(self.components).enumerate() {
            let place = if self.components > 1 {
                2.0 * number as f64 / (self.components - 1) as f64 - 1.0
            } else {
                0.0
            };
            of_one[1..=self.n].fill(place);
        }
        if let Some(flat) = outputs.last_mut() {
            *flat = -2.0;
        }
        outputs
    }

    /// The root `L` of a quadratic from its numbers, `N(N+1)/2`.
    pub(super) fn root(self, of_one: &[f64], root: &mut Vec<f64>) {
        root.clear();
        root.extend_from_slice(&of_one[1 + self.n..self.width()]);
        for i in 0..self.n {
            let entry = &mut root[at(i, i)];
            *entry = entry.clamp(LOG_ROOT[0], LOG_ROOT[1]).exp();
        }
    }

    /// The potential of a step in the units of the model, from outputs in units of `middles` and `spreads` of its states.
    pub(super) fn components(
        self,
        outputs: &[f64],
        [middles, spreads]: &[Vec<f64>; 2],
    ) -> Vec<PotentialComponent> {
        let (n, mut root) = (self.n, Vec::new());
        let mut of_step: Vec<PotentialComponent> = Vec::with_capacity(self.components + 1);
        for of_one in outputs.chunks_exact(self.width()).take(self.components) {
            self.root(of_one, &mut root);
            let centre = (0..n).map(|i| middles[i] + spreads[i] * of_one[1 + i]);
            // Row i is column i of L.
            let rows = (0..n * n).map(|place| match (place / n, place % n) {
                (row, column) if column >= row => root[at(column, row)] / spreads[column],
                _ => 0.0,
            });
            of_step.push(PotentialComponent {
                log_weight: of_one[0],
                centre: centre.collect(),
                root: rows.collect(),
            });
        }
        let log_weight = outputs[self.outputs() - 1];
        of_step.push(PotentialComponent { log_weight, ..Self::flat(middles) });
        of_step
    }

    /// What says nothing of a state.
    pub(super) fn flat(middles: &[f64]) -> PotentialComponent {
        PotentialComponent { log_weight: 0.0, centre: middles.to_vec(), root: Vec::new() }
    }
}
