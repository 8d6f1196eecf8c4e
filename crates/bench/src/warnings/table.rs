//! Tables of what was silent and what was warned of.

use super::runs::Run;

/// A log-evidence that is off by more than this is wrong, and by less than the other sound (nats).
const WRONG: f64 = 5.0;
const SOUND: f64 = 1.0;

/// Standard errors within which a wrong log-evidence is honest.
const HONEST: f64 = 3.0;

/// The ratio of a standard deviation and the exact one from which on it is wrong, and up to which it is sound.
const WRONG_DEVIATION: f64 = 1.5;
const SOUND_DEVIATION: f64 = 1.25;

/// The warning that is about standard deviations, and not about the log-evidence.
const OF_DEVIATIONS: &str = "ancestors";

impl Run {
    fn is_wrong(&self) -> bool {
        self.error.abs() > WRONG
    }

    fn warns(&self) -> bool {
        !self.warnings.is_empty()
    }

    /// Within so many standard errors of the exact value.
    fn is_within(&self, errors: f64) -> bool {
        self.standard_error.is_some_and(|error| self.error.abs() <= errors * error)
    }

    /// Whether it is wrong, and neither a warning nor its standard error says so.
    pub(super) fn is_silent(&self) -> bool {
        self.is_wrong() && !self.warns() && !self.is_within(HONEST)
    }

    /// Whether the log-evidence is right.
    fn is_near(&self) -> bool {
        self.error.abs() < SOUND
    }

    /// Whether something is said of the log-evidence.
    fn warns_of_evidence(&self) -> bool {
        self.warnings.split('+').any(|warning| !warning.is_empty() && warning != OF_DEVIATIONS)
    }

    fn warns_of_deviations(&self) -> bool {
        self.warnings.split('+').any(|warning| warning == OF_DEVIATIONS)
    }

    fn has_deviation(&self, holds: impl Fn(f64) -> bool) -> bool {
        self.deviation_ratio.is_some_and(holds)
    }
}

/// Figures of some runs.
struct Row {
    wrong: usize,
    silent: usize,
    near: usize,
    near_warned: usize,
    near_warned_of_evidence: usize,
    unwarned: usize,
    within: [usize; 2],
}

impl Row {
    fn of<'r>(runs: impl Iterator<Item = &'r Run> + Clone) -> Self {
        let count = |of: &dyn Fn(&Run) -> bool| runs.clone().filter(|run| of(run)).count();
        Row {
            wrong: count(&Run::is_wrong),
            silent: count(&Run::is_silent),
            near: count(&Run::is_near),
            near_warned: count(&|run| run.is_near() && run.warns()),
            near_warned_of_evidence: count(&|run| run.is_near() && run.warns_of_evidence()),
            unwarned: count(&|run| !run.warns()),
            within: [2.0, 3.0].map(|errors| count(&|run| !run.warns() && run.is_within(errors))),
        }
    }

    fn cells(&self) -> String {
        [
            share(self.silent, self.wrong),
            share(self.near_warned, self.near),
            share(self.near_warned_of_evidence, self.near),
            share(self.within[0], self.unwarned),
            share(self.within[1], self.unwarned),
        ]
        .join(" | ")
    }
}

/// A share in per cent, and of how many.
fn share(part: usize, whole: usize) -> String {
    match whole {
        0 => "–".to_string(),
        _ => format!("{:.1} % of {whole}", 100.0 * part as f64 / whole as f64),
    }
}

const HEADER: &str = "silent, of those off by > 5 | warned, of those off by < 1 | warned of the evidence, of these | \
                      within 2 errors, of those without a warning | within 3";

