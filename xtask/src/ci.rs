//! What has to hold before a change lands.

use std::path::Path;
use std::process::{Command, ExitCode};
use std::time::Instant;

use crate::process::{built, cargo, run};
use crate::{docs, python, slurm};

/// burn's backends, which tests hold ours against.
const WITH_BURN: [&str; 2] = ["--features", "burn"];

/// What every change is held against.
fn usual(root: &Path, update_expectations: bool) -> Result<(), ExitCode> {
    let strict_docs = [("RUSTDOCFLAGS", "-D warnings")];
    step("format", || cargo(root, &["fmt", "--all", "--check"], &[]))?;
    step("lints", || {
        let lints = |of: &[&str]| {
            cargo(
                root,
                &[&["clippy", "--workspace", "--locked"], of, &["--", "--deny", "warnings"]].concat(),
                &[],
            )
        };
        // Without burn what is shipped is linted; with it, tests are, too. Then the library without command and pages.
        lints(&[])?;
        lints(&[&["--all-targets"], WITH_BURN.as_slice()].concat())?;
        let alone = ["-p", "motes", "-p", "motes-cli", "--no-default-features", "--locked"];
        cargo(root, &[&["clippy"], alone.as_slice(), &["--", "--deny", "warnings"]].concat(), &[])
    })?;
    step("tests", || {
        cargo(root, &[&["test", "--workspace", "--locked"], WITH_BURN.as_slice()].concat(), &[])
    })?;
    step("packages", || package(root, &["--no-verify"]))?;
    step("docs", || cargo(root, &["doc", "--workspace", "--no-deps", "--locked"], &strict_docs))?;
    // The same targets and profile as the tests, so that dependencies have the same features: none is compiled a second time. Python's library is one of them.
    step("regression run", || {
        let build = ["build", "--workspace", "--lib", "--bins", "--tests", "--locked"];
        cargo(root, &[&build, WITH_BURN.as_slice()].concat(), &[python::AS_EXTENSION])?;
        let mut command = Command::new(built("debug", "motes-bench"));
        command.current_dir(root).args(["regress", "fig1"]);
        if update_expectations {
            command.arg("--update");
        }
        run(&mut command)
    })?;
    step("Python package", || python::check(root))?;
    step("gallery", || docs::check_gallery(root))?;
    step("instruction counts", || {
        let mut command = Command::new(built("debug", "motes-speed"));
        command.current_dir(root).arg("instructions");
        if update_expectations {
            command.arg("--update");
        }
        run(&mut command)
    })
}

/// What takes longer than one waits for at every change.
fn thorough(root: &Path) -> Result<(), ExitCode> {
    let scores = [
        "--test",
        "all",
        "--",
        "evidence::",
        "planted::",
        "calibration::",
        "exact_posteriors::",
        "--include-ignored",
        "--nocapture",
    ];
    step("scores of evidence, of planted bugs, of calibration and of posteriors", || {
        cargo(root, &[&["test", "--workspace", "--locked"], &WITH_BURN[..], &scores].concat(), &[])
    })?;
    let properties = ["test", "--workspace", "--locked", "--test", "properties", "--test", "any_experiment"];
    step("properties of many inputs", || {
        cargo(root, &[&properties[..], &WITH_BURN].concat(), &[("PROPTEST_CASES", MANY_CASES)])
    })?;
    step("crates built from their packages", || package(root, &[]))?;
    step("pages and their site", || docs::check_site(root))?;
    step("graphics processors", || graphics(root))?;
    step("sweeps on a real Slurm", || slurm::check(root))
}

/// burn's backend on Vulkan beside ours: loss, gradients, and trainings that go on.
fn graphics(root: &Path) -> Result<(), ExitCode> {
    // Debian's mesa-vulkan-drivers has one that computes on the host.
    let drivers = ["/usr/share/vulkan/icd.d", "/etc/vulkan/icd.d"];
    if !drivers.iter().any(|folder| std::fs::read_dir(folder).is_ok_and(|mut files| files.next().is_some())) {
        println!("ci: parity on wgpu is left out: there is no Vulkan driver");
        return Ok(());
    }
    let tests = ["test", "--locked", "--package", "motes-tests", "--features", "wgpu", "--test", "all"];
    cargo(root, &[&tests[..], &["--", "gradients::backends", "resume::"]].concat(), &[])
}

/// Packs all crates that are published as they would be: all files there, descriptions whole.
fn package(root: &Path, more: &[&str]) -> Result<(), ExitCode> {
    let arguments = ["publish", "--workspace", "--dry-run", "--locked", "--allow-dirty"];
    cargo(root, &[&arguments, more].concat(), &[])
}

/// Inputs that each property is held against in the thorough run, instead of 256.
const MANY_CASES: &str = "50000";

/// Runs every check, stops at the first that fails, and ends with its status.
pub(crate) fn check(root: &Path, all: bool, update_expectations: bool) -> ExitCode {
    let slow = || if all { thorough(root) } else { Ok(()) };
    match usual(root, update_expectations).and_then(|()| slow()) {
        Ok(()) => {
            println!("ci: all checks passed");
            ExitCode::SUCCESS
        }
        Err(status) => status,
    }
}

fn step(name: &str, check: impl FnOnce() -> Result<(), ExitCode>) -> Result<(), ExitCode> {
    println!("ci: {name}");
    let start = Instant::now();
    let result = check();
    let verdict = if result.is_ok() { "passed" } else { "FAILED" };
    println!("ci: {name} {verdict} in {:.0} s", start.elapsed().as_secs_f64());
    result
}
