//! How good the estimates of many filters are: the only place where the truth is looked at.

use motes_models::Sequence;
use motes_smc::WeightReport;

use crate::config::Epidemic;
use crate::metric::Metric;
use crate::problem::{ErrorTarget, Problem};
use crate::reference::{PosteriorMean, References, SmoothedReference};
use crate::statistics::{mean, median, squared_error, squared_norm, standard_deviation};

/// What a bank of filters said, recorded step by step.
pub(crate) struct Recorded {
    /// Number of filters, `B`.
    pub(crate) filters: usize,
    /// Each filter's estimate at each time: `T×B×N`, before resampling.
    pub(crate) means: Vec<f64>,
    /// Each filter's effective sample size at each time, before resampling: `T×B`.
    pub(crate) effective_sample_sizes: Vec<f64>,
    /// Each filter's final estimate of the log-evidence.
    pub(crate) log_evidence: Vec<f64>,
    /// Whether weights can be trusted.
    pub(crate) report: WeightReport,
}

/// All metrics of one unit, in the order of the tables.
pub(crate) fn metrics(problem: &Problem, references: &References, recorded: &Recorded) -> Vec<Metric> {
    let mut found = match problem.judged {
        ErrorTarget::WholeState => normalised(problem, references, recorded),
        ErrorTarget::EachState { redrawn } => by_state(problem, recorded, redrawn),
    };
    found.extend(recorded.report.mean_pareto_k().map(|index| Metric::new("tail_index", index)));
    found
}

/// The metrics of `filters` filters of which only these did not lose all weight: the effective sample size of the others counts as 0.
pub(crate) fn metrics_of_survivors(
    problem: &Problem,
    references: &References,
    survivors: &Recorded,
    filters: usize,
) -> Vec<Metric> {
    let share = survivors.filters as f64 / filters as f64;
    let mut found = match survivors.filters {
        0 => vec![Metric::new("ess", 0.0)],
        _ => metrics(problem, references, survivors),
    };
    for metric in found.iter_mut().filter(|metric| metric.name == "ess") {
        metric.value *= share;
    }
    found.push(Metric::new("lost_runs", (filters - survivors.filters) as f64));
    found
}

/// What estimates of the evidence and of smoothed states are worth. None of the numbers is that of the simulated states.
pub(crate) fn metrics_of_smoothing(
    problem: &Problem,
    references: &References,
    recorded: &Recorded,
) -> Vec<Metric> {
    let (means, log_evidence) = match (&problem.exact, &references.smoothed) {
        (Some(exact), _) => (&exact.smoothed, exact.log_evidence),
        (None, Some(reference)) => (&reference.means, reference.log_evidence),
        (None, None) => return vec![],
    };
    let (filters, n) = (recorded.filters, problem.trajectory.states.width());
    let (horizon, size) = (means.len() / n, squared_norm(means));
    let times = || (0..horizon).zip(means.chunks_exact(n));
    let of_filter = |filter: usize| {
        let at = |time: usize| &recorded.at(time, n)[filter * n..][..n];
        times().map(|(time, mean)| squared_error(at(time), mean)).sum::<f64>() / size
    };
    let of_mean =
        |(time, mean): (usize, &[f64])| squared_error(&average(recorded.at(time, n), n, filters), mean);
    let errors = recorded.log_evidence.iter().map(|found| (found - log_evidence).powi(2));
    let mut found = vec![
        Metric::new("log_evidence_mse", mean(&errors.collect::<Vec<f64>>())),
        Metric::new("nmse_smoothed", times().map(of_mean).sum::<f64>() / size),
        Metric::new("nmse_smoothed_single", mean(&(0..filters).map(of_filter).collect::<Vec<f64>>())),
        Metric::new("ess", mean(&recorded.effective_sample_sizes)),
        Metric::new("log_evidence_mean", mean(&recorded.log_evidence)),
        Metric::new("log_evidence_std", standard_deviation(&recorded.log_evidence)),
        Metric::new("log_evidence_reference", log_evidence),
    ];
    if let Some(SmoothedReference { differences: [of_means, of_evidence], .. }) = &references.smoothed {
        found.push(Metric::new("nmse_smoothed_reference", *of_means));
        found.push(Metric::new("log_evidence_reference_difference", *of_evidence));
    }
    found.extend(recorded.report.mean_pareto_k().map(|index| Metric::new("tail_index", index)));
    found
}

