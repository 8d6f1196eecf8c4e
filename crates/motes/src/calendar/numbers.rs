//! Times that are written as numbers or dates.

use chrono::{Datelike, NaiveDate, Timelike};
use motes_formulas::TimeUnit;
use thiserror::Error;

use super::label::Time;

/// What is no time.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[error("{value} is no time; {expected}")]
pub struct NoTime {
    /// What stands there.
    pub value: String,
    /// What would be right.
    pub expected: &'static str,
}

const MICROSECONDS_OF_A_DAY: f64 = 86_400e6;

/// The time of a label: a number; or of a date days or weeks since the year 1, or the calendar year with its decimals.
pub(crate) fn time_of(label: &str, unit: Option<TimeUnit>) -> Result<f64, NoTime> {
    let refuse = |expected| {
        let value =
            if label.trim().is_empty() { "an empty cell".to_string() } else { label.trim().to_string() };
        Err(NoTime { value, expected })
    };
    let found = Time::read(label);
    let Some(unit) = unit else {
        return match found {
            Some(Time::Number { value, .. }) => Ok(value),
            Some(_) => refuse("for dates give unit = \"day\", \"week\" or \"year\" in [time]"),
            None => refuse("it must be a number"),
        };
    };
    // Eight digits may be a date.
    let date = Time::in_digits(label).or(found).and_then(date_of);
    let Some((date, microseconds)) = date else {
        let day = label.trim().get(..10).and_then(Time::read);
        if matches!(day, Some(Time::Moment { .. })) {
            return refuse("a time of a day is written 2024-03-01T12:00, and its zone +01:00 or Z");
        }
        return refuse("it must be a date, as 2024-03-01, since [time] has a unit");
    };
    let days = f64::from(date.num_days_from_ce()) + microseconds / MICROSECONDS_OF_A_DAY;
    Ok(match unit {
        TimeUnit::Day => days,
        TimeUnit::Week => days / 7.0,
        TimeUnit::Year => {
            let of_year = f64::from(date.ordinal0()) + microseconds / MICROSECONDS_OF_A_DAY;
            f64::from(date.year()) + of_year / f64::from(days_in_year(date.year()))
        }
    })
}

/// Whether a label that is a date says by which clock, in a zone.
pub(crate) fn has_zone(label: &str) -> Option<bool> {
    match Time::read(label) {
        Some(Time::Moment { ahead, .. }) => Some(ahead.is_some()),
        _ => None,
    }
}

/// The label of a time, as [`time_of`] reads it: a number of at most 12 digits, or a date, with the time of the day where it is not its beginning or `has_zone` asks for it, in UTC.
pub(crate) fn label_of(time: f64, unit: Option<TimeUnit>, has_zone: bool) -> String {
    const MILLISECONDS: f64 = 86_400e3;
    let number = || format!("{time:.11e}").parse::<f64>().unwrap_or(time).to_string();
    let days = match unit {
        None => return number(),
        Some(TimeUnit::Day) => time,
        Some(TimeUnit::Week) => time * 7.0,
        Some(TimeUnit::Year) => {
            let year = time.floor() as i32;
            let Some(start) = NaiveDate::from_ymd_opt(year, 1, 1) else { return number() };
            f64::from(start.num_days_from_ce()) + (time - time.floor()) * f64::from(days_in_year(year))
        }
    };
    let milliseconds = (days * MILLISECONDS).round() as i64;
    let (day, rest) = (milliseconds.div_euclid(86_400_000), milliseconds.rem_euclid(86_400_000));
    let Some(date) = i32::try_from(day).ok().and_then(NaiveDate::from_num_days_from_ce_opt) else {
        return number();
    };
    if rest == 0 && !has_zone {
        return date.to_string();
    }
    let seconds = match rest % 60_000 {
        0 => String::new(),
        part if part % 1000 == 0 => format!(":{:02}", part / 1000),
        part => format!(":{:06.3}", part as f64 / 1000.0),
    };
    let zone = if has_zone { "Z" } else { "" };
    format!("{date}T{:02}:{:02}{seconds}{zone}", rest / 3_600_000, rest / 60_000 % 60)
}

/// Whether two labels are the same time.
pub(crate) fn is_same_time(one: &str, other: &str) -> bool {
    let units = [None, Some(TimeUnit::Day)];
    units.into_iter().any(|unit| match (time_of(one, unit), time_of(other, unit)) {
        (Ok(one), Ok(other)) => (one - other).abs() <= 1e-9 * one.abs().max(1.0),
        _ => false,
    })
}

