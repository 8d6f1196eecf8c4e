//! Signs of life: what a task is doing, in a file that it writes anew now and then.

use std::path::Path;
use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::Duration;

use serde::{Deserialize, Serialize};

use super::submission::{Place, now};
use crate::durable;

/// How often a task says that it lives.
const EVERY: Duration = Duration::from_secs(20);
/// Seconds after which a task that says nothing is taken for dead.
pub(super) const SILENCE: u64 = 120;

/// What a task says of itself.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct Sign {
    /// The node.
    pub(super) machine: String,
    /// The unit that it began last.
    pub(super) unit: Option<String>,
    /// When it began it, in seconds since 1970.
    pub(super) since: u64,
    /// When it wrote this.
    pub(super) now: u64,
    /// Whether it has ended, its share done or not.
    pub(super) has_ended: bool,
}

impl Sign {
    /// The last one of a task; none if it has not begun.
    pub(super) fn read(place: &Place, task: usize) -> Option<Sign> {
        serde_json::from_str(&std::fs::read_to_string(place.sign(task)).ok()?).ok()
    }
}

/// Writes signs until it is dropped.
pub(super) struct Life {
    sign: Arc<Mutex<Sign>>,
    end: Option<(Sender<()>, JoinHandle<()>)>,
}

impl Life {
    /// Begins the signs of a task. Where they cannot be written, the task goes on without.
    pub(super) fn of(place: &Place, task: usize) -> Life {
        let first =
            Sign { machine: durable::machine(), unit: None, since: now(), now: now(), has_ended: false };
        let sign = Arc::new(Mutex::new(first));
        let (path, shared) = (place.sign(task), Arc::clone(&sign));
        let (sender, receiver) = channel();
        let write_until_the_end = move || {
            loop {
                let has_ended = match receiver.recv_timeout(EVERY) {
                    Err(RecvTimeoutError::Timeout) | Ok(()) => false,
                    Err(RecvTimeoutError::Disconnected) => true,
                };
                let mut sign = shared.lock().unwrap_or_else(PoisonError::into_inner).clone();
                (sign.now, sign.has_ended) = (now(), has_ended);
                write(&path, &sign);
                if has_ended {
                    return;
                }
            }
        };
        let thread = std::thread::Builder::new().spawn(write_until_the_end);
        Life { sign, end: thread.ok().map(|thread| (sender, thread)) }
    }

    /// A unit has begun.
    pub(super) fn began(&self, unit: &str) {
        let mut sign = self.sign.lock().unwrap_or_else(PoisonError::into_inner);
        (sign.unit, sign.since) = (Some(unit.into()), now());
        drop(sign);
        // At once, so that short shares are seen, too.
        if let Some((sender, _)) = &self.end {
            let _ = sender.send(());
        }
    }
}

impl Drop for Life {
    fn drop(&mut self) {
        if let Some((sender, thread)) = self.end.take() {
            drop(sender);
            let _ = thread.join();
        }
    }
}

/// A sign is worth no error: the next one may be written again.
fn write(path: &Path, sign: &Sign) {
    if let Ok(text) = serde_json::to_string(sign) {
        let _ = durable::write(path, &[text.as_bytes()]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_task_says_what_it_does_and_that_it_has_ended() {
        let folder = tempfile::tempdir().unwrap();
        let place = Place::at(folder.path());
        assert_eq!(Sign::read(&place, 3), None);
        let life = Life::of(&place, 3);
        life.began("N10 x = 10 fcnn repetition 0");
        drop(life);
        let sign = Sign::read(&place, 3).unwrap();
        assert_eq!(sign.unit.as_deref(), Some("N10 x = 10 fcnn repetition 0"));
        assert!(sign.has_ended && now() - sign.now < SILENCE);
    }
}