/// The error of each coordinate of an epidemic's state, over all times, and how much of it is the spread of single runs.
fn by_state(problem: &Problem, recorded: &Recorded, redrawn: usize) -> Vec<Metric> {
    let truth = problem.truth();
    let (n, horizon) = (truth.width(), truth.len());
    let mut found = Vec::new();
    for (state, name) in Epidemic::STATES.iter().enumerate() {
        let (mut error, mut spread) = (0.0, 0.0);
        for time in 0..horizon {
            let of_runs: Vec<f64> = recorded.coordinate(time, n, state).collect();
            error += (mean(&of_runs) - truth.row(time)[state]).powi(2) / horizon as f64;
            spread += standard_deviation(&of_runs).powi(2) / horizon as f64;
        }
        found.push(Metric::new(&format!("mse_{name}"), error));
        found.push(Metric::new(&format!("run_variance_{name}"), spread));
    }
    found.push(Metric::new("ess", mean(&recorded.effective_sample_sizes)));
    found.push(Metric::new("log_evidence_mean", mean(&recorded.log_evidence)));
    found.push(Metric::new("log_evidence_std", standard_deviation(&recorded.log_evidence)));
    found.push(Metric::new("trajectories_redrawn", redrawn as f64));
    found
}

fn normalised(problem: &Problem, references: &References, recorded: &Recorded) -> Vec<Metric> {
    let truth = problem.truth();
    let (n, last) = (truth.width(), truth.len() - 1);
    let averages: Vec<Vec<f64>> =
        (0..=last).map(|time| average(recorded.at(time, n), n, recorded.filters)).collect();
    let all: f64 = averages.iter().enumerate().map(|(time, mean)| squared_error(mean, truth.row(time))).sum();
    let size: f64 = truth.rows().map(squared_norm).sum();
    let finals = recorded.at(last, n).chunks_exact(n);
    let mut found = vec![
        Metric::new("nmse_final", normalised_error(&averages[last], truth, last)),
        Metric::new(
            "nmse_final_single",
            median(finals.map(|mean| normalised_error(mean, truth, last)).collect()),
        ),
        Metric::new("nmse_all", all / size),
        Metric::new("ess", mean(&recorded.effective_sample_sizes)),
        Metric::new("log_evidence_mean", mean(&recorded.log_evidence)),
        Metric::new("log_evidence_std", standard_deviation(&recorded.log_evidence)),
    ];
    if let Some(exact) = &problem.exact {
        found.push(Metric::new("log_evidence_exact", exact.log_evidence));
    }
    let posteriors = [
        (&references.gaussian, "nmse_posterior", "nmse_posterior_reference"),
        (&references.exact, "nmse_posterior_exact", "nmse_posterior_exact_reference"),
    ];
    for (posterior, error_name, difference_name) in posteriors {
        let Some(PosteriorMean { mean, difference }) = posterior else { continue };
        let error = squared_error(&averages[last], mean) / squared_norm(mean);
        found.push(Metric::new(error_name, error));
        found.extend(difference.map(|difference| Metric::new(difference_name, difference)));
    }
    found
}

impl Recorded {
    /// Nothing yet, of `filters` filters over `horizon` times and `width` coordinates.
    pub(crate) fn with_capacity(filters: usize, horizon: usize, width: usize) -> Self {
        Recorded {
            filters,
            means: Vec::with_capacity(horizon * filters * width),
            effective_sample_sizes: Vec::with_capacity(horizon * filters),
            log_evidence: Vec::with_capacity(filters),
            report: WeightReport::default(),
        }
    }

    /// What the filters said that did not lose all weight: whose estimate of the evidence is not 0.
    pub(crate) fn survivors(&self, width: usize) -> Recorded {
        let survives = |filter: &usize| self.log_evidence[*filter] > f64::NEG_INFINITY;
        let filters: Vec<usize> = (0..self.filters).filter(survives).collect();
        let horizon = self.effective_sample_sizes.len() / self.filters;
        let mut kept = Recorded::with_capacity(filters.len(), horizon, width);
        for time in 0..horizon {
            for filter in &filters {
                kept.means.extend_from_slice(&self.at(time, width)[filter * width..][..width]);
                kept.effective_sample_sizes.push(self.effective_sample_sizes[time * self.filters + filter]);
            }
        }
        kept.log_evidence.extend(filters.iter().map(|filter| self.log_evidence[*filter]));
        Recorded { report: self.report.clone(), ..kept }
    }

