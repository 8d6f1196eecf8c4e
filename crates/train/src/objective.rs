//! What training maximises, as a function of log densities alone.

use serde::{Deserialize, Serialize};

/// A scalar of the log densities of drawn particles, to be maximised.
///
/// With `ℓ_t^k = log p(x_t^k | x_{t−1}^k) + log p(y_t | x_t^k)`, where `p(x_0)` stands at `t = 0`:
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Objective {
    /// `Σ_t 1/K Σ_k ℓ_t^k`: the paper's likelihood of the model in logarithmic form.
    #[default]
    LogLikelihood,
    /// `Σ_t log 1/K Σ_k exp ℓ_t^k`: the paper's equation "likelihood" to the letter, one logarithm for each time.
    Literal,
    /// `Σ_t 1/K Σ_k (ℓ_t^k − log q_t^k)`: with the entropy that keeps a proposal from collapsing.
    Elbo,
}

/// An objective's value, and its derivative with respect to each `ℓ_t^k` and `log q_t^k`.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Evaluation {
    pub(crate) value: f64,
    /// `T×K`, row-major.
    pub(crate) d_log_model: Vec<f64>,
    /// `T×K`, row-major; none where the value does not depend on them.
    pub(crate) d_log_proposal: Option<Vec<f64>>,
}

impl Objective {
    /// Whether it depends on `log q`.
    pub(crate) fn needs_log_proposal(self) -> bool {
        self == Objective::Elbo
    }

    /// The value at `ℓ` and `log q` (`T×K`, row-major). `log q` is read only if it is [needed](Objective::needs_log_proposal).
    pub(crate) fn evaluate(self, log_model: &[f64], log_proposal: &[f64], particles: usize) -> Evaluation {
        let share = 1.0 / particles as f64;
        let mean = |values: &[f64]| share * values.iter().sum::<f64>();
        let constant = |value| vec![value; log_model.len()];
        match self {
            Objective::LogLikelihood => {
                Evaluation { value: mean(log_model), d_log_model: constant(share), d_log_proposal: None }
            }
            Objective::Elbo => Evaluation {
                value: mean(log_model) - mean(log_proposal),
                d_log_model: constant(share),
                d_log_proposal: Some(constant(-share)),
            },
            Objective::Literal => {
                let (mut value, mut d_log_model) = (0.0, Vec::with_capacity(log_model.len()));
                for row in log_model.chunks_exact(particles) {
                    let largest = row.iter().copied().fold(f64::NEG_INFINITY, f64::max);
                    let sum: f64 = row.iter().map(|log| (log - largest).exp()).sum();
                    value += largest + (sum * share).ln();
                    d_log_model.extend(row.iter().map(|log| (log - largest).exp() / sum));
                }
                Evaluation { value, d_log_model, d_log_proposal: None }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn derivatives_are_those_of_the_value() {
        let (model, proposal) = ([-1.0, 0.5, -3.0, 2.0, 0.1, -0.7], [0.3, -1.0, 0.2, 0.9, -0.4, 0.0]);
        let h = 1e-6;
        for objective in [Objective::LogLikelihood, Objective::Literal, Objective::Elbo] {
            let found = objective.evaluate(&model, &proposal, 3);
            assert_eq!(found.d_log_proposal.is_some(), objective.needs_log_proposal());
            for at in 0..6 {
                let value = |of_model: f64, of_proposal: f64| {
                    let (mut model, mut proposal) = (model, proposal);
                    model[at] += of_model;
                    proposal[at] += of_proposal;
                    objective.evaluate(&model, &proposal, 3).value
                };
                let slope = (value(h, 0.0) - value(-h, 0.0)) / (2.0 * h);
                assert!((slope - found.d_log_model[at]).abs() < 1e-8, "{objective:?}");
                let slope = (value(0.0, h) - value(0.0, -h)) / (2.0 * h);
                let expected = found.d_log_proposal.as_ref().map_or(0.0, |d| d[at]);
                assert!((slope - expected).abs() < 1e-8, "{objective:?}");
            }
        }
    }

    #[test]
    fn the_literal_objective_is_the_logarithm_of_the_mean_likelihood() {
        let log_model = [2.0_f64.ln(), 4.0_f64.ln(), 6.0_f64.ln(), 1.0_f64.ln()];
        let found = Objective::Literal.evaluate(&log_model, &[0.0; 4], 2);
        assert!((found.value - (3.0_f64.ln() + 3.5_f64.ln())).abs() < 1e-14);
    }
}
