//! One line for a value of an experiment file that cannot be: which key, which value, what would be right.

use super::error::ConfigError;

/// As many as can be counted one by one.
const MOST: usize = 1_000_000_000;

/// Checks that name the file.
pub(crate) struct Checks<'a> {
    pub(crate) file: &'a str,
}

impl Checks<'_> {
    pub(crate) fn that(
        &self,
        fine: bool,
        key: &str,
        value: impl ToString,
        expected: &str,
    ) -> Result<(), ConfigError> {
        if fine {
            return Ok(());
        }
        Err(ConfigError::Key {
            file: self.file.to_string(),
            key: key.to_string(),
            value: value.to_string(),
            expected: expected.to_string(),
        })
    }

    /// A number of things that are counted one by one, or have a place in memory.
    pub(crate) fn count(&self, key: &str, value: usize) -> Result<(), ConfigError> {
        self.that(value > 0, key, value, "it must be at least 1")?;
        self.that(value <= MOST, key, value, &format!("it must be at most {MOST}"))
    }

    pub(crate) fn within(
        &self,
        key: &str,
        value: usize,
        least: usize,
        most: usize,
    ) -> Result<(), ConfigError> {
        let expected = format!("it must be from {least} to {most}");
        self.that((least..=most).contains(&value), key, value, &expected)
    }

    /// One value or more, all different.
    pub(crate) fn distinct(
        &self,
        key: &str,
        values: impl Iterator<Item = String>,
    ) -> Result<(), ConfigError> {
        let mut values: Vec<String> = values.collect();
        self.that(!values.is_empty(), key, "empty", "it must have one value or more")?;
        values.sort();
        let twice = values.windows(2).find(|pair| pair[0] == pair[1]);
        self.that(twice.is_none(), key, format!("{values:?}"), "no value may stand twice")
    }
}