/// Tables of all runs: by half, then by model and by particles.
pub(super) fn table(runs: &[Run]) -> String {
    let mut text = format!("| models | {HEADER} |\n|---|--:|--:|--:|--:|--:|\n");
    let halves = distinct(runs.iter().map(|run| run.half.as_str()));
    for half in &halves {
        let row = Row::of(runs.iter().filter(|run| run.half == *half));
        text += &format!("| {half} | {} |\n", row.cells());
    }
    for half in &halves {
        text += &format!("\n## {half}\n\n| model | {HEADER} |\n|---|--:|--:|--:|--:|--:|\n");
        let of_half = || runs.iter().filter(|run| run.half == *half);
        for model in distinct(of_half().map(|run| run.model.as_str())) {
            let row = Row::of(of_half().filter(|run| run.model == model));
            text += &format!("| {model} | {} |\n", row.cells());
        }
        text += &format!("\n| proposal, K | {HEADER} |\n|---|--:|--:|--:|--:|--:|\n");
        for proposal in distinct(of_half().map(|run| run.proposal.as_str())) {
            let mut sizes: Vec<usize> = of_half().map(|run| run.particles).collect();
            sizes.sort_unstable();
            sizes.dedup();
            for size in sizes {
                let chosen = of_half().filter(|run| run.proposal == proposal && run.particles == size);
                text += &format!("| {proposal}, {size} | {} |\n", Row::of(chosen).cells());
            }
        }
    }
    text + &deviations(runs)
}

/// Standard deviations of the last state beside the exact ones, in the models that have them.
fn deviations(runs: &[Run]) -> String {
    let mut text = format!(
        "\n## Standard deviations of the last state\n\n\
         | model | no warning, of those off by a factor > {WRONG_DEVIATION} | warned of ancestors, of those within {SOUND_DEVIATION} |\n\
         |---|--:|--:|\n"
    );
    let known = || runs.iter().filter(|run| run.deviation_ratio.is_some());
    for model in distinct(known().map(|run| run.model.as_str())) {
        let count = |of: &dyn Fn(&Run) -> bool| {
            known().filter(|run| run.model == model).filter(|run| of(run)).count()
        };
        let is_wrong = |run: &Run| run.has_deviation(|ratio| ratio > WRONG_DEVIATION);
        let is_sound = |run: &Run| run.has_deviation(|ratio| ratio <= SOUND_DEVIATION);
        text += &format!(
            "| {model} | {} | {} |\n",
            share(count(&|run| is_wrong(run) && !run.warns()), count(&is_wrong)),
            share(count(&|run| is_sound(run) && run.warns_of_deviations()), count(&is_sound))
        );
    }
    text
}

/// Each name once, in order of appearance.
fn distinct<'r>(names: impl Iterator<Item = &'r str>) -> Vec<&'r str> {
    let mut found: Vec<&str> = Vec::new();
    for name in names {
        if !found.contains(&name) {
            found.push(name);
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    fn run(error: f64, standard_error: f64, warnings: &str, deviation_ratio: Option<f64>) -> Run {
        Run {
            half: "set".into(),
            model: "level".into(),
            proposal: "bootstrap".into(),
            particles: 100,
            run: 0,
            error,
            standard_error: Some(standard_error),
            deviation_ratio,
            warnings: warnings.into(),
            key: String::new(),
        }
    }

    #[test]
    fn a_wrong_run_is_silent_without_a_warning_and_without_an_honest_error() {
        let silent = |error, standard_error, warnings| run(error, standard_error, warnings, None).is_silent();
        assert!(silent(-6.0, 1.0, "") && silent(f64::NEG_INFINITY, 1.0, ""));
        assert!(!silent(-6.0, 2.1, "") && !silent(-6.0, 1.0, "few") && !silent(-4.9, 0.1, ""));
    }

    #[test]
    fn shares_are_of_what_they_are_said_to_be_of() {
        let runs = [
            run(-6.0, 1.0, "", None),
            run(-6.0, 1.0, "few", None),
            run(0.1, 0.2, "", None),
            run(0.5, 0.2, "ancestors", Some(2.0)),
            run(0.5, 0.2, "few+ancestors", Some(1.1)),
        ];
        let found = table(&runs);
        let first = "| set | 50.0 % of 2 | 66.7 % of 3 | 33.3 % of 3 | 50.0 % of 2 | 50.0 % of 2 |";
        assert!(found.contains(first), "{found}");
        assert!(found.ends_with("| level | 0.0 % of 1 | 100.0 % of 1 |\n"), "{found}");
    }
}
