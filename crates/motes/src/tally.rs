//! What filters of all series say beside their estimates, added up as they go.

use motes_models::StepRecord;
use motes_smc::{EvidenceWarning, Verdict, WeightDiagnosis, WeightReport};

use crate::engine::Running;
use crate::estimate::{Estimate, Forecast};
use crate::exact::ExactEvidence;
use crate::filtered::Filtered;
use crate::model::Model;
use crate::options::{FilterOptions, ProposalName};
use crate::warning::Warning;

/// Standard errors by which a log-evidence may be off before it differs from the exact one, and the same in nats: at least, and at most or without an error.
const ERRORS: f64 = 4.0;
const LEAST_DIFFERENCE: f64 = 1.0;
const MOST_DIFFERENCE: f64 = 5.0;

/// What a filter of one series says, as far as it has come.
pub struct SeriesTally<'m> {
    report: WeightReport,
    exact: Option<ExactEvidence<'m>>,
}

impl<'m> SeriesTally<'m> {
    /// Before the first row.
    pub fn new(model: &'m Model, options: &FilterOptions) -> Self {
        let is_beside = options.check && options.proposal != ProposalName::Exact;
        let exact = if is_beside { ExactEvidence::beside(model, options.particles) } else { None };
        SeriesTally { report: WeightReport::default(), exact }
    }
}

/// What filters of all series say.
#[derive(Debug, Clone)]
pub struct Tally {
    weights: WeightReport,
    least_ess: Option<f64>,
    log_evidence: Vec<f64>,
    standard_errors: Vec<Option<f64>>,
    exact: Vec<Option<f64>>,
    opinions: Vec<Option<Verdict>>,
    warnings: Vec<Warning>,
}

impl Tally {
    /// Before the first series, with what is to be said whatever filters find.
    pub fn new(warnings: Vec<Warning>) -> Self {
        Tally {
            weights: WeightReport::default(),
            least_ess: None,
            log_evidence: vec![],
            standard_errors: vec![],
            exact: vec![],
            opinions: vec![],
            warnings,
        }
    }

    /// Takes in a row of a series, by the steps that lead to it.
    pub fn step(
        &mut self,
        series: &mut SeriesTally<'_>,
        steps: &[StepRecord],
        measurement: &[Option<f64>],
        diagnosis: Option<&WeightDiagnosis>,
    ) {
        if let Some(diagnosis) = diagnosis {
            series.report.add(diagnosis);
            self.weights.add(diagnosis);
            let size = diagnosis.effective_sample_size;
            self.least_ess = Some(self.least_ess.map_or(size, |least| least.min(size)));
        }
        // Where a matrix cannot be factored, or there are too many states, there is no exact answer.
        if series.exact.as_mut().is_some_and(|exact| !exact.row(steps, measurement)) {
            series.exact = None;
        }
    }

    /// Takes in what is to be said after the last row of a series, whose name it is; `measured` says what was measured at a time, and what the data call it.
    pub fn end_series(
        &mut self,
        name: Option<&str>,
        series: &SeriesTally<'_>,
        running: &Running<'_>,
        measured: impl Fn(usize) -> TimeLabel,
    ) {
        let (log_evidence, standard_error) = (running.log_evidence(), running.standard_error());
        let exact = series.exact.as_ref().map(ExactEvidence::log_evidence);
        let warning = |text: String| Warning { series: name.map(String::from), text };
        let at = |step: usize| measured(step).named(step);
        let of_weights = series.report.warnings().map(|found| warning(found.describe(&at)));
        self.warnings.extend(of_weights);
        let states = running.states();
        let of_evidence = running.evidence_warnings();
        self.warnings
            .extend(of_evidence.iter().map(|found| warning(of_evidence_warning(found, states, &at))));
        if let Some((exact, by)) = exact.zip(series.exact.as_ref().map(ExactEvidence::name)) {
            let most = standard_error
                .map_or(MOST_DIFFERENCE, |error| (ERRORS * error).clamp(LEAST_DIFFERENCE, MOST_DIFFERENCE));
            let difference = log_evidence - exact;
            if difference.abs() > most {
                self.warnings.push(warning(format!(
                    "the log-evidence is off by {difference:.1}: {by}, which is exact for this model, has {exact:.3}; take \
                     --proposal exact"
                )));
            }
        }
        self.warnings.extend(running.missed().map(|nats| {
            warning(format!(
                "the filter misses mass: the log-evidence of a bootstrap filter is {nats:.1} larger; take --proposal bootstrap, or another that agrees with it"
            ))
        }));
        let verdict = running.verdict();
        self.warnings.extend(of_opinion(name, verdict, running.difference(), at));
        self.opinions.push(verdict);
        self.log_evidence.push(log_evidence);
        self.standard_errors.push(standard_error);
        self.exact.push(exact);
    }

