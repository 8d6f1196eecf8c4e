//! A task of an array: does its share of the units, as far as nobody has done it.

use std::path::Path;

use motes_cli::{Interrupt, status};
use motes_proposals::networks::open_device;

use super::error::ClusterError;
use super::sign::Life;
use super::submission::Place;
use crate::record_units::{Keeper, record_units};
use crate::standing::{PlacedUnit, belonging, is_missing};
use crate::store::{Contributor, Record, StoreError};

/// One of many that fill a folder.
struct Task<'a> {
    contributor: Contributor,
    life: &'a Life,
}

impl Keeper for Task<'_> {
    fn started(&mut self, name: &str) {
        self.life.began(name);
    }

    fn keep(&mut self, record: &Record) -> Result<(), StoreError> {
        self.contributor.write(record)
    }
}

/// Does the share of a task of the submission in `folder`. A task that is run again, or twice at once, leaves the same units.
///
/// # Errors
/// [`ClusterError`] if the submission cannot be read, or a result not written.
pub fn work(folder: &Path, task: usize, interrupt: &Interrupt) -> Result<(), ClusterError> {
    let place = Place::at(folder);
    let submission = place.read()?;
    let share = place.share(task)?;
    let (life, here) = (Life::of(&place, task), submission.provenance());
    for (number, plan) in submission.plans.iter().enumerate() {
        let dealt: Vec<_> = share.iter().filter(|dealt| dealt.plan == number).collect();
        if dealt.is_empty() || interrupt.check().is_break() {
            continue;
        }
        let contributor = Contributor::join(&plan.folder)?;
        let (records, _) = belonging(plan, contributor.read()?, "");
        let left = dealt.iter().filter(|dealt| is_missing(plan, &records, &dealt.unit));
        let (units, seconds): (Vec<PlacedUnit>, Vec<f64>) =
            left.map(|dealt| (dealt.unit.clone(), dealt.seconds)).unzip();
        if !units.is_empty() {
            open_device(plan.backend)?;
        }
        status(&format!("{}: {} of {} units of task {task} are left", plan.figure, units.len(), dealt.len()));
        record_units(&units, &seconds, (plan, &here), interrupt, &mut Task { contributor, life: &life })?;
    }
    if interrupt.check().is_break() {
        status(&format!(
            "task {task} was told to stop; the command that submitted it submits again what is left"
        ));
    }
    Ok(())
}
