//! What is the matter with times of consecutive rows: wrong order, the same twice, unequal steps, several sequences in one.

use std::cmp::Ordering;

use super::cycle::is_cycle;
use super::steps::{Steps, Unit, listed};
use crate::calendar::Time;

/// Times that are not one step apart, in words.
#[derive(Debug, Clone, PartialEq)]
pub(in super::super) struct Irregular {
    /// What was found.
    pub(in super::super) found: String,
    /// What was assumed, and what to do.
    pub(in super::super) assumed: String,
}

/// So many steps are all named, and so many odd ones of more.
const SHORT: usize = 6;
const NAMED: usize = 3;

const ASSUMED: &str = "rows are taken as consecutive time steps";

/// Looks at the times of consecutive rows, each with what its row is called: `line 3 (2024-03-01)`.
///
/// `name` is the column's; `is_named` says whether it is called a time: other numbers are looked at where they go up. `is_whole` says that the rows are all that
/// there are, of which several sequences may have become one.
pub(in super::super) fn irregular(
    name: &str,
    is_named: bool,
    is_whole: bool,
    times: &[Time],
    called: &dyn Fn(usize) -> String,
) -> Option<Irregular> {
    let steps = Steps::of(times).filter(|steps| !steps.lengths.is_empty())?;
    if steps.usual().is_some() || !is_time(name, is_named, times, &steps) {
        return None;
    }
    let line = |at: usize| called(at).split(" (").next().unwrap_or_default().to_string();
    if is_whole && let Some(starts) = restarts(times) {
        let first: Vec<String> = starts.iter().take(NAMED).map(|at| called(*at)).collect();
        let more = more(starts.len(), first.len());
        let found = format!("it begins again at {}{more}", listed(&first));
        return Some(Irregular { found, assumed: several() });
    }
    if is_whole && let Some(size) = repeats(times) {
        return Some(Irregular { found: format!("each value stands in {size} rows"), assumed: several() });
    }
    let mut found = vec![in_words(&steps, called)];
    let is_back = |at: &usize| steps.lengths[*at] < 0.0;
    let back: Vec<usize> = (0..steps.lengths.len()).filter(is_back).collect();
    if back.len() == steps.lengths.len() && back.len() > 1 {
        found = vec![format!("it goes backwards, from {} to {}", called(0), called(back.len()))];
    } else if let Some(first) = back.first() {
        let others = more(back.len(), 1);
        found.push(format!("{} is before {}{others}", called(first + 1), line(*first)));
    }
    let twice = twice(times);
    if steps.lengths.iter().all(|step| *step == 0.0) {
        found = vec![format!("all {} rows have the same time", times.len())];
    } else if let Some((first, again)) = twice.first() {
        let others = more(twice.len(), 1);
        found.push(format!("{} repeats {}{others}", called(*again), line(*first)));
    }
    let mut cure = Vec::new();
    if !back.is_empty() {
        cure.push("sort them".to_string());
    }
    if !twice.is_empty() {
        cure.push("leave one row for each time".to_string());
    }
    cure.extend(of_gaps(&steps));
    let cure = if cure.is_empty() { String::new() } else { format!("; {}", cure.join(", and ")) };
    // Times that go forwards may be what the model is about.
    let is_forward = steps.lengths.iter().all(|step| *step > 0.0);
    let of_model = match is_forward {
        true => format!(
            "; or name it in the model, [time] column = \"{name}\", and steps are as long as the times say"
        ),
        false => String::new(),
    };
    Some(Irregular { found: found.join("; "), assumed: format!("{ASSUMED}{cure}{of_model}") })
}

/// What to do where several sequences may have become one.
fn several() -> String {
    format!(
        "{ASSUMED} of one sequence; are they several? put each row's into a column called series, and each is filtered on its own"
    )
}

/// ` and 3 more`, where there are more than were named.
fn more(all: usize, named: usize) -> String {
    if all > named { format!(" and {} more", all - named) } else { String::new() }
}

/// Whether a column is one of times: dates are; numbers are where they are called so, or go up as times do.
fn is_time(name: &str, is_named: bool, times: &[Time], steps: &Steps) -> bool {
    if steps.unit != Unit::Numbers {
        return true;
    }
    let value = |time: &Time| if let Time::Number { value, .. } = time { *value } else { f64::NAN };
    let values: Vec<f64> = times.iter().map(value).collect();
    if is_named {
        return !is_cycle(name, &values);
    }
    let count = steps.lengths.len();
    let up = steps.lengths.iter().filter(|step| **step > 0.0).count();
    let usual = steps.most_common().map_or(0, |(usual, count)| if usual > 0.0 { count } else { 0 });
    // Ten numbers in order are no chance; of fewer, equal steps say that somebody counted.
    10 * up >= 9 * count && (count >= 9 || (count >= 3 && 2 * usual > count))
}