    /// More that is to be said.
    pub fn warn(&mut self, warnings: impl IntoIterator<Item = Warning>) {
        self.warnings.extend(warnings);
    }

    /// All of it, beside estimates and forecasts.
    pub fn into_filtered(self, estimates: Vec<Estimate>, forecasts: Vec<Vec<Forecast>>) -> Filtered {
        Filtered {
            estimates,
            forecasts,
            log_evidence_per_series: self.log_evidence,
            standard_error_per_series: self.standard_errors,
            exact_log_evidence_per_series: self.exact,
            weights: self.weights,
            least_ess: self.least_ess,
            warnings: self.warnings,
            opinions: self.opinions,
            particles: vec![],
        }
    }
}

/// What the data call a time, and what was measured then.
#[derive(Debug, Clone, Default)]
pub struct TimeLabel {
    /// The time of the row, where it is known; it is that of the step else.
    pub time: Option<f64>,
    /// What the data call the time.
    pub label: Option<String>,
    /// The measurements that are there, with their names.
    pub values: Vec<(String, f64)>,
}

impl TimeLabel {
    /// The time, for people: `t = 30 (1901, flow = 3.2)`.
    fn named(&self, step: usize) -> String {
        /// Measurements that are named.
        const MOST: usize = 3;
        let values = self.values.iter().take(MOST).map(|(name, value)| format!("{name} = {value}"));
        // A label that is the time is said once.
        let label =
            self.label.iter().filter(|label| label.trim().parse().ok() != self.time || self.time.is_none());
        let known: Vec<String> = label.cloned().chain(values).collect();
        let more = if self.values.len() > MOST { ", …" } else { "" };
        let time = self.time.map_or(step.to_string(), |time| time.to_string());
        match known.is_empty() {
            true => format!("t = {time}"),
            false => format!("t = {time} ({}{more})", known.join(", ")),
        }
    }
}

/// A warning about evidence or a state in the words of the model and the data.
fn of_evidence_warning(warning: &EvidenceWarning, states: &[String], at: &dyn Fn(usize) -> String) -> String {
    match warning {
        EvidenceWarning::Surprise { steps, worst, best, usual } => {
            let more = if *steps > 1 { format!("; {steps} times in all") } else { String::new() };
            format!(
                "at {} the measurement lies beyond all particles (its log-density is {best:.1} at most, where {usual:.1} is usual{more}): the model \
                 does not expect it, and the log-evidence is too low; correct it if it is wrong, else give the state or the measurement heavier \
                 tails",
                at(*worst)
            )
        }
        EvidenceWarning::LargeError { .. } => {
            format!("{warning}; take more particles, or a proposal that sees the measurement")
        }
        EvidenceWarning::FewAncestors { coordinate, step, since, ancestors } => {
            let particles =
                if *ancestors < 1.5 { "one particle".into() } else { format!("{ancestors:.0} particles") };
            format!(
                "state {} hardly moves by itself, and at {} its values descend from {particles} of {}: its standard deviation and quantiles are \
                 too narrow from there on; give it noise, or make it a parameter",
                states[*coordinate],
                at(*step),
                at(*since)
            )
        }
    }
}

/// What a bootstrap filter beside another says against it, if it does; `larger` is by how much its log-evidence of all steps is larger, and `at` what the data call
/// a time.
fn of_opinion(
    series: Option<&str>,
    verdict: Option<Verdict>,
    larger: f64,
    at: impl FnOnce(usize) -> String,
) -> Option<Warning> {
    let Some(Verdict::Warns { first_step, difference, error }) = verdict else { return None };
    // What has less evidence in all is no better, even if it was once.
    let bootstrap = if larger > 0.0 { "--proposal bootstrap, " } else { "" };
    let text = format!(
        "from {} on the filter misses mass: the log-evidence of a bootstrap filter is {difference:.1} ± {error:.1} larger; take {bootstrap}more \
         particles, or a larger --defensive share",
        at(first_step)
    );
    Some(Warning { series: series.map(String::from), text })
}
