//! The labels that go on where those of rows end.

use chrono::{Datelike, Days, NaiveDate};

use super::label::{Time, months};

/// So many rows tell that they have equal steps.
const FEWEST: usize = 3;

/// The last day that each month has.
const LAST_OF_ALL: u32 = 28;

/// So many labels after those of a series, written alike: of whole numbers or dates with equal steps, and where rows count as steps whatever the `calendar` says, of months and quarters.
/// None of others.
pub(crate) fn following(labels: &[&str], count: usize, calendar: bool) -> Option<Vec<String>> {
    let times: Vec<Time> = labels.iter().map(|label| Time::read(label)).collect::<Option<_>>()?;
    let ahead = || 1..=count as i64;
    let of_places = |place: &dyn Fn(&Time) -> Option<i64>, write: &dyn Fn(i64) -> Option<String>| {
        let places: Vec<i64> = times.iter().map(place).collect::<Option<_>>()?;
        let step = equal_step(&places)?;
        let last = *places.last()?;
        ahead()
            .map(|number| write(last.checked_add(step.checked_mul(number)?)?))
            .collect::<Option<Vec<String>>>()
    };
    let separator = |at: usize| labels[0].trim().as_bytes().get(at).map(|byte| char::from(*byte));
    match times.first()? {
        Time::Number { .. } => {
            let whole = |time: &Time| match time {
                Time::Number { value, decimals: Some(0) } if value.abs() < 1e15 => Some(*value as i64),
                _ => None,
            };
            of_places(&whole, &|number| Some(number.to_string()))
        }
        Time::Month(_) | Time::Quarter(_) if !calendar => None,
        Time::Month(_) => {
            let of = |time: &Time| if let Time::Month(months) = time { Some(*months) } else { None };
            let between = separator(4)?;
            of_places(&of, &|months| {
                Some(format!("{:04}{between}{:02}", months.div_euclid(12), months.rem_euclid(12) + 1))
            })
        }
        Time::Quarter(_) => {
            let of = |time: &Time| if let Time::Quarter(quarters) = time { Some(*quarters) } else { None };
            // What stands between the year and the number of the quarter.
            let between =
                labels[0].trim().get(4..)?.trim_end_matches(|c: char| c.is_ascii_digit()).to_string();
            of_places(&of, &|quarters| {
                Some(format!("{:04}{between}{}", quarters.div_euclid(4), quarters.rem_euclid(4) + 1))
            })
        }
        Time::Moment { date: first, .. } => {
            let is_day = |label: &&str| label.trim().len() == 10;
            if !labels.iter().all(is_day) {
                return None;
            }
            let between = separator(4)?;
            let write = |date: NaiveDate| {
                format!("{:04}{between}{:02}{between}{:02}", date.year(), date.month(), date.day())
            };
            let of_day = |time: &Time| match time {
                Time::Moment { date, .. } => Some(i64::from(date.num_days_from_ce())),
                _ => None,
            };
            let day = |days: i64| {
                let start = NaiveDate::from_ymd_opt(1, 1, 1)?;
                start.checked_add_days(Days::new(u64::try_from(days - 1).ok()?)).map(write)
            };
            let of_month = |time: &Time| match time {
                Time::Moment { date, .. } if date.day() == first.day() => Some(months(*date)),
                _ => None,
            };
            let month = |months: i64| {
                let year = i32::try_from(months.div_euclid(12)).ok()?;
                NaiveDate::from_ymd_opt(year, months.rem_euclid(12) as u32 + 1, first.day()).map(write)
            };
            let by_months =
                || if calendar && first.day() <= LAST_OF_ALL { of_places(&of_month, &month) } else { None };
            of_places(&of_day, &day).or_else(by_months)
        }
    }
}

/// The step between numbers, where it is the same between all of them and above 0.
fn equal_step(numbers: &[i64]) -> Option<i64> {
    let step = numbers.get(1)? - numbers[0];
    let is_equal = numbers.windows(2).all(|pair| pair[1] - pair[0] == step);
    (numbers.len() >= FEWEST && is_equal && step > 0).then_some(step)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn labels_go_on_as_they_are_written() {
        for (labels, expected) in [
            (["1968", "1969", "1970"], ["1971", "1972"]),
            (["-2", "0", "2"], ["4", "6"]),
            (["2024-02-27", "2024-02-28", "2024-02-29"], ["2024-03-01", "2024-03-02"]),
            (["2024/02/15", "2024/02/22", "2024/02/29"], ["2024/03/07", "2024/03/14"]),
            (["2023-10-01", "2023-11-01", "2023-12-01"], ["2024-01-01", "2024-02-01"]),
            (["2023-10", "2023-11", "2023-12"], ["2024-01", "2024-02"]),
            (["2023Q2", "2023Q3", "2023Q4"], ["2024Q1", "2024Q2"]),
            (["2023-Q2", "2023-Q4", "2024-Q2"], ["2024-Q4", "2025-Q2"]),
        ] {
            assert_eq!(
                following(&labels, 2, true).as_deref(),
                Some(expected.map(String::from).as_slice()),
                "{labels:?}"
            );
        }
    }

    #[test]
    fn what_has_no_equal_steps_is_not_continued() {
        for labels in [
            ["2024-03-01", "2024-03-04", "2024-03-05"], // a weekend
            ["2024-01-31", "2024-02-29", "2024-03-31"], // ends of months
            ["2024-03-01T12:00", "2024-03-02T12:00", "2024-03-03T12:00"],
            ["1.5", "2.5", "3.5"],
            ["3", "2", "1"],
            ["a", "b", "c"],
        ] {
            assert_eq!(following(&labels, 2, true), None, "{labels:?}");
        }
        // Months are no equal steps of a clock.
        assert_eq!(following(&["2023-10", "2023-11", "2023-12"], 2, false), None);
        assert_eq!(following(&["1969", "1970"], 2, true), None);
        assert_eq!(following(&[], 2, true), None);
    }
}
