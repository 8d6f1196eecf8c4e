//! Handing a sweep to Slurm.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use motes_cli::{Interrupt, result, status};

use super::deal::deal;
use super::error::{ClusterError, at};
use super::probe::{ProbeOutcome, probe};
use super::scripts::{ARRAY, FINISH, Scripts};
use super::slurm;
use super::submission::{Dealt, Jobs, Place, Submission};
use crate::config::{ConfigError, Plan, ReproduceArgs};
use crate::estimate::Estimator;
use crate::progress::duration;
use crate::standing::{is_missing, read, wanted};
use crate::store::Store;
use crate::unit::UnitConfig;

/// Tasks of an array where nothing is said.
const TASKS: usize = 100;

/// Prints the scripts that these plans would be submitted with, were no unit there yet.
///
/// # Errors
/// [`ClusterError::File`] if a folder has no absolute path.
pub fn dry_run(plans: &[Plan], args: &ReproduceArgs) -> Result<(), ClusterError> {
    let (plans, out, _) = absolute(plans, args)?;
    let place = Place::next(&out);
    let units: usize = plans.iter().map(|plan| wanted(plan).len()).sum();
    let tasks = args.cluster.tasks.unwrap_or(TASKS).min(units.max(1));
    for (name, text) in scripts(&place, args, &plans, tasks).all() {
        result(&format!("==> {} <==\n{text}", place.script(name).display()));
    }
    Ok(())
}

fn scripts<'a>(place: &'a Place, args: &'a ReproduceArgs, plans: &[Plan], tasks: usize) -> Scripts<'a> {
    Scripts { place, name: args.figure.clone(), args: &args.cluster, tasks, jobs: threads(plans) }
}

/// Threads of a task: the same for all plans.
fn threads(plans: &[Plan]) -> usize {
    plans.first().map_or(1, |plan| plan.jobs)
}

/// What there was to submit.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SubmitOutcome {
    /// Units, which are now in the queue.
    Units,
    /// None: all that are missing are in the queue already.
    Queued,
    /// None: all are there.
    Complete,
}

/// Submits what these plans lack: a probe, the array, and the job after it.
///
/// # Errors
/// [`ClusterError`]; nothing is left in the queue then.
pub fn submit(
    plans: &[Plan],
    args: &ReproduceArgs,
    estimator: &Estimator,
    interrupt: &Interrupt,
) -> Result<SubmitOutcome, ClusterError> {
    slurm::check()?;
    args.backend.check()?;
    let (plans, out, experiments) = absolute(plans, args)?;
    let mut dealt = units(&plans)?;
    if dealt.is_empty() {
        return Ok(SubmitOutcome::Complete);
    }
    leave_out_queued(&out, &mut dealt)?;
    if dealt.is_empty() {
        return Ok(SubmitOutcome::Queued);
    }
    for (number, plan) in plans.iter().enumerate() {
        let of_plan: Vec<usize> = (0..dealt.len()).filter(|at| dealt[*at].plan == number).collect();
        let points: Vec<_> = of_plan.iter().map(|at| dealt[*at].unit.0.clone()).collect();
        let seconds = estimator.seconds(plan, &points, interrupt);
        of_plan.into_iter().zip(seconds).for_each(|(at, seconds)| dealt[at].seconds = seconds);
    }
    if interrupt.check().is_break() {
        return Err(ClusterError::Interrupted);
    }
    let (configs, seconds): (Vec<&UnitConfig>, Vec<f64>) =
        dealt.iter().map(|dealt| (&dealt.unit.1, dealt.seconds)).unzip();
    let shares = deal(&configs, &seconds, args.cluster.tasks.unwrap_or(TASKS));
    let shares: Vec<Vec<Dealt>> =
        shares.iter().map(|share| share.iter().map(|at| dealt[*at].clone()).collect()).collect();
    warn_of_limit(args, &dealt);

    let place = Place::create(&out)?;
    let submission = Submission::of(&plans, &out, &experiments, shares.len());
    let jobs = place
        .write(&submission, &shares, &scripts(&place, args, &plans, shares.len()).all())
        .and_then(|()| hand_over(&place, interrupt))
        .inspect_err(|_| place.remove())?;
    let workers = |share: &[Dealt]| threads(&plans).min(share.len()).max(1) as f64;
    let lengths =
        shares.iter().map(|share| share.iter().map(|dealt| dealt.seconds).sum::<f64>() / workers(share));
    let longest = duration(lengths.fold(0.0, f64::max));
    let (array, finish) = (jobs.array.unwrap_or_default(), jobs.finish.unwrap_or_default());
    result(&format!(
        "job {array}: {} units in {} tasks, the longest of which takes about {longest} by trials on this machine",
        dealt.len(),
        shares.len()
    ));
    result(&format!("job {finish}: tables, figures and verdicts, when job {array} has ended"));
    result(&format!(
        "watch them with the same command and --status, or squeue --jobs {array},{finish}; logs are in {}",
        place.folder().display()
    ));
    Ok(SubmitOutcome::Units)
}

