//! Adam, in one pass over all weights.

use motes_proposals::{Gradients, Parameters, Values};

use crate::AdamConfig;

/// An optimiser together with what it remembers of each weight.
pub(crate) struct AdamSteps {
    config: AdamConfig,
    moments: Option<Moments>,
    /// How many steps each stretch of weights has taken: by where it begins.
    taken: std::collections::BTreeMap<usize, i32>,
}

/// Running means of gradients and of their squares.
struct Moments {
    first: Values,
    second: Values,
}

/// What one step does to every weight alike.
#[derive(Clone, Copy)]
struct Step<T> {
    beta_1: T,
    beta_2: T,
    /// `1 − β₁` and `1 − β₂`, from 64 bits.
    rest: [T; 2],
    /// `α / (1 − β₁ᵗ)`.
    rate: T,
    /// `1 / √(1 − β₂ᵗ)`.
    unbias: T,
    epsilon: T,
}

impl AdamSteps {
    pub(crate) fn new(config: &AdamConfig) -> Self {
        AdamSteps { config: *config, moments: None, taken: std::collections::BTreeMap::new() }
    }

    /// Moves every weight that has a gradient against it: `m ← β₁ m + (1 − β₁) g`, `v ← β₂ v + (1 − β₂) g²`,
    /// `θ ← θ − α m̂ / (√v̂ + ε)` with `m̂ = m / (1 − β₁ᵗ)`, `v̂ = v / (1 − β₂ᵗ)` (Kingma and Ba 2015).
    pub(crate) fn step(&mut self, parameters: &mut Parameters, gradients: &Gradients) {
        let weights = parameters.values_mut();
        let zeros = || weights.zeros_like(weights.len());
        let Moments { first, second } =
            self.moments.get_or_insert_with(|| Moments { first: zeros(), second: zeros() });
        for range in gradients.ranges() {
            let taken = self.taken.entry(range.start).or_insert(0);
            *taken += 1;
            let AdamConfig { learning_rate, beta_1, beta_2, epsilon } = self.config;
            let rate = learning_rate / (1.0 - beta_1.powi(*taken));
            let unbias = 1.0 / (1.0 - beta_2.powi(*taken)).sqrt();
            match (&mut *weights, gradients.values(), &mut *first, &mut *second) {
                (Values::F32(weights), Values::F32(gradient), Values::F32(first), Values::F32(second)) => {
                    let step = Step {
                        beta_1: beta_1 as f32,
                        beta_2: beta_2 as f32,
                        rest: [(1.0 - beta_1) as f32, (1.0 - beta_2) as f32],
                        rate: rate as f32,
                        unbias: unbias as f32,
                        epsilon: epsilon as f32,
                    };
                    let at = || range.clone();
                    let moments = (&mut first[at()], &mut second[at()]);
                    move_narrow(step, &mut weights[at()], &gradient[at()], moments);
                }
                (Values::F64(weights), Values::F64(gradient), Values::F64(first), Values::F64(second)) => {
                    let rest = [1.0 - beta_1, 1.0 - beta_2];
                    let step = Step { beta_1, beta_2, rest, rate, unbias, epsilon };
                    let at = || range.clone();
                    let moments = (&mut first[at()], &mut second[at()]);
                    move_wide(step, &mut weights[at()], &gradient[at()], moments);
                }
                _ => unreachable!("gradients and moments have the precision of the weights"),
            }
        }
    }
}

/// The same loop in both precisions.
macro_rules! moving {
    ($name:ident, $real:ty) => {
        fn $name(
            step: Step<$real>,
            weights: &mut [$real],
            gradient: &[$real],
            (first, second): (&mut [$real], &mut [$real]),
        ) {
            pulp::Arch::new().dispatch(
                #[inline(always)]
                || {
                    let moments = first.iter_mut().zip(second);
                    for ((weight, g), (m, v)) in weights.iter_mut().zip(gradient).zip(moments) {
                        *m = step.beta_1 * *m + step.rest[0] * g;
                        *v = step.beta_2 * *v + step.rest[1] * (g * g);
                        *weight -= step.rate * *m / (v.sqrt() * step.unbias + step.epsilon);
                    }
                },
            );
        }
    };
}

moving!(move_narrow, f32);
moving!(move_wide, f64);
