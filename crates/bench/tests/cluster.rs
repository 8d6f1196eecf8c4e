//! Sweeps as job arrays, on programs that stand for Slurm's: they run a job's script where it is submitted. `cargo xtask slurm-test` does the
//! same on a real one.
#![cfg(unix)]

mod common;

use std::os::unix::fs::PermissionsExt;
use std::path::PathBuf;
use std::process::{Command, Output, Stdio};

use common::{TINY, Workplace, stderr};

/// Runs a script as its job, each task of an array after the other. A file `refuse` has what it refuses; `kill` has how many tasks it kills.
const SBATCH: &str = r#"#!/bin/bash
here=$(dirname "$0")
[ "$1" = --version ] && exit 0
script=${!#}
echo "$@" >> "$here/submitted"
if [ -e "$here/refuse" ] && [[ $script == *array.sh ]]; then
  cat "$here/refuse" >&2; exit 1
fi
if [ -e "$here/elsewhere" ]; then echo 7; exit 0; fi
last=$(sed -n 's/#SBATCH --array=0-//p' "$script")
for task in $(seq 0 "${last:-0}"); do
  if [ -e "$here/kill" ] && [ "$task" -lt "$(cat "$here/kill")" ] && [ -n "$last" ]; then continue; fi
  SLURM_ARRAY_TASK_ID=$task bash "$script" >> "$here/log" 2>&1
done
echo 7
"#;

/// Nothing waits, but what a file says.
const SQUEUE: &str = "#!/bin/bash\ncat \"$(dirname \"$0\")/queue\" 2>/dev/null\nexit 0\n";

struct Cluster {
    place: Workplace,
}

impl Cluster {
    fn new() -> Cluster {
        let place = Workplace::new(TINY);
        std::fs::create_dir(place.path("bin")).unwrap();
        for (name, text) in [("sbatch", SBATCH), ("squeue", SQUEUE), ("scancel", "#!/bin/bash\n")] {
            let path = place.path("bin").join(name);
            std::fs::write(&path, text).unwrap();
            std::fs::set_permissions(&path, std::fs::Permissions::from_mode(0o755)).unwrap();
        }
        Cluster { place }
    }

    fn command(&self, arguments: &[&str]) -> Command {
        let path = std::env::var("PATH").unwrap();
        let mut command = self.place.reproduce(&["tiny", "--engine", "slurm"]);
        command.env("PATH", format!("{}:{path}", self.place.path("bin").display())).args(arguments);
        command
    }

    fn run(&self, arguments: &[&str]) -> Output {
        self.command(arguments).output().unwrap()
    }

    fn write(&self, name: &str, text: &str) {
        // The mode of a program stays.
        std::fs::write(self.place.path("bin").join(name), text).unwrap();
    }

    fn remove(&self, name: &str) {
        std::fs::remove_file(self.place.path("bin").join(name)).unwrap();
    }

    /// `motes-bench` with these arguments, as a task has it.
    fn task(&self, submission: &str, task: &str) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_motes-bench"));
        command.arg("work").arg(self.place.path(submission)).arg(task).stderr(Stdio::null());
        command
    }

    /// Tables, without what names the number of threads or the time.
    fn expected(&self) -> Vec<(String, Vec<u8>)> {
        assert!(self.place.run(&["tiny", "--out", "whole"]).status.success());
        self.place.tables("whole")
    }
}

fn stdout(output: &Output) -> String {
    String::from_utf8_lossy(&output.stdout).into_owned()
}

#[test]
fn an_array_makes_the_tables_of_a_local_run() {
    let cluster = Cluster::new();
    let output = cluster.run(&["--tasks", "5"]);
    assert!(output.status.success(), "{}", stderr(&output));
    let said = stdout(&output);
    assert!(said.starts_with("job 7: 48 units in 5 tasks, the longest of which takes about "), "{said}");
    assert_eq!(cluster.place.tables("runs"), cluster.expected());
    let parts = cluster.place.files("runs/tiny/quick", "part.jsonl");
    assert!(parts.is_empty(), "{parts:?}");
    // The array waits for nothing, the job after it for the array, however that ends.
    let submitted = std::fs::read_to_string(cluster.place.path("bin/submitted")).unwrap();
    let jobs: Vec<&str> = submitted.lines().map(|line| line.split('/').next().unwrap()).collect();
    assert_eq!(jobs, ["--parsable ", "--parsable ", "--parsable --dependency=afterany:7 "]);

    // All is there: the same command submits nothing and makes the tables here.
    let output = cluster.run(&["--tasks", "5"]);
    assert!(output.status.success(), "{}", stderr(&output));
    assert!(stdout(&output).contains("written to runs/tiny/quick"), "{}", stdout(&output));
    assert!(!cluster.place.path("runs/slurm/0002").exists());
}

