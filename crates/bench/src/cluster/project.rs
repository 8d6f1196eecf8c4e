//! How long a sweep would take on many cores: its units dealt as they would be, with times that spread as measured ones do.

use std::collections::BTreeMap;
use std::path::Path;

use motes_cli::{Interrupt, result};
use motes_models::Seed;
use rand::RngExt;

use super::deal::deal;
use super::error::ClusterError;
use crate::config::{Plan, ReproduceArgs};
use crate::estimate::Estimator;
use crate::progress::duration;
use crate::record_units::name;
use crate::standing::wanted;
use crate::statistics::{median, quantiles};
use crate::unit::UnitConfig;
use crate::verify::VerifyError;

/// A unit that took so many times the median of its kind was stopped in between: runs in the background are, while something is timed.
const STOPPED: f64 = 3.0;
/// Simulated sweeps for each number of cores.
const DRAWS: usize = 20;

/// Prints, for each number of cores, how long all units of these plans would take, and what share of the cores' time is work.
///
/// A unit's time is the estimate of a trial on this machine, times a ratio that is drawn from measured ones: of units to the median of those
/// that differ in their repetition alone, in the `timings.csv` of `experiments/reference`.
///
/// # Errors
/// [`ClusterError`] if a table of times cannot be read.
pub fn project(
    plans: &[Plan],
    args: &ReproduceArgs,
    estimator: &Estimator,
    interrupt: &Interrupt,
) -> Result<(), ClusterError> {
    let (mut units, mut names, mut seconds, mut ratios) = (vec![], vec![], vec![], vec![]);
    for plan in plans {
        let (points, configs): (Vec<_>, Vec<UnitConfig>) = wanted(plan).into_iter().unzip();
        seconds.extend(estimator.seconds(plan, &points, interrupt));
        names.extend(points.iter().map(|point| format!("{} {}", plan.figure, name(point))));
        units.extend(configs);
        let measured = args.experiments.join("reference").join(&plan.figure).join(&plan.profile_name);
        ratios.extend(spread(&measured.join("timings.csv"))?);
    }
    let all = ratios.len();
    ratios.retain(|ratio| *ratio < STOPPED);
    let stopped = all - ratios.len();
    if ratios.is_empty() {
        ratios.push(1.0);
    }
    let (units, total): (Vec<&UnitConfig>, f64) = (units.iter().collect(), seconds.iter().sum());
    let longest = seconds.iter().zip(&names).max_by(|(one, _), (other, _)| one.total_cmp(other));
    let longest =
        longest.map_or(String::new(), |(second, name)| format!("{name}, takes {}", duration(*second)));
    let [low, high] = quantiles(&ratios, [0.05, 0.95]);
    result(&format!(
        "{} units, {} of one core by trials on this machine, without the reference filters that they share; the longest, {longest}; measured \
         times are {low:.2} to {high:.2} times their median ({} units, 5 % and 95 %, without {stopped} that were stopped in between)\n",
        units.len(),
        duration(total),
        ratios.len()
    ));
    result("| cores | time, median | 95 % | share of the cores' time that is work |\n|---:|---:|---:|---:|");
    for &cores in &args.cluster.project {
        let shares = deal(&units, &seconds, cores);
        let mut stream = Seed::from_u64(args.seed).child("projection").nth(cores as u64).stream();
        let (mut times, mut busy) = (Vec::new(), Vec::new());
        for _ in 0..DRAWS {
            let drawn: Vec<f64> =
                seconds.iter().map(|second| second * ratios[stream.random_range(0..ratios.len())]).collect();
            let of_share = |share: &Vec<usize>| share.iter().map(|unit| drawn[*unit]).sum::<f64>();
            let time = shares.iter().map(of_share).fold(0.0, f64::max);
            busy.push(drawn.iter().sum::<f64>() / (time * cores as f64));
            times.push(time);
        }
        let [middle, most] = quantiles(&times, [0.5, 0.95]);
        let share = 100.0 * median(busy);
        result(&format!("| {cores} | {} | {} | {share:.0} % |", duration(middle), duration(most)));
    }
    Ok(())
}

/// The ratios of measured times to the median of their kind: same panel, method and x. None where nothing was measured.
fn spread(path: &Path) -> Result<Vec<f64>, ClusterError> {
    if !path.exists() {
        return Ok(Vec::new());
    }
    let damaged = |source| VerifyError::Table { path: path.to_path_buf(), source };
    let mut reader = csv::Reader::from_path(path).map_err(damaged)?;
    // By panel, method and x: by repetition, seconds of training and of filters.
    let mut kinds: BTreeMap<[String; 3], BTreeMap<String, f64>> = BTreeMap::new();
    for row in reader.deserialize() {
        let (_, panel, method, x, repetition, what, value): (
            String,
            String,
            String,
            String,
            String,
            String,
            f64,
        ) = row.map_err(damaged)?;
        if what.ends_with("_seconds") {
            *kinds.entry([panel, method, x]).or_default().entry(repetition).or_default() += value;
        }
    }
    let of_kind = |seconds: BTreeMap<String, f64>| {
        let seconds: Vec<f64> = seconds.into_values().collect();
        let median = median(seconds.clone());
        // One alone says nothing of a spread, and moments are those of the clock.
        let counts = seconds.len() > 2 && median > 1.0;
        seconds.into_iter().filter(move |_| counts).map(move |second| second / median)
    };
    Ok(kinds.into_values().flat_map(of_kind).collect())
}
