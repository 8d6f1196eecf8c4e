//! What xtask asks cargo for, and what it does when a build fails.
#![cfg(unix)]

use std::path::PathBuf;
use std::process::{Command, Output, Stdio};
use std::sync::{Mutex, MutexGuard, PoisonError};

use tempfile::TempDir;

/// A copy of xtask with a target folder of its own, programs in it that say how they were started, and a cargo that does the same.
struct Place {
    folder: TempDir,
}

impl Place {
    /// `runner` and `cargo` are what the shell does in their place.
    fn new(runner: &str, cargo: &str) -> Self {
        let place = Place { folder: tempfile::tempdir().unwrap() };
        let _alone = alone();
        std::fs::create_dir(place.path("release")).unwrap();
        std::fs::copy(env!("CARGO_BIN_EXE_xtask"), place.path("release/xtask")).unwrap();
        for program in ["motes-bench", "motes-speed"] {
            place.script(&format!("release/{program}"), &format!("echo {program} \"$@\" >>{LOG}; {runner}"));
        }
        place.script("cargo", &format!("echo cargo \"$@\" >>{LOG}; {cargo}"));
        place
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn script(&self, name: &str, text: &str) {
        use std::os::unix::fs::PermissionsExt;
        let path = self.path(name);
        std::fs::write(&path, format!("#!/bin/sh\ncd {}\n{text}\n", self.folder.path().display())).unwrap();
        std::fs::set_permissions(path, std::fs::Permissions::from_mode(0o755)).unwrap();
    }

    fn run(&self, arguments: &[&str]) -> Output {
        let mut command = Command::new(self.path("release/xtask"));
        command.args(arguments).env("CARGO", self.path("cargo"));
        command.env("CARGO_MANIFEST_DIR", "/work/xtask");
        command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
        let started = {
            let _alone = alone();
            command.spawn().unwrap()
        };
        started.wait_with_output().unwrap()
    }

    /// What was started, in order.
    fn log(&self) -> Vec<String> {
        let text = std::fs::read_to_string(self.path(LOG)).unwrap_or_default();
        text.lines().map(String::from).collect()
    }
}

/// Writes programs or starts one, and no other test does meanwhile: a program cannot be started while a process that another
/// test has just forked still has it open for writing.
fn alone() -> MutexGuard<'static, ()> {
    static ALONE: Mutex<()> = Mutex::new(());
    ALONE.lock().unwrap_or_else(PoisonError::into_inner)
}

const LOG: &str = "log";
const BUILD: &str = "cargo build --release --package motes-bench";

fn said(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).trim().to_string()
}

#[test]
fn the_runner_gets_the_arguments_and_where_things_are() {
    let place = Place::new("exit 7", "exit 0");
    let output =
        place.run(&["reproduce", "fig1", "--profile", "paper", "--out=there", "--backend", "native"]);
    assert_eq!(output.status.code(), Some(7));
    assert_eq!(
        place.log(),
        [
            BUILD,
            "motes-bench reproduce --experiments /work/experiments fig1 --profile paper --out=there --backend native"
        ]
    );
    for (arguments, started) in [
        (
            ["verify", "--help"],
            "verify --experiments /work/experiments --from /work/experiments/reference --help",
        ),
        (["verify", "--from=x"], "verify --experiments /work/experiments --from=x"),
    ] {
        let place = Place::new("exit 0", "exit 0");
        assert!(place.run(&arguments).status.success());
        assert_eq!(place.log(), [BUILD, &format!("motes-bench {started}")]);
    }
    let place = Place::new("exit 0", "exit 0");
    assert!(place.run(&["bench", "--peers"]).status.success());
    assert_eq!(
        place.log()[1],
        "motes-speed measure --out /work/runs/speed --peer-scripts /work/crates/speed/peers --peers"
    );
}

#[test]
fn backends_of_burn_are_built_after_the_arguments_were_checked() {
    for backend in [&["--backend", "flex"][..], &["--backend=ndarray"]] {
        let place = Place::new("exit 0", "exit 0");
        assert!(place.run(&[&["reproduce", "fig1"], backend].concat()).status.success());
        let arguments =
            format!("--experiments /work/experiments --out /work/runs fig1 {}", backend.join(" "));
        let (check, run) = (
            format!("motes-bench reproduce --dry-run {arguments}"),
            format!("motes-bench reproduce {arguments}"),
        );
        let with_burn = format!("{BUILD} --features burn");
        assert_eq!(place.log(), [BUILD, &check, &with_burn, &run]);
    }
    // What the check refuses is not built.
    let place = Place::new("echo error: no such figure >&2; exit 2", "exit 0");
    let output = place.run(&["reproduce", "fig0", "--backend", "flex"]);
    assert_eq!((output.status.code(), said(&output).as_str()), (Some(2), "error: no such figure"));
    assert_eq!(place.log().len(), 2);
}

#[test]
fn a_build_that_fails_is_said_in_one_line() {
    let place = Place::new("exit 0", "case \"$*\" in *burn*) exit 101;; esac");
    let output = place.run(&["reproduce", "fig1", "--backend", "flex"]);
    assert_eq!(
        said(&output),
        "error: cargo build --release --package motes-bench --features burn failed; the backend needs it"
    );
    assert_eq!(output.status.code(), Some(1));
    let place = Place::new("exit 0", "exit 101");
    let output = place.run(&["verify"]);
    assert_eq!(said(&output), "error: cargo build --release --package motes-bench failed");
    assert_eq!((output.status.code(), place.log().len()), (Some(1), 1));
}

#[test]
fn a_wrong_command_starts_nothing() {
    let place = Place::new("exit 0", "exit 0");
    let output = place.run(&["reprodce"]);
    let line = "error: unrecognized subcommand 'reprodce'  tip: a similar subcommand exists: 'reproduce'; see cargo xtask --help";
    assert_eq!((output.status.code(), said(&output).as_str()), (Some(2), line));
    assert_eq!(place.log(), [""; 0]);
}

#[test]
fn a_cargo_that_is_not_there_is_said() {
    let place = Place::new("exit 0", "exit 0");
    std::fs::remove_file(place.path("cargo")).unwrap();
    let output = place.run(&["reproduce", "fig1"]);
    assert!(said(&output).contains("No such file or directory"), "{}", said(&output));
    assert_eq!(output.status.code(), Some(3));
}