/// The plans on paths that hold on every node, and the folders of results and experiments.
fn absolute(plans: &[Plan], args: &ReproduceArgs) -> Result<(Vec<Plan>, PathBuf, PathBuf), ClusterError> {
    let absolute = |path: &Path| -> Result<PathBuf, ClusterError> {
        let path = std::path::absolute(path).map_err(at(path))?;
        let spoils = |letter: char| letter.is_control() || "\"\\".contains(letter);
        if path.to_str().is_none_or(|text| text.contains(spoils)) {
            let expected =
                "scripts of Slurm cannot name it: without quotes, backslashes and line breaks, in UTF-8";
            let value = format!("{:?}", path.display().to_string());
            return Err(ConfigError::option("--out or --experiments", &value, expected.into()).into());
        }
        Ok(path)
    };
    let plan = |plan: &Plan| {
        let (folder, learned) = (absolute(&plan.folder)?, absolute(&plan.learned)?);
        Ok(Plan { folder, learned, ..plan.clone() })
    };
    let plans = plans.iter().map(plan).collect::<Result<_, ClusterError>>()?;
    Ok((plans, absolute(&args.out)?, absolute(&args.experiments)?))
}

/// What the plans lack.
fn units(plans: &[Plan]) -> Result<Vec<Dealt>, ClusterError> {
    let mut units = Vec::new();
    for (number, plan) in plans.iter().enumerate() {
        let (mut store, wanted) = (Store::open(&plan.folder)?, wanted(plan));
        let (records, remarks) = read(plan, &mut store)?;
        remarks.iter().for_each(|remark| status(remark));
        let (all, before) = (wanted.len(), units.len());
        let missing = wanted.into_iter().filter(|unit| is_missing(plan, &records, unit));
        units.extend(missing.map(|unit| Dealt { plan: number, unit, seconds: 0.0 }));
        let missing = units.len() - before;
        status(&plan.to_string());
        status(&format!("{} units are there, {missing} to run", all - missing));
    }
    Ok(units)
}

/// Leaves out the shares of tasks that still wait or run as far as Slurm says. Should they come to nothing, the same command submits their
/// units another time.
fn leave_out_queued(out: &Path, dealt: &mut Vec<Dealt>) -> Result<(), ClusterError> {
    for place in Place::all(out)? {
        let Some(array) = place.jobs().array else { continue };
        let mut keys = BTreeSet::new();
        for task in slurm::queued(&array).unwrap_or_default().into_iter().flatten() {
            match place.share(task) {
                Ok(share) => keys.extend(share.iter().map(|dealt| dealt.unit.1.key())),
                Err(error) => status(&format!("job {array} is not waited for: {error}")),
            }
        }
        let before = dealt.len();
        dealt.retain(|dealt| !keys.contains(&dealt.unit.1.key()));
        if dealt.len() < before {
            let count = before - dealt.len();
            status(&format!(
                "{count} units are left to job {array}, which waits or runs; scancel {array} takes it back"
            ));
        }
    }
    Ok(())
}

/// A unit that needs longer than a task may run ends no task's time well.
fn warn_of_limit(args: &ReproduceArgs, dealt: &[Dealt]) {
    let Some(limit) = args.cluster.time.as_ref() else { return };
    let Some(seconds) = limit.seconds() else { return };
    let longest = dealt.iter().map(|dealt| dealt.seconds).fold(0.0, f64::max);
    // Tasks are told before the end of their time, and Slurm may tell them a minute earlier.
    if longest + 180.0 > seconds as f64 {
        status(&format!(
            "warning: --time {limit} leaves less than the {} that the longest unit takes by a trial on this machine; its training goes on from a \
             checkpoint where the same command is given again",
            duration(longest)
        ));
    }
}

/// Submits probe, array and the job after it; what was submitted is taken back if anything after it fails.
fn hand_over(place: &Place, interrupt: &Interrupt) -> Result<Jobs, ClusterError> {
    let (mut submitted, mut behind) = (Vec::new(), Vec::new());
    if let ProbeOutcome::Waits(job) = probe(place, interrupt)? {
        behind = vec![format!("--dependency=afterok:{job}"), "--kill-on-invalid-dep=yes".into()];
        submitted.push(job);
    }
    let mut all = || {
        let array = slurm::submit(&place.script(ARRAY), &behind)?;
        submitted.push(array.clone());
        let finish = slurm::submit(&place.script(FINISH), &[format!("--dependency=afterany:{array}")])?;
        submitted.push(finish.clone());
        let jobs = Jobs { array: Some(array), finish: Some(finish) };
        place.write_jobs(&jobs).map(|()| jobs)
    };
    let done = all();
    if done.is_err() {
        submitted.iter().for_each(|job| slurm::cancel(job));
    }
    done
}
