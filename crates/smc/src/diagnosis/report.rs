//! What weights say about a run, in words.

use std::fmt;

use serde::{Deserialize, Serialize};

use super::PARETO_K_LIMIT;
use super::pareto::Tail;
use super::upper_end::UPPER_END;

/// Fewer effective particles than this, and one of them has more than half of the weight: `max W_k ≥ Σ W_k² = 1/K_eff`.
pub const LEAST_EFFECTIVE_PARTICLES: f64 = 2.0;

/// The share of particles that are effective from which on a tail carries too little of the weight to matter, whatever its index.
const MANY_EFFECTIVE: f64 = 0.1;

/// Distinct weights in a tail, below which its index says too little.
const LEAST_TAIL_WEIGHTS: usize = 15;

/// Standard errors by which steps are compared; a run of some hundred steps is held against as many.
const USUAL_ERRORS: f64 = 4.0;

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
    /// How many distinct weights `k̂` rests on.
    pub tail_weights: usize,
    /// The tail index `ξ` of the largest *log*-weights, if there are enough: about 0 where the measurement lies beyond all particles, and
    /// `−2/d` where they have reached the peak of its likelihood in `d` dimensions. Few effective particles are a matter of variance then, which the standard
    /// error of the evidence has, and no sign that anything was missed.
    pub upper_end: Option<f64>,
}

impl WeightDiagnosis {
    /// Whether the largest log-weights have an upper end in sight, so that particles have reached what the measurement asks for.
    fn has_upper_end(&self) -> bool {
        self.upper_end.is_some_and(|index| index < UPPER_END)
    }

    /// `k̂` less so many of its standard errors.
    fn tail_bound(&self, errors: f64) -> Option<f64> {
        let index = self.pareto_k?;
        Some(index - errors * Tail { index, weights: self.tail_weights.max(1) }.error())
    }

    /// Whether the tail index says something about averages: it rests on enough weights, the tail carries a good part of the weight, and nothing bounds it.
    fn has_telling_tail(&self) -> bool {
        self.tail_weights >= LEAST_TAIL_WEIGHTS
            && self.effective_sample_size < MANY_EFFECTIVE * self.particles as f64
            && !self.has_upper_end()
    }

    /// Whether one particle has more than half of the weight.
    fn is_poor(&self) -> bool {
        self.effective_sample_size < LEAST_EFFECTIVE_PARTICLES
    }
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
    poor: usize,
    poorest: Option<WeightDiagnosis>,
    fitted: usize,
    sum_of_indices: f64,
    /// The step with the largest index, of those that it says something about.
    heaviest: Option<WeightDiagnosis>,
}

/// A reason not to trust the weights of a run, with the step at which they are worst.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum WeightWarning {
    /// Fewer than two effective particles: one has more than half of the weight.
    FewParticles {
        /// At how many steps.
        steps: usize,
        /// The worst of them.
        worst: WeightDiagnosis,
    },
    /// Weights of a step have a tail index above [`PARETO_K_LIMIT`], by more than the sampling error of the largest of so many steps.
    HeavyTail {
        /// The step of the largest.
        worst: WeightDiagnosis,
        /// The index of that step, less its sampling error.
        pareto_k: f64,
    },
}

impl WeightWarning {
    /// The step at which it is worst.
    pub fn step(&self) -> usize {
        match self {
            WeightWarning::FewParticles { worst, .. } | WeightWarning::HeavyTail { worst, .. } => worst.time,
        }
    }
}

