//! The order of rows that come one at a time.

use std::cmp::Ordering;
use std::collections::HashMap;

use super::column::is_named_as_time;
use crate::calendar::Time;

/// Looks whether the carried column of a stream goes forward; it keeps the last time of each series.
#[derive(Debug, Default)]
pub struct RowOrder {
    /// The line and the time of the last row of each series.
    last: HashMap<usize, (u64, Time)>,
    said_back: bool,
    said_same: bool,
}

impl RowOrder {
    /// Takes in the label of a series' next row, of a column of that name. What it says is said once: of a row that is before the one before it, and of one at the same
    /// time.
    pub fn next(&mut self, column: &str, series: usize, line: u64, label: &str) -> Option<String> {
        let time = Time::read(label)?;
        if matches!(time, Time::Number { .. }) && !is_named_as_time(column) {
            return None;
        }
        let (before, last) = self.last.insert(series, (line, time))?;
        let label = label.trim();
        match last.order(&time)? {
            Ordering::Greater if !self.said_back && !begins_again(&last, &time) => {
                self.said_back = true;
                Some(format!(
                    "column {column}: line {line} ({label}) is before line {before}; rows are taken as consecutive time steps, in the order in \
                     which they come"
                ))
            }
            Ordering::Equal if !self.said_same => {
                self.said_same = true;
                Some(format!(
                    "column {column}: line {line} ({label}) repeats line {before}; rows are taken as consecutive time steps"
                ))
            }
            _ => None,
        }
    }
}

/// Whether numbers may be those of hours or months, which begin again at 0 or 1.
fn begins_again(last: &Time, time: &Time) -> bool {
    matches!((last, time), (Time::Number { .. }, Time::Number { value, .. }) if [0.0, 1.0].contains(value))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_is_said_once() {
        let mut order = RowOrder::default();
        let mut next = |series, line, label| order.next("date", series, line, label);
        assert_eq!(next(0, 2, "2024-03-02"), None);
        assert_eq!(next(1, 3, "2024-03-01"), None);
        assert_eq!(next(0, 4, "2024-03-09"), None);
        assert!(next(0, 5, "2024-03-08").unwrap().contains("line 5 (2024-03-08) is before line 4"));
        assert_eq!(next(0, 6, "2024-03-07"), None);
        assert!(next(0, 7, "2024-03-07").unwrap().contains("line 7 (2024-03-07) repeats line 6"));
        assert_eq!([next(0, 8, "2024-03-07"), next(0, 9, "?"), next(0, 10, "")], [None, None, None]);
        assert_eq!(RowOrder::default().next("temperature", 0, 2, "3"), None);
    }
}
