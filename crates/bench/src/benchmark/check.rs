//! The names and numbers of a benchmark's file: each in its range, or named.

use motes::ProposalName;
use motes::train::LearnObjective;
use motes_cli::one_of;
use motes_proposals::HeadConfig;

use super::file::{Benchmark, BenchmarkProfile};
use crate::config::{Checks, ConfigError};

/// The figures of a card that others may have found, too.
pub(super) const FIGURES: [&str; 4] = ["ess_fraction", "log_evidence_gap", "e_l", "e_x"];

pub(super) fn check(file: &str, benchmark: &Benchmark) -> Result<(), ConfigError> {
    let checks = Checks { file };
    let share = |value: f64| value > 0.0 && value <= 1.0;
    let Benchmark { resample_below, defensive, designed, learned, recorded, outside, .. } = benchmark;
    checks.that(
        share(*resample_below),
        "resample_below",
        resample_below,
        "it must be above 0 and at most 1",
    )?;
    if let Some(defensive) = defensive {
        let fine = (0.0..1.0).contains(defensive);
        checks.that(fine, "defensive", defensive, "it must be at least 0 and below 1")?;
    }
    for name in designed {
        if let Err(expected) = name.parse::<ProposalName>() {
            checks.that(false, "designed", name, &expected)?;
        }
    }
    let names = designed.iter().cloned().chain(learned.iter().map(|method| method.name.clone()));
    checks.distinct("designed and learned", names)?;
    for (at, method) in learned.iter().enumerate() {
        let key = format!("learned.{}", method.name);
        let plain = |letter: char| letter.is_ascii_alphanumeric() || letter == '-';
        let fine = !method.name.is_empty() && method.name.chars().all(plain);
        checks.that(
            fine,
            "learned.name",
            &method.name,
            "it must be letters, digits and hyphens: a folder is called so",
        )?;
        if let Some(from) = &method.from {
            let earlier = || learned[..at].iter().map(|earlier| earlier.name.as_str());
            let fine = earlier().any(|earlier| earlier == from);
            checks.that(fine, &format!("{key}.from"), from, &one_of(from, earlier()))?;
        }
        for (what, value) in [("dropout", method.dropout), ("weight_penalty", method.weight_penalty)] {
            let below = if what == "dropout" { 1.0 } else { f64::INFINITY };
            let expected = "it must be at least 0, and a dropout below 1";
            checks.that((0.0..below).contains(&value), &format!("{key}.{what}"), value, expected)?;
        }
        if let Some(Err(error)) = method.head.map(|head| head.head(2)) {
            checks.that(false, &format!("{key}.head"), format!("{:?}", method.head), &error.to_string())?;
        }
        let is_mixture = matches!(method.head, Some(HeadConfig::Mixture { .. }));
        let fine = method.objective != LearnObjective::Fivo || !is_mixture;
        let expected = "draws of a mixture have no derivatives: take a gaussian, a kernel or a flow";
        checks.that(fine, &format!("{key}.head"), "a mixture", expected)?;
        let fine = !method.objective.needs_recorded() || recorded.is_some();
        let expected = "it learns from recorded sequences: the file needs [recorded]";
        checks.that(fine, &format!("{key}.objective"), method.objective, expected)?;
    }
    if let Some(recorded) = recorded {
        let fine = recorded.data.is_some() != (recorded.sequences > 0);
        let expected = "there must be a file of data or a number of sequences, and not both";
        checks.that(fine, "recorded.sequences", recorded.sequences, expected)?;
        let fine = recorded.data.is_none() || recorded.set.is_empty();
        checks.that(fine, "recorded.set", "there", "data of a file are not drawn from a model")?;
    }
    for found in outside {
        let fine = FIGURES.contains(&found.figure.as_str());
        checks.that(fine, "outside.figure", &found.figure, &one_of(&found.figure, FIGURES))?;
        checks.that(found.value.is_finite(), "outside.value", found.value, "it must be finite")?;
    }
    for (name, profile) in &benchmark.profiles {
        let BenchmarkProfile { updates, further_updates, times, sequences, particles, .. } = *profile;
        let key = |key: &str| format!("profiles.{name}.{key}");
        for (what, count) in [
            ("updates", updates),
            ("further_updates", further_updates),
            ("sequences", sequences),
            ("particles", particles),
            ("reference_particles", profile.reference_particles),
            ("reference_filters", profile.reference_filters),
        ] {
            checks.count(&key(what), count)?;
        }
        checks.within(&key("times"), times, 2, 1_000_000)?;
        if let Some(error) = profile.reference_error {
            checks.that(error > 0.0, &key("reference_error"), error, "it must be greater than 0")?;
            let several = profile.reference_filters > 1;
            checks.that(
                several,
                &key("reference_filters"),
                1,
                "one filter has no standard error: 2 or more",
            )?;
        }
        for &k in &profile.equal_time {
            checks.count(&key("equal_time"), k)?;
        }
        let ascending = profile.equal_time.windows(2).all(|pair| pair[0] < pair[1]);
        let text = format!("{:?}", profile.equal_time);
        checks.that(ascending, &key("equal_time"), text, "it must grow from one number to the next")?;
    }
    Ok(())
}
