//! One piece of work, done in turns by all who can, or several in turns by us.

use std::path::Path;

use crate::equal::difference;
use crate::error::SpeedError;
use crate::peak::product_on_two_threads;
use crate::task::{Answer, Request, Task};
use crate::worker::Worker;
use crate::workloads::{Growing, Kind, Workload};
use motes_cli::Interrupt;
use motes_cli::status;

/// A piece of work and those who are to do it.
pub(crate) struct Contest<'a> {
    pub(crate) workload: Workload,
    pub(crate) python: Option<&'a Path>,
    pub(crate) peers: &'a Path,
    pub(crate) rounds: u64,
}

/// What came of it.
pub(crate) struct Outcome {
    pub(crate) workload: Workload,
    pub(crate) ours: Entry,
    pub(crate) peers: Vec<Entry>,
    /// Before each round of training, the rate of the largest product on two threads.
    pub(crate) peaks: Vec<f64>,
}

/// What one contestant did.
#[derive(Debug, Default, Clone, serde::Serialize)]
pub(crate) struct Entry {
    pub(crate) name: String,
    /// Processes side by side.
    pub(crate) processes: usize,
    /// Of each round: until the last process was done, on average over its runs.
    pub(crate) seconds: Vec<f64>,
    /// What showed that the work is equal.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) check: Option<Answer>,
    /// Of all its processes together, in bytes.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) peak_memory: Option<u64>,
    /// Why it did nothing.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) error: Option<String>,
}

impl Entry {
    /// A contestant that is not measured.
    fn absent(name: &str, check: Option<Answer>, error: String) -> Entry {
        status(&format!("{name}: {error}"));
        Entry { name: name.into(), check, error: Some(error), ..Entry::default() }
    }
}

/// A contestant at work.
struct Team {
    entry: Entry,
    workers: Vec<Worker>,
}

impl Team {
    fn gather(
        name: &str,
        tasks: &[Task],
        start: impl Fn(&Task) -> Result<Worker, SpeedError>,
    ) -> Result<Team, SpeedError> {
        let mut workers = Vec::new();
        for task in tasks {
            let mut worker = start(task)?;
            worker.prepare(task)?;
            workers.push(worker);
        }
        let check = workers.first_mut().map(|worker| worker.ask(&Request::Check(true))).transpose()?;
        let entry = Entry { name: name.into(), processes: workers.len(), check, ..Entry::default() };
        Ok(Team { entry, workers })
    }

    /// One round of some runs, in each of which all processes start together.
    fn round(&mut self, runs: usize) -> Result<(), SpeedError> {
        let mut total = 0.0;
        for _ in 0..runs {
            for worker in &mut self.workers {
                worker.send(&Request::Run(true))?;
            }
            let mut slowest: f64 = 0.0;
            for worker in &mut self.workers {
                slowest = slowest.max(worker.receive_seconds()?);
            }
            total += slowest;
        }
        self.entry.seconds.push(total / runs as f64);
        Ok(())
    }

    fn end(mut self) -> Entry {
        self.entry.peak_memory = self.workers.iter().map(Worker::peak_memory).sum();
        self.entry
    }
}

/// Why the work of a team is not ours, if it is not.
fn unequal(ours: &Team, theirs: &Team) -> Option<String> {
    let (Some(ours), Some(theirs)) = (&ours.entry.check, &theirs.entry.check) else {
        return Some("nothing shows that the work is equal".into());
    };
    difference(ours, theirs).map(|reason| format!("the work is not equal: {reason}"))
}

impl Contest<'_> {
    pub(crate) fn run(self, interrupt: &Interrupt) -> Result<Outcome, SpeedError> {
        let Contest { workload, python, peers, rounds } = self;
        status(&workload.name);
        let mut ours = Team::gather("motes", &workload.ours, |_| Worker::ours("motes"))?;
        let (mut teams, mut absent) = (Vec::new(), Vec::new());
        if let Some(python) = python {
            for (name, tasks) in &workload.peers {
                match Team::gather(name, tasks, |task| Worker::peer(name, python, peers, task)) {
                    Ok(team) => match unequal(&ours, &team) {
                        None => teams.push(team),
                        Some(reason) => absent.push(Entry::absent(name, team.entry.check, reason)),
                    },
                    Err(error) => absent.push(Entry::absent(name, None, error.to_string())),
                }
            }
        }
        let mut peaks = Vec::new();
        for _ in 0..rounds {
            if interrupt.check().is_break() {
                return Err(SpeedError::Interrupted);
            }
            if let Kind::Train { .. } = workload.kind {
                peaks.push(product_on_two_threads());
            }
            ours.round(workload.kind.runs())?;
            for team in &mut teams {
                if team.entry.error.is_none()
                    && let Err(error) = team.round(workload.kind.runs())
                {
                    team.entry.error = Some(error.to_string());
                }
            }
        }
        let peers = teams.into_iter().map(Team::end).chain(absent).collect();
        Ok(Outcome { ours: ours.end(), workload, peers, peaks })
    }
}

/// What filters of growing size took.
#[derive(serde::Serialize)]
pub(crate) struct Growth {
    pub(crate) method: &'static str,
    pub(crate) size: char,
    pub(crate) values: Vec<usize>,
    /// Of each round, the seconds of each size.
    pub(crate) seconds: Vec<Vec<f64>>,
}

/// Filters of all sizes in turns: a machine that becomes slower does so for all of them.
pub(crate) fn grow(growing: Growing, rounds: u64, interrupt: &Interrupt) -> Result<Growth, SpeedError> {
    let Growing { method, size, filters } = growing;
    status(&format!("growth {method} {size}"));
    let mut teams = Vec::new();
    for (_, workload) in &filters {
        teams.push(Team::gather("motes", &workload.ours, |_| Worker::ours("motes"))?);
    }
    let mut seconds = Vec::new();
    for _ in 0..rounds {
        if interrupt.check().is_break() {
            return Err(SpeedError::Interrupted);
        }
        for (team, (_, workload)) in teams.iter_mut().zip(&filters) {
            team.round(workload.kind.runs())?;
        }
        seconds.push(teams.iter().filter_map(|team| team.entry.seconds.last().copied()).collect());
    }
    Ok(Growth { method, size, values: filters.into_iter().map(|(value, _)| value).collect(), seconds })
}
