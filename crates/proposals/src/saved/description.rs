//! The description of a proposal: `proposal.toml`, or what the family calls it.

use motes_models::{StateSpaceModel, SystemGraph};
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

use super::fingerprint::Fingerprint;
use crate::family::Family;

/// The version of the folder's layout and of what its entries mean.
pub const SAVED_FORMAT: u32 = 3;

/// The whole file but for its first line.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Description<Config> {
    pub(super) format: u32,
    pub(super) family: String,
    /// T, for an unrolled family.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) horizon: Option<usize>,
    pub(super) proposal: Config,
    /// How it was trained, for people to read.
    pub(super) training: toml::Table,
    pub(super) system: Fingerprint,
}

/// What is read first, whatever else there is.
#[derive(Deserialize)]
struct Head {
    format: u32,
    family: String,
}

impl<Config: Serialize + DeserializeOwned> Description<Config> {
    /// Reads the file.
    pub(super) fn parse(text: &str) -> Result<Self, String> {
        toml::from_str(text).map_err(one_line)
    }
}

impl Description<()> {
    /// The text for a proposal, but for the hash in its first line.
    pub(super) fn of<F: Family>(
        proposal: &F,
        model: &dyn StateSpaceModel,
        graph: Option<&SystemGraph>,
        training: &impl Serialize,
    ) -> Result<String, String> {
        let training = toml::Table::try_from(training)
            .map_err(|error| format!("the training settings cannot be written: {error}"))?;
        let description = Description {
            format: SAVED_FORMAT,
            family: F::NAME.into(),
            horizon: proposal.horizon(),
            proposal: proposal.config().clone(),
            training,
            system: Fingerprint::of(model, graph),
        };
        toml::to_string(&description).map_err(|error| error.to_string())
    }

    /// Format version and family.
    pub(super) fn peek(text: &str) -> Result<(u32, String), String> {
        let Head { format, family } = toml::from_str(text).map_err(one_line)?;
        Ok((format, family))
    }
}

fn one_line(error: toml::de::Error) -> String {
    error.message().lines().collect::<Vec<_>>().join(" ")
}
