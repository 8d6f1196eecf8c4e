//! A submission on disk: all that its tasks and the job after them need, as values.

use std::fs::File;
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::time::{SystemTime, UNIX_EPOCH};

use serde::{Deserialize, Serialize};

use super::error::{ClusterError, at};
use crate::config::Plan;
use crate::durable;
use crate::provenance::Provenance;
use crate::standing::PlacedUnit;

/// Where submissions lie in a folder of results, each in a folder of its own.
const FOLDER: &str = "slurm";
const SUBMISSION: &str = "submission.json";
const JOBS: &str = "jobs.json";
/// The program, as it was at the submission: what is built later is no part of it.
const PROGRAM: &str = "motes-bench";

/// What all tasks of a submission have in common.
#[derive(Debug, Serialize, Deserialize)]
pub(super) struct Submission {
    /// The figures.
    pub(super) plans: Vec<Plan>,
    /// Where results go.
    pub(super) out: PathBuf,
    /// Where the experiment files lie.
    pub(super) experiments: PathBuf,
    /// Tasks of the array.
    pub(super) tasks: usize,
    /// What was built.
    pub(super) revision: String,
    /// Seconds since 1970.
    pub(super) when: u64,
}

/// The jobs that Slurm gave numbers.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Jobs {
    pub(super) array: Option<String>,
    pub(super) finish: Option<String>,
}

/// A unit of a task's share.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct Dealt {
    /// The number of its figure among the submission's plans.
    pub(super) plan: usize,
    pub(super) unit: PlacedUnit,
    /// How long it was estimated to take.
    pub(super) seconds: f64,
}

/// The files of a submission.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Place {
    folder: PathBuf,
}

impl Place {
    pub(super) fn at(folder: &Path) -> Place {
        Place { folder: folder.to_path_buf() }
    }

    /// All of a results folder, the earliest first.
    pub(super) fn all(out: &Path) -> Result<Vec<Place>, ClusterError> {
        let folder = out.join(FOLDER);
        let mut places = Vec::new();
        if folder.is_dir() {
            for entry in std::fs::read_dir(&folder).map_err(at(&folder))? {
                let place = Place::at(&entry.map_err(at(&folder))?.path());
                if place.submission_file().exists() {
                    places.push(place);
                }
            }
        }
        places.sort_by(|one, other| one.folder.cmp(&other.folder));
        Ok(places)
    }

    /// The next one that a results folder would have.
    pub(super) fn next(out: &Path) -> Place {
        let number = (1_usize..).find(|number| !Place::numbered(out, *number).folder.exists());
        Place::numbered(out, number.unwrap_or(1))
    }

    /// The next one, created: two that submit at once get two.
    pub(super) fn create(out: &Path) -> Result<Place, ClusterError> {
        let parent = out.join(FOLDER);
        std::fs::create_dir_all(&parent).map_err(at(&parent))?;
        loop {
            let place = Place::next(out);
            match std::fs::create_dir(&place.folder) {
                Err(error) if error.kind() == std::io::ErrorKind::AlreadyExists => {}
                created => return created.map(|()| place.clone()).map_err(at(&place.folder)),
            }
        }
    }

    fn numbered(out: &Path, number: usize) -> Place {
        Place { folder: out.join(FOLDER).join(format!("{number:04}")) }
    }

    pub(super) fn folder(&self) -> &Path {
        &self.folder
    }

    /// The folder of results that it lies in.
    pub(super) fn out(&self) -> PathBuf {
        self.folder.parent().and_then(Path::parent).unwrap_or(&self.folder).to_path_buf()
    }

    pub(super) fn program(&self) -> PathBuf {
        self.folder.join(PROGRAM)
    }

    /// What the probe leaves where it sees the folder.
    pub(super) fn probed(&self) -> PathBuf {
        self.folder.join("probed")
    }

    pub(super) fn script(&self, name: &str) -> PathBuf {
        self.folder.join(format!("{name}.sh"))
    }

    pub(super) fn sign(&self, task: usize) -> PathBuf {
        self.folder.join(format!("task-{task}.json"))
    }

    fn submission_file(&self) -> PathBuf {
        self.folder.join(SUBMISSION)
    }

    fn share_file(&self, task: usize) -> PathBuf {
        self.folder.join(format!("share-{task}.jsonl"))
    }

    pub(super) fn read(&self) -> Result<Submission, ClusterError> {
        read_json(&self.submission_file())
    }

    /// The jobs; none where sbatch was not reached.
    pub(super) fn jobs(&self) -> Jobs {
        read_json(&self.folder.join(JOBS)).unwrap_or_default()
    }

    pub(super) fn share(&self, task: usize) -> Result<Vec<Dealt>, ClusterError> {
        let path = self.share_file(task);
        let file = BufReader::new(File::open(&path).map_err(at(&path))?);
        let damaged = |error: serde_json::Error| damaged(&path, &error);
        let line =
            |line: std::io::Result<String>| serde_json::from_str(&line.map_err(at(&path))?).map_err(damaged);
        file.lines().map(line).collect()
    }

    /// Writes the submission, the share of each task, and the scripts by their names.
    pub(super) fn write(
        &self,
        submission: &Submission,
        shares: &[Vec<Dealt>],
        scripts: &[(&str, String)],
    ) -> Result<(), ClusterError> {
        for (name, text) in scripts {
            put(&self.script(name), text)?;
        }
        for (task, share) in shares.iter().enumerate() {
            let text: String = share.iter().map(|dealt| json(dealt) + "\n").collect();
            put(&self.share_file(task), &text)?;
        }
        let (program, here) = (self.program(), std::env::current_exe().map_err(at(&self.folder))?);
        std::fs::copy(&here, &program).map_err(at(&program))?;
        put(&self.submission_file(), &json(submission))
    }

    pub(super) fn write_jobs(&self, jobs: &Jobs) -> Result<(), ClusterError> {
        put(&self.folder.join(JOBS), &json(jobs))
    }

    /// Takes back a submission that Slurm refused.
    pub(super) fn remove(&self) {
        // What is left of it harms nobody.
        let _ = std::fs::remove_dir_all(&self.folder);
    }
}

impl Submission {
    /// One of these plans, made by this program now.
    pub(super) fn of(plans: &[Plan], out: &Path, experiments: &Path, tasks: usize) -> Self {
        Submission {
            plans: plans.to_vec(),
            out: out.to_path_buf(),
            experiments: experiments.to_path_buf(),
            tasks,
            revision: Provenance::here().revision,
            when: now(),
        }
    }

    /// What a task computes with: the revision of the submission, on the processor of the node.
    pub(super) fn provenance(&self) -> Provenance {
        Provenance::of(self.revision.clone())
    }
}

/// Seconds since 1970.
pub(super) fn now() -> u64 {
    SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |since| since.as_secs())
}

fn put(path: &Path, text: &str) -> Result<(), ClusterError> {
    durable::write(path, &[text.as_bytes()]).map_err(at(path))
}

fn json(value: &impl Serialize) -> String {
    serde_json::to_string(value).expect("a submission has only string keys, and paths in UTF-8")
}

fn read_json<T: for<'a> Deserialize<'a>>(path: &Path) -> Result<T, ClusterError> {
    let text = std::fs::read_to_string(path).map_err(at(path))?;
    serde_json::from_str(&text).map_err(|error| damaged(path, &error))
}

fn damaged(path: &Path, error: &serde_json::Error) -> ClusterError {
    ClusterError::Submission { path: path.to_path_buf(), reason: error.to_string() }
}
