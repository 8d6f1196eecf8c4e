//! Bad input: one line that says what is wrong and what would be right, the right status, and nothing written.

mod common;

use common::{TINY, Workplace, stderr};

/// Runs `experiment` with `arguments` and expects exactly this line and status 2, and no results folder.
fn refused(experiment: &str, arguments: &[&str], line: &str) {
    let place = Workplace::new(experiment);
    let output = place.run(arguments);
    assert_eq!(stderr(&output), format!("error: {line}"), "for {arguments:?}");
    assert_eq!(output.status.code(), Some(2));
    assert!(!place.path("runs").exists(), "something was written for {arguments:?}");
}

#[test]
fn arguments() {
    let cases: [(&[&str], &str); 11] = [
        (&["tni"], "figure tni: did you mean tiny? there are tiny, all"),
        (&["tiny", "--profile", "papr"], "--profile papr: there are quick"),
        (
            &["tiny", "--methods", "fcn"],
            "--methods fcn: did you mean fcnn? there are min-degeneracy, bootstrap, fcnn",
        ),
        (&["tiny", "--methods", "fcnn,bootstrap,fcnn"], "--methods fcnn,bootstrap,fcnn: fcnn stands twice"),
        (&["tiny", "--panels", "N5"], "--panels N5: did you mean N6? there are N6, N8"),
        (&["tiny", "--backend", "cuda"], "--backend cuda: there are native, flex, ndarray"),
        (&["tiny", "--repetitions", "0"], "--repetitions 0: it must be an integer from 1 to 1000000"),
        (&["tiny", "--repetitions=-1"], "--repetitions -1: it must be an integer from 1 to 1000000"),
        (&["tiny", "--jobs", "two"], "--jobs two: it must be an integer from 1 to 1024"),
        (&["tiny", "--seed", "1.5"], "--seed 1.5: it must be an integer from 0 to 18446744073709551615"),
        (
            &["tiny", "--sed", "1"],
            "unexpected argument '--sed' found  tip: a similar argument exists: '--seed'; see motes-bench --help",
        ),
    ];
    for (arguments, line) in cases {
        refused(TINY, arguments, line);
    }
}

