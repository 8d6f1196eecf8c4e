//! Running the program on experiments of the tests' own.
#![allow(dead_code, missing_docs)]

use std::collections::BTreeSet;
use std::path::PathBuf;
use std::process::{Command, Output};

use tempfile::TempDir;

/// A folder with one small experiment, `tiny.toml`, and room for results.
pub struct Workplace {
    pub folder: TempDir,
}

pub const TINY: &str = r#"
title = "A tiny figure"
axis = "particles"
methods = ["min-degeneracy", "bootstrap", "fcnn"]

[system]
drift = "identity"
noise = "gaussian"
densities = "gaussian"
snr_db = 5.0
neighbours = 3
unmeasured = 2
dimension = 6
horizon = 4

[filter]
particles = 8
resampling = "multinomial"
ess_threshold = 0.3333333333333333

[training]
objective = "log-likelihood"
gradient = "full"
learning_rate = 0.001
beta_1 = 0.9
beta_2 = 0.999
epsilon = 1e-8

[proposals.fcnn]
ridge = 1e-6

[proposals.rnn]
cell = "lstm"
depth = 1
ridge = 1e-6

[proposals.gnn]
order = 3
adapter = "fixed"
ridge = 1e-6

[proposals.psi]
ridge = 1e-3

[[panels]]
name = "N6"
dimension = 6

[[panels]]
name = "N8"
dimension = 8

[profiles.quick]
x = [4, 8]
repetitions = 4
filter_runs = 5
training_steps = 20
reference_particles = 100
sizes = { fcnn = [16, 16], rnn = 8, gnn = [8, 8], psi = 3 }
"#;

impl Workplace {
    pub fn new(experiment: &str) -> Self {
        let folder = tempfile::tempdir().unwrap();
        std::fs::create_dir(folder.path().join("experiments")).unwrap();
        std::fs::write(folder.path().join("experiments/tiny.toml"), experiment).unwrap();
        Workplace { folder }
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// `motes-bench reproduce` with these arguments, not yet started.
    pub fn reproduce(&self, arguments: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_motes-bench"));
        command.current_dir(self.folder.path()).arg("reproduce").args(arguments);
        command
    }

    pub fn run(&self, arguments: &[&str]) -> Output {
        self.reproduce(arguments).output().unwrap()
    }

    /// Everything in the results folder `out` but what depends on the clock.
    pub fn tables(&self, out: &str) -> Vec<(String, Vec<u8>)> {
        let folder = self.path(out).join("tiny/quick");
        ["units.csv", "summary.csv", "table.md", "figure.svg", "failures.csv"]
            .map(|name| (name.to_string(), std::fs::read(folder.join(name)).unwrap()))
            .to_vec()
    }

    /// Number of stored units: whole lines, each key once, in parts and then in what they were merged into meanwhile.
    pub fn units(&self, out: &str) -> usize {
        let folder = format!("{out}/tiny/quick");
        let parts = self.files(&folder, "part.jsonl").into_iter();
        let texts =
            parts.chain([self.path(&folder).join("units.jsonl")]).filter_map(|path| std::fs::read(path).ok());
        let mut keys = BTreeSet::new();
        for text in texts {
            let lines = text.split_inclusive(|byte| *byte == b'\n').filter(|line| line.ends_with(b"\n"));
            keys.extend(lines.map(|line| line[..44].to_vec()));
        }
        keys.len()
    }

    /// The files in a folder, if it is there, whose names end so.
    pub fn files(&self, folder: &str, extension: &str) -> Vec<PathBuf> {
        let Ok(entries) = std::fs::read_dir(self.path(folder)) else { return vec![] };
        let paths = entries.map(|entry| entry.unwrap().path());
        let mut files: Vec<PathBuf> =
            paths.filter(|path| path.to_string_lossy().ends_with(&format!(".{extension}"))).collect();
        files.sort();
        files
    }
}

pub fn stderr(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).trim().to_string()
}
