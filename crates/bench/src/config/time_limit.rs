//! Time limits as Slurm writes them.

use std::fmt;
use std::str::FromStr;

/// A time limit, as it was given.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct TimeLimit {
    text: String,
    /// None: no limit.
    seconds: Option<u64>,
}

impl TimeLimit {
    /// Its seconds; `None` where there is no limit.
    pub fn seconds(&self) -> Option<u64> {
        self.seconds
    }
}

impl fmt::Display for TimeLimit {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(&self.text)
    }
}

impl FromStr for TimeLimit {
    type Err = String;

    /// `M`, `M:S`, `H:M:S`, `D-H`, `D-H:M`, `D-H:M:S`, or that there is none.
    fn from_str(text: &str) -> Result<Self, String> {
        let seconds = match text.to_ascii_uppercase().as_str() {
            "UNLIMITED" | "INFINITE" => Some(None),
            _ => seconds(text).filter(|seconds| *seconds > 0).map(Some),
        };
        let expected = "it must be minutes, minutes:seconds, hours:minutes:seconds, days-hours, days-hours:minutes or UNLIMITED";
        Ok(TimeLimit { text: text.into(), seconds: seconds.ok_or(expected)? })
    }
}

fn seconds(text: &str) -> Option<u64> {
    const UNITS: [u64; 3] = [3600, 60, 1];
    let (days, rest) = match text.split_once('-') {
        Some((days, rest)) => (Some(number(days)?), rest),
        None => (None, text),
    };
    let numbers: Vec<u64> = rest.split(':').map(number).collect::<Option<_>>()?;
    // What the first number counts: hours behind days, else by how many there are.
    let first = match (days, numbers.len()) {
        (Some(_), 1..=3) | (None, 3) => 0,
        (None, 1..=2) => 1,
        _ => return None,
    };
    let parts = numbers.iter().zip(&UNITS[first..]).map(|(number, unit)| number.checked_mul(*unit));
    let days = Some(days.unwrap_or(0).checked_mul(86_400)?);
    parts.chain([days]).try_fold(0_u64, |sum, part| sum.checked_add(part?))
}

fn number(text: &str) -> Option<u64> {
    let is_number = !text.is_empty() && text.bytes().all(|byte| byte.is_ascii_digit());
    is_number.then(|| text.parse().ok()).flatten()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn limits_are_read_as_slurm_reads_them() {
        let seconds = |text: &str| text.parse::<TimeLimit>().map(|limit| limit.seconds());
        for (text, expected) in [
            ("90", 5400),
            ("90:30", 5430),
            ("2:00:00", 7200),
            ("1-12", 129_600),
            ("1-0:30", 88_200),
            ("1-0:0:1", 86_401),
        ] {
            assert_eq!(seconds(text), Ok(Some(expected)), "{text}");
        }
        assert_eq!(seconds("unlimited"), Ok(None));
        for text in ["", "0", "-1", "1:2:3:4", "1-", "one", "1.5", "1:", "99999999999999999999"] {
            assert!(seconds(text).is_err(), "{text}");
        }
    }
}
