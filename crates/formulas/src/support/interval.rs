//! Sets of numbers that a measurement can be in.

use std::fmt;

/// An end of an interval.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct End {
    /// Where it is.
    pub at: f64,
    /// Whether it belongs to the interval.
    pub is_in: bool,
}

/// The numbers that a measurement can be.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Support {
    /// The whole numbers from 0 on.
    Counts {
        /// The largest of them, if there is one.
        most: Option<f64>,
    },
    /// The whole numbers from one on to another.
    Integers {
        /// The smallest of them, if there is one.
        least: Option<f64>,
        /// The largest of them, if there is one.
        most: Option<f64>,
    },
    /// All numbers between two ends.
    Interval {
        /// The lower end; none where it goes down without end.
        low: Option<End>,
        /// The upper end; none where it goes up without end.
        high: Option<End>,
    },
}

impl Support {
    /// Whether a number is one of them, exactly: 0.9999999999 is no count.
    pub fn has(&self, value: f64) -> bool {
        match *self {
            Support::Counts { most } => {
                value >= 0.0 && value.fract() == 0.0 && most.is_none_or(|most| value <= most)
            }
            Support::Integers { least, most } => {
                value.fract() == 0.0
                    && least.is_none_or(|least| value >= least)
                    && most.is_none_or(|most| value <= most)
            }
            Support::Interval { low, high } => {
                let is_above = |end: End| value > end.at || (end.is_in && value == end.at);
                let is_below = |end: End| value < end.at || (end.is_in && value == end.at);
                low.is_none_or(is_above) && high.is_none_or(is_below)
            }
        }
    }
}

/// In words: `a count is a whole number from 0 to 10`.
impl fmt::Display for Support {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Support::Counts { most: None } => formatter.write_str("a count is a whole number, 0 or more"),
            Support::Counts { most: Some(0.0) } => formatter.write_str("it can only be 0"),
            Support::Counts { most: Some(1.0) } => formatter.write_str("it can only be 0 or 1"),
            Support::Counts { most: Some(most) } => {
                write!(formatter, "a count is a whole number from 0 to {}", Digits(most))
            }
            Support::Integers { least, most } => {
                formatter.write_str("it is a whole number")?;
                least.map_or(Ok(()), |least| write!(formatter, ", {} or more", Digits(least)))?;
                most.map_or(Ok(()), |most| write!(formatter, ", {} or less", Digits(most)))
            }
            Support::Interval { low: None, high: None } => formatter.write_str("it can be any number"),
            Support::Interval { low: Some(low), high: Some(high) } => {
                let words = |end: End| if end.is_in { "" } else { " (not itself)" };
                write!(
                    formatter,
                    "it must lie from {}{} to {}{}",
                    Digits(low.at),
                    words(low),
                    Digits(high.at),
                    words(high)
                )
            }
            Support::Interval { low: Some(End { at, is_in }), high: None } => {
                write!(formatter, "it must be {} {}", if is_in { "at least" } else { "above" }, Digits(at))
            }
            Support::Interval { low: None, high: Some(End { at, is_in }) } => {
                write!(formatter, "it must be {} {}", if is_in { "at most" } else { "below" }, Digits(at))
            }
        }
    }
}

/// A number with all its digits, and not hundreds of zeros.
pub(crate) struct Digits(pub(crate) f64);

impl fmt::Display for Digits {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.0 == 0.0 || (1e-5..1e16).contains(&self.0.abs()) {
            true => write!(formatter, "{}", self.0),
            false => write!(formatter, "{:e}", self.0),
        }
    }
}
