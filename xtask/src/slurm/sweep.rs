//! One sweep: submitted, waited for, and held against another.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::time::Duration;

use super::cluster::{Cluster, capture, wait_for, wait_until};

/// What is run: many short units, of all families.
const FIGURE: [&str; 5] = ["fig1", "--profile", "smoke", "--repetitions", "40"];
/// How long an array may take: a node that died is found out after a minute, and its tasks are held for two.
const PATIENCE: Duration = Duration::from_secs(270);
/// How often the command is given again, at most.
const ROUNDS: usize = 3;

pub(super) struct Sweep<'a> {
    pub(super) cluster: &'a Cluster,
    pub(super) program: PathBuf,
    pub(super) experiments: PathBuf,
    pub(super) out: PathBuf,
    pub(super) tasks: usize,
}

/// The tables that do not depend on the clock.
type Tables = [Vec<u8>; 2];

impl Sweep<'_> {
    fn command(&self) -> Command {
        let mut command = self.cluster.command(&self.program);
        command.arg("reproduce").args(FIGURE);
        command.arg("--experiments").arg(&self.experiments).arg("--out").arg(&self.out);
        command
    }

    fn on_slurm(&self, more: &[&str]) -> Result<Output, String> {
        let mut command = self.command();
        command.args(["--engine", "slurm", "--tasks", &self.tasks.to_string()]).args(more);
        command.output().map_err(|error| format!("{}: {error}", self.program.display()))
    }

    /// Runs it in this process's place, without Slurm.
    pub(super) fn run_here(&self) -> Result<(), String> {
        capture(&mut self.command()).map(drop)
    }

    /// Submits what is missing.
    pub(super) fn submit(&self) -> Result<(), String> {
        let output = self.on_slurm(&[])?;
        match output.status.success() {
            true => Ok(()),
            false => Err(format!("not submitted: {}", said(&output))),
        }
    }

    /// Waits until nothing of it is in the queue.
    pub(super) fn wait(&self) -> Result<(), String> {
        wait_for("the end of the array", PATIENCE, || {
            let mut squeue = self.cluster.command("squeue");
            // A controller that is being restarted does not answer.
            Ok(capture(squeue.arg("--noheader")).is_ok_and(|jobs| jobs.is_empty()))
        })
    }

    /// Waits until nothing of it is in the queue, and takes back what is stuck there: Slurm holds some tasks for good after a fault.
    pub(super) fn wait_or_take_back(&self) -> Result<&'static str, String> {
        if self.wait().is_ok() {
            return Ok("Slurm ran all tasks to an end");
        }
        self.cluster.cancel_all();
        self.wait()?;
        self.cluster.resume_nodes();
        Ok("Slurm held a task for good, and it was taken back")
    }

    /// Gives the same command again until all units are there; says how often.
    pub(super) fn again_until_all_is_there(&self) -> Result<usize, String> {
        for round in 0..ROUNDS {
            let status = capture(self.command().arg("--status"))?;
            if status.lines().next().is_some_and(|line| line.ends_with(" 0 left")) {
                return Ok(round);
            }
            self.submit()?;
            self.wait()?;
        }
        Err(format!("units are left after {ROUNDS} more rounds"))
    }

    /// Waits until tasks have left some units.
    pub(super) fn wait_for_units(&self) -> Result<(), String> {
        wait_until("the first units", || {
            let entries = std::fs::read_dir(self.results()).into_iter().flatten().flatten();
            let is_part = |path: PathBuf| path.to_string_lossy().ends_with(".part.jsonl");
            Ok(entries.filter(|entry| is_part(entry.path())).count() > 4)
        })
    }

    /// Waits until the controller answers.
    pub(super) fn wait_for_an_answer(&self) -> Result<(), String> {
        wait_until("the controller", || Ok(capture(self.cluster.command("squeue").arg("--noheader")).is_ok()))
    }

    fn results(&self) -> PathBuf {
        self.out.join(FIGURE[0]).join(FIGURE[2])
    }

    /// What the last job made.
    pub(super) fn tables(&self) -> Result<Tables, String> {
        let read = |name: &str| {
            let path: &Path = &self.results().join(name);
            std::fs::read(path).map_err(|error| format!("{}: {error}", path.display()))
        };
        Ok([read("units.csv")?, read("summary.csv")?])
    }

    pub(super) fn is(&self, expected: &Tables) -> Result<(), String> {
        match self.tables()? == *expected {
            true => Ok(()),
            false => Err(format!(
                "the tables in {} are others than those of the local run",
                self.results().display()
            )),
        }
    }

    /// A sweep that is done has nothing to submit.
    pub(super) fn submits_nothing(&self) -> Result<String, String> {
        let output = self.on_slurm(&[])?;
        let mut squeue = self.cluster.command("squeue");
        let jobs = capture(squeue.arg("--noheader"))?;
        match output.status.success() && jobs.is_empty() && said(&output).contains(" 0 to run") {
            true => Ok("the same command had nothing to submit".into()),
            false => Err(format!("a finished sweep was submitted again: {}", said(&output))),
        }
    }

    /// What Slurm refuses is told in its own words, and leaves nothing in the queue.
    pub(super) fn refuses_what_slurm_refuses(&self) -> Result<String, String> {
        let output = self.on_slurm(&["--partition", "nowhere"])?;
        let said = said(&output);
        let line = said.lines().last().unwrap_or_default();
        match output.status.code() == Some(3) && line.contains("invalid partition") {
            true => Ok(format!("a partition that is not there: {line}")),
            false => Err(format!("a partition that is not there was not refused: {said}")),
        }
    }
}

fn said(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).trim().to_string()
}
