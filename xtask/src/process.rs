//! Starting other programs.

use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};

use motes_cli::status;

/// A program that cargo built in a profile: beside this one, wherever cargo was told to put what it builds.
pub(crate) fn built(profile: &str, program: &str) -> PathBuf {
    let this = std::env::current_exe().unwrap_or_default();
    let target = this.parent().and_then(Path::parent).unwrap_or(Path::new("target"));
    target.join(profile).join(format!("{program}{}", std::env::consts::EXE_SUFFIX))
}

/// Runs cargo in `root`; `Err` is the status to end with.
pub(crate) fn cargo(root: &Path, arguments: &[&str], environment: &[(&str, &str)]) -> Result<(), ExitCode> {
    let program = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let mut command = Command::new(program);
    command.current_dir(root).args(arguments).envs(environment.iter().copied());
    run(&mut command)
}

/// Runs a command to its end; `Err` is the status to end with.
pub(crate) fn run(command: &mut Command) -> Result<(), ExitCode> {
    match command.status() {
        Ok(ended) if ended.success() => Ok(()),
        Ok(ended) => Err(ExitCode::from(ended.code().map_or(1, |code| u8::try_from(code).unwrap_or(1)))),
        Err(error) => {
            status(&format!("error: {}: {error}", command.get_program().to_string_lossy()));
            Err(ExitCode::from(3))
        }
    }
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
