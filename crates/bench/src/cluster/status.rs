//! How far a sweep has come: units on disk, and what tasks say of themselves.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use motes_cli::{result, status};

use super::error::{ClusterError, at};
use super::sign::{SILENCE, Sign};
use super::submission::{Place, Submission, now};
use crate::config::Plan;
use crate::progress::duration;
use crate::standing::{Count, belonging, wanted};
use crate::store::{Contents, Contributor, Outcome, Record};

/// Prints how many units of each plan are done, failed and left, and of each submission of these plans the same by task.
///
/// # Errors
/// [`ClusterError`] if results or submissions cannot be read. Nothing is written.
pub fn show_status(plans: &[Plan], out: &Path) -> Result<(), ClusterError> {
    for plan in plans {
        let count = Count::of(&wanted(plan), &belonging(plan, contents(&plan.folder)?, "").0);
        result(&format!("{} {}: {count}", plan.figure, plan.profile_name));
    }
    let absolute = |plan: &Plan| std::path::absolute(&plan.folder).map_err(at(&plan.folder));
    let ours: BTreeSet<PathBuf> = plans.iter().map(absolute).collect::<Result<_, _>>()?;
    for place in Place::all(out)? {
        match place.read() {
            Ok(submission) if submission.plans.iter().any(|plan| ours.contains(&plan.folder)) => {
                show_tasks(&place, &submission)?;
            }
            Ok(_) => {}
            Err(error) => status(&format!("left out: {error}")),
        }
    }
    Ok(())
}

/// Prints what each task of a submission has done, of all of its figures.
fn show_tasks(place: &Place, submission: &Submission) -> Result<(), ClusterError> {
    // By their keys, whether they failed.
    let mut there: BTreeMap<String, bool> = BTreeMap::new();
    for plan in &submission.plans {
        let failed = |record: &Record| matches!(record.outcome, Outcome::Failed(_));
        let records = contents(&plan.folder)?.records;
        there.extend(records.iter().map(|record| (record.config.key(), failed(record))));
    }
    let job = place.jobs().array.unwrap_or_else(|| "none".into());
    let age = duration(now().saturating_sub(submission.when) as f64);
    result(&format!("\narray {job}, submitted {age} ago, {}\n", place.folder().display()));
    result("| task | done | failed | left | now |\n|---:|---:|---:|---:|---|");
    for task in 0..submission.tasks {
        let share = match place.share(task) {
            Ok(share) => share,
            Err(error) => {
                status(&format!("left out: {error}"));
                continue;
            }
        };
        let found = share.iter().map(|dealt| there.get(&dealt.unit.1.key()));
        let (mut done, mut failed) = (0, 0);
        for is_failed in found.flatten() {
            done += usize::from(!is_failed);
            failed += usize::from(*is_failed);
        }
        let left = share.len() - done - failed;
        let doing = doing(Sign::read(place, task), left);
        result(&format!("| {task} | {done} | {failed} | {left} | {doing} |"));
    }
    Ok(())
}

/// The units of a folder. One that nobody has written to has none, and is not created.
fn contents(folder: &Path) -> Result<Contents, ClusterError> {
    match folder.is_dir() {
        true => Ok(Contributor::join(folder)?.read()?),
        false => Ok(Contents::default()),
    }
}

/// What a task does, by its last sign.
fn doing(sign: Option<Sign>, left: usize) -> String {
    let Some(Sign { machine, unit, since, now: last, has_ended }) = sign else {
        return "has not begun".into();
    };
    let ago = |since: u64| duration(now().saturating_sub(since) as f64);
    match (has_ended, unit) {
        (true, _) if left > 0 => format!("stopped {} ago on {machine}", ago(last)),
        (true, _) => format!("ended {} ago on {machine}", ago(last)),
        (false, _) if now().saturating_sub(last) > SILENCE => {
            format!("no sign of life for {} from {machine}", ago(last))
        }
        (false, Some(unit)) => format!("{unit}, for {} on {machine}", ago(since)),
        (false, None) => format!("begins on {machine}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_task_that_says_nothing_for_long_is_said_to() {
        let sign = |age: u64, has_ended| {
            let then = now() - age;
            Some(Sign { machine: "n1".into(), unit: Some("u".into()), since: then, now: then, has_ended })
        };
        assert_eq!(doing(None, 3), "has not begun");
        assert!(doing(sign(3, false), 3).starts_with("u, for 3"));
        assert_eq!(doing(sign(600, false), 3), "no sign of life for 10 min from n1");
        assert_eq!(doing(sign(600, true), 3), "stopped 10 min ago on n1");
        assert_eq!(doing(sign(600, true), 0), "ended 10 min ago on n1");
    }
}
