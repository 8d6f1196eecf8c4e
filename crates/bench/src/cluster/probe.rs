//! A first job, which tells whether nodes see the folder and can run the program.

use std::time::{Duration, Instant};

use motes_cli::{Interrupt, status};

use super::error::ClusterError;
use super::slurm;
use super::submission::Place;

/// How long it is waited for before the array is submitted behind it.
const PATIENCE: Duration = Duration::from_secs(60);
/// How long after its end its file may take to appear on this machine: network file systems remember what was not there.
const DELAY: Duration = Duration::from_secs(35);
const PAUSE: Duration = Duration::from_millis(250);

/// What the probe said.
pub(super) enum Probed {
    /// A node ran the program in the folder.
    Fine,
    /// It still waits in the queue.
    Waits(String),
}

/// Submits the probe and waits for it, for a while.
pub(super) fn probe(place: &Place, interrupt: &Interrupt) -> Result<Probed, ClusterError> {
    let job = slurm::submit(&place.script("probe"), &[])?;
    let (start, mut ended) = (Instant::now(), None::<Instant>);
    loop {
        if has_probed(place) {
            return Ok(Probed::Fine);
        }
        if ended.is_some_and(|ended| ended.elapsed() > DELAY) {
            let (program, folder) = (place.program(), place.folder().to_path_buf());
            return Err(ClusterError::NotShared { job, program, folder });
        }
        if ended.is_none() && slurm::queued(&job).is_some_and(|tasks| tasks.is_empty()) {
            ended = Some(Instant::now());
        }
        if (ended.is_none() && start.elapsed() > PATIENCE) || interrupt.check().is_break() {
            status(&format!("job {job}, which looks whether nodes see the folder, waits in the queue"));
            return Ok(Probed::Waits(job));
        }
        std::thread::sleep(PAUSE);
    }
}

/// Whether its file is there. The folder is listed: a name that was looked up in vain is remembered by some file systems.
fn has_probed(place: &Place) -> bool {
    let wanted = place.probed();
    let entries = std::fs::read_dir(place.folder()).into_iter().flatten();
    entries.flatten().any(|entry| entry.path() == wanted)
}
