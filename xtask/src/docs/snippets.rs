//! Python in pages.

use std::path::{Path, PathBuf};
use std::process::Command;

/// An interpreter that has the package.
pub(super) struct Python {
    program: PathBuf,
    package: PathBuf,
}

impl Python {
    /// That of the environment of `cargo xtask python`, where the package is built.
    pub(super) fn find(root: &Path) -> Option<Self> {
        let package = root.join("crates/python/python");
        let python = Python { program: root.join("target/python/bin/python"), package };
        let asked = python.command(&["-c", "import motes"]).stderr(std::process::Stdio::null()).status();
        asked.is_ok_and(|status| status.success()).then_some(python)
    }

    fn command(&self, arguments: &[&str]) -> Command {
        let mut command = Command::new(&self.program);
        command.args(arguments).env("PYTHONPATH", &self.package);
        command
    }

    /// Runs the code of a page in a folder; `Err` is what it said last.
    pub(super) fn run(&self, folder: &Path, code: &str) -> Result<(), String> {
        let output = self.command(&["-c", code]).current_dir(folder).output();
        let output = output.map_err(|error| format!("{}: {error}", self.program.display()))?;
        match output.status.success() {
            true => Ok(()),
            false => {
                let said = String::from_utf8_lossy(&output.stderr);
                Err(said.trim_end().lines().last().unwrap_or("Python failed").to_string())
            }
        }
    }
}
