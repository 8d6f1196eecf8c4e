//! Numbers on a command line.

use std::ops::RangeInclusive;
use std::str::FromStr;

/// A value parser of integers in a range, for clap.
///
/// # Errors
/// What the parser gives back names the range.
pub fn integer<N: FromStr + PartialOrd + Copy + std::fmt::Display>(
    range: RangeInclusive<N>,
) -> impl Fn(&str) -> Result<N, String> + Clone {
    let (least, most) = range.into_inner();
    move |text| {
        text.parse()
            .ok()
            .filter(|number| (least..=most).contains(number))
            .ok_or_else(|| format!("it must be an integer from {least} to {most}"))
    }
}
