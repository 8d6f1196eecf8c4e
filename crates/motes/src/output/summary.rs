//! A run in a few figures, and what it was made with.

use motes_smc::{LARGEST_ERROR, Verdict};

use crate::filtered::Filtered;
use crate::options::{FilterOptions, ProposalName};

/// The standard error of a log-evidence behind it, as ` ± 0.123`; one above 10 is an extrapolation, of which no more is told.
pub fn plus_minus(error: f64) -> String {
    match error > LARGEST_ERROR {
        true => format!(" ± more than {LARGEST_ERROR}"),
        false => format!(" ± {error:.3}"),
    }
}

/// The figures of a filter over so many times, a name and a value each; `has_series` says whether its series have names.
pub fn filter_summary(
    times: usize,
    has_series: bool,
    filtered: &Filtered,
    options: &FilterOptions,
) -> Vec<(String, String)> {
    let k = options.particles;
    let error = match filtered.standard_error() {
        Some(_) if options.proposal == ProposalName::Exact => ", exact".to_string(),
        Some(error) => plus_minus(error),
        None if options.check => " (too few particles for a standard error)".to_string(),
        None => " (its standard error was not asked for)".to_string(),
    };
    let evidence = match filtered.log_evidence() {
        evidence if evidence.is_nan() => "none, of an average over draws".to_string(),
        evidence => format!("{evidence:.3}{error}"),
    };
    let mut figures = vec![("log-evidence", evidence), ("times", times.to_string())];
    let exact: Option<f64> = filtered.exact_log_evidence_per_series.iter().copied().sum();
    if let Some(exact) = exact {
        figures.insert(1, ("exact", format!("{exact:.3}")));
    }
    if let Some((mean, least)) = filtered.weights.effective_sample_size().zip(filtered.least_ess) {
        figures.push(("effective sample size", format!("{mean:.0} of {k}, {least:.0} at least")));
    }
    if has_series {
        figures.insert(1, ("series", filtered.log_evidence_per_series.len().to_string()));
    }
    if let Some(index) = filtered.weights.pareto_k() {
        figures.push(("Pareto k", format!("{index:.2}")));
    }
    if let Some(said) = opinion(&filtered.opinions) {
        figures.push(("second opinion", said));
    }
    figures.into_iter().map(|(name, value)| (name.to_string(), value)).collect()
}

/// What bootstrap filters beside the filters of all series say, in a few words; none where none ran.
fn opinion(opinions: &[Option<Verdict>]) -> Option<String> {
    let said: Vec<&Verdict> = opinions.iter().flatten().collect();
    let count = |which: fn(&Verdict) -> bool| said.iter().filter(|verdict| which(verdict)).count();
    let against = count(|verdict| matches!(verdict, Verdict::Warns { .. }));
    let without = count(|verdict| matches!(verdict, Verdict::NoOpinion { .. }));
    let (unjudged, steps) = said.iter().fold((0, 0), |(unjudged, steps), verdict| match verdict {
        Verdict::NoOpinion { unjudged: of_this, steps: all, .. } => (unjudged + of_this, steps + all),
        _ => (unjudged, steps),
    });
    let of_all = |number: usize| {
        if said.len() > 1 { format!(" for {number} of {} series", said.len()) } else { String::new() }
    };
    match said.len() {
        0 => None,
        _ if against > 0 => Some(format!("against it{}", of_all(against))),
        _ if without > 0 => Some(format!(
            "none{}: {unjudged} of {steps} times are too hard for a bootstrap filter",
            of_all(without)
        )),
        _ => Some("agrees".into()),
    }
}

/// The share that was asked for, or what there is where none was.
fn defensive_share(options: &FilterOptions) -> String {
    match (options.defensive, &options.proposal) {
        (None, ProposalName::Linearised) => "0, or 0.1 where noise is drawn that is not normal".into(),
        _ => options.defensive_share().to_string(),
    }
}

/// What a filter of the model of that file or name was made with, a name and a value each; `set` are parameters that were given other values.
pub fn filter_settings(model: &str, set: &[(String, f64)], options: &FilterOptions) -> Vec<(String, String)> {
    let mut settings = vec![
        ("model".to_string(), model.to_string()),
        ("proposal".into(), options.proposal.to_string()),
        ("particles".into(), options.particles.to_string()),
        ("defensive share".into(), defensive_share(options)),
        ("resample below".into(), options.resample_below.to_string()),
        ("resampling".into(), format!("{:?}", options.resampling).to_lowercase()),
        ("seed".into(), options.seed.to_string()),
    ];
    settings.extend(set.iter().map(|(name, value)| (format!("--set {name}"), value.to_string())));
    settings
}
