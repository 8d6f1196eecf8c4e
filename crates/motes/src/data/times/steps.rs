//! How far apart the times of consecutive rows are.

use super::calendar::{dates, in_days, in_months, in_working_days};
use crate::calendar::Time;

/// What steps are counted in.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Unit {
    /// Numbers have no unit.
    Numbers,
    Seconds,
    Days,
    /// Days from Monday to Friday.
    WorkingDays,
    Months,
    Quarters,
}

/// The steps from row to row.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Steps {
    pub(super) unit: Unit,
    pub(super) lengths: Vec<f64>,
    /// Decimals of numbers, the most that one has; none where that is not known.
    decimals: Option<u32>,
    /// The largest number.
    largest: f64,
}

/// Differences of whole numbers, which may be as far apart as such can be.
fn differences(numbers: &[i64]) -> Vec<f64> {
    numbers.windows(2).map(|pair| (i128::from(pair[1]) - i128::from(pair[0])) as f64).collect()
}

impl Steps {
    /// The steps between times of one kind; none where one is of another.
    pub(super) fn of(times: &[Time]) -> Option<Self> {
        let whole = |unit, numbers: &[i64]| Steps::new(unit, differences(numbers));
        match times.first()? {
            Time::Number { .. } => Steps::of_numbers(times),
            Time::Month(_) => {
                let number = |time: &Time| if let Time::Month(number) = time { Some(*number) } else { None };
                Some(whole(Unit::Months, &times.iter().map(number).collect::<Option<Vec<_>>>()?))
            }
            Time::Quarter(_) => {
                let number =
                    |time: &Time| if let Time::Quarter(number) = time { Some(*number) } else { None };
                Some(whole(Unit::Quarters, &times.iter().map(number).collect::<Option<Vec<_>>>()?))
            }
            Time::Moment { .. } => {
                let Some(dates) = dates(times) else {
                    let instants = times.iter().map(Time::microseconds).collect::<Option<Vec<i128>>>()?;
                    let lengths = instants.windows(2).map(|pair| (pair[1] - pair[0]) as f64 / 1e6);
                    return Some(Steps::new(Unit::Seconds, lengths.collect()));
                };
                let in_days = whole(Unit::Days, &in_days(&dates));
                let in_months = in_months(&dates).map(|numbers| whole(Unit::Months, &numbers));
                if in_days.usual().is_some() {
                    return Some(in_days);
                }
                if let Some(in_months) = in_months.as_ref().filter(|steps| steps.usual().is_some()) {
                    return Some(in_months.clone());
                }
                let in_working_days = in_working_days(&dates).map(|days| whole(Unit::WorkingDays, &days));
                in_working_days.or(in_months).or(Some(in_days))
            }
        }
    }

    fn new(unit: Unit, lengths: Vec<f64>) -> Self {
        Steps { unit, lengths, decimals: None, largest: 0.0 }
    }

    fn of_numbers(times: &[Time]) -> Option<Self> {
        let (mut values, mut most) = (Vec::with_capacity(times.len()), Some(0));
        for time in times {
            let Time::Number { value, decimals } = time else { return None };
            values.push(*value);
            most = most.zip(*decimals).map(|(most, decimals)| most.max(decimals));
        }
        let lengths = values.windows(2).map(|pair| pair[1] - pair[0]).collect();
        let largest = values.iter().fold(0.0_f64, |largest, value| largest.max(value.abs()));
        Some(Steps { unit: Unit::Numbers, lengths, decimals: most, largest })
    }

    /// How far a step may be from a usual one to be one: what rounding and clocks do to it.
    fn tolerance(&self, usual: f64) -> f64 {
        /// A hundredth of a step makes no difference to a model of equal steps.
        const JITTER: f64 = 0.01;
        /// The last digit that is written is rounded, but says something where it is large.
        const ROUNDED: f64 = 0.15;
        let usual = usual.abs();
        match self.unit {
            Unit::Numbers => {
                let digit = self.decimals.filter(|decimals| *decimals > 0);
                let digit = digit.map_or(0.0, |decimals| 10_f64.powi(-(decimals.min(300) as i32)));
                (JITTER * usual).max(digit.min(ROUNDED * usual) * (1.0 + 1e-9))
                    + 8.0 * f64::EPSILON * self.largest
            }
            Unit::Seconds => JITTER * usual,
            Unit::Days | Unit::WorkingDays | Unit::Months | Unit::Quarters => 0.0,
        }
    }

