//! The scripts that Slurm gets.

use std::path::Path;

use super::submission::Place;
use crate::config::{ClusterArgs, TimeLimit};

/// Seconds before the time limit at which a task is told, so that long trainings leave a checkpoint.
const WARNING: u64 = 120;

/// The names of the scripts.
pub(super) const PROBE: &str = "probe";
pub(super) const ARRAY: &str = "array";
pub(super) const FINISH: &str = "finish";

/// The jobs of a submission.
pub(super) struct Scripts<'a> {
    pub(super) place: &'a Place,
    pub(super) name: String,
    pub(super) args: &'a ClusterArgs,
    /// Tasks of the array.
    pub(super) tasks: usize,
    /// Threads of a task.
    pub(super) jobs: usize,
}

impl Scripts<'_> {
    /// All of them by their names.
    pub(super) fn all(&self) -> [(&'static str, String); 3] {
        [(PROBE, self.probe()), (ARRAY, self.array()), (FINISH, self.finish())]
    }

    /// The array, each task of which does its share. The shell becomes the program: signals and the exit status are its own.
    fn array(&self) -> String {
        let last = self.tasks - 1;
        let mut options = self.options("", "task-%a.log");
        options.push(format!("--array=0-{last}"));
        options.push(format!("--cpus-per-task={}", self.jobs));
        options.push("--requeue".into());
        let limit = self.args.time.as_ref().and_then(TimeLimit::seconds);
        let warning = limit.map_or(WARNING, |seconds| WARNING.min(seconds / 10));
        options.push(format!("--signal=B:TERM@{warning}"));
        options.extend(self.time());
        self.script(&options, &format!("work {} \"$SLURM_ARRAY_TASK_ID\"", self.folder()))
    }

    /// The job after the array.
    fn finish(&self) -> String {
        let mut options = self.options("-tables", "tables.log");
        options.extend(self.time());
        self.script(&options, &format!("finish {}", self.folder()))
    }

    /// The job before the array: runs the program on a node and leaves a file.
    fn probe(&self) -> String {
        let mut options = self.options("-probe", "probe.log");
        options.push("--time=5".into());
        let probed = quoted(&self.place.probed());
        self.script(&options, &format!("probed {probed}"))
    }

    fn time(&self) -> Option<String> {
        self.args.time.as_ref().map(|time| format!("--time={time}"))
    }

    fn folder(&self) -> String {
        quoted(self.place.folder())
    }

    fn options(&self, what: &str, log: &str) -> Vec<String> {
        // A percent sign begins a pattern of Slurm's, but for the one that was meant to.
        let folder = self.place.folder().display().to_string().replace('%', "%%");
        let mut options = vec![
            format!("--job-name=motes-{}{what}", self.name),
            format!("--output=\"{folder}/{log}\""),
            "--open-mode=append".into(),
            format!("--chdir=\"{}\"", self.place.folder().display()),
        ];
        options.extend(self.args.partition.as_ref().map(|partition| format!("--partition={partition}")));
        options.extend(self.args.sbatch.clone());
        options
    }

    fn script(&self, options: &[String], arguments: &str) -> String {
        let options: String = options.iter().map(|option| format!("#SBATCH {option}\n")).collect();
        let program = quoted(&self.place.program());
        // Large pages, in which one walks through matrices of weights faster.
        let pages = "export GLIBC_TUNABLES=\"${GLIBC_TUNABLES:-glibc.malloc.hugetlb=1}\"";
        format!("#!/bin/bash\n{options}set -euo pipefail\n{pages}\nexec {program} {arguments}\n")
    }
}

/// A path as one word of the shell.
fn quoted(path: &Path) -> String {
    format!("'{}'", path.display().to_string().replace('\'', r"'\''"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_stay_one_word_and_percent_signs_stay_percent_signs() {
        let (args, place) = (ClusterArgs::default(), Place::at(Path::new("/a b/it's 5%")));
        let scripts = Scripts { place: &place, name: "fig1".into(), args: &args, tasks: 3, jobs: 2 };
        let text = scripts.array();
        assert!(text.contains("#SBATCH --array=0-2\n"), "{text}");
        assert!(text.contains("#SBATCH --output=\"/a b/it's 5%%/task-%a.log\"\n"), "{text}");
        assert!(text.ends_with(
            "exec '/a b/it'\\''s 5%/motes-bench' work '/a b/it'\\''s 5%' \"$SLURM_ARRAY_TASK_ID\"\n"
        ));
    }
}
