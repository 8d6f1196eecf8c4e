//! The series that rows belong to, as they appear.

use std::collections::HashMap;

/// The series so far, in order of appearance, with the number of rows of each.
#[derive(Default)]
pub(super) struct SeenSeries {
    series: Vec<(String, usize)>,
    /// The number of each series by its name.
    numbers: HashMap<String, usize>,
}

impl SeenSeries {
    /// The number of the series of that name, which is new if it was not there.
    pub(super) fn number_of(&mut self, name: &str) -> usize {
        if let Some(number) = self.numbers.get(name) {
            return *number;
        }
        let number = self.series.len();
        self.numbers.insert(name.into(), number);
        self.series.push((name.into(), 0));
        number
    }

    /// How many rows a series has.
    pub(super) fn times(&self, series: usize) -> usize {
        self.series[series].1
    }

    /// One more row of it.
    pub(super) fn add(&mut self, series: usize) {
        self.series[series].1 += 1;
    }

    pub(super) fn names(&self) -> impl Iterator<Item = &str> {
        self.series.iter().map(|(name, _)| name.as_str())
    }
}
