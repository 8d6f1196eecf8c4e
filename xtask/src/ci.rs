//! What has to hold before a change lands.

use std::path::Path;
use std::process::{Command, ExitCode};
use std::time::Instant;

use crate::process::{built, cargo, run};

fn run_all(root: &Path, update_expectations: bool) -> Result<(), ExitCode> {
    let strict_docs = [("RUSTDOCFLAGS", "-D warnings")];
    step("format", || cargo(root, &["fmt", "--all", "--check"], &[]))?;
    step("lints", || {
        let lints = ["clippy", "--workspace", "--all-targets", "--locked", "--", "--deny", "warnings"];
        cargo(root, &lints, &[])
    })?;
    step("tests", || cargo(root, &["test", "--workspace", "--locked"], &[]))?;
    step("docs", || cargo(root, &["doc", "--workspace", "--no-deps", "--locked"], &strict_docs))?;
    // The same packages, targets and profile as the tests: nothing is compiled a second time.
    step("regression run", || {
        cargo(root, &["build", "--workspace", "--all-targets", "--locked"], &[])?;
        let mut command = Command::new(built("debug", "motes-bench"));
        command.current_dir(root).args(["regress", "fig1"]);
        if update_expectations {
            command.arg("--update");
        }
        run(&mut command)
    })?;
    step("instruction counts", || {
        let mut command = Command::new(built("debug", "motes-bench"));
        command.current_dir(root).arg("instructions");
        if update_expectations {
            command.arg("--update");
        }
        run(&mut command)
    })
}

/// Runs every check, stops at the first that fails, and ends with its status.
pub(crate) fn check(root: &Path, update_expectations: bool) -> ExitCode {
    match run_all(root, update_expectations) {
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
