//! Bad input: one line that says what is wrong and what would be right, the right status, and nothing written.
//!
//! The lines are in `snapshots/`: `INSTA_UPDATE=always cargo test -p motes-bench --test bad_input` writes them anew, to be read before
//! they are committed.

mod common;

use common::{TINY, Workplace, stderr};

/// What the program says of `experiment` with `arguments`: one line, with status 2 and no results folder.
fn told(experiment: &str, arguments: &[&str]) -> String {
    let place = Workplace::new(experiment);
    let output = place.run(arguments);
    let said = stderr(&output);
    assert_eq!(said.lines().count(), 1, "for {arguments:?}: {said}");
    assert_eq!(output.status.code(), Some(2), "for {arguments:?}: {said}");
    assert!(output.stdout.is_empty(), "for {arguments:?}");
    let there: Vec<_> = std::fs::read_dir(place.folder.path()).unwrap().collect();
    assert_eq!(there.len(), 1, "something was written for {arguments:?}: {there:?}");
    said
}

#[test]
fn arguments() {
    let cases: [&[&str]; 28] = [
        &["tni"],
        &["tiny", "--profile", "papr"],
        &["tiny", "--methods", "fcn"],
        &["tiny", "--methods", "fcnn,bootstrap,fcnn"],
        &["tiny", "--methods", ""],
        &["tiny", "--panels", "N5"],
        &["tiny", "--x", "5"],
        &["tiny", "--x", "4,8,4"],
        &["tiny", "--backend", "gpu"],
        &["tiny", "--backend", "cuda"],
        &["tiny", "--repetitions", "0"],
        &["tiny", "--repetitions=-1"],
        &["tiny", "--repetitions", "1000001"],
        &["tiny", "--jobs", "two"],
        &["tiny", "--seed", "1.5"],
        &["tiny", "--seed", "18446744073709551616"],
        &["tiny", "--sed", "1"],
        &["tiny", "--experiments", "no/such/folder"],
        &["tiny", "--engine", "slrm"],
        &["tiny", "--tasks", "4"],
        &["tiny", "--engine", "slurm", "--fresh"],
        &["tiny", "--engine", "slurm", "--tasks", "0"],
        &["tiny", "--engine", "slurm", "--partition", "a b"],
        &["tiny", "--engine", "slurm", "--time", "soon"],
        &["tiny", "--engine", "slurm", "--sbatch", "--mem=4G\nrm -r x"],
        &["learned-growth", "--engine", "slurm"],
        &["learned-growth", "--status"],
        &[],
    ];
    let said = cases.map(|arguments| format!("{}\n    {}", arguments.join(" "), told(TINY, arguments)));
    insta::with_settings!({ omit_expression => true }, { insta::assert_snapshot!(said.join("\n")) });
}