#[test]
fn keys_and_values_of_the_experiment() {
    let cases = [
        ("x = [4, 8]", "x = [4, 0]", "key `profiles.quick.x` is 0; it must be at least 1"),
        ("x = [4, 8]", "x = [4, 4]", "key `profiles.quick.x` is [\"4\", \"4\"]; no value may stand twice"),
        ("x = [4, 8]", "x = []", "key `profiles.quick.x` is empty; it must have one value or more"),
        ("x = [4, 8]", "x = [4, -8]", "line 54, key `x`: invalid value: integer `-8`, expected usize"),
        ("particles = 8", "particles = 0", "key `filter.particles` is 0; it must be at least 1"),
        ("horizon = 4", "horizon = 0", "key `system.horizon` is 0; it must be at least 1"),
        (
            "horizon = 4",
            "horizon = \"4\"",
            "line 14, key `horizon`: invalid type: string \"4\", expected usize",
        ),
        (
            "horizon = 4",
            "horizn = 4",
            "line 14, key `horizn`: `horizn` is not known here; did you mean horizon? there are drift, noise, \
             densities, snr_db, neighbours, unmeasured, dimension, horizon",
        ),
        ("horizon = 4", "horizon = 4\nhorizon = 5", "line 15, key `horizon`: duplicate key"),
        (
            "snr_db = 5.0",
            "snr_db = nan",
            "key `system.snr_db` is NaN; it must be a number of dB from -200 to 200",
        ),
        (
            "snr_db = 5.0",
            "snr_db = -inf",
            "key `system.snr_db` is -inf; it must be a number of dB from -200 to 200",
        ),
        (
            "repetitions = 4",
            "repetitions = 0",
            "key `profiles.quick.repetitions` is 0; it must be at least 1",
        ),
        (
            "filter_runs = 5",
            "filter_runs = 0",
            "key `profiles.quick.filter_runs` is 0; it must be at least 1",
        ),
        (
            "fcnn = [16, 16]",
            "fcnn = [16, 0]",
            "key `profiles.quick.sizes.fcnn` is [16, 0]; it must be one or more widths from 1 to 65536",
        ),
        (
            "gnn = [8, 8]",
            "gnn = []",
            "key `profiles.quick.sizes.gnn` is []; it must be one or more widths from 1 to 65536",
        ),
        ("rnn = 8", "rnn = 0", "key `profiles.quick.sizes.rnn` is 0; it must be from 1 to 65536"),
        ("psi = 3", "psi = 0", "key `profiles.quick.sizes.psi` is 0; it must be from 1 to 1024"),
        (
            "reference_particles = 100",
            "reference_particles = 0",
            "key `profiles.quick.reference_particles` is 0; it must be at least 1",
        ),
        (
            "ridge = 1e-6",
            "ridge = -1e-6",
            "key `proposals.fcnn.ridge` is -0.000001; it must be at least 0 and finite",
        ),
        (
            "ridge = 1e-3",
            "ridge = -1e-3",
            "key `proposals.psi.ridge` is -0.001; it must be at least 0 and finite",
        ),
        ("order = 3", "order = 65", "key `proposals.gnn.order` is 65; it must be from 0 to 64"),
        ("depth = 1", "depth = 0", "key `proposals.rnn.depth` is 0; it must be from 1 to 64"),
        (
            "cell = \"lstm\"",
            "cell = \"lsm\"",
            "line 33, key `cell`: `lsm` is not known here; did you mean lstm? there are lstm, gru, elman",
        ),
        (
            "adapter = \"fixed\"",
            "adapter = \"fix\"",
            "line 39, key `adapter`: `fix` is not known here; did you mean fixed? there are fixed, learned",
        ),
        (
            "gradient = \"full\"",
            "gradient = \"truncated\"",
            "key `training.gradient_window` is absent; a truncated gradient needs a window of at least 1",
        ),
        (
            "gradient = \"full\"",
            "gradient = \"full\"\ngradient_window = 3",
            "key `training.gradient_window` is 3; a full gradient has no window: leave it out, or set gradient = \"truncated\"",
        ),
        (
            "gradient = \"full\"",
            "gradient = \"full\"\nclip_norm = 0.0",
            "key `training.clip_norm` is 0; it must be positive and finite",
        ),
        ("beta_1 = 0.9", "beta_1 = 1.0", "key `training.beta_1` is 1; it must be at least 0 and below 1"),
        (
            "dimension = 8",
            "dimension = 6",
            "key `panels.*.dimension` is [\"6\", \"6\"]; no value may stand twice",
        ),
        ("snr_db = 5.0\n", "", "line 6: missing field `snr_db`"),
        (
            "learning_rate = 0.001",
            "learning_rate = 0.0",
            "key `training.learning_rate` is 0; it must be positive and finite",
        ),
        (
            "ess_threshold = 0.3333333333333333",
            "ess_threshold = 1.5",
            "key `filter.ess_threshold` is 1.5; it must be above 0 and at most 1",
        ),
        (
            "neighbours = 3",
            "neighbours = 6",
            "key `panels.N6.dimension` is 6; N must exceed the 6 neighbours",
        ),
        (
            "noise = \"gaussian\"",
            "noise = \"gausian\"",
            "line 8, key `noise`: `gausian` is not known here; did you mean gaussian? there are gaussian, \
             exponential, uniform",
        ),
        (
            "\"fcnn\"]",
            "\"fcnn\", \"fcnn\"]",
            "key `methods` is [\"bootstrap\", \"fcnn\", \"fcnn\", \"min-degeneracy\"]; no value may stand twice",
        ),
    ];
    for (right, wrong, line) in cases {
        assert!(TINY.contains(right), "{right}");
        let line = line.to_string();
        let separator = if line.starts_with("line") || line.starts_with("key") { ": " } else { "" };
        refused(
            &TINY.replacen(right, wrong, 1),
            &["tiny"],
            &format!("experiments/tiny.toml{separator}{line}"),
        );
    }
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
