//! Processes that take tasks: ours, and those of other libraries.

use std::io::{BufRead, BufReader, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};

use crate::error::SpeedError;
use crate::task::{Answer, Request, Task};

/// A process with one task.
pub(crate) struct Worker {
    name: String,
    child: Child,
    requests: ChildStdin,
    answers: BufReader<ChildStdout>,
}

impl Worker {
    /// Our own.
    pub(crate) fn ours(name: &str) -> Result<Self, SpeedError> {
        let program = std::env::current_exe().map_err(SpeedError::system("this program"))?;
        let mut command = Command::new(program);
        command.arg("serve");
        Worker::start(name, command)
    }

    /// Another library's, with the given Python and the folder of its scripts.
    pub(crate) fn peer(name: &str, python: &Path, scripts: &Path, task: &Task) -> Result<Self, SpeedError> {
        let mut command = Command::new(python);
        command.arg(scripts.join("worker.py")).args(["--threads", &task.threads().to_string()]);
        Worker::start(name, command)
    }

    fn start(name: &str, mut command: Command) -> Result<Self, SpeedError> {
        command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::null());
        let mut child = command.spawn().map_err(SpeedError::system(command.get_program()))?;
        let (Some(requests), Some(answers)) = (child.stdin.take(), child.stdout.take()) else {
            return Err(SpeedError::Worker { who: name.into(), reason: "it has no pipes".into() });
        };
        Ok(Worker { name: name.into(), child, requests, answers: BufReader::new(answers) })
    }

    /// Sends a request without waiting.
    pub(crate) fn send(&mut self, request: &Request) -> Result<(), SpeedError> {
        let text = serde_json::to_string(request).unwrap_or_default();
        writeln!(self.requests, "{text}").map_err(SpeedError::system(&self.name))
    }

    /// Waits for an answer; one that is an error becomes one.
    pub(crate) fn receive(&mut self) -> Result<Answer, SpeedError> {
        let fail = |reason: String| SpeedError::Worker { who: self.name.clone(), reason };
        let mut line = String::new();
        self.answers.read_line(&mut line).map_err(|error| fail(error.to_string()))?;
        if line.is_empty() {
            return Err(fail("it ended".into()));
        }
        let answer: Answer = serde_json::from_str(&line).map_err(|error| fail(error.to_string()))?;
        match answer.error {
            Some(reason) => Err(fail(reason)),
            None => Ok(answer),
        }
    }

    /// Waits for an answer that says how long a run took.
    pub(crate) fn receive_seconds(&mut self) -> Result<f64, SpeedError> {
        let seconds = self.receive()?.seconds;
        let fail = |reason: &str| SpeedError::Worker { who: self.name.clone(), reason: reason.into() };
        seconds.ok_or_else(|| fail("it did not say how long it took"))
    }

    pub(crate) fn ask(&mut self, request: &Request) -> Result<Answer, SpeedError> {
        self.send(request)?;
        self.receive()
    }

    pub(crate) fn prepare(&mut self, task: &Task) -> Result<Answer, SpeedError> {
        self.ask(&Request::Prepare(task.clone()))
    }

    /// The most memory that the process ever had, in bytes, where the system tells.
    pub(crate) fn peak_memory(&self) -> Option<u64> {
        let status = std::fs::read_to_string(format!("/proc/{}/status", self.child.id())).ok()?;
        let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
        Some(line.trim().strip_suffix("kB")?.trim().parse::<u64>().ok()? * 1024)
    }
}

impl Drop for Worker {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// A Python environment with the pinned versions of the other libraries, built once.
pub(crate) fn environment(scripts: &Path, folder: &Path) -> Result<PathBuf, SpeedError> {
    let python = folder.join("bin/python");
    let list = scripts.join("requirements.txt");
    let wanted = std::fs::read_to_string(&list).map_err(SpeedError::system(&list))?;
    // Written last: a half-built environment has none.
    let mark = folder.join("requirements.txt");
    if std::fs::read_to_string(&mark).is_ok_and(|found| found == wanted) {
        return absolute(&python);
    }
    motes_cli::status("building a Python environment with the other libraries; this takes some minutes");
    let run = |mut command: Command| {
        let name = command.get_program().to_string_lossy().into_owned();
        let status = command.stdout(Stdio::null()).status().map_err(SpeedError::system(&name))?;
        match status.success() {
            true => Ok(()),
            false => Err(SpeedError::Worker { who: name, reason: format!("{status}") }),
        }
    };
    let mut create = Command::new("python3");
    create.args(["-m", "venv", "--clear"]).arg(folder);
    run(create)?;
    let mut install = Command::new(&python);
    install.args(["-m", "pip", "install", "--quiet", "--requirement"]).arg(&list);
    run(install)?;
    std::fs::write(&mark, wanted).map_err(SpeedError::system(&mark))?;
    absolute(&python)
}

/// Without following links: the environment's Python is a link out of it.
fn absolute(path: &Path) -> Result<PathBuf, SpeedError> {
    std::path::absolute(path).map_err(SpeedError::system(path))
}
