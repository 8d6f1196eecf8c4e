//! Steps of dates in units of the calendar.

use chrono::{Datelike, NaiveDate};

use crate::calendar::{Time, months};

/// The dates of times that have all the same time of the day, as their own clocks show it: with them, days are days also where clocks change.
pub(super) fn dates(times: &[Time]) -> Option<Vec<NaiveDate>> {
    let mut clock = None;
    let date = |time: &Time| match time {
        Time::Moment { date, time, .. } => (*clock.get_or_insert(*time) == *time).then_some(*date),
        _ => None,
    };
    times.iter().map(date).collect()
}

/// The numbers of days.
pub(super) fn in_days(dates: &[NaiveDate]) -> Vec<i64> {
    dates.iter().map(|date| i64::from(date.num_days_from_ce())).collect()
}

/// The numbers of months, if each date stands for a month: the same day in all of them, the last days, or the first. No month has two dates.
pub(super) fn in_months(dates: &[NaiveDate]) -> Option<Vec<i64>> {
    let latest = dates.iter().map(Datelike::day).max()?;
    let last = |date: &NaiveDate| u32::from(date.num_days_in_month());
    let is_same = dates.iter().all(|date| date.day() == latest.min(last(date)));
    // A weekend may be before the last day of a month, or after the first.
    let is_end = dates.iter().all(|date| date.day() + 3 >= last(date));
    let is_start = dates.iter().all(|date| date.day() <= 4);
    let numbers: Vec<i64> = dates.iter().map(|date| months(*date)).collect();
    let has_two = dates
        .windows(2)
        .zip(numbers.windows(2))
        .any(|(dates, numbers)| numbers[0] == numbers[1] && dates[0] != dates[1]);
    ((is_same || is_end || is_start) && !has_two).then_some(numbers)
}

/// The numbers of days from Monday to Friday, if there are no others, weekends are passed over, and most steps go to the next one.
pub(super) fn in_working_days(dates: &[NaiveDate]) -> Option<Vec<i64>> {
    const WEEK: i64 = 5;
    let number = |date: &NaiveDate| {
        let in_week = i64::from(date.weekday().num_days_from_monday());
        let week = (i64::from(date.num_days_from_ce()) - in_week).div_euclid(7);
        (in_week < WEEK).then_some(week * WEEK + in_week)
    };
    let numbers: Vec<i64> = dates.iter().map(number).collect::<Option<_>>()?;
    let pairs = || dates.windows(2).zip(numbers.windows(2));
    let next = pairs().filter(|(_, numbers)| numbers[1] - numbers[0] == 1).count();
    let passes_weekends =
        pairs().any(|(dates, numbers)| numbers[1] - numbers[0] == 1 && (dates[1] - dates[0]).num_days() == 3);
    (passes_weekends && 2 * next > numbers.len() - 1).then_some(numbers)
}
