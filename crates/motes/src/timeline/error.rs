//! What can be wrong with the time or the inputs of a row.

use thiserror::Error;

use crate::calendar::NoTime;

/// Why a row gives no step.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum TimelineError {
    /// The time of a row cannot be read.
    #[error(transparent)]
    NoTime(#[from] NoTime),
    /// A row is earlier than the one before.
    #[error("{time} comes after {before}; within a series times increase")]
    Backwards {
        /// Its time.
        time: String,
        /// That of the row before.
        before: String,
    },
    /// The first row is earlier than the start.
    #[error("the first row is at {time}, before the start of [time] at {start}")]
    BeforeStart {
        /// Its time.
        time: String,
        /// The start.
        start: String,
    },
    /// Some times have a zone, and others do not.
    #[error(
        "{label} has {this} zone, and a row before has {other}: which is earlier is not known; write a zone, as +01:00 or Z, in all rows or in none"
    )]
    Zones {
        /// The time.
        label: String,
        /// `a` or `no`.
        this: &'static str,
        /// `none` or `one`.
        other: &'static str,
    },
    /// The time of a row has a zone and that of the start has none, or the other way round.
    #[error("{label} has {this} zone, and start = \"{start}\" of [time] has {other}")]
    StartZone {
        /// The time of the row.
        label: String,
        /// That of the start.
        start: String,
        /// `a` or `no`.
        this: &'static str,
        /// `none` or `one`.
        other: &'static str,
    },
    /// A gap has more sub-steps than anybody waits for.
    #[error(
        "the gap of {gap} before this row has {sub_steps:.0} sub-steps of {step}, more than 1000000; a longer step in [time], or another unit?"
    )]
    SubSteps {
        /// The time since the row before.
        gap: f64,
        /// How many there would be.
        sub_steps: f64,
        /// Their length.
        step: f64,
    },
    /// An input is missing where it is needed.
    #[error("the input {input} has no value here, and {place} needs it")]
    Missing {
        /// The input.
        input: String,
        /// Who needs it.
        place: &'static str,
    },
    /// An input was missing in a row before, whose value holds in this step.
    #[error(
        "the input {input} has no value {rows} before {row}, and {place} needs it in the step to this row"
    )]
    MissingBefore {
        /// The input.
        input: String,
        /// How far before: `in the row`, or `2 rows`.
        rows: String,
        /// Before which row: `this one`, or its time where it is ahead.
        row: String,
        /// Who needs it.
        place: &'static str,
    },
    /// An input is needed before the first row.
    #[error(
        "the input {input} is needed before it has a value, in the step to this row; give it one by first = … in [inputs]"
    )]
    NoFirst {
        /// The input.
        input: String,
    },
    /// An input is needed at a time that its file does not have.
    #[error(transparent)]
    BeyondFile(Box<BeyondFile>),
    /// The times of a file have zones, and those of the rows have none, or the other way round.
    #[error(
        "{file} has times with {own} zone, and the rows have times with {of_rows} zone: which is earlier is not known; write zones in both or in none"
    )]
    FileZones {
        /// The file.
        file: String,
        /// `a` or `no`.
        own: &'static str,
        /// `a` or `no`.
        of_rows: &'static str,
    },
    /// A file has nothing for a series.
    #[error("{file} has {}", of_series(series))]
    NoSeries {
        /// The file.
        file: String,
        /// The series.
        series: String,
    },
    /// A measurement is of the time since the row before, and there is none.
    #[error(
        "{entry} looks back at the sub-steps since the row before, and there are none; give the time of x_0 by start = … in [time], or leave the cell empty"
    )]
    NoStepBefore {
        /// The measurement.
        entry: String,
    },
    /// An input is missing in a row ahead.
    #[error("the input {input} has no value at {time}, a row of --inputs")]
    MissingAhead {
        /// The input.
        input: String,
        /// The time of the row as it is written, or `t = 7`.
        time: String,
    },
    /// Inputs ahead are not known.
    #[error("the input {input} is not known ahead; give its values by --inputs")]
    Ahead {
        /// The input.
        input: String,
    },
    /// Inputs of a simulation are not known.
    #[error(
        "the model has the input {input}; give its values by --inputs, or simulate = \"normal(0, 1)\" in [inputs]"
    )]
    Simulated {
        /// The input.
        input: String,
    },
}

impl TimelineError {
    /// Says how far the rows of the series go, where a file of inputs ends before them.
    pub(crate) fn go_on_to(&mut self, time: &str) {
        if let TimelineError::BeyondFile(beyond) = self
            && beyond.is_after
        {
            // A table writes 7.0 where a file has 7.
            let number = time.trim().parse::<f64>().map(|number| number.to_string());
            let time = number.unwrap_or_else(|_| time.trim().to_string());
            beyond.on_to = format!(", and the rows go on to {time}");
        }
    }

    /// The column of data that it is about; none where there is none. `column_of` has those that inputs come from, and `clock` is that of times.
    pub(crate) fn column(
        &self,
        column_of: impl Fn(&str) -> Option<String>,
        clock: Option<&String>,
    ) -> Option<String> {
        let found = match self {
            TimelineError::Missing { input, .. }
            | TimelineError::MissingBefore { input, .. }
            | TimelineError::NoFirst { input } => column_of(input),
            TimelineError::NoStepBefore { entry } => Some(entry.clone()),
            _ => None,
        };
        found.or_else(|| clock.cloned())
    }
}

/// An input is needed at a time that its file does not have.
#[derive(Debug, Clone, PartialEq, Error)]
#[error(
    "{file} has {input} from {first} to {last}, and {time} is needed{lag}{on_to}; give it more rows, or beyond = \"hold\" in [inputs], which takes its first and its last value there"
)]
pub struct BeyondFile {
    /// The file.
    pub file: String,
    /// The input.
    pub input: String,
    /// The first time of the file, as it is written.
    pub first: String,
    /// The last time of the file.
    pub last: String,
    /// The time that is needed.
    pub time: String,
    /// By how much that is earlier than the step, in words, if it is.
    pub lag: String,
    /// Whether that is after the last one.
    pub is_after: bool,
    /// How far the rows behind go, in words, if that is after the last one and there are such.
    pub on_to: String,
}

/// What is said of a time that has a zone, or has none, beside others that are the other way round: `a` zone and `none`, or `no` zone and `one`.
pub(super) fn zone_words(has: bool) -> [&'static str; 2] {
    if has { ["a", "none"] } else { ["no", "one"] }
}

/// What a file of inputs lacks.
fn of_series(series: &str) -> String {
    match series.is_empty() {
        true => "a column of series, and the data have none".to_string(),
        false => format!("no rows of series {series}"),
    }
}
