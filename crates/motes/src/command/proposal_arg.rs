//! A proposal as an argument.

use std::path::PathBuf;
use std::str::FromStr;

use motes::{LearnedProposal, Model, MotesError, ProposalName};

/// A proposal by its name, or the folder that it was learned into.
#[derive(Debug, Clone)]
pub(super) enum ProposalArg {
    Designed(ProposalName),
    Folder(PathBuf),
}

impl FromStr for ProposalArg {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text.parse() {
            Ok(name) => Ok(ProposalArg::Designed(name)),
            Err(_) if std::path::Path::new(text).is_dir() => Ok(ProposalArg::Folder(text.into())),
            Err(reason) => Err(format!("{reason}, and there is no such folder")),
        }
    }
}

impl ProposalArg {
    /// The proposal, read if it is in a folder.
    pub(super) fn of(&self, model: &Model) -> Result<ProposalName, MotesError> {
        match self {
            ProposalArg::Designed(name) => Ok(name.clone()),
            ProposalArg::Folder(folder) => Ok(ProposalName::Learned(LearnedProposal::load(folder, model)?)),
        }
    }
}
