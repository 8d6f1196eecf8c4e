//! The numbers of an experiment file: each in its range, or named.

use super::{Axis, ConfigError, Experiment, Gradient};

/// Checks every number that a run would use, for all profiles.
pub(super) fn check(file: &str, experiment: &Experiment) -> Result<(), ConfigError> {
    let checks = Checks { file };
    let Experiment { axis, methods, system, filter, training, proposals, panels, profiles, .. } = experiment;

    checks.at_least_one("system.neighbours", system.neighbours)?;
    checks.at_least_one("system.dimension", system.dimension)?;
    checks.at_least_one("system.horizon", system.horizon)?;
    let decibels = (-200.0..=200.0).contains(&system.snr_db);
    checks.that(decibels, "system.snr_db", system.snr_db, "it must be a number of dB from -200 to 200")?;
    checks.at_least_one("filter.particles", filter.particles)?;
    let fraction = filter.ess_threshold > 0.0 && filter.ess_threshold <= 1.0;
    checks.that(
        fraction,
        "filter.ess_threshold",
        filter.ess_threshold,
        "it must be above 0 and at most 1",
    )?;
    for (key, value) in [("learning_rate", training.learning_rate), ("epsilon", training.epsilon)] {
        let fine = value > 0.0 && value.is_finite();
        checks.that(fine, &format!("training.{key}"), value, "it must be positive and finite")?;
    }
    for (key, value) in [("beta_1", training.beta_1), ("beta_2", training.beta_2)] {
        // The optimiser computes in 32 bits.
        let fine = (0.0..1.0).contains(&(value as f32));
        checks.that(fine, &format!("training.{key}"), value, "it must be at least 0 and below 1")?;
    }
    match (training.gradient, training.gradient_window) {
        (Gradient::Full, Some(window)) => {
            let expected = "a full gradient has no window: leave it out, or set gradient = \"truncated\"";
            checks.that(false, "training.gradient_window", window, expected)?;
        }
        (Gradient::Truncated, window) => {
            let value = window.map_or("absent".to_string(), |window| window.to_string());
            let expected = "a truncated gradient needs a window of at least 1";
            checks.that(
                window.is_some_and(|window| window > 0),
                "training.gradient_window",
                value,
                expected,
            )?;
        }
        (Gradient::Full, None) => {}
    }
    let clip_norm = training.clip_norm.unwrap_or(1.0);
    let fine = clip_norm > 0.0 && clip_norm.is_finite();
    checks.that(fine, "training.clip_norm", clip_norm, "it must be positive and finite")?;
    proposals.check(&checks)?;

    checks.distinct("methods", methods.iter().map(|method| method.name().to_string()))?;
    checks.distinct("panels", panels.iter().map(|panel| panel.name.clone()))?;
    for panel in panels {
        let key = format!("panels.{}.dimension", panel.name);
        match panel.dimension {
            Some(dimension) => checks.system_of(experiment, dimension, &key)?,
            None => checks.system_of(experiment, system.dimension, "system.dimension")?,
        }
    }
    // Panels differ in N or not at all: units of equal configuration would be one and the same.
    let sizes = panels.iter().map(|panel| panel.dimension.unwrap_or(system.dimension));
    checks.distinct("panels.*.dimension", sizes.map(|dimension| dimension.to_string()))?;
    let one_panel = *axis != Axis::Dimension || panels.len() == 1;
    checks.that(
        one_panel,
        "panels",
        panels.len(),
        "where the x axis is the dimension there must be one panel",
    )?;
    for (name, profile) in profiles {
        let key = |key: &str| format!("profiles.{name}.{key}");
        checks.distinct(&key("x"), profile.x.iter().map(usize::to_string))?;
        for &x in &profile.x {
            checks.at_least_one(&key("x"), x)?;
            if *axis == Axis::Dimension {
                checks.system_of(experiment, x, &key("x"))?;
            }
        }
        checks.at_least_one(&key("repetitions"), profile.repetitions)?;
        checks.at_least_one(&key("filter_runs"), profile.filter_runs)?;
        checks.at_least_one(&key("training_steps"), profile.training_steps)?;
        checks.at_least_one(&key("reference_particles"), profile.reference_particles)?;
        profile.sizes.check(name, &checks)?;
        if let Some(chosen) = &profile.panels {
            checks.distinct(&key("panels"), chosen.iter().cloned())?;
            for panel in chosen {
                let names = panels.iter().map(|panel| panel.name.as_str());
                let known = names.clone().any(|name| name == panel);
                checks.that(known, &key("panels"), panel, &super::one_of(panel, names))?;
            }
        }
    }
    Ok(())
}

/// Checks that name the file.
pub(super) struct Checks<'a> {
    file: &'a str,
}

impl Checks<'_> {
    pub(super) fn that(
        &self,
        fine: bool,
        key: &str,
        value: impl ToString,
        expected: &str,
    ) -> Result<(), ConfigError> {
        if fine {
            return Ok(());
        }
        Err(ConfigError::Key {
            file: self.file.to_string(),
            key: key.to_string(),
            value: value.to_string(),
            expected: expected.to_string(),
        })
    }

    pub(super) fn at_least_one(&self, key: &str, value: usize) -> Result<(), ConfigError> {
        self.that(value > 0, key, value, "it must be at least 1")
    }

    pub(super) fn within(
        &self,
        key: &str,
        value: usize,
        least: usize,
        most: usize,
    ) -> Result<(), ConfigError> {
        let expected = format!("it must be from {least} to {most}");
        self.that((least..=most).contains(&value), key, value, &expected)
    }

    fn distinct(&self, key: &str, values: impl Iterator<Item = String>) -> Result<(), ConfigError> {
        let mut values: Vec<String> = values.collect();
        self.that(!values.is_empty(), key, "empty", "it must have one value or more")?;
        values.sort();
        let twice = values.windows(2).find(|pair| pair[0] == pair[1]);
        self.that(twice.is_none(), key, format!("{values:?}"), "no value may stand twice")
    }

    /// N against what the graph and the measurement matrix need of it.
    fn system_of(&self, experiment: &Experiment, dimension: usize, key: &str) -> Result<(), ConfigError> {
        let system = &experiment.system;
        let enough = dimension > system.neighbours;
        self.that(enough, key, dimension, &format!("N must exceed the {} neighbours", system.neighbours))?;
        let half = 2 * system.unmeasured <= dimension;
        self.that(
            half,
            "system.unmeasured",
            system.unmeasured,
            &format!("it must be at most half of N = {dimension}"),
        )
    }
}