#[test]
fn the_same_command_submits_what_killed_tasks_left() {
    let cluster = Cluster::new();
    cluster.write("kill", "2");
    assert!(cluster.run(&["--tasks", "4"]).status.success());
    let left = 48 - cluster.place.units("runs");
    assert!((1..48).contains(&left), "{left} units are left");
    let output = cluster.run(&["--status"]);
    let said = stdout(&output);
    assert!(
        said.starts_with(&format!("tiny quick: {} of 48 units done, 0 failed, {left} left\n", 48 - left))
    );
    let begun = said.lines().filter(|line| line.ends_with("| has not begun |")).count();
    let ended = said.lines().filter(|line| line.contains("| ended ")).count();
    assert_eq!((begun, ended), (2, 2), "{said}");

    // As long as Slurm lists these tasks they are left to it.
    cluster.write("queue", "0\n1\n");
    let output = cluster.run(&["--tasks", "4"]);
    assert!(stderr(&output).contains(&format!("{left} units are left to job 7")), "{}", stderr(&output));
    assert!(output.status.success() && !cluster.place.path("runs/slurm/0002").exists());
    cluster.remove("queue");

    cluster.remove("kill");
    let output = cluster.run(&["--tasks", "4"]);
    assert!(stdout(&output).starts_with(&format!("job 7: {left} units in ")), "{}", stdout(&output));
    assert_eq!(cluster.place.tables("runs"), cluster.expected());
}

#[test]
fn tasks_that_are_run_twice_at_once_and_killed_do_no_harm() {
    let cluster = Cluster::new();
    cluster.write("kill", "2");
    assert!(cluster.run(&["--tasks", "2"]).status.success());
    let submission = "runs/slurm/0001";
    let mut killed = cluster.task(submission, "0").spawn().unwrap();
    std::thread::sleep(std::time::Duration::from_millis(30));
    killed.kill().unwrap();
    killed.wait().unwrap();
    let twice = ["0", "0", "1", "1"].map(|task| cluster.task(submission, task).spawn().unwrap());
    for mut task in twice {
        assert!(task.wait().unwrap().success());
    }
    let mut finish = Command::new(env!("CARGO_BIN_EXE_motes-bench"));
    let output = finish.arg("finish").arg(cluster.place.path(submission)).output().unwrap();
    assert!(output.status.success(), "{}", stderr(&output));
    assert!(stdout(&output).contains("tiny quick: 48 of 48 units done, 0 failed, 0 left"));
    assert_eq!(cluster.place.tables("runs"), cluster.expected());
}

#[test]
fn what_slurm_refuses_is_said_once_and_in_its_words() {
    let cluster = Cluster::new();
    cluster.write("refuse", "sbatch: error: invalid partition specified: nowhere\n");
    let output = cluster.run(&["--partition", "nowhere"]);
    let last = stderr(&output).lines().last().unwrap_or_default().to_string();
    assert_eq!(last, "error: sbatch: invalid partition specified: nowhere");
    assert_eq!(output.status.code(), Some(3));
    assert!(!cluster.place.path("runs/slurm/0001").exists());
}

#[test]
fn a_folder_that_nodes_do_not_see_is_found_out_before_the_array_is_submitted() {
    let cluster = Cluster::new();
    cluster.write("elsewhere", "");
    let output = cluster.run(&[]);
    let said = stderr(&output);
    assert!(
        said.lines().last().unwrap_or_default().contains("--out must be a folder that all nodes share"),
        "{said}"
    );
    assert_eq!(output.status.code(), Some(3));
    let submitted = std::fs::read_to_string(cluster.place.path("bin/submitted")).unwrap();
    assert_eq!(submitted.lines().count(), 1, "{submitted}");
}