impl WeightReport {
    /// Takes in the weights of a step.
    pub fn add(&mut self, step: &WeightDiagnosis) {
        self.steps += 1;
        self.sum_of_sizes += step.effective_sample_size;
        if step.is_poor() {
            self.poor += 1;
            if self.poorest.is_none_or(|poorest| step.effective_sample_size < poorest.effective_sample_size) {
                self.poorest = Some(*step);
            }
        }
        let Some(index) = step.pareto_k else { return };
        self.fitted += 1;
        self.sum_of_indices += index;
        let bound = |step: &WeightDiagnosis| step.tail_bound(USUAL_ERRORS);
        let largest = self.heaviest.as_ref().and_then(bound);
        if step.has_telling_tail() && largest.is_none_or(|largest| bound(step) > Some(largest)) {
            self.heaviest = Some(*step);
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
    pub fn mean_pareto_k(&self) -> Option<f64> {
        (self.fitted > 0).then(|| self.sum_of_indices / self.fitted as f64)
    }

    /// The largest `k̂` of a step, less its sampling error: the bound that the largest of as many sound steps exceeds in one run of a hundred, about.
    ///
    /// `k̂` has a standard error of about `(1 + k)/√n`, where `n` distinct weights make the tail, and the largest of `T` normal errors is at most `√(2 log 50T)`
    /// standard errors in 99 of 100 runs. Steps whose largest log-weights have an upper end have no part in it, nor those with `K/4` effective particles
    /// or more: what the tail adds to an average is small there.
    pub fn pareto_k(&self) -> Option<f64> {
        self.heaviest?.tail_bound((2.0 * (50.0 * self.steps as f64).ln()).sqrt())
    }

    /// All that is not to be trusted.
    pub fn warnings(&self) -> impl Iterator<Item = WeightWarning> {
        let few = self.poorest.map(|worst| WeightWarning::FewParticles { steps: self.poor, worst });
        let heavy = self.heaviest.zip(self.pareto_k()).filter(|(_, index)| *index > PARETO_K_LIMIT);
        let heavy = heavy.map(|(worst, pareto_k)| WeightWarning::HeavyTail { worst, pareto_k });
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
        if let Some(index) = self.heaviest.and_then(|heaviest| heaviest.pareto_k) {
            write!(f, ", tail index at most {index:.2} in a step")?;
        }
        self.warnings().try_for_each(|warning| write!(f, "\nwarning: {warning}"))
    }
}

impl WeightWarning {
    /// The warning in words, where `at` is what a step is called.
    pub fn describe(&self, at: &dyn Fn(usize) -> String) -> String {
        match self {
            WeightWarning::FewParticles { steps, worst } => {
                let (k, step) = (worst.particles, at(worst.time));
                let more = if *steps > 1 { format!(", at {steps} steps in all") } else { String::new() };
                format!("at {step} one particle of {k} has more than half of the weight{more}")
            }
            WeightWarning::HeavyTail { worst, pareto_k } => format!(
                "at {} the weights have a tail index (Pareto k) of at least {pareto_k:.2}, above {PARETO_K_LIMIT}: averages by them need far \
                 more particles; where the proposal is too narrow, a defensive share bounds them",
                at(worst.time)
            ),
        }
    }
}

impl fmt::Display for WeightWarning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.describe(&|step| format!("step {step}")))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn step(
        time: usize,
        particles: usize,
        size: f64,
        pareto_k: Option<f64>,
        upper_end: Option<f64>,
    ) -> WeightDiagnosis {
        let (effective_sample_size, tail_weights) = (size, (3.0 * (particles as f64).sqrt()) as usize);
        WeightDiagnosis { time, particles, effective_sample_size, pareto_k, tail_weights, upper_end }
    }

    #[test]
    fn a_report_has_a_line_for_each_warning() {
        let mut report = WeightReport::default();
        assert_eq!((report.to_string().as_str(), report.warnings().count()), ("0 steps", 0));
        report.add(&step(0, 1000, 80.0, Some(0.3), Some(-0.2)));
        report.add(&step(1, 1000, 300.0, None, None));
        assert_eq!(
            report.to_string(),
            "2 steps, 190.0 effective particles, tail index at most 0.30 in a step"
        );
        report.add(&step(2, 1000, 5.0, Some(2.9), Some(-0.1)));
        report.add(&step(3, 1000, 6.0, Some(0.9), Some(0.1)));
        assert_eq!(
            report.to_string(),
            "4 steps, 97.8 effective particles, tail index at most 2.90 in a step\n\
             warning: at step 2 the weights have a tail index (Pareto k) of at least 1.72, above 0.7: averages by them need far more \
             particles; where the proposal is too narrow, a defensive share bounds them"
        );
        report.add(&step(4, 1000, 1.5, None, Some(-2.0)));
        let first = report.warnings().next().map(|warning| (warning.step(), warning.to_string()));
        let expected = "at step 4 one particle of 1000 has more than half of the weight".to_string();
        assert_eq!(first, Some((4, expected)));
    }

    #[test]
    fn few_particles_at_a_peak_that_was_reached_are_no_reason_for_a_warning() {
        let mut report = WeightReport::default();
        report.add(&step(0, 1000, 6.0, Some(19.0), Some(-1.2)));
        assert_eq!((report.warnings().count(), report.pareto_k()), (0, None));
        assert_eq!(report.mean_pareto_k(), Some(19.0));
    }

    #[test]
    fn the_largest_of_many_steps_is_held_against_how_many_there_were() {
        let of = |steps: usize| {
            let mut report = WeightReport::default();
            (0..steps).for_each(|time| report.add(&step(time, 1000, 80.0, Some(1.3), None)));
            report.warnings().count()
        };
        assert_eq!([of(1), of(100_000)], [1, 0]);
        let mut few_weights = WeightReport::default();
        few_weights.add(&step(0, 100, 8.0, Some(1.3), None));
        assert_eq!(few_weights.warnings().count(), 0);
        let mut many_effective = WeightReport::default();
        many_effective.add(&step(0, 1000, 100.0, Some(3.0), None));
        assert_eq!(many_effective.warnings().count(), 0);
    }
}
