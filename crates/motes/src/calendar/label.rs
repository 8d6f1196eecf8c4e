//! The time that a label states.

use std::cmp::Ordering;
use std::str::FromStr;

use chrono::{Datelike, FixedOffset, NaiveDate, NaiveTime, Timelike};

/// What a label says.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Time {
    /// A number, with how many decimals it is written; none where that is not known.
    Number { value: f64, decimals: Option<u32> },
    /// A time of a day, and how far its clock is ahead of UTC, in seconds, where it says so.
    Moment { date: NaiveDate, time: NaiveTime, ahead: Option<i32> },
    /// A month, by its number since the year 0.
    Month(i64),
    /// A quarter, likewise.
    Quarter(i64),
}

impl Time {
    /// Reads a label: a number, a date of ISO 8601 with or without a time and a zone, a month `2024-03` or a quarter `2024Q1`.
    pub(crate) fn read(text: &str) -> Option<Self> {
        let text = text.trim();
        number(text).or_else(|| moment(text)).or_else(|| month(text)).or_else(|| quarter(text))
    }

    /// Numbers of eight or six digits as the dates or months that they may be.
    pub(crate) fn in_digits(text: &str) -> Option<Self> {
        let text = text.trim();
        let is_number = text.bytes().all(|byte| byte.is_ascii_digit());
        // Years that somebody measured in.
        let is_year = |year: i32| (1600..2400).contains(&year);
        match (is_number, text.len()) {
            (true, 8) => {
                let date = date(&format!("{}-{}-{}", &text[..4], &text[4..6], &text[6..]))?;
                is_year(date.year()).then_some(Time::Moment { date, time: NaiveTime::MIN, ahead: None })
            }
            (true, 6) => {
                let date = date(&format!("{}-{}-01", &text[..4], &text[4..]))?;
                is_year(date.year()).then_some(Time::Month(months(date)))
            }
            _ => None,
        }
    }

    /// Which of two is earlier; none where they cannot be compared.
    pub(crate) fn order(&self, other: &Time) -> Option<Ordering> {
        match (self, other) {
            (Time::Number { value: a, .. }, Time::Number { value: b, .. }) => a.partial_cmp(b),
            (Time::Month(a), Time::Month(b)) | (Time::Quarter(a), Time::Quarter(b)) => Some(a.cmp(b)),
            (Time::Moment { ahead: a, .. }, Time::Moment { ahead: b, .. }) if a.is_some() == b.is_some() => {
                Some(self.microseconds()?.cmp(&other.microseconds()?))
            }
            _ => None,
        }
    }

    /// Microseconds since the year 1, in UTC where the zone is known, of a time of a day.
    pub(crate) fn microseconds(&self) -> Option<i128> {
        let Time::Moment { date, time, ahead } = self else { return None };
        let days = i128::from(date.num_days_from_ce());
        let seconds = i128::from(time.num_seconds_from_midnight()) - i128::from(ahead.unwrap_or(0));
        Some((days * 86_400 + seconds) * 1_000_000 + i128::from(time.nanosecond() / 1000))
    }
}

/// The number of a month since the year 0.
pub(crate) fn months(date: NaiveDate) -> i64 {
    i64::from(date.year()) * 12 + i64::from(date.month0())
}

fn number(text: &str) -> Option<Time> {
    let value = text.parse::<f64>().ok().filter(|value| value.is_finite())?;
    let digits = text.trim_start_matches(['+', '-']);
    let is_plain = digits.bytes().all(|byte| byte.is_ascii_digit() || byte == b'.');
    let decimals = digits.split_once('.').map_or(0, |(_, decimals)| decimals.len() as u32);
    Some(Time::Number { value, decimals: is_plain.then_some(decimals) })
}

fn moment(text: &str) -> Option<Time> {
    if !has_year(text) {
        return None;
    }
    // Of an interval, as a week from one day to another, the beginning.
    if let Some((from, _)) = text.split_once('/').filter(|(from, to)| from.len() == 10 && to.len() == 10) {
        return moment(from);
    }
    let text = text.strip_suffix(" UTC").map_or_else(|| text.to_string(), |text| format!("{text}Z"));
    let Some((day, clock)) = text.split_once(['T', 't', ' ']) else {
        let date = date(&text)?;
        return Some(Time::Moment { date, time: NaiveTime::MIN, ahead: None });
    };
    let (date, clock) = (date(day)?, clock.trim());
    let (clock, ahead) = match clock.strip_suffix(['Z', 'z']) {
        Some(clock) => (clock, Some(0)),
        None => match clock.rfind(['+', '-']) {
            Some(at) => (&clock[..at], Some(zone(&clock[at..])?)),
            None => (clock, None),
        },
    };
    let formats = ["%H:%M:%S%.f", "%H:%M", "%H:%M:%S,%f"];
    let time = formats.iter().find_map(|format| NaiveTime::parse_from_str(clock.trim(), format).ok())?;
    Some(Time::Moment { date, time, ahead })
}

