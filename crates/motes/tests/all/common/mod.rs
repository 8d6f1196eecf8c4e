//! Running the command in a folder of the test's own.
#![allow(dead_code, missing_docs)]

use std::path::PathBuf;
use std::process::{Command, Output, Stdio};

use tempfile::TempDir;

/// A random walk, measured.
pub const WALK: &str = r#"
[parameters]
noise = 1
[initial]
x = "normal(0, 1)"
[transition]
x = "normal(0.9*x, 1)"
[measurement]
y = "normal(x, noise)"
"#;

/// The same as matrices.
pub const WALK_LINEAR: &str = r#"
kind = "linear-gaussian"
states = ["x"]
measurements = ["y"]
A = [[0.9]]
Q = [[1.0]]
C = [[1.0]]
R = [[1.0]]
m0 = [0.0]
P0 = [[1.0]]
"#;

pub struct Workplace {
    pub folder: TempDir,
}

impl Workplace {
    pub fn new() -> Self {
        let place = Workplace { folder: tempfile::tempdir().unwrap() };
        place.write("walk.toml", WALK);
        place.write("linear.toml", WALK_LINEAR);
        place.write("d.csv", "y\n0.5\n1.5\n\n".trim_end());
        place
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    pub fn write(&self, name: &str, text: impl AsRef<[u8]>) {
        std::fs::write(self.path(name), text).unwrap();
    }

    pub fn read(&self, name: &str) -> String {
        std::fs::read_to_string(self.path(name)).unwrap()
    }

    /// `motes` with these arguments, not yet started.
    pub fn motes(&self, arguments: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_motes"));
        command.current_dir(self.folder.path()).args(arguments).stdin(Stdio::null());
        command
    }

    pub fn run(&self, arguments: &[&str]) -> Output {
        self.motes(arguments).output().unwrap()
    }

    /// What it printed where it was content.
    pub fn printed(&self, arguments: &[&str]) -> String {
        let output = self.run(arguments);
        assert_eq!(output.status.code(), Some(0), "{arguments:?}: {}", stderr(&output));
        String::from_utf8(output.stdout).unwrap()
    }
}

pub fn stderr(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).trim_end().to_string()
}
