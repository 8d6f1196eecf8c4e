//! Building the programs that do the work in release mode, and becoming them.

use std::ffi::{OsStr, OsString};
use std::path::Path;
use std::process::{Command, ExitCode, Stdio};

use crate::process::{become_program, build, built, run};

const RUNNER: &str = "motes-bench";
const PURPOSE: &str = "; the backend needs it";
const DRY_RUN: &str = "--dry-run";

/// Runs a figure. With a backend of burn, arguments and experiment file are checked before burn is built.
pub(crate) fn reproduce(root: &Path, arguments: &[OsString]) -> ExitCode {
    let folders = [("--experiments", root.join("experiments")), ("--out", root.join("runs"))];
    let arguments = with_folders("reproduce", arguments, folders);
    if let Err(exit_status) = build(root, RUNNER, &[], "") {
        return exit_status;
    }
    if let Some(feature) = feature(&arguments)
        && !arguments.iter().any(|argument| argument == DRY_RUN)
    {
        let mut check = Command::new(built("release", RUNNER));
        check.arg(&arguments[0]).arg(DRY_RUN).args(&arguments[1..]).stdout(Stdio::null());
        if let Err(exit_status) = run(&mut check) {
            return exit_status;
        }
        if let Err(exit_status) = build(root, RUNNER, &["--features", feature], PURPOSE) {
            return exit_status;
        }
    }
    become_program(&built("release", RUNNER), &arguments)
}

/// Judges the paper's claims.
pub(crate) fn verify(root: &Path, arguments: &[OsString]) -> ExitCode {
    let reference = root.join("experiments/reference");
    let folders = [("--experiments", root.join("experiments")), ("--from", reference)];
    hand_over(root, RUNNER, with_folders("verify", arguments, folders))
}

/// Times filters and training.
pub(crate) fn measure(root: &Path, arguments: &[OsString]) -> ExitCode {
    let folders = [("--out", root.join("runs/speed")), ("--peer-scripts", root.join("crates/speed/peers"))];
    hand_over(root, "motes-speed", with_folders("measure", arguments, folders))
}

fn hand_over(root: &Path, program: &str, arguments: Vec<OsString>) -> ExitCode {
    match build(root, program, &[], "") {
        Ok(()) => become_program(&built("release", program), &arguments),
        Err(exit_status) => exit_status,
    }
}

/// Like cargo, programs work on the workspace from whatever folder of it the command is given in: the command, where things are if
/// that was left open, then the arguments as they were given.
fn with_folders<const COUNT: usize>(
    command: &str,
    arguments: &[OsString],
    folders: [(&str, std::path::PathBuf); COUNT],
) -> Vec<OsString> {
    let is_given = |option: &str| arguments.iter().any(|argument| value_of(option, argument).is_some());
    let open = folders.into_iter().filter(|(option, _)| !is_given(option));
    let open = open.flat_map(|(option, folder)| [option.into(), folder.into_os_string()]);
    std::iter::once(command.into()).chain(open).chain(arguments.iter().cloned()).collect()
}

/// What an argument says of an option: nothing if it is another, an empty value if the value is the next argument.
fn value_of<'a>(option: &str, argument: &'a OsStr) -> Option<&'a str> {
    let rest = argument.to_str()?.strip_prefix(option)?;
    if rest.is_empty() { Some(rest) } else { rest.strip_prefix('=') }
}

/// The cargo feature that the backend needs, if it is another than our own; which names there are is the runner's business.
fn feature(arguments: &[OsString]) -> Option<&'static str> {
    let mut given =
        arguments.iter().enumerate().filter_map(|(at, argument)| match value_of("--backend", argument)? {
            "" => arguments.get(at + 1)?.to_str(),
            name => Some(name),
        });
    match given.next()? {
        "native" => None,
        "wgpu" => Some("wgpu"),
        "cuda" => Some("cuda"),
        _ => Some("burn"),
    }
}
