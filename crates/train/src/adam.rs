//! Adam, in one pass over all weights.

use std::mem::discriminant;

use motes_models::batch::by_widest_vectors;
use motes_proposals::{GradientPart, Parameters, Slice, Values, Workspace};
use serde::Serialize;

use crate::TrainError;

/// The settings of Adam.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct AdamConfig {
    /// Step size.
    pub learning_rate: f64,
    /// Forgetting factor of the gradient's mean.
    pub beta_1: f64,
    /// Forgetting factor of its square's mean.
    pub beta_2: f64,
    /// Added to the root in the denominator.
    pub epsilon: f64,
}

impl AdamConfig {
    /// The paper's: learning rate 0.001, forgetting factors 0.9 and 0.999; ε is Adam's usual 1e-8.
    pub fn paper() -> Self {
        AdamConfig { learning_rate: 1e-3, beta_1: 0.9, beta_2: 0.999, epsilon: 1e-8 }
    }

    fn check(&self) -> Result<(), TrainError> {
        // The optimiser computes in 32 bits: what rounds to 1 or to 0 there is as bad as 1 or 0.
        let positive = |value: f64| value as f32 > 0.0 && (value as f32).is_finite();
        let forgetting = |value: f64| (0.0..1.0).contains(&(value as f32));
        for (fine, name, value, expected) in [
            (
                positive(self.learning_rate),
                "the learning rate",
                format!("{:?}", self.learning_rate),
                "positive and finite in 32 bits",
            ),
            (
                forgetting(self.beta_1),
                "Adam's first forgetting factor",
                self.beta_1.to_string(),
                "at least 0 and below 1",
            ),
            (
                forgetting(self.beta_2),
                "Adam's second forgetting factor",
                self.beta_2.to_string(),
                "at least 0 and below 1",
            ),
            (
                positive(self.epsilon),
                "Adam's epsilon",
                format!("{:?}", self.epsilon),
                "positive and finite in 32 bits",
            ),
        ] {
            if !fine {
                return Err(TrainError::Setting { name, value, expected });
            }
        }
        Ok(())
    }
}

/// The optimiser of Kingma and Ba (2015), with its moments of each weight.
///
/// [`train`](crate::train) uses it. A training loop of one's own uses it with [`rollout`](crate::rollout()):
///
/// ```
/// use motes_models::{GraphDiffusion, GraphDiffusionConfig, ModelShape, Seed, simulate};
/// use motes_proposals::{Backend, Family, Fcnn, FcnnConfig, Parametric};
/// use motes_train::{Adam, AdamConfig, GradientFlow, Objective, rollout};
///
/// let seed = Seed::from_u64(1);
/// let system = GraphDiffusion::random(&GraphDiffusionConfig::new(6), &mut seed.child("graph").stream())?;
/// let measurements = simulate(&system, 4, &mut seed.child("data").stream())?.measurements;
/// let config = FcnnConfig { widths: vec![16], ..FcnnConfig::paper() };
/// let shape = ModelShape::of(&system);
/// let mut proposal = Fcnn::create(&config, &shape, 4, Backend::Native.into(), &seed.child("weights"))?;
///
/// let mut adam = Adam::new(&AdamConfig { learning_rate: 1e-2, ..AdamConfig::paper() })?;
/// let (objective, flow) = (Objective::Elbo, GradientFlow::Full);
/// let mut stream = seed.child("training").stream();
/// let mut objectives = Vec::new();
/// for _ in 0..20 {
///     let mut found = rollout(&proposal, &system, &measurements, objective, flow, 10, &mut stream)?;
///     adam.step(proposal.parameters_mut(), &mut found.workspace)?;
///     objectives.push(found.objective);
/// }
/// assert!(objectives[19] > objectives[0]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct Adam {
    config: AdamConfig,
    pub(crate) moments: Option<Moments>,
    /// How many steps each matrix has taken.
    pub(crate) steps: Vec<i32>,
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
    complements: [T; 2],
    /// `α / (1 − β₁ᵗ)`.
    rate: T,
    /// `1 / √(1 − β₂ᵗ)`.
    bias_correction: T,
    epsilon: T,
}

impl Step<f64> {
    /// Step number `taken`, from 1 on.
    fn new(config: &AdamConfig, taken: i32) -> Self {
        let AdamConfig { learning_rate, beta_1, beta_2, epsilon } = *config;
        let rate = learning_rate / (1.0 - beta_1.powi(taken));
        let bias_correction = 1.0 / (1.0 - beta_2.powi(taken)).sqrt();
        Step { beta_1, beta_2, complements: [1.0 - beta_1, 1.0 - beta_2], rate, bias_correction, epsilon }
    }

