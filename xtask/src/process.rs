//! Starting other programs.

use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode, ExitStatus};

use motes_cli::status;

/// A program that cargo built in a profile: beside this one, wherever cargo was told to put what it builds.
pub(crate) fn built(profile: &str, program: &str) -> PathBuf {
    let this = std::env::current_exe().unwrap_or_default();
    let target = this.parent().and_then(Path::parent).unwrap_or(Path::new("target"));
    target.join(profile).join(format!("{program}{}", std::env::consts::EXE_SUFFIX))
}

/// Cargo with some arguments, in `root`.
fn cargo_in(root: &Path, arguments: &[&str]) -> Command {
    let mut command = Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
    command.current_dir(root).args(arguments);
    command
}

/// Runs cargo in `root`; `Err` is the status to end with.
pub(crate) fn cargo(root: &Path, arguments: &[&str], environment: &[(&str, &str)]) -> Result<(), ExitCode> {
    run(cargo_in(root, arguments).envs(environment.iter().copied()))
}

/// Builds a program in release mode; if that fails, one line below cargo's own says what was built, and what for.
pub(crate) fn build(root: &Path, program: &str, features: &[&str], purpose: &str) -> Result<(), ExitCode> {
    if !built("release", program).exists() {
        status(&format!("building {program} in release mode; the first build takes some minutes"));
    }
    let arguments = [&["build", "--release", "--package", program], features].concat();
    if ended(&mut cargo_in(root, &arguments))?.success() {
        return Ok(());
    }
    status(&format!("error: cargo {} failed{purpose}", arguments.join(" ")));
    Err(ExitCode::FAILURE)
}

/// Runs a command to its end; `Err` is the status to end with.
pub(crate) fn run(command: &mut Command) -> Result<(), ExitCode> {
    let ended = ended(command)?;
    if ended.success() {
        return Ok(());
    }
    Err(ExitCode::from(ended.code().map_or(1, |code| u8::try_from(code).unwrap_or(1))))
}

/// How a command ended; `Err` is the status to end with if it cannot be started.
fn ended(command: &mut Command) -> Result<ExitStatus, ExitCode> {
    command.status().map_err(|error| {
        status(&format!("error: {}: {error}", command.get_program().to_string_lossy()));
        ExitCode::from(3)
    })
}

/// Replaces this process, so that signals and the exit status are the program's own.
#[cfg(unix)]
pub(crate) fn become_program(program: &Path, arguments: &[OsString]) -> ExitCode {
    use std::os::unix::process::CommandExt;
    let mut command = Command::new(program);
    // Large pages of memory, in which one walks through matrices of weights faster. The C library of Linux reads this; others do not
    // look at it.
    const TUNABLES: &str = "GLIBC_TUNABLES";
    if std::env::var_os(TUNABLES).is_none() {
        command.env(TUNABLES, "glibc.malloc.hugetlb=1");
    }
    let error = command.args(arguments).exec();
    status(&format!("error: {}: {error}", program.display()));
    ExitCode::from(3)
}

/// Runs the program and ends as it does.
#[cfg(not(unix))]
pub(crate) fn become_program(program: &Path, arguments: &[OsString]) -> ExitCode {
    run(Command::new(program).args(arguments)).err().unwrap_or(ExitCode::SUCCESS)
}
