//! A first job, which tells whether nodes see the folder and can run the program.

use std::time::{Duration, Instant};

use motes_cli::{Interrupt, status};

use super::error::ClusterError;
use super::scripts::PROBE;
use super::slurm;
use super::submission::Place;

/// How long it is waited for before the array is submitted behind it.
const PATIENCE: Duration = Duration::from_secs(60);
/// How long after its end its file may take to appear on this machine: network file systems remember what was not there.
const DELAY: Duration = Duration::from_secs(35);
const PAUSE: Duration = Duration::from_millis(250);

/// What the probe said.
pub(super) enum ProbeOutcome {
    /// A node ran the program in the folder.
    Fine,
    /// It still waits in the queue.
    Waits(String),
}

/// Submits the probe and waits for it, for a while.
pub(super) fn probe(place: &Place, interrupt: &Interrupt) -> Result<ProbeOutcome, ClusterError> {
    let job = slurm::submit(&place.script(PROBE), &[])?;
    let (start, mut ended) = (Instant::now(), None::<Instant>);
    loop {
        if has_probed(place) {
            return Ok(ProbeOutcome::Fine);
        }
        if ended.is_some_and(|ended| ended.elapsed() > DELAY) {
            return Err(ClusterError::NotShared { job, out: place.out(), said: last_words(place) });
        }
        if ended.is_none() && slurm::queued(&job).is_some_and(|jobs| jobs.is_empty()) {
            ended = Some(Instant::now());
        }
        if interrupt.check().is_break() {
            slurm::cancel(&job);
            return Err(ClusterError::Interrupted);
        }
        if ended.is_none() && start.elapsed() > PATIENCE {
            status(&format!("job {job}, which looks whether nodes see the folder, waits in the queue"));
            return Ok(ProbeOutcome::Waits(job));
        }
        std::thread::sleep(PAUSE);
    }
}

/// The last line of the probe's log.
fn last_words(place: &Place) -> String {
    let log = std::fs::read_to_string(place.folder().join("probe.log")).unwrap_or_default();
    log.lines().last().unwrap_or("it left no word here").trim().to_string()
}

/// Whether its file is there. A name that was looked up in vain is remembered by network file systems, and so is a list of names: the folder is
/// changed, then listed.
fn has_probed(place: &Place) -> bool {
    let wanted = place.probed();
    let touched = place.folder().join("looked");
    let _ = std::fs::write(&touched, "").and_then(|()| std::fs::remove_file(&touched));
    let entries = std::fs::read_dir(place.folder()).into_iter().flatten();
    entries.flatten().any(|entry| entry.path() == wanted)
}
