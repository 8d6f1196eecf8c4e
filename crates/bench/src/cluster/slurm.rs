//! Slurm's own commands.

use std::io::ErrorKind;
use std::path::Path;
use std::process::{Command, Output};

use super::error::ClusterError;

/// Makes sure that jobs can be submitted from here.
pub(super) fn check() -> Result<(), ClusterError> {
    run(Command::new("sbatch").arg("--version")).map(drop)
}

/// Submits a script and gives the number of its job.
pub(super) fn submit(script: &Path, more: &[String]) -> Result<String, ClusterError> {
    let output = run(Command::new("sbatch").arg("--parsable").args(more).arg(script))?;
    // The last line is `NUMBER` or `NUMBER;CLUSTER`; some sites say more before it.
    let text = String::from_utf8_lossy(&output.stdout);
    let last = text.lines().rfind(|line| !line.trim().is_empty()).unwrap_or_default();
    let number = last.trim().split(';').next().unwrap_or_default();
    match !number.is_empty() && number.bytes().all(|byte| byte.is_ascii_digit()) {
        true => Ok(number.to_string()),
        false => Err(ClusterError::Refused {
            command: "sbatch".into(),
            words: format!(
                "it said {last:?} where a job's number was expected; squeue --me shows whether it took the job"
            ),
        }),
    }
}

/// Takes back a job.
pub(super) fn cancel(job: &str) {
    // A job that has ended meanwhile needs no taking back.
    let _ = run(Command::new("scancel").arg(job));
}

/// What of a user's job waits or runs as far as Slurm says, tasks by their numbers; none where it says nothing. Only a hint: it saves work that
/// would be done twice.
pub(super) fn queued(job: &str) -> Option<Vec<Option<usize>>> {
    let arguments = ["--me", "--noheader", "--array", "--format=%K", "--jobs", job];
    let output = Command::new("squeue").args(arguments).output().ok()?;
    if !output.status.success() {
        // A job that it has forgotten is not queued.
        return words(&output).contains("Invalid job id").then(Vec::new);
    }
    let text = String::from_utf8_lossy(&output.stdout);
    Some(text.lines().map(|line| line.trim().parse().ok()).collect())
}

fn run(command: &mut Command) -> Result<Output, ClusterError> {
    let name = command.get_program().to_string_lossy().into_owned();
    match command.output() {
        Ok(output) if output.status.success() => Ok(output),
        Ok(output) => Err(ClusterError::Refused { command: name, words: words(&output) }),
        Err(error) if error.kind() == ErrorKind::NotFound => Err(ClusterError::NoSlurm),
        Err(error) => Err(ClusterError::Refused { command: name, words: error.to_string() }),
    }
}

/// What a command said, in one line.
fn words(output: &Output) -> String {
    let text = String::from_utf8_lossy(&output.stderr);
    let lines =
        text.lines().map(|line| line.trim().trim_start_matches("sbatch: ").trim_start_matches("error: "));
    lines.filter(|line| !line.is_empty()).collect::<Vec<_>>().join("; ")
}
