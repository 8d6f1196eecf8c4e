//! Round dates along a stretch of time, for the marks of an axis.

use chrono::{Datelike, NaiveDate};
use motes_formulas::TimeUnit;

use super::numbers::time_of;

/// The date of a label in days since the year 1; none where it is a number, or no time.
pub(crate) fn days_of(label: &str) -> Option<f64> {
    time_of(label, Some(TimeUnit::Day)).ok()
}

/// A distance between marks.
#[derive(Clone, Copy)]
enum Every {
    /// Seconds, which divide a day.
    Seconds(u32),
    Days(u32),
    Months(u32),
    Years(u32),
}

impl Every {
    /// From small to large.
    const ALL: [Every; 27] = [
        Every::Seconds(1),
        Every::Seconds(5),
        Every::Seconds(15),
        Every::Seconds(30),
        Every::Seconds(60),
        Every::Seconds(300),
        Every::Seconds(900),
        Every::Seconds(1800),
        Every::Seconds(3600),
        Every::Seconds(3 * 3600),
        Every::Seconds(6 * 3600),
        Every::Seconds(12 * 3600),
        Every::Days(1),
        Every::Days(2),
        Every::Days(7),
        Every::Months(1),
        Every::Months(2),
        Every::Months(3),
        Every::Months(6),
        Every::Years(1),
        Every::Years(2),
        Every::Years(5),
        Every::Years(10),
        Every::Years(20),
        Every::Years(50),
        Every::Years(100),
        Every::Years(1000),
    ];

    /// About how many days it is.
    fn days(self) -> f64 {
        match self {
            Every::Seconds(seconds) => f64::from(seconds) / 86_400.0,
            Every::Days(days) => f64::from(days),
            Every::Months(months) => f64::from(months) * 30.4,
            Every::Years(years) => f64::from(years) * 365.25,
        }
    }

    /// The marks from one day to another.
    fn marks(self, low: f64, high: f64) -> Vec<f64> {
        let multiples = |every: f64| {
            let first = (low / every).ceil();
            let count = ((high / every).floor() - first).max(-1.0) as usize;
            (0..=count).map(|at| (first + at as f64) * every).filter(|mark| *mark <= high).collect()
        };
        let of_months = |every: i32| -> Vec<f64> {
            let Some(start) = date(low) else { return vec![] };
            let first = (12 * start.year() + start.month0() as i32).div_euclid(every);
            let marks = (first..).map(|number| {
                let month = number * every;
                NaiveDate::from_ymd_opt(month.div_euclid(12), month.rem_euclid(12) as u32 + 1, 1)
            });
            let days = marks.map_while(|mark| mark.map(|mark| f64::from(mark.num_days_from_ce())));
            days.skip_while(|mark| *mark < low).take_while(|mark| *mark <= high).collect()
        };
        match self {
            Every::Seconds(_) | Every::Days(_) => multiples(self.days()),
            Every::Months(months) => of_months(months as i32),
            Every::Years(years) => of_months(12 * years as i32),
        }
    }

    /// A mark as text, as short as it can be told from others.
    fn text(self, mark: f64) -> String {
        let Some(date) = date(mark) else { return mark.to_string() };
        let seconds = ((mark - mark.floor()) * 86_400.0).round() as u32;
        match self {
            Every::Seconds(every) => {
                let (hour, minute, second) = (seconds / 3600, seconds / 60 % 60, seconds % 60);
                match every < 60 {
                    true => format!("{hour:02}:{minute:02}:{second:02}"),
                    false => format!("{:02}-{:02} {hour:02}:{minute:02}", date.month(), date.day()),
                }
            }
            Every::Days(_) => format!("{:04}-{:02}-{:02}", date.year(), date.month(), date.day()),
            Every::Months(_) => format!("{:04}-{:02}", date.year(), date.month()),
            Every::Years(_) => date.year().to_string(),
        }
    }
}

/// The date of a day since the year 1.
fn date(days: f64) -> Option<NaiveDate> {
    // A hair before midnight is rounding.
    let whole = (days + 1e-9).floor();
    (whole.abs() < 1e8).then(|| NaiveDate::from_num_days_from_ce_opt(whole as i32)).flatten()
}

/// At most `most` round dates between two days since the year 1, and what each is called.
pub(crate) fn marks(low: f64, high: f64, most: usize) -> Vec<(f64, String)> {
    let fits = |every: &&Every| (high - low) / every.days() <= most as f64;
    let every = Every::ALL.iter().find(fits).copied().unwrap_or(Every::Years(1000));
    every.marks(low, high).into_iter().map(|mark| (mark, every.text(mark))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn texts(low: &str, high: &str, most: usize) -> Vec<String> {
        let marks = marks(days_of(low).unwrap(), days_of(high).unwrap(), most);
        marks.into_iter().map(|(_, text)| text).collect()
    }

    #[test]
    fn marks_are_round_dates() {
        assert_eq!(texts("1949-05-01", "1960-01-01", 6), ["1950", "1952", "1954", "1956", "1958", "1960"]);
        assert_eq!(texts("2023-11-15", "2024-03-10", 5), ["2023-12", "2024-01", "2024-02", "2024-03"]);
        assert_eq!(
            texts("2024-02-28", "2024-03-02", 5),
            ["2024-02-28", "2024-02-29", "2024-03-01", "2024-03-02"]
        );
        assert_eq!(
            texts("2024-02-29 22:00", "2024-03-01 07:00", 4),
            ["03-01 00:00", "03-01 03:00", "03-01 06:00"]
        );
        assert_eq!(texts("2024-02-29 23:59:50", "2024-03-01 00:00:20", 4), ["00:00:00", "00:00:15"]);
        assert_eq!(texts("2024-03-01", "2024-03-01", 4), ["00:00:00"]);
    }

    #[test]
    fn only_dates_are_dates() {
        assert!(days_of("1871").is_none() && days_of("a").is_none() && days_of("").is_none());
        assert_eq!(days_of("2024-03").unwrap(), days_of("2024-03-01").unwrap());
    }
}
