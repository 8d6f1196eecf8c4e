//! A problem on its way to the reader of the error, who learns the file last.

use super::FileError;
use super::place::Place;
use super::problem::Problem;

/// A section of a model file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(crate) enum Section {
    Series,
    Time,
    Inputs,
    Parameters,
    Initial,
    Definitions,
    Draws,
    Transition,
    Measurement,
}

impl Section {
    pub(crate) const ALL: [Section; 9] = [
        Section::Series,
        Section::Time,
        Section::Inputs,
        Section::Parameters,
        Section::Initial,
        Section::Definitions,
        Section::Draws,
        Section::Transition,
        Section::Measurement,
    ];

    /// Its key.
    pub(crate) fn name(self) -> &'static str {
        self.title().trim_matches(['[', ']'])
    }

    /// How it stands in a file.
    pub(crate) fn title(self) -> &'static str {
        match self {
            Section::Series => "[series]",
            Section::Time => "[time]",
            Section::Inputs => "[inputs]",
            Section::Parameters => "[parameters]",
            Section::Initial => "[initial]",
            Section::Definitions => "[definitions]",
            Section::Draws => "[draws]",
            Section::Transition => "[transition]",
            Section::Measurement => "[measurement]",
        }
    }
}

/// What is wrong, and where as far as is known.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Fault {
    /// A byte of the text that was parsed.
    pub(crate) at: Option<usize>,
    pub(crate) section: Option<Section>,
    pub(crate) key: Option<String>,
    pub(crate) problem: Box<Problem>,
}

impl Fault {
    /// A problem without a place.
    pub(crate) fn new(problem: Problem) -> Fault {
        Fault { at: None, section: None, key: None, problem: Box::new(problem) }
    }

    /// At a byte.
    pub(crate) fn at(at: usize, problem: Problem) -> Fault {
        Fault { at: Some(at), ..Fault::new(problem) }
    }

    /// In a section.
    pub(crate) fn in_section(self, section: Section) -> Fault {
        Fault { section: Some(section), ..self }
    }

    /// At a key.
    pub(crate) fn of_key(self, key: &str) -> Fault {
        Fault { key: Some(key.to_string()), ..self }
    }

    /// The error for the reader; `text` is what the place is counted in.
    pub(crate) fn in_file(self, file: &str, text: &str) -> FileError {
        let place = Place {
            at: self.at.map(|byte| Place::line_and_column(text, byte)),
            section: self.section.map(Section::title),
            key: self.key,
        };
        FileError::Refused { file: file.to_string(), place, problem: self.problem }
    }
}
