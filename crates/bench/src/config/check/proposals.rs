//! What has to hold of the settings and sizes of learned families.

use motes_proposals::Origin;

use super::super::checks::Checks;
use super::super::error::ConfigError;
use super::super::proposals::{Proposals, Sizes};

/// The largest width of a layer.
const LARGEST: usize = 65_536;

impl Proposals {
    pub(in crate::config) fn check(&self, checks: &Checks<'_>) -> Result<(), ConfigError> {
        let Proposals { fcnn, rnn, gnn, gnn_short_steps, psi, standardised } = self;
        let ridges = [("fcnn", fcnn.ridge), ("rnn", rnn.ridge), ("psi", psi.ridge)];
        for (family, ridge) in ridges.into_iter().chain(gnn.iter().map(|gnn| ("gnn", gnn.ridge))) {
            let fine = ridge >= 0.0 && ridge.is_finite();
            let key = format!("proposals.{family}.ridge");
            checks.that(fine, &key, ridge, "it must be at least 0 and finite")?;
        }
        checks.within("proposals.rnn.depth", rnn.depth, 1, 64)?;
        if let Some(gnn) = gnn {
            checks.within("proposals.gnn.order", gnn.order, 0, 64)?;
        }
        if let Some(steps) = gnn_short_steps {
            checks.positive_in_32_bits("proposals.gnn-short-steps.learning_rate", steps.learning_rate)?;
        }
        if let Some(standardised) = standardised {
            let key = "proposals.standardised.trajectories";
            checks.within(key, standardised.trajectories, 1, 100_000)?;
            let anchored = standardised.origin == Origin::Prediction;
            let expected = "methods with -anchored have that origin; there are mean, mean-at-each-time";
            checks.that(!anchored, "proposals.standardised.origin", "prediction", expected)?;
        }
        Ok(())
    }
}

impl Sizes {
    pub(in crate::config) fn check(&self, profile: &str, checks: &Checks<'_>) -> Result<(), ConfigError> {
        let key = |family: &str| format!("profiles.{profile}.sizes.{family}");
        let gnn = self.gnn.iter().map(|widths| ("gnn", widths));
        for (family, widths) in [("fcnn", &self.fcnn)].into_iter().chain(gnn) {
            let fine = !widths.is_empty() && widths.iter().all(|width| (1..=LARGEST).contains(width));
            let expected = "it must be one or more widths from 1 to 65536";
            checks.that(fine, &key(family), format!("{widths:?}"), expected)?;
        }
        checks.within(&key("rnn"), self.rnn, 1, LARGEST)?;
        checks.within(&key("psi"), self.psi, 1, 1024)
    }
}
