//! What weights say about a run, in words.

use std::fmt;

use serde::{Deserialize, Serialize};

use super::PARETO_K_LIMIT;

/// Fewer effective particles than this, and one of them has more than half of the weight: `max W_k ≥ Σ W_k² = 1/K_eff`.
pub const LEAST_EFFECTIVE_PARTICLES: f64 = 2.0;

/// The weights of one step, as figures that tell whether they can be trusted.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct WeightDiagnosis {
    /// The step, `t`.
    pub time: usize,
    /// `K`.
    pub particles: usize,
    /// `K_eff`, the mean over the filters of a bank.
    pub effective_sample_size: f64,
    /// `k̂` of all weights of the bank, if there are enough ([`pareto_k`](crate::pareto_k)).
    pub pareto_k: Option<f64>,
}

/// What the weights of a run say about how far it can be trusted, step by step added up.
///
/// ```
/// use faer::mat;
/// use motes_models::{Gaussian, LinearGaussian, Seed};
/// use motes_smc::{Bootstrap, FilterSettings, ParticleFilter, WeightReport};
///
/// let initial = Gaussian::new("P_0", vec![0.0], mat![[1.0]])?;
/// let model = LinearGaussian::new(initial, mat![[0.9]], mat![[1.0]], mat![[1.0]], mat![[0.01]])?;
/// let stream = Seed::from_u64(7).stream();
/// let mut filter = ParticleFilter::new(&model, Bootstrap, FilterSettings::new(1000), stream)?;
/// let mut report = WeightReport::default();
/// for measurement in [[0.3], [40.0], [36.0]] {
///     filter.step(&measurement)?;
///     report.add(&filter.diagnosis());
/// }
/// // Forty standard deviations off, one particle is nearest by far.
/// assert!(report.warnings().next().is_some());
/// println!("{report}");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct WeightReport {
    steps: usize,
    sum_of_sizes: f64,
    least: Option<WeightDiagnosis>,
    few: usize,
    fitted: usize,
    sum_of_indices: f64,
    heaviest: Option<(usize, f64)>,
}

/// A reason not to trust the weights of a run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum WeightWarning {
    /// One particle has more than half of the weight.
    FewParticles {
        /// At how many steps.
        steps: usize,
        /// The worst of them.
        worst: WeightDiagnosis,
    },
    /// Weights have a tail index above [`PARETO_K_LIMIT`] in the mean over steps; that of a single step of few particles says little.
    HeavyTail {
        /// The mean.
        mean: f64,
        /// The step of the largest.
        time: usize,
        /// The largest.
        largest: f64,
    },
}

impl WeightReport {
    /// Takes in the weights of a step.
    pub fn add(&mut self, step: &WeightDiagnosis) {
        self.steps += 1;
        self.sum_of_sizes += step.effective_sample_size;
        self.few += usize::from(step.effective_sample_size < LEAST_EFFECTIVE_PARTICLES);
        if self.least.is_none_or(|least| step.effective_sample_size < least.effective_sample_size) {
            self.least = Some(*step);
        }
        if let Some(index) = step.pareto_k {
            self.fitted += 1;
            self.sum_of_indices += index;
            if self.heaviest.is_none_or(|(_, largest)| index > largest) {
                self.heaviest = Some((step.time, index));
            }
        }
    }

    /// Steps taken in.
    pub fn steps(&self) -> usize {
        self.steps
    }

    /// The mean of `K_eff` over all steps; `None` before the first.
    pub fn effective_sample_size(&self) -> Option<f64> {
        (self.steps > 0).then(|| self.sum_of_sizes / self.steps as f64)
    }

    /// The mean of `k̂` over the steps that have one.
    pub fn pareto_k(&self) -> Option<f64> {
        (self.fitted > 0).then(|| self.sum_of_indices / self.fitted as f64)
    }

    /// All that is not to be trusted.
    pub fn warnings(&self) -> impl Iterator<Item = WeightWarning> {
        let few = self.least.filter(|_| self.few > 0);
        let few = few.map(|worst| WeightWarning::FewParticles { steps: self.few, worst });
        let mean = self.pareto_k().filter(|mean| *mean > PARETO_K_LIMIT);
        let heavy = mean.zip(self.heaviest);
        let heavy = heavy.map(|(mean, (time, largest))| WeightWarning::HeavyTail { mean, time, largest });
        few.into_iter().chain(heavy)
    }
}

/// A line of figures, and one for each warning.
impl fmt::Display for WeightReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} steps", self.steps)?;
        if let Some(size) = self.effective_sample_size() {
            write!(f, ", {size:.1} effective particles")?;
        }
        if let Some(index) = self.pareto_k() {
            write!(f, ", tail index {index:.2}")?;
        }
        self.warnings().try_for_each(|warning| write!(f, "\nwarning: {warning}"))
    }
}

impl fmt::Display for WeightWarning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            WeightWarning::FewParticles { steps, worst } => write!(
                f,
                "at {steps} steps one particle has more than half of the weight ({:.1} effective ones of {} at step {})",
                worst.effective_sample_size, worst.particles, worst.time
            ),
            WeightWarning::HeavyTail { mean, time, largest } => write!(
                f,
                "the weights have a tail index of {mean:.2}, above {PARETO_K_LIMIT} (largest {largest:.2} at step {time}): averages by them \
                 need far more particles; where the proposal is too narrow, a defensive weight bounds them"
            ),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_report_has_a_line_for_each_warning() {
        let mut report = WeightReport::default();
        assert_eq!((report.to_string().as_str(), report.warnings().count()), ("0 steps", 0));
        let step = |time, effective_sample_size, pareto_k| WeightDiagnosis {
            time,
            particles: 10,
            effective_sample_size,
            pareto_k,
        };
        report.add(&step(0, 8.0, Some(0.3)));
        report.add(&step(1, 3.0, None));
        assert_eq!(report.to_string(), "2 steps, 5.5 effective particles, tail index 0.30");
        report.add(&step(2, 1.5, Some(1.4)));
        report.add(&step(3, 1.2, Some(0.9)));
        assert_eq!(
            report.to_string(),
            "4 steps, 3.4 effective particles, tail index 0.87\n\
             warning: at 2 steps one particle has more than half of the weight (1.2 effective ones of 10 at step 3)\n\
             warning: the weights have a tail index of 0.87, above 0.7 (largest 1.40 at step 2): averages by them need far more \
             particles; where the proposal is too narrow, a defensive weight bounds them"
        );
    }
}
