//! Python in pages.

use std::path::{Path, PathBuf};
use std::process::Command;

/// An interpreter that has the package.
pub(super) struct Python {
    program: PathBuf,
    package: PathBuf,
}

impl Python {
    /// That of the environment of `cargo xtask python`; none where that was never made, `Err` where its package does not load.
    pub(super) fn find(root: &Path) -> Result<Option<Self>, String> {
        let package = root.join("crates/python/python");
        let python = Python { program: root.join("target/python/bin/python"), package };
        if !python.program.exists() {
            return Ok(None);
        }
        python.run(root, "import motes").map(|()| Some(python))
    }

    fn command(&self, arguments: &[&str]) -> Command {
        let mut command = Command::new(&self.program);
        command.args(arguments).env("PYTHONPATH", &self.package);
        command
    }

    /// Runs code in a folder; `Err` is what it said.
    pub(super) fn run(&self, folder: &Path, code: &str) -> Result<(), String> {
        let output = self.command(&["-c", code]).current_dir(folder).output();
        let output = output.map_err(|error| format!("{}: {error}", self.program.display()))?;
        match output.status.success() {
            true => Ok(()),
            false => {
                let said = String::from_utf8_lossy(&output.stderr);
                Err(format!("{} failed: {}", self.program.display(), said.trim_end()))
            }
        }
    }
}