fn days_in_year(year: i32) -> u32 {
    NaiveDate::from_ymd_opt(year, 12, 31).map_or(365, |date| date.ordinal())
}

/// The day, and the microseconds since its beginning: in UTC where the zone is known.
fn date_of(time: Time) -> Option<(NaiveDate, f64)> {
    let first_of = |months: i64| {
        let year = i32::try_from(months.div_euclid(12)).ok()?;
        NaiveDate::from_ymd_opt(year, months.rem_euclid(12) as u32 + 1, 1).map(|date| (date, 0.0))
    };
    match time {
        Time::Number { .. } => None,
        Time::Month(months) => first_of(months),
        Time::Quarter(quarters) => first_of(3 * quarters),
        Time::Moment { date, time, ahead } => {
            let seconds = i64::from(time.num_seconds_from_midnight()) - i64::from(ahead.unwrap_or(0));
            let date = date.checked_add_signed(chrono::Duration::days(seconds.div_euclid(86_400)))?;
            let seconds = seconds.rem_euclid(86_400) as f64;
            Some((date, seconds * 1e6 + f64::from(time.nanosecond() / 1000)))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dates_are_days_weeks_and_years() {
        let at = |label: &str, unit| time_of(label, Some(unit)).unwrap();
        let days = |label: &str| at(label, TimeUnit::Day);
        assert_eq!(days("2024-03-01") - days("2024-02-28"), 2.0);
        assert_eq!(days("2024-03-01T12:00") - days("2024-03-01"), 0.5);
        // Where the zone is known, clocks that change do not matter.
        let day = days("2024-03-31T12:00+02:00") - days("2024-03-30T12:00+01:00");
        assert!((day - 23.0 / 24.0).abs() < 1e-9);
        assert_eq!(days("2024-01-01T00:30+01:00"), days("2023-12-31T23:30Z"));
        assert!((at("2024-01-22", TimeUnit::Week) - at("2024-01-01", TimeUnit::Week) - 3.0).abs() < 1e-9);
        assert_eq!(at("1950-07-02T12:00", TimeUnit::Year), 1950.5);
        assert_eq!(at("1950-01", TimeUnit::Year), 1950.0);
        assert_eq!(at("2023Q3", TimeUnit::Year), 2023.0 + 181.0 / 365.0);
        assert_eq!(days("20240301"), days("2024-03-01"));
    }

    #[test]
    fn times_that_no_row_has_are_called_as_they_are_read() {
        let of = |label: &str, unit, gap: f64, expected: &str| {
            let time = time_of(label, Some(unit)).unwrap() + gap;
            let found = label_of(time, Some(unit), has_zone(label) == Some(true));
            assert_eq!(found, expected);
            assert!((time_of(&found, Some(unit)).unwrap() - time).abs() < 1e-8);
        };
        of("2024-01-01", TimeUnit::Year, 1.0, "2025-01-01");
        of("2024-03-01", TimeUnit::Week, 1.0, "2024-03-08");
        of("2024-02-28T18:00", TimeUnit::Day, 0.25, "2024-02-29");
        of("2024-02-28T12:00", TimeUnit::Day, 0.25, "2024-02-28T18:00");
        of("2024-02-28T12:00:20", TimeUnit::Day, 10.0 / 86_400.0, "2024-02-28T12:00:30");
        of("2024-02-28T12:00:20", TimeUnit::Day, 0.25 / 86_400.0, "2024-02-28T12:00:20.250");
        of("2024-02-28T12:00+01:00", TimeUnit::Day, 1.0, "2024-02-29T11:00Z");
        assert_eq!(label_of(0.3 + (0.3 - 0.2), None, false), "0.4");
        assert!(is_same_time("2024-01-01", "2024/01/01") && is_same_time("4", "4.0"));
        assert!(!is_same_time("2024-12-31", "2025-01-01") && !is_same_time("a", "a"));
    }

    #[test]
    fn what_is_no_time_is_refused() {
        assert_eq!(time_of(" 1950.25 ", None), Ok(1950.25));
        let line = |label: &str, unit| time_of(label, unit).unwrap_err().to_string();
        assert_eq!(line("", None), "an empty cell is no time; it must be a number");
        assert_eq!(
            line("2024-03-01", None),
            "2024-03-01 is no time; for dates give unit = \"day\", \"week\" or \"year\" in [time]"
        );
        let expected = "12.5 is no time; it must be a date, as 2024-03-01, since [time] has a unit";
        assert_eq!(line("12.5", Some(TimeUnit::Day)), expected);
    }
}
