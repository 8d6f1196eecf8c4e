//! What a column of labels is as a whole.

use crate::calendar::Time;

/// What kind of times a column has.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in super::super) enum Kind {
    /// Numbers, which may be times or anything else.
    Numbers,
    /// Dates, with times of the day or without.
    Dates,
    Months,
    Quarters,
}

/// The labels of all rows, read.
#[derive(Debug, Clone, PartialEq)]
pub(in super::super) struct Times {
    pub(in super::super) kind: Kind,
    /// What each row says; none where it says nothing, or no time as the others.
    pub(in super::super) of_rows: Vec<Option<Time>>,
}

/// What a label is for the column: zones are there for all rows or for none.
fn kind_of(time: &Time) -> (Kind, bool) {
    match time {
        Time::Number { .. } => (Kind::Numbers, false),
        Time::Moment { ahead, .. } => (Kind::Dates, ahead.is_some()),
        Time::Month(_) => (Kind::Months, false),
        Time::Quarter(_) => (Kind::Quarters, false),
    }
}

impl Times {
    /// Reads a column. It has times where all that is there is a number, or two thirds of the rows at least are dates, months or quarters of one kind.
    pub(in super::super) fn of(labels: &[&str]) -> Option<Self> {
        if labels.iter().all(|label| Time::in_digits(label).is_some()) {
            let times: Vec<Option<Time>> = labels.iter().map(|label| Time::in_digits(label)).collect();
            let kinds = times.iter().flatten().map(kind_of).collect::<Vec<_>>();
            if kinds.windows(2).all(|pair| pair[0] == pair[1]) {
                return kinds.first().map(|(kind, _)| Times { kind: *kind, of_rows: times });
            }
        }
        let read: Vec<Option<Time>> = labels.iter().map(|label| Time::read(label)).collect();
        let count = |kind| read.iter().flatten().filter(|time| kind_of(time) == kind).count();
        let kinds = [
            (Kind::Numbers, false),
            (Kind::Dates, false),
            (Kind::Dates, true),
            (Kind::Months, false),
            (Kind::Quarters, false),
        ];
        let (most, kind) =
            kinds.into_iter().map(|kind| (count(kind), kind)).max_by_key(|(count, _)| *count)?;
        let is_there = |label: &&&str| !label.trim().is_empty();
        let is_one = match kind.0 {
            // Numbers among texts are no times.
            Kind::Numbers => most > 0 && most == labels.iter().filter(is_there).count(),
            _ => most >= 2 && 3 * most >= 2 * labels.len(),
        };
        let of_kind = |time: Option<Time>| time.filter(|time| kind_of(time) == kind);
        is_one.then(|| Times { kind: kind.0, of_rows: read.into_iter().map(of_kind).collect() })
    }
}

/// Words that name times.
const NAMES: [&str; 24] = [
    "date",
    "datetime",
    "day",
    "days",
    "hour",
    "hours",
    "index",
    "minute",
    "minutes",
    "month",
    "months",
    "period",
    "quarter",
    "quarters",
    "second",
    "seconds",
    "step",
    "t",
    "time",
    "timestamp",
    "week",
    "weeks",
    "year",
    "years",
];

/// The words of a column's name, in small letters.
pub(super) fn words(name: &str) -> impl Iterator<Item = String> {
    name.split(|letter: char| !letter.is_alphanumeric()).map(str::to_lowercase)
}

/// Whether a column is called a time: `date`, `Day`, `obs_time`.
pub(in super::super) fn is_named_as_time(name: &str) -> bool {
    words(name).any(|word| NAMES.contains(&word.as_str()))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn kind(labels: &str) -> Option<Kind> {
        Times::of(&labels.split(',').collect::<Vec<_>>()).map(|times| times.kind)
    }

    #[test]
    fn a_column_is_what_most_of_its_rows_are() {
        assert_eq!(kind("2024-01-01,2024-01-02 12:00,2024-01-03"), Some(Kind::Dates));
        assert_eq!(kind("2024-01-01,2024-01-02,?"), Some(Kind::Dates));
        assert_eq!(kind("2024-01-01,,"), None);
        assert_eq!(kind("2024-01,2024-02"), Some(Kind::Months));
        assert_eq!(kind("20240131,20240201"), Some(Kind::Dates));
        assert_eq!(kind("20240131,20241301"), Some(Kind::Numbers));
        assert_eq!(kind("1871,1872,"), Some(Kind::Numbers));
        assert_eq!(kind("1871,a"), None);
        assert_eq!([kind("a,b"), kind("")], [None, None]);
        assert_eq!(kind("2024-01-01T00:00Z,2024-01-02"), None);
    }

    #[test]
    fn a_name_says_that_a_column_is_a_time() {
        for name in ["date", "Year", "obs_time", "t", "Day of study"] {
            assert!(is_named_as_time(name), "{name}");
        }
        for name in ["temperature", "animal", "", "birthday", "sometimes"] {
            assert!(!is_named_as_time(name), "{name}");
        }
    }
}
