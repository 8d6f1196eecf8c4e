//! Adam, in one pass over all weights.

use motes_proposals::{GradientPart, Parameters, Slice, Values, Workspace};

use crate::AdamConfig;

/// An optimiser together with what it remembers of each weight.
pub(crate) struct AdamSteps {
    config: AdamConfig,
    pub(crate) moments: Option<Moments>,
    /// How many steps each matrix has taken.
    pub(crate) taken: Vec<i32>,
}

/// Running means of gradients and of their squares.
pub(crate) struct Moments {
    pub(crate) first: Values,
    pub(crate) second: Values,
}

/// What one step does to every weight of a matrix alike.
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

impl Step<f64> {
    /// Step number `taken`, from 1 on.
    fn new(config: &AdamConfig, taken: i32) -> Self {
        let AdamConfig { learning_rate, beta_1, beta_2, epsilon } = *config;
        let rate = learning_rate / (1.0 - beta_1.powi(taken));
        let unbias = 1.0 / (1.0 - beta_2.powi(taken)).sqrt();
        Step { beta_1, beta_2, rest: [1.0 - beta_1, 1.0 - beta_2], rate, unbias, epsilon }
    }

    fn narrow(self) -> Step<f32> {
        let Step { beta_1, beta_2, rest, rate, unbias, epsilon } = self;
        Step {
            beta_1: beta_1 as f32,
            beta_2: beta_2 as f32,
            rest: rest.map(|rest| rest as f32),
            rate: rate as f32,
            unbias: unbias as f32,
            epsilon: epsilon as f32,
        }
    }
}

impl AdamSteps {
    pub(crate) fn new(config: &AdamConfig) -> Self {
        AdamSteps { config: *config, moments: None, taken: Vec::new() }
    }

    /// Moves every weight that has a gradient against it: `m ← β₁ m + (1 − β₁) g`, `v ← β₂ v + (1 − β₂) g²`,
    /// `θ ← θ − α m̂ / (√v̂ + ε)` with `m̂ = m / (1 − β₁ᵗ)`, `v̂ = v / (1 − β₂ᵗ)` (Kingma and Ba 2015).
    ///
    /// The gradients are gone then: each part of them is used while it is in a cache.
    pub(crate) fn step(&mut self, parameters: &mut Parameters, workspace: &mut Workspace) {
        self.taken.resize(parameters.len(), 0);
        let weights = parameters.values_mut();
        let zeros = || weights.zeros_like(weights.len());
        let Moments { first, second } =
            self.moments.get_or_insert_with(|| Moments { first: zeros(), second: zeros() });
        let mut current = None;
        workspace.hand_over(|GradientPart { matrix, range, values }| {
            let (wide, narrow) = match current {
                Some((number, steps)) if number == matrix => steps,
                _ => {
                    self.taken[matrix] += 1;
                    let step = Step::new(&self.config, self.taken[matrix]);
                    current.insert((matrix, (step, step.narrow()))).1
                }
            };
            let at = || range.clone();
            match (&mut *weights, values, &mut *first, &mut *second) {
                (Values::F32(weights), Slice::F32(gradient), Values::F32(first), Values::F32(second)) => {
                    move_narrow(narrow, &mut weights[at()], gradient, (&mut first[at()], &mut second[at()]));
                }
                (Values::F64(weights), Slice::F64(gradient), Values::F64(first), Values::F64(second)) => {
                    move_wide(wide, &mut weights[at()], gradient, (&mut first[at()], &mut second[at()]));
                }
                _ => unreachable!("gradients and moments have the precision of the weights"),
            }
        });
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
