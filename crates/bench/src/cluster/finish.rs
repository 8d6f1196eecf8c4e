//! The job after an array: tables, figures and verdicts of all that is there.

use std::path::Path;
use std::time::Duration;

use motes_cli::{result, status};

use super::error::ClusterError;
use super::submission::Place;
use crate::outputs::write_outputs;
use crate::standing::{Count, read, wanted};
use crate::store::{Store, StoreError};
use crate::verify::{judges, verify};

/// How often a folder is tried that another run has, ...
const ATTEMPTS: usize = 60;
/// ... and how long after the last time.
const PAUSE: Duration = Duration::from_secs(1);

/// Writes the tables and figures of a submission's plans, and the verdicts on the paper's claims; says whether all units are there and none
/// failed.
///
/// # Errors
/// [`ClusterError`] if something cannot be read or written.
pub fn finish(folder: &Path) -> Result<bool, ClusterError> {
    let submission = Place::at(folder).read()?;
    let mut is_whole = true;
    for plan in &submission.plans {
        let mut store = open(&plan.folder)?;
        let (records, remarks) = read(plan, &mut store)?;
        remarks.iter().for_each(|remark| status(remark));
        write_outputs(plan, &store, &records)?;
        let count = Count::of(&wanted(plan), &records);
        result(&format!("{} {}: {count}", plan.figure, plan.profile_name));
        is_whole &= count.left() == 0 && count.failed == 0;
    }
    if submission.plans.iter().any(|plan| judges(&plan.figure)) {
        verify(&submission.out, &submission.experiments)?;
        result(&format!("verdicts in {}", submission.out.display()));
    }
    Ok(is_whole)
}

/// The results folder, once another run has left it.
fn open(folder: &Path) -> Result<Store, StoreError> {
    for _ in 1..ATTEMPTS {
        match Store::open(folder) {
            Err(StoreError::Locked { .. }) => std::thread::sleep(PAUSE),
            opened => return opened,
        }
    }
    Store::open(folder)
}
