//! What the networks see of a particle and a measurement, in standard units.

use motes_models::equations::{Lanes, Scalar};

/// Inputs stay within this many standard deviations of their mean: a network extrapolates badly.
const LARGEST: f64 = 10.0;

/// What inputs are: blocks of `N` numbers, `x_{t−1}` and the predicted state where there is a past, then two of `M`, `y_t` and the innovation.
#[derive(Debug, Clone, Copy)]
pub(super) struct Blocks {
    of_states: usize,
    n: usize,
    m: usize,
}

impl Blocks {
    /// Those at `t = 0` and later, for states of `n` coordinates and measurements of `m`.
    pub(super) fn of(n: usize, m: usize) -> [Self; 2] {
        [0, 2].map(|of_states| Blocks { of_states, n, m })
    }

    /// How many blocks of states and of measurements there are.
    pub(super) fn numbers(self) -> [usize; 2] {
        [self.of_states, 2]
    }

    /// How many inputs there are.
    pub(super) fn count(self) -> usize {
        self.of_states * self.n + 2 * self.m
    }

    /// How many there are at each node of a graph.
    pub(super) fn features(self) -> usize {
        self.of_states + 2
    }

    /// `N`.
    pub(super) fn nodes(self) -> usize {
        self.n
    }
}

/// The means and standard deviations of inputs, by which they are brought to standard units.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Standards {
    pub(super) means: Vec<f64>,
    /// 1 over the standard deviations; 0 for an input that does not vary.
    pub(super) scales: Vec<f64>,
}

impl Standards {
    /// Those that change nothing.
    pub(super) fn none(count: usize) -> Self {
        Standards { means: vec![0.0; count], scales: vec![1.0; count] }
    }

    /// Brings the inputs of a tile to standard units; what is not a number becomes the mean.
    #[inline(always)]
    pub(super) fn apply(&self, inputs: &mut [Lanes]) {
        for ((input, mean), scale) in inputs.iter_mut().zip(&self.means).zip(&self.scales) {
            for value in &mut input.0 {
                let standard = (*value - mean) * scale;
                let within = if standard > LARGEST { LARGEST } else { standard };
                let within = if within < -LARGEST { -LARGEST } else { within };
                *value = if within.is_nan() { 0.0 } else { within };
            }
        }
    }
}

/// The innovation of an entry of the measurement in units of its predicted standard deviation: `(s/I) / √(1/I + |J|²)` with the slope `s`, the
/// information `I` and the derivatives `J` of its location along the noise; 0 where it is not finite.
#[inline(always)]
pub(super) fn innovation(slope: Lanes, information: Lanes, jacobian: &[Lanes]) -> Lanes {
    let mut spread = Lanes::from(0.0);
    for entry in jacobian {
        spread = spread + *entry * *entry;
    }
    let mut found = slope / (information * (information * spread + 1.0)).sqrt();
    for value in &mut found.0 {
        *value = if value.is_finite() { *value } else { 0.0 };
    }
    found
}