/// The steps in words: all where they are few, else those that are not as most are.
fn in_words(steps: &Steps, called: &dyn Fn(usize) -> String) -> String {
    let lengths = &steps.lengths;
    let count = lengths.len();
    if count <= SHORT {
        return format!("step{} of {}", if count == 1 { "" } else { "s" }, steps.all_words());
    }
    match steps.most_common() {
        Some((usual, common)) if 2 * common > count => {
            let odd: Vec<usize> = (0..count).filter(|at| !steps.is_usual(lengths[*at], usual)).collect();
            let named: Vec<String> = odd
                .iter()
                .take(NAMED)
                .map(|at| format!("{} to {}", steps.words(lengths[*at]), called(at + 1)))
                .collect();
            let others = more(odd.len(), named.len());
            format!(
                "steps of {}, but for {} of {count}: {}{others}",
                steps.words(usual),
                odd.len(),
                listed(&named)
            )
        }
        _ => {
            let least = lengths.iter().copied().fold(f64::INFINITY, f64::min);
            let most = lengths.iter().copied().fold(f64::NEG_INFINITY, f64::max);
            format!("steps from {} to {}", steps.words(least), steps.words(most))
        }
    }
}

/// What to do about steps that are too long, where rows would fill them.
fn of_gaps(steps: &Steps) -> Option<String> {
    let forward = || steps.lengths.iter().copied().filter(|step| *step > 0.0);
    let least = forward().fold(f64::INFINITY, f64::min);
    let is_most = |(usual, count): &(f64, usize)| *usual > 0.0 && 2 * count > steps.lengths.len();
    let usual = steps.most_common().filter(is_most).map_or(least, |(usual, _)| usual);
    let is_multiple = |step: f64| steps.is_usual(step, (step / usual).round().max(1.0) * usual);
    let longer = forward().filter(|step| *step > usual && !steps.is_usual(*step, usual)).count();
    if longer == 0 || !forward().all(is_multiple) {
        return None;
    }
    let what = match steps.unit {
        Unit::Numbers | Unit::Seconds => "times",
        Unit::Days => "days",
        Unit::WorkingDays => "working days",
        Unit::Months => "months",
        Unit::Quarters => "quarters",
    };
    // Weeks are not missing days.
    let what = if usual == 1.0 { what } else { "times" };
    Some(format!("give missing {what} as rows with empty cells"))
}

/// The rows at which times go back to the start, where each block of two rows at least goes up.
fn restarts(times: &[Time]) -> Option<Vec<usize>> {
    let goes = |at: usize| times[at].order(&times[at + 1]);
    let starts: Vec<usize> =
        (0..times.len() - 1).filter(|at| goes(*at) == Some(Ordering::Greater)).map(|at| at + 1).collect();
    let ends = starts.iter().copied().chain([times.len()]);
    let blocks: Vec<(usize, usize)> = [0].into_iter().chain(starts.iter().copied()).zip(ends).collect();
    let goes_up = |(start, end): &(usize, usize)| {
        end - start >= 2 && (*start..end - 1).all(|at| goes(at) == Some(Ordering::Less))
    };
    // To the first half of the block before.
    let goes_back = |pair: &[(usize, usize)]| {
        let middle = pair[0].0 + (pair[0].1 - pair[0].0) / 2;
        times[pair[1].0].order(&times[middle]) != Some(Ordering::Greater)
    };
    let is_so = !starts.is_empty() && blocks.iter().all(goes_up) && blocks.windows(2).all(goes_back);
    is_so.then_some(starts)
}

/// In how many rows each time stands, one after the other, if it is the same number of two at least for all.
fn repeats(times: &[Time]) -> Option<usize> {
    let mut sizes = vec![1];
    for pair in times.windows(2) {
        match pair[0].order(&pair[1])? {
            Ordering::Less => sizes.push(1),
            Ordering::Equal => *sizes.last_mut()? += 1,
            Ordering::Greater => return None,
        }
    }
    let size = *sizes.first()?;
    (sizes.len() >= 2 && size >= 2 && sizes.iter().all(|other| *other == size)).then_some(size)
}

/// Rows that have the time of one before, each with that one.
fn twice(times: &[Time]) -> Vec<(usize, usize)> {
    let mut places: Vec<usize> = (0..times.len()).collect();
    places.sort_by(|a, b| times[*a].order(&times[*b]).unwrap_or(Ordering::Equal));
    let is_same = |pair: &&[usize]| times[pair[0]].order(&times[pair[1]]) == Some(Ordering::Equal);
    let mut found: Vec<(usize, usize)> =
        places.windows(2).filter(is_same).map(|pair| (pair[0], pair[1])).collect();
    found.sort_by_key(|(_, again)| *again);
    found
}