#[test]
fn keys_and_values_of_the_experiment() {
    // What is replaced, and by what.
    let edits = [
        ("x = [4, 8]", "x = [4, 0]"),
        ("x = [4, 8]", "x = [4, 4]"),
        ("x = [4, 8]", "x = []"),
        ("x = [4, 8]", "x = [4, -8]"),
        ("particles = 8", "particles = 0"),
        ("horizon = 4", "horizon = 0"),
        ("horizon = 4", "horizon = \"4\""),
        ("horizon = 4", "horizn = 4"),
        ("horizon = 4", "horizon = 4\nhorizon = 5"),
        ("snr_db = 5.0", "snr_db = nan"),
        ("snr_db = 5.0", "snr_db = -inf"),
        ("snr_db = 5.0", "snr_db = inf"),
        ("repetitions = 4", "repetitions = -4"),
        ("\"fcnn\"]", "\"fcn\"]"),
        ("filter_runs = 5", "filter_runs = 1000000000"),
        ("repetitions = 4", "repetitions = 0"),
        ("filter_runs = 5", "filter_runs = 0"),
        ("fcnn = [16, 16]", "fcnn = [16, 0]"),
        ("gnn = [8, 8]", "gnn = []"),
        ("rnn = 8", "rnn = 0"),
        ("psi = 3", "psi = 0"),
        ("reference_particles = 100", "reference_particles = 0"),
        ("ridge = 1e-6", "ridge = -1e-6"),
        ("ridge = 1e-3", "ridge = -1e-3"),
        ("order = 3", "order = 65"),
        ("depth = 1", "depth = 0"),
        ("cell = \"lstm\"", "cell = \"lsm\""),
        ("adapter = \"fixed\"", "adapter = \"fix\""),
        ("gradient = \"full\"", "gradient = \"truncated\""),
        ("gradient = \"full\"", "gradient = \"full\"\ngradient_window = 3"),
        ("gradient = \"full\"", "gradient = \"full\"\nclip_norm = 0.0"),
        ("gradient = \"full\"", "gradient = \"full\"\nweight_penalty = -1.0"),
        ("gradient = \"full\"", "gradient = \"full\"\ndropout = 1.0"),
        ("beta_1 = 0.9", "beta_1 = 1.0"),
        ("dimension = 8", "dimension = 6"),
        ("snr_db = 5.0\n", ""),
        ("learning_rate = 0.001", "learning_rate = 0.0"),
        ("learning_rate = 0.001", "learning_rate = 1e-60"),
        ("learning_rate = 0.001", "learning_rate = 0.001\nschedule = \"constant\""),
        ("learning_rate = 0.001", "learning_rate = 0.001\nschedule = \"linear\""),
        ("\"fcnn\"]", "\"fcnn\", \"gnn-short-steps\"]"),
        ("[proposals.psi]", "[proposals.gnn-short-steps]\nlearning_rate = 0.0\n[proposals.psi]"),
        ("epsilon = 1e-8", "epsilon = 1e-50"),
        ("ess_threshold = 0.3333333333333333", "ess_threshold = 1.5"),
        ("neighbours = 3", "neighbours = 6"),
        ("noise = \"gaussian\"", "noise = \"gausian\""),
        ("\"fcnn\"]", "\"fcnn\", \"fcnn\"]"),
        ("horizon = 4", "horizon = 1000000000000"),
        ("repetitions = 4", "repetitions = 1000001"),
        ("dimension = 8", "dimension = 70000"),
        ("ess_threshold = 0.3333333333333333", "ess_threshold = 0.3333333333333333\ndefensive_weight = 1.0"),
        ("ess_threshold = 0.3333333333333333", "ess_threshold = 0.3333333333333333\ndefensive_weight = nan"),
        ("[system]", "[systm]"),
        ("x = [4, 8]", "x = 4"),
    ];
    let said = edits.map(|(right, wrong)| {
        assert!(TINY.contains(right), "{right}");
        let line = told(&TINY.replacen(right, wrong, 1), &["tiny"]);
        format!("{} -> {}\n    {line}", right.replace('\n', " ⏎ "), wrong.replace('\n', " ⏎ "))
    });
    insta::with_settings!({ omit_expression => true }, { insta::assert_snapshot!(said.join("\n")) });
}

#[test]
fn files_that_are_no_experiments() {
    let files =
        [("empty", ""), ("no TOML", "{]"), ("not closed", "title = \"A"), ("another", "title = \"A\"\n")];
    let said = files.map(|(name, text)| format!("{name}\n    {}", told(text, &["tiny"])));
    insta::with_settings!({ omit_expression => true }, { insta::assert_snapshot!(said.join("\n")) });
}

#[test]
fn an_output_folder_that_cannot_be_written() {
    let place = Workplace::new(TINY);
    std::fs::write(place.path("file"), "").unwrap();
    let output = place.run(&["tiny", "--out", "file"]);
    assert_eq!(
        stderr(&output),
        "error: --out file/tiny/quick: Not a directory (os error 20); give a folder that can be written"
    );
    assert_eq!(output.status.code(), Some(3));
    assert_eq!(std::fs::read(place.path("file")).unwrap(), b"");
}

#[cfg(unix)]
#[test]
fn an_argument_that_is_no_text() {
    use std::os::unix::ffi::OsStrExt;
    let place = Workplace::new(TINY);
    let mut command = place.reproduce(&[]);
    let output = command.arg(std::ffi::OsStr::from_bytes(b"\xff")).output().unwrap();
    assert_eq!(output.status.code(), Some(2));
    assert!(stderr(&output).starts_with("error: invalid UTF-8"), "{}", stderr(&output));
}

#[test]
fn figures_are_found_by_their_whole_name() {
    let place = Workplace::new(TINY);
    let other = TINY.replacen("horizon = 4", "horizon = 0", 1);
    std::fs::write(place.path("experiments/tiny.v2.toml"), other).unwrap();
    let output = place.run(&["tiny.v2"]);
    assert_eq!(
        stderr(&output),
        "error: experiments/tiny.v2.toml: key `system.horizon` is 0; it must be at least 1"
    );
}

#[test]
fn help_is_no_error() {
    let output = Workplace::new(TINY).run(&["--help"]);
    assert!(output.status.success() && output.stderr.is_empty());
    assert!(String::from_utf8_lossy(&output.stdout).contains("--repetitions"));
}
