//! What has to hold of an epidemic, and of what only epidemics have.

use motes_cli::one_of;

use super::super::checks::Checks;
use super::super::error::ConfigError;
use super::super::schema::{Axis, Epidemic, Experiment};

impl Checks<'_> {
    pub(in crate::config) fn epidemic(
        &self,
        experiment: &Experiment,
        epidemic: &Epidemic,
    ) -> Result<(), ConfigError> {
        let key = |name: &str| format!("epidemic.{name}");
        let Epidemic { infection_rate, removal_rate, time_step, .. } = *epidemic;
        let rates =
            [("infection_rate", infection_rate), ("removal_rate", removal_rate), ("time_step", time_step)];
        for (name, rate) in rates {
            let fine = rate >= 0.0 && rate.is_finite();
            self.that(fine, &key(name), rate, "it must be at least 0 and finite")?;
        }
        for mean in epidemic.initial_means {
            self.that(mean.is_finite(), &key("initial_means"), mean, "it must be finite")?;
        }
        for (name, value) in [
            ("initial_variance", epidemic.initial_variance),
            ("state_variance", epidemic.state_variance),
            ("measurement_variance", epidemic.measurement_variance),
            ("largest_state", epidemic.largest_state),
        ] {
            let fine = value > 0.0 && value.is_finite();
            self.that(fine, &key(name), value, "it must be positive and finite")?;
        }
        self.count(&key("horizon"), epidemic.horizon)?;
        // N is what it is; and with another T another trajectory may be the first that does not run away, so that repetitions
        // would not be paired.
        let expected = "the x axis of an epidemic is the number of particles";
        let name = if experiment.axis == Axis::Dimension { "dimension" } else { "horizon" };
        self.that(experiment.axis == Axis::Particles, "axis", name, expected)?;
        if let Some(reference) = &experiment.reference {
            self.within("reference.smoother_lag", reference.smoother_lag, 1, epidemic.horizon)?;
        }
        self.series(experiment, epidemic)?;
        self.one_x(experiment)?;
        self.printed(experiment)
    }

    fn series(&self, experiment: &Experiment, epidemic: &Epidemic) -> Result<(), ConfigError> {
        let Some(series) = &experiment.series else { return Ok(()) };
        let known = Epidemic::STATES.contains(&series.state.as_str());
        self.that(known, "series.state", &series.state, &one_of(&series.state, Epidemic::STATES))?;
        for window @ [first, last] in &series.windows {
            let fine = first < last && *last <= epidemic.horizon;
            let expected =
                format!("it must be two times, the first before the last, up to {}", epidemic.horizon);
            self.that(fine, "series.windows", format!("{window:?}"), &expected)?;
        }
        let some = !series.windows.is_empty();
        self.that(some, "series.windows", "empty", "it must have one window or more")
    }

    /// A reference does not depend on how many particles others have, and a figure over time shows one number of them.
    fn one_x(&self, experiment: &Experiment) -> Result<(), ConfigError> {
        let has_references = experiment.methods.iter().any(|method| method.is_reference());
        if !has_references && experiment.series.is_none() {
            return Ok(());
        }
        for (name, profile) in &experiment.profiles {
            let expected =
                "it must be one number of particles where there are reference methods or a [series]";
            let x = format!("{:?}", profile.x);
            self.that(profile.x.len() == 1, &format!("profiles.{name}.x"), x, expected)?;
        }
        Ok(())
    }

    fn printed(&self, experiment: &Experiment) -> Result<(), ConfigError> {
        let metrics = Epidemic::STATES.map(|state| format!("mse_{state}"));
        for (method, values) in &experiment.printed {
            let key = format!("printed.{}", method.name());
            let expected = "the experiment does not have this method";
            self.that(experiment.methods.contains(method), &key, "there", expected)?;
            for (metric, value) in values {
                let expected = one_of(metric, metrics.iter().map(String::as_str));
                self.that(metrics.contains(metric), &key, metric, &expected)?;
                let fine = *value >= 0.0 && value.is_finite();
                self.that(fine, &format!("{key}.{metric}"), value, "it must be at least 0 and finite")?;
            }
        }
        Ok(())
    }
}
