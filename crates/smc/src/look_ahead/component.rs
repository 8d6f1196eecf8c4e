//! One of the quadratics that a potential is the sum of.

use motes_models::equations::triangle::{at, factor_from_last};

use super::error::LookAheadError;
use super::potential::{Numbers, Potential};

/// A quadratic of a potential `ψ_t(x) = Σ_j w_j exp(−½ |R_j (x − r_j)|²)`.
#[derive(Debug, Clone, PartialEq)]
pub struct PotentialComponent {
    /// `log w`; only differences between components of a step matter.
    pub log_weight: f64,
    /// `r`, `N`.
    pub centre: Vec<f64>,
    /// `R`, of any number of rows of `N`: without rows, or where all are 0, the component is flat.
    pub root: Vec<f64>,
}

impl PotentialComponent {
    /// The potential of it, if all of it is finite and as wide as a state of step `index`.
    ///
    /// # Errors
    /// [`LookAheadError`] otherwise.
    pub(super) fn potential(&self, index: usize, n: usize) -> Result<Potential, LookAheadError> {
        let wrong = |what, found, expected| Err(LookAheadError::Step { index, what, found, expected });
        if self.centre.len() != n {
            return wrong("the length of the centre of a quadratic", self.centre.len(), n);
        }
        if !self.root.len().is_multiple_of(n) {
            let rows = self.root.len().div_ceil(n);
            return wrong("the length of the root of a quadratic", self.root.len(), rows * n);
        }
        let mut curvature = Numbers::from_elem(0.0, n * n);
        for row in self.root.chunks_exact(n) {
            for i in 0..n {
                for j in 0..n {
                    curvature[i * n + j] += row[i] * row[j];
                }
            }
        }
        let potential = Potential {
            reference: Numbers::from_slice(&self.centre),
            curvature,
            slope: Numbers::from_elem(0.0, n),
        };
        match potential.is_finite() && self.log_weight.is_finite() {
            true => Ok(potential),
            false => Err(LookAheadError::Potential { index }),
        }
    }
}

/// A quadratic, and what is the same of it for all particles of a step.
#[derive(Debug, Clone)]
pub(super) struct Component {
    /// `log w`.
    pub(super) log_weight: f64,
    pub(super) potential: Potential,
    /// The `L` with `Λ = I + S A S = Lᵀ L` at the variances of the step; nothing where it has none.
    pub(super) lower: Numbers,
    /// `½ log |Λ|` of it.
    pub(super) log_determinant: f64,
    is_flat: bool,
}

impl Component {
    /// That of a step whose coordinates are normal draws of their own with these variances, if they are.
    pub(super) fn new(log_weight: f64, potential: Potential, variances: Option<&[f64]>) -> Self {
        let n = potential.reference.len();
        let mut lower = Numbers::new();
        if let Some(variances) = variances {
            lower.resize(n * (n + 1) / 2, 0.0);
            for i in 0..n {
                for j in 0..=i {
                    let scaled = variances[i].sqrt() * potential.curvature[i * n + j] * variances[j].sqrt();
                    lower[at(i, j)] = if i == j { 1.0 + scaled } else { scaled };
                }
            }
            factor_from_last(n, &mut lower);
        }
        let has_lower = variances.is_some();
        let log_determinant = (0..n).filter(|_| has_lower).map(|i| lower[at(i, i)].ln()).sum();
        let is_flat = potential.curvature.iter().chain(&potential.slope).all(|entry| *entry == 0.0);
        Component { log_weight, potential, lower, log_determinant, is_flat }
    }

    /// Whether it is the same for all states.
    pub(super) fn is_flat(&self) -> bool {
        self.is_flat
    }
}