/// Whether a text begins with four digits.
fn has_year(text: &str) -> bool {
    text.len() >= 4 && text.bytes().take(4).all(|byte| byte.is_ascii_digit())
}

/// A year of four digits, a month and a day.
fn date(text: &str) -> Option<NaiveDate> {
    let formats = ["%Y-%m-%d", "%Y/%m/%d"];
    match has_year(text) && text.len() <= 10 {
        true => formats.iter().find_map(|format| NaiveDate::parse_from_str(text, format).ok()),
        false => None,
    }
}

/// How far a zone as `+01:00`, `-0330` or `+01` is ahead of UTC, in seconds.
fn zone(text: &str) -> Option<i32> {
    let whole = if text.len() == 3 { format!("{text}:00") } else { text.to_string() };
    FixedOffset::from_str(&whole).ok().map(|zone| zone.local_minus_utc())
}

fn month(text: &str) -> Option<Time> {
    let is_month = text.len() == 7 && matches!(text.as_bytes()[4], b'-' | b'/');
    if !is_month || !text.is_ascii() {
        return None;
    }
    date(&format!("{}-{}-01", &text[..4], &text[5..])).map(|date| Time::Month(months(date)))
}

fn quarter(text: &str) -> Option<Time> {
    let (year, number) = text.split_once(['Q', 'q'])?;
    let year = year.trim_end_matches(['-', ' ', '/']);
    let is_year = year.len() == 4 && year.bytes().all(|byte| byte.is_ascii_digit());
    let number = number.parse::<i64>().ok().filter(|number| (1..=4).contains(number))?;
    is_year.then(|| year.parse::<i64>().ok().map(|year| Time::Quarter(year * 4 + number - 1)))?
}

#[cfg(test)]
mod tests {
    use super::*;

    fn kind(text: &str) -> &'static str {
        match Time::read(text) {
            None => "none",
            Some(Time::Number { .. }) => "number",
            Some(Time::Moment { ahead: None, .. }) => "moment",
            Some(Time::Moment { .. }) => "moment in a zone",
            Some(Time::Month(_)) => "month",
            Some(Time::Quarter(_)) => "quarter",
        }
    }

    #[test]
    fn a_label_is_a_time_in_the_ways_of_iso() {
        for (text, expected) in [
            ("2024-03-01", "moment"),
            (" 2024-03-01 12:00 ", "moment"),
            ("2024-03-01T12:00:05.25", "moment"),
            ("2024/03/01", "moment"),
            ("2024-01-29/2024-02-04", "moment"),
            ("2024-03-01T12:00Z", "moment in a zone"),
            ("2024-03-01 12:00:00+01:00", "moment in a zone"),
            ("2024-03-01 12:00:00-0330", "moment in a zone"),
            ("2024-03-01 12:00:00 UTC", "moment in a zone"),
            ("2024-03-01T12:00+01", "moment in a zone"),
            ("2024-03", "month"),
            ("2024Q1", "quarter"),
            ("2024-Q4", "quarter"),
            ("2024", "number"),
            ("-1.5e3", "number"),
        ] {
            assert_eq!(kind(text), expected, "{text}");
        }
    }

    /// Catches a panic, and a label that is taken for a time which it is not.
    #[test]
    fn what_is_no_time_is_none() {
        let long = "9".repeat(400);
        for text in [
            "2024-01-29/",
            "2024-01-29/2024-02",
            "",
            " ",
            "a",
            "2024-02-30",
            "2024-13",
            "2024-00",
            "2024Q5",
            "2024Q0",
            "Q1",
            "2024Q",
            "é024-01",
            "20é4-01",
            "2024-03-01T25:00",
            "2024-03-01T12:00+99:00",
            "2024-03-01T",
            "99999-01-01",
            "-2024-03-01",
            "01/03/2024",
            "1 may",
            "nan",
            "inf",
            &long,
            "2024-03-01T12:00:00+",
            "2024-03-01 +",
            "T",
            "ééééééé",
            "2024-03-01é",
        ] {
            assert_eq!(kind(text), "none", "{text}");
            let _ = Time::in_digits(text);
        }
        assert_eq!(Time::in_digits("20240230"), None);
        assert_eq!(Time::in_digits("90000101"), None);
        assert!(matches!(Time::in_digits("20240229"), Some(Time::Moment { .. })));
        assert!(matches!(Time::in_digits("202412"), Some(Time::Month(24299))));
    }

    #[test]
    fn zones_are_taken_into_account() {
        let read = |text| Time::read(text).unwrap();
        let (a, b) = (read("2024-03-01 12:00+01:00"), read("2024-03-01T11:00Z"));
        assert_eq!(a.order(&b), Some(Ordering::Equal));
        assert_eq!(read("2024-03-01").order(&b), None);
        assert_eq!(read("2024-03-01").order(&read("2024-03-01 00:01")), Some(Ordering::Less));
    }
}
