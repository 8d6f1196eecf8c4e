//! What has to hold of the settings of learning once.

use super::super::checks::Checks;
use super::super::error::ConfigError;
use super::super::learning::Learning;
use super::super::method::Method;
use super::super::schema::{Axis, Experiment};

impl Checks<'_> {
    pub(in crate::config) fn learning(
        &self,
        experiment: &Experiment,
        learning: &Learning,
    ) -> Result<(), ConfigError> {
        let key = |name: &str| format!("learning.{name}");
        self.within(&key("horizon"), learning.horizon, 2, 1_000_000)?;
        for (name, count) in [
            ("rows", learning.rows),
            ("elbo.particles", learning.elbo.particles),
            ("elbo.sequences", learning.elbo.sequences),
            ("elbo.steps_for_one", learning.elbo.steps_for_one),
            ("elbo.trajectories", learning.elbo.trajectories),
        ] {
            self.within(&key(name), count, 1, 1_000_000)?;
        }
        let rate = learning.learning_rate;
        let fine = rate as f32 > 0.0 && (rate as f32).is_finite();
        self.that(fine, &key("learning_rate"), rate, "it must be positive and finite in 32 bits")?;
        if let Some(largest) = learning.largest_state {
            let fine = largest > 0.0 && largest.is_finite();
            self.that(fine, &key("largest_state"), largest, "it must be positive and finite")?;
        }
        for (name, head) in [("head", Some(learning.head)), ("exact_head", learning.exact_head)] {
            if let Some(Err(error)) = head.map(|head| head.head(1)) {
                self.that(false, &key(name), format!("{head:?}"), &error.to_string())?;
            }
        }
        // rnn and psi are made in units of trajectories of that length.
        let longest = match experiment.axis {
            Axis::Horizon => experiment.profiles.values().flat_map(|profile| &profile.x).max().copied(),
            Axis::Particles | Axis::Dimension => experiment.sizes().map(|(_, horizon)| horizon),
        };
        let longest = longest.unwrap_or_default();
        let expected =
            format!("sequences that are filtered have up to {longest} times, and it must be as many");
        self.that(learning.horizon >= longest, &key("horizon"), learning.horizon, &expected)?;
        let regularised = [experiment.training.dropout, experiment.training.weight_penalty];
        let expected = "what is learned once has neither dropout nor a penalty here";
        let none = regularised.iter().all(Option::is_none);
        self.that(none, "training", "there", expected)?;
        for method in experiment.methods.iter().filter(|method| !can_be_learned_once(method)) {
            let expected = "what is learned once is fcnn, rnn, gnn or psi";
            self.that(false, "methods", method.name(), expected)?;
        }
        Ok(())
    }
}

/// Whether it is a family as it is, or not learned.
fn can_be_learned_once(method: &Method) -> bool {
    !method.is_anchored() && *method != Method::GnnShortSteps
}