    /// One coordinate of each filter's estimate at one time.
    pub(crate) fn coordinate(
        &self,
        time: usize,
        width: usize,
        coordinate: usize,
    ) -> impl Iterator<Item = f64> {
        self.at(time, width).iter().skip(coordinate).step_by(width).copied()
    }

    /// The estimates at one time, `B×N`.
    fn at(&self, time: usize, width: usize) -> &[f64] {
        let block = self.filters * width;
        &self.means[time * block..(time + 1) * block]
    }
}

fn average(rows: &[f64], width: usize, count: usize) -> Vec<f64> {
    let mut sum = vec![0.0; width];
    for row in rows.chunks_exact(width) {
        sum.iter_mut().zip(row).for_each(|(sum, value)| *sum += value / count as f64);
    }
    sum
}

/// `‖estimate − truth_t‖² / ‖truth_t‖²`.
fn normalised_error(estimate: &[f64], truth: &Sequence, time: usize) -> f64 {
    squared_error(estimate, truth.row(time)) / squared_norm(truth.row(time))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::unit::tests::unit;

    #[test]
    fn an_estimate_off_by_a_known_amount_has_a_known_error() {
        let mut problem = Problem::draw(&unit(6, 2, 4)).unwrap();
        let truth = problem.truth().clone();
        // Two filters: one right, one off by 1 in each of 6 coordinates; at time 0 both are right.
        let mut means = [truth.row(0), truth.row(0), truth.row(1)].concat();
        means.extend(truth.row(1).iter().map(|x| x + 1.0));
        let recorded = Recorded {
            filters: 2,
            means,
            effective_sample_sizes: vec![4.0, 2.0, 1.0, 1.0],
            log_evidence: vec![-10.0, -12.0],
            report: WeightReport::default(),
        };
        let exact = problem.exact.as_ref().unwrap().log_evidence;
        let size = |time: usize| truth.row(time).iter().map(|x| x * x).sum::<f64>();
        let expected = [
            ("nmse_final", 1.5 / size(1)),
            ("nmse_final_single", 3.0 / size(1)),
            ("nmse_all", 1.5 / (size(0) + size(1))),
            ("ess", 2.0),
            ("log_evidence_mean", -11.0),
            ("log_evidence_std", 2.0_f64.sqrt()),
            ("log_evidence_exact", exact),
        ];
        let found = metrics(&problem, &References::default(), &recorded);
        assert_eq!(found.len(), expected.len());
        for (found, (name, value)) in found.iter().zip(expected) {
            assert_eq!(found.name, name);
            assert!((found.value - value).abs() < 1e-12 * value.abs().max(1.0), "{name}: {}", found.value);
        }
        // Where the exact means are not those of the true system, estimates are held against its states.
        problem.has_gaussian_noise = false;
        assert_eq!(problem.truth(), &problem.trajectory.states);
    }

    #[test]
    fn errors_of_an_epidemic_are_by_state_and_over_all_times() {
        let mut problem = Problem::draw(&unit(6, 2, 4)).unwrap();
        problem.exact = None;
        problem.judged = ErrorTarget::EachState { redrawn: 3 };
        problem.trajectory.states = Sequence::new(3, vec![1.0, 2.0, 3.0, 4.0, 5.0, 6.0]).unwrap();
        // Two runs at two times: their mean is off by 1 in S at t = 0 and by 2 in R at t = 1; they differ by 2 in I at t = 1.
        let means = vec![2.0, 2.0, 3.0, 2.0, 2.0, 3.0, 4.0, 4.0, 8.0, 4.0, 6.0, 8.0];
        let recorded = Recorded {
            filters: 2,
            means,
            effective_sample_sizes: vec![4.0, 2.0, 1.0, 1.0],
            log_evidence: vec![-10.0, -12.0],
            report: WeightReport::default(),
        };
        let expected = [
            ("mse_S", 0.5),
            ("run_variance_S", 0.0),
            ("mse_I", 0.0),
            ("run_variance_I", 1.0),
            ("mse_R", 2.0),
            ("run_variance_R", 0.0),
            ("ess", 2.0),
            ("log_evidence_mean", -11.0),
            ("log_evidence_std", 2.0_f64.sqrt()),
            ("trajectories_redrawn", 3.0),
        ];
        let found = metrics(&problem, &References::default(), &recorded);
        assert_eq!(found.len(), expected.len());
        for (found, (name, value)) in found.iter().zip(expected) {
            assert_eq!(found.name, name);
            assert!((found.value - value).abs() < 1e-12, "{name}: {}", found.value);
        }
    }
}
