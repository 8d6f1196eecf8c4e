//! What xtask sees by itself: it refuses with one line and starts no build.

use std::process::{Command, Output};

/// Runs xtask with a cargo that does not exist, so that a build would fail in another way.
fn xtask(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_xtask")).args(arguments).env("CARGO", "/no/such/cargo").output().unwrap()
}

fn refused(arguments: &[&str], status: i32, line: &str) {
    let output = xtask(arguments);
    assert_eq!(String::from_utf8_lossy(&output.stderr).trim(), format!("error: {line}"));
    assert_eq!(output.status.code(), Some(status));
    assert!(output.stdout.is_empty());
}

#[test]
fn bad_input_is_refused_before_any_build() {
    refused(
        &["reproduce", "fig0"],
        2,
        "figure fig0: did you mean fig1? there are fig1, fig2, fig3, fig4, fig5, fig6, table1, fig7, all",
    );
    refused(
        &["reproduce", "fig1", "--profile", "papr"],
        2,
        "--profile papr: did you mean paper? there are paper, quick, smoke in fig1",
    );
    refused(
        &["reproduce", "fig1", "--methods", "fcnnn"],
        2,
        "--methods fcnnn: did you mean fcnn? there are min-degeneracy, bootstrap, fcnn, rnn, gnn, psi in fig1",
    );
    refused(
        &["reproduce", "all", "--methods", "smoother"],
        2,
        "--methods smoother: there are min-degeneracy, bootstrap, fcnn, rnn, gnn, psi in fig1",
    );
    refused(
        &["reproduce", "fig1", "--panels", "N11"],
        2,
        "--panels N11: did you mean N10? there are N10, N25, N50 in fig1",
    );
    refused(
        &["reproduce", "fig1", "--backend", "flux"],
        2,
        "--backend flux: did you mean flex? there are native, flex, ndarray",
    );
    refused(
        &["reproduce", "fig1", "--repetitions", "0"],
        2,
        "--repetitions 0: it must be an integer from 1 to 1000000",
    );
    refused(
        &["verify", "--from", "no/such/folder"],
        2,
        "--from no/such/folder: there is no such folder; give one that holds FIGURE/PROFILE/units.csv",
    );
    refused(
        &["reprodce"],
        2,
        "unrecognized subcommand 'reprodce'  tip: a similar subcommand exists: 'reproduce'; see cargo xtask --help",
    );
}

#[test]
fn an_output_folder_that_cannot_be_written_is_refused_before_any_build() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("file");
    std::fs::write(&file, "").unwrap();
    let line = format!(
        "--out {}/fig1/quick: Not a directory (os error 20); give a folder that can be written",
        file.display()
    );
    refused(&["reproduce", "fig1", "--out", file.to_str().unwrap()], 3, &line);
}

#[test]
fn a_bad_experiment_file_is_refused_before_any_build() {
    let folder = tempfile::tempdir().unwrap();
    let original =
        std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/../experiments/fig1.toml")).unwrap();
    let write = |text: String| std::fs::write(folder.path().join("mine.toml"), text).unwrap();
    let file = folder.path().join("mine.toml");
    let experiments = folder.path().to_str().unwrap();

    write(original.replace("x = [10, 20, 30, 40, 50]", "x = [10, 0]"));
    let line = format!("{}: key `profiles.paper.x` is 0; it must be at least 1", file.display());
    refused(&["reproduce", "mine", "--experiments", experiments], 2, &line);

    write(original.replace("snr_db", "snr_bd"));
    let output = xtask(&["reproduce", "mine", "--experiments", experiments]);
    let said = String::from_utf8_lossy(&output.stderr).to_string();
    assert!(said.contains("`snr_bd` is not known here; did you mean snr_db?"), "{said}");
    assert_eq!(output.status.code(), Some(2));
}

#[test]
fn good_input_goes_on_to_the_build() {
    let folder = tempfile::tempdir().unwrap();
    let output = xtask(&["reproduce", "fig1", "--out", folder.path().to_str().unwrap()]);
    let said = String::from_utf8_lossy(&output.stderr).to_string();
    assert!(said.contains("/no/such/cargo"), "{said}");
    assert_eq!(output.status.code(), Some(3));
}