    fn narrow(self) -> Step<f32> {
        let Step { beta_1, beta_2, complements, rate, bias_correction, epsilon } = self;
        Step {
            beta_1: beta_1 as f32,
            beta_2: beta_2 as f32,
            complements: complements.map(|complement| complement as f32),
            rate: rate as f32,
            bias_correction: bias_correction as f32,
            epsilon: epsilon as f32,
        }
    }
}

impl Adam {
    /// An optimiser before its first step.
    ///
    /// # Errors
    /// [`TrainError::Setting`] if a setting is outside its range.
    pub fn new(config: &AdamConfig) -> Result<Self, TrainError> {
        config.check()?;
        Ok(Adam { config: *config, moments: None, steps: Vec::new() })
    }

    /// Takes the next steps with another learning rate; 0 stands still.
    pub(crate) fn set_learning_rate(&mut self, learning_rate: f64) {
        self.config.learning_rate = learning_rate;
    }

    /// Moves every weight `θ` that has a gradient `g` against it.
    ///
    /// `m ← β₁ m + (1 − β₁) g`, `v ← β₂ v + (1 − β₂) g²`, `θ ← θ − α m̂ / (√v̂ + ε)`,
    /// with `m̂ = m / (1 − β₁ᵗ)` and `v̂ = v / (1 − β₂ᵗ)`; `t` counts the steps in which the weight had a gradient.
    ///
    /// The gradients in `workspace` are gone afterwards: each part of them is used while it is in a cache.
    ///
    /// # Errors
    /// [`TrainError::Optimiser`] if the gradients are not of these parameters, or if the steps before were taken with others. Nothing has
    /// changed then.
    pub fn step(&mut self, parameters: &mut Parameters, workspace: &mut Workspace) -> Result<(), TrainError> {
        if !workspace.fits(parameters) {
            return Err(TrainError::Optimiser { what: "gradients" });
        }
        let matrices = parameters.len();
        let weights = parameters.values_mut();
        let zeros = || weights.zeros_like(weights.len());
        let Moments { first, second } =
            self.moments.get_or_insert_with(|| Moments { first: zeros(), second: zeros() });
        let like_weights = discriminant(&*first) == discriminant(&*weights) && first.len() == weights.len();
        if !like_weights || !(self.steps.is_empty() || self.steps.len() == matrices) {
            return Err(TrainError::Optimiser { what: "the moments of earlier steps" });
        }
        self.steps.resize(matrices, 0);
        let mut current = None;
        workspace.hand_over(|GradientPart { matrix, range, values }| {
            let (wide, narrow) = match current {
                Some((number, steps)) if number == matrix => steps,
                _ => {
                    self.steps[matrix] += 1;
                    let step = Step::new(&self.config, self.steps[matrix]);
                    current.insert((matrix, (step, step.narrow()))).1
                }
            };
            let at = || range.clone();
            match (&mut *weights, values, &mut *first, &mut *second) {
                (Values::F32(weights), Slice::F32(gradient), Values::F32(first), Values::F32(second)) => {
                    update_f32(narrow, &mut weights[at()], gradient, (&mut first[at()], &mut second[at()]));
                }
                (Values::F64(weights), Slice::F64(gradient), Values::F64(first), Values::F64(second)) => {
                    update_f64(wide, &mut weights[at()], gradient, (&mut first[at()], &mut second[at()]));
                }
                _ => unreachable!("gradients and moments have the precision of the weights"),
            }
        });
        Ok(())
    }
}

/// The same loop in both precisions.
macro_rules! update {
    ($name:ident, $real:ty) => {
        fn $name(
            step: Step<$real>,
            weights: &mut [$real],
            gradient: &[$real],
            (first, second): (&mut [$real], &mut [$real]),
        ) {
            by_widest_vectors(
                #[inline(always)]
                || {
                    let moments = first.iter_mut().zip(second.iter_mut());
                    for ((weight, g), (m, v)) in weights.iter_mut().zip(gradient).zip(moments) {
                        *m = step.beta_1 * *m + step.complements[0] * g;
                        *v = step.beta_2 * *v + step.complements[1] * (g * g);
                        *weight -= step.rate * *m / (v.sqrt() * step.bias_correction + step.epsilon);
                    }
                },
            );
        }
    };
}

update!(update_f32, f32);
update!(update_f64, f64);