    /// Whether a step is as long as a usual one.
    pub(super) fn is_usual(&self, step: f64, usual: f64) -> bool {
        (step - usual).abs() <= self.tolerance(usual)
    }

    /// The step that all are, if they go forward.
    pub(super) fn usual(&self) -> Option<f64> {
        let (usual, count) = self.most_common()?;
        (usual > 0.0 && count == self.lengths.len()).then_some(usual)
    }

    /// The most common step, and how many there are of it.
    pub(super) fn most_common(&self) -> Option<(f64, usize)> {
        let mut sorted = self.lengths.clone();
        sorted.sort_by(f64::total_cmp);
        let median = *sorted.get(sorted.len() / 2)?;
        let mut runs: Vec<(usize, f64)> = Vec::new();
        for step in &sorted {
            match runs.last_mut() {
                Some((count, of)) if of == step => *count += 1,
                _ => runs.push((1, *step)),
            }
        }
        let longest = runs.iter().max_by_key(|(count, _)| *count).map_or(median, |(_, step)| *step);
        let count = |usual: f64| self.lengths.iter().filter(|step| self.is_usual(**step, usual)).count();
        [median, longest].map(|usual| (usual, count(usual))).into_iter().max_by_key(|(_, count)| *count)
    }

    /// A step in words: `1 day`, `-2 days`, `0.5`.
    pub(super) fn words(&self, step: f64) -> String {
        let (size, unit) = self.in_unit(step);
        match unit {
            "" => size,
            unit => format!("{size} {unit}{}", if size == "1" { "" } else { "s" }),
        }
    }

    /// Several steps in words: `1, 4, 1 and -2 days`.
    pub(super) fn all_words(&self) -> String {
        let units: Vec<&str> = self.lengths.iter().map(|step| self.in_unit(*step).1).collect();
        let is_one = units.windows(2).all(|pair| pair[0] == pair[1]);
        let mut words: Vec<String> = self.lengths.iter().map(|step| self.words(*step)).collect();
        if is_one && words.len() > 1 {
            let last = words.len() - 1;
            for (word, step) in words.iter_mut().zip(&self.lengths).take(last) {
                *word = self.in_unit(*step).0;
            }
            if words[last].starts_with("1 ") && !words[last].ends_with('s') {
                words[last].push('s');
            }
        }
        listed(&words)
    }

    /// A step as a number of the largest unit that it is a whole number of.
    fn in_unit(&self, step: f64) -> (String, &'static str) {
        let unit = match self.unit {
            Unit::Numbers => "",
            Unit::Days => "day",
            Unit::WorkingDays => "working day",
            Unit::Months => "month",
            Unit::Quarters => "quarter",
            Unit::Seconds => {
                let all = |unit: f64| self.lengths.iter().all(|step| step % unit == 0.0);
                let units = [(86_400.0, "day"), (3600.0, "hour"), (60.0, "minute")];
                let (size, unit) = units.into_iter().find(|(unit, _)| all(*unit)).unwrap_or((1.0, "second"));
                return (number(step / size), unit);
            }
        };
        (number(step), unit)
    }
}

/// A number in six digits.
fn number(value: f64) -> String {
    let is_common = value == 0.0 || (1e-4..1e9).contains(&value.abs());
    match is_common {
        true => {
            let decimals = (5 - value.abs().max(1e-4).log10().floor() as i32).clamp(0, 9) as usize;
            let text = format!("{value:.decimals$}");
            let text =
                if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.') } else { &text };
            text.to_string()
        }
        false => format!("{value:e}"),
    }
}

/// `a, b and c`.
pub(super) fn listed(words: &[String]) -> String {
    match words {
        [] => String::new(),
        [one] => one.clone(),
        [first @ .., last] => format!("{} and {last}", first.join(", ")),
    }
}
