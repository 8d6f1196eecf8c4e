//! Numbers that begin again by the calendar or the clock: months after 12, hours after 23.

use super::column::words;

/// The last number of a cycle and the first of the next one, for the words that name them.
const CYCLES: [(&[&str], &[f64], f64); 9] = [
    (&["month", "months", "period"], &[12.0], 1.0),
    (&["quarter", "quarters", "period"], &[4.0], 1.0),
    (&["week", "weeks", "period"], &[52.0, 53.0], 1.0),
    (&["day", "days", "dayofweek"], &[7.0, 28.0, 29.0, 30.0, 31.0, 365.0, 366.0], 1.0),
    (&["day", "days"], &[6.0], 0.0),
    (&["hour", "hours"], &[23.0], 0.0),
    (&["hour", "hours"], &[12.0, 24.0], 1.0),
    (&["minute", "minutes", "second", "seconds"], &[59.0], 0.0),
    (&["minute", "minutes", "second", "seconds"], &[60.0], 1.0),
];

/// Whether numbers of a column of that name count by ones, but for the beginnings of new cycles.
pub(super) fn is_cycle(name: &str, values: &[f64]) -> bool {
    let words: Vec<String> = words(name).collect();
    let named = |names: &[&str]| words.iter().any(|word| names.contains(&word.as_str()));
    let begins_again = |from: f64, to: f64| {
        CYCLES.iter().any(|(names, last, first)| named(names) && last.contains(&from) && to == *first)
    };
    values.windows(2).all(|pair| pair[1] - pair[0] == 1.0 || begins_again(pair[0], pair[1]))
}