#[test]
fn paths_that_would_spoil_a_script_are_refused() {
    let cluster = Cluster::new();
    for out in ["a\"b", "a\\b", "a\nb"] {
        let output = cluster.run(&["--dry-run", "--out", out]);
        let said = stderr(&output);
        assert!(said.contains("scripts of Slurm cannot name it") && said.lines().count() == 1, "{said}");
        assert_eq!(output.status.code(), Some(2));
    }
}

#[test]
fn a_damaged_submission_stands_in_nobodys_way() {
    let cluster = Cluster::new();
    cluster.write("kill", "1");
    assert!(cluster.run(&["--tasks", "3"]).status.success());
    let folder = cluster.place.path("runs/slurm/0001");
    std::fs::write(folder.join("share-0.jsonl"), "{").unwrap();
    let output = cluster.run(&["--status"]);
    assert!(output.status.success() && stderr(&output).starts_with("left out: "), "{}", stderr(&output));
    cluster.write("queue", "0\nN/A\n99\n");
    std::fs::write(folder.join("submission.json"), "{").unwrap();
    assert!(cluster.run(&["--status"]).status.success());
    cluster.remove("kill");
    assert!(cluster.run(&["--tasks", "3"]).status.success());
    cluster.remove("queue");
    assert!(cluster.run(&["--tasks", "3"]).status.success());
    assert_eq!(cluster.place.tables("runs"), cluster.expected());
}

#[test]
fn what_is_no_number_of_a_job_is_taken_for_none() {
    let cluster = Cluster::new();
    let sbatch = SBATCH.replace("echo 7", "echo Welcome; echo 7");
    cluster.write("sbatch", &sbatch);
    assert!(stdout(&cluster.run(&["--tasks", "2"])).starts_with("job 7: 48 units"));
    let cluster = Cluster::new();
    cluster.write("sbatch", &SBATCH.replace("echo 7", "echo Welcome"));
    let output = cluster.run(&["--tasks", "2"]);
    assert!(stderr(&output).contains("where a job's number was expected"), "{}", stderr(&output));
    assert_eq!(output.status.code(), Some(3));
}

#[test]
fn without_slurm_one_line_says_so() {
    let place = Workplace::new(TINY);
    let output =
        place.reproduce(&["tiny", "--engine", "slurm"]).env("PATH", place.folder.path()).output().unwrap();
    assert_eq!(
        stderr(&output),
        "error: sbatch is not on the path; give --engine slurm on a login node of a cluster, or leave it out"
    );
    assert_eq!(output.status.code(), Some(3));
}

#[test]
fn a_time_limit_below_one_units_estimate_is_warned_of() {
    let cluster = Cluster::new();
    let slow = TINY.replacen("training_steps = 20", "training_steps = 10000000", 1);
    std::fs::write(cluster.place.path("experiments/tiny.toml"), slow).unwrap();
    cluster.write("kill", "1000");
    let said = stderr(&cluster.run(&["--methods", "fcnn", "--time", "1"]));
    assert!(said.contains("warning: --time 1 leaves less than the "), "{said}");
}

#[test]
fn a_dry_run_prints_scripts_that_a_checker_of_scripts_accepts() {
    let cluster = Cluster::new();
    let output = cluster.run(&[
        "--dry-run",
        "--tasks",
        "4",
        "--partition",
        "p",
        "--time",
        "1-0",
        "--sbatch",
        "--mem-per-cpu=4G",
    ]);
    assert!(output.status.success(), "{}", stderr(&output));
    let said = stdout(&output);
    assert!(!cluster.place.path("runs").exists(), "a dry run wrote something");
    for option in ["--array=0-3", "--partition=p", "--time=1-0", "--mem-per-cpu=4G"] {
        assert!(said.contains(&format!("#SBATCH {option}\n")), "{option}: {said}");
    }
    let scripts: Vec<&str> = said.split("==> ").skip(1).collect();
    assert_eq!(scripts.len(), 3);
    for (number, script) in scripts.into_iter().enumerate() {
        let (_, text) = script.split_once(" <==\n").unwrap();
        let path: PathBuf = cluster.place.path(&format!("{number}.sh"));
        std::fs::write(&path, text).unwrap();
        match Command::new("shellcheck").arg(&path).output() {
            Ok(output) => assert!(output.status.success(), "{text}\n{}", stdout(&output)),
            Err(_) => println!("shellcheck is not there: skipped"),
        }
        assert!(Command::new("bash").arg("-n").arg(&path).status().unwrap().success());
    }
}
