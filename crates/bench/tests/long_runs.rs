//! What happens to a run over its life: killed, resumed, split over threads, shared, damaged, changed.

mod common;

use std::process::Stdio;
use std::time::{Duration, Instant};

use common::{TINY, Workplace, stderr};

const UNITS: usize = 48;

/// Waits until the run has stored `units` units.
fn wait_for(place: &Workplace, out: &str, units: usize) {
    let start = Instant::now();
    while place.units(out) < units {
        assert!(
            start.elapsed() < Duration::from_secs(120),
            "only {} units after two minutes",
            place.units(out)
        );
        std::thread::sleep(Duration::from_millis(2));
    }
}

/// An experiment slow enough to be stopped in the middle.
fn slower() -> String {
    TINY.replacen("training_steps = 20", "training_steps = 120", 1)
}

#[test]
fn one_thread_two_threads_and_killed_runs_give_the_same_bytes() {
    let place = Workplace::new(&slower());
    assert!(place.run(&["tiny", "--out", "one", "--jobs", "1"]).status.success());
    assert!(place.run(&["tiny", "--out", "two", "--jobs", "2"]).status.success());
    let expected = place.tables("one");
    assert_eq!(place.tables("two"), expected);

    let mut stored = 0;
    for stop_at in [3, 15, 30] {
        let mut run = place
            .reproduce(&["tiny", "--out", "killed", "--jobs", "2"])
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        wait_for(&place, "killed", stop_at);
        run.kill().unwrap();
        run.wait().unwrap();
        stored = place.units("killed");
    }
    assert!((30..UNITS).contains(&stored), "the run was to be killed half way and has {stored} units");
    let output = place.run(&["tiny", "--out", "killed"]);
    assert!(output.status.success());
    let said = stderr(&output);
    assert!(said.contains(&format!("{stored} units are there, {} to run", UNITS - stored)), "{said}");
    assert_eq!(place.tables("killed"), expected);
}

#[test]
fn a_run_says_what_it_will_take_and_complains_of_nothing() {
    let place = Workplace::new(TINY);
    for jobs in ["1", "2"] {
        let output = place.run(&["tiny", "--jobs", jobs, "--out", jobs]);
        let said = stderr(&output);
        assert_eq!(output.status.code(), Some(0), "{said}");
        assert!(said.contains("estimated time"), "{said}");
        assert!(!said.contains("no threads of its own"), "{said}");
    }
}

#[test]
fn parts_add_up_to_the_whole() {
    let place = Workplace::new(TINY);
    assert!(place.run(&["tiny", "--out", "whole"]).status.success());
    for part in [
        &["tiny", "--out", "parts", "--methods", "fcnn", "--panels", "N8"][..],
        &["tiny", "--out", "parts", "--methods", "min-degeneracy,bootstrap", "--repetitions", "2"],
        &["tiny", "--out", "parts", "--x", "8"],
        &["tiny", "--out", "parts"],
    ] {
        assert!(place.run(part).status.success());
    }
    assert_eq!(place.tables("parts"), place.tables("whole"));
}

#[test]
fn two_runs_do_not_share_a_folder() {
    let place = Workplace::new(&slower());
    let mut first = place
        .reproduce(&["tiny", "--jobs", "2"])
        .stderr(Stdio::null())
        .stdout(Stdio::null())
        .spawn()
        .unwrap();
    wait_for(&place, "runs", 1);
    let second = place.run(&["tiny"]);
    assert_eq!(second.status.code(), Some(3));
    let line = format!(
        "error: runs/tiny/quick is in use by another run (process {}); wait for it, or give another --out",
        first.id()
    );
    assert_eq!(stderr(&second), line);
    first.kill().unwrap();
    first.wait().unwrap();
    assert!(place.run(&["tiny"]).status.success(), "a killed run must free its folder");
}

#[test]
fn a_damaged_unit_is_set_aside_and_computed_again() {
    let place = Workplace::new(TINY);
    assert!(place.run(&["tiny"]).status.success());
    let expected = place.tables("runs");
    let path = place.path("runs/tiny/quick/units.jsonl");
    let mut lines: Vec<Vec<u8>> =
        std::fs::read(&path).unwrap().split_inclusive(|byte| *byte == b'\n').map(<[u8]>::to_vec).collect();
    // One is cut short, one has a wrong byte, and the file ends within the last.
    let middle = lines[1].len() / 2;
    lines[1].truncate(middle);
    lines[1].push(b'\n');
    let middle = lines[2].len() / 2;
    lines[2][middle] ^= 4;
    let last = lines.len() - 1;
    lines[last].truncate(100);
    std::fs::write(&path, lines.concat()).unwrap();
    let output = place.run(&["tiny"]);
    let said = stderr(&output);
    assert!(said.contains("damaged units set aside in runs/tiny/quick/units.damaged: 3; what"), "{said}");
    assert!(said.contains("45 units are there, 3 to run"), "{said}");
    assert_eq!(place.tables("runs"), expected);
}

#[test]
fn units_of_another_configuration_or_seed_are_not_mixed_in() {
    let place = Workplace::new(TINY);
    assert!(place.run(&["tiny", "--methods", "bootstrap"]).status.success());
    let output = place.run(&["tiny", "--methods", "bootstrap", "--seed", "2"]);
    let said = stderr(&output);
    assert!(
        said.contains(
            "16 units in runs/tiny/quick are of another run and not used: seed is 1 there and 2 here"
        )
    );
    let table = place.tables("runs");
    assert!(place.run(&["tiny", "--methods", "bootstrap", "--seed", "2", "--out", "fresh"]).status.success());
    assert_eq!(place.tables("fresh"), table);

    let changed = TINY.replacen("snr_db = 5.0", "snr_db = 4.0", 1);
    std::fs::write(place.path("experiments/tiny.toml"), changed).unwrap();
    let said = stderr(&place.run(&["tiny", "--methods", "bootstrap"]));
    assert!(said.contains("system.snr_db is 5.0 there and 4.0 here"), "{said}");
}

#[test]
fn weights_of_a_collapsed_proposal_are_warned_of_and_a_defensive_weight_bounds_them() {
    // Trained long enough to collapse, and weights enough to see it.
    let collapsed = TINY
        .replacen("x = [4, 8]", "x = [20]", 1)
        .replacen("filter_runs = 5", "filter_runs = 100", 1)
        .replacen("training_steps = 20", "training_steps = 300", 1)
        .replacen("learning_rate = 0.001", "learning_rate = 0.01", 1);
    let safe = collapsed.replacen("particles = 8", "particles = 8\ndefensive_weight = 0.5", 1);
    let place = Workplace::new(&collapsed);
    let indices = |out: &str| -> Vec<f64> {
        let arguments = ["tiny", "--methods", "fcnn", "--repetitions", "2", "--out", out];
        assert!(place.run(&arguments).status.success());
        let units = std::fs::read_to_string(place.path(out).join("tiny/quick/units.csv")).unwrap();
        let of_index = units.lines().filter(|line| line.contains(",tail_index,"));
        of_index.map(|line| line.rsplit(',').next().unwrap().parse().unwrap()).collect()
    };
    let table = |out: &str| std::fs::read_to_string(place.path(out).join("tiny/quick/table.md")).unwrap();
    let plain = indices("runs");
    assert!(plain.len() == 4 && plain.iter().all(|index| *index > 0.7), "{plain:?}");
    assert!(
        table("runs").contains("Weights not to be trusted: the tail index is above 0.7"),
        "{}",
        table("runs")
    );

    std::fs::write(place.path("experiments/tiny.toml"), safe).unwrap();
    let safe = indices("safe");
    assert!(
        safe.len() == 4 && safe.iter().zip(&plain).all(|(safe, plain)| safe < plain),
        "{safe:?} for {plain:?}"
    );
    println!("tail indices {plain:.2?}, with a defensive weight {safe:.2?}");
    // And what was run without is another run.
    let said = stderr(&place.run(&["tiny", "--methods", "fcnn", "--repetitions", "1"]));
    assert!(said.contains("of another run and not used: filter.defensive_weight is"), "{said}");
}

#[test]
fn fresh_runs_the_selection_again() {
    let place = Workplace::new(TINY);
    assert!(place.run(&["tiny"]).status.success());
    let expected = place.tables("runs");
    let said = stderr(&place.run(&["tiny", "--fresh", "--methods", "bootstrap"]));
    assert!(said.contains("16 units to run"), "{said}");
    assert_eq!(place.tables("runs"), expected);
}

#[test]
fn failing_units_are_recorded_and_decide_the_status() {
    // Two bootstrap particles and exact uniform densities: no particle explains the measurements.
    let failing = TINY
        .replacen("noise = \"gaussian\"", "noise = \"uniform\"", 1)
        .replacen("densities = \"gaussian\"", "densities = \"exact\"", 1)
        .replacen("x = [4, 8]", "x = [1, 2]", 1);
    let place = Workplace::new(&failing);
    let output = place.run(&["tiny", "--methods", "bootstrap"]);
    assert_eq!(output.status.code(), Some(1));
    let summary = std::fs::read_to_string(place.path("runs/tiny/quick/summary.csv")).unwrap();
    assert!(summary.contains("tiny,N6,bootstrap,1,nmse_final,,,0,4"), "{summary}");
    let failures = std::fs::read_to_string(place.path("runs/tiny/quick/failures.csv")).unwrap();
    assert!(failures.contains("all weights of filter"), "{failures}");
    // They are results: the same command finds them there and ends as before.
    let again = place.run(&["tiny", "--methods", "bootstrap"]);
    assert_eq!(again.status.code(), Some(1));
    assert!(stderr(&again).contains("16 units are there, 0 to run"));
}

#[cfg(unix)]
#[test]
fn signals_end_a_run_cleanly_with_their_own_status() {
    for (signal, status) in [("-INT", 130), ("-TERM", 143)] {
        let place = Workplace::new(&slower());
        let run = place
            .reproduce(&["tiny", "--jobs", "2"])
            .stderr(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .unwrap();
        wait_for(&place, "runs", 2);
        // The shell's own kill: there need not be a program of that name.
        let kill = format!("kill {signal} {}", run.id());
        assert!(std::process::Command::new("sh").args(["-c", &kill]).status().unwrap().success());
        let output = run.wait_with_output().unwrap();
        assert_eq!(output.status.code(), Some(status));
        let said = stderr(&output);
        assert!(said.contains("the same command goes on where this one stopped"), "{said}");
        assert!(place.files("runs/tiny/quick", "partial").is_empty());
        assert!(place.files("runs/tiny/quick", "part.jsonl").is_empty());
        assert!(place.path("runs/tiny/quick/units.csv").exists());
    }
}

#[cfg(not(feature = "burn"))]
#[test]
fn a_backend_that_was_not_built_is_refused() {
    let place = Workplace::new(TINY);
    let output = place.run(&["tiny", "--methods", "fcnn", "--backend", "flex"]);
    let said = stderr(&output);
    assert_eq!(
        said,
        "error: --backend flex: the backend flex is not in this build; it needs the cargo feature `burn` of motes-networks"
    );
    assert_eq!(output.status.code(), Some(2));
    assert!(!place.path("runs").exists());
}

#[test]
fn a_dry_run_says_what_would_be_run_and_writes_nothing() {
    let place = Workplace::new(TINY);
    let output = place.run(&["tiny", "--methods", "fcnn", "--backend", "flex", "--dry-run"]);
    assert!(output.status.success(), "{}", stderr(&output));
    assert_eq!(
        String::from_utf8_lossy(&output.stdout).trim(),
        "tiny quick: panels N6 N8, x = [4, 8], methods fcnn, 4 repetitions, seed 1, backend flex"
    );
    assert!(output.stderr.is_empty() && !place.path("runs").exists());
}

#[cfg(feature = "burn")]
#[test]
fn all_backends_run() {
    let place = Workplace::new(TINY);
    for backend in ["native", "flex", "ndarray"] {
        let output = place.run(&["tiny", "--methods", "fcnn", "--backend", backend, "--out", backend]);
        assert!(output.status.success(), "{}", stderr(&output));
    }
    let loss = |backend: &str| {
        let units = std::fs::read_to_string(place.path(backend).join("tiny/quick/units.csv")).unwrap();
        let losses: Vec<f64> = units
            .lines()
            .filter(|line| line.contains(",loss_first,"))
            .map(|line| line.rsplit(',').next().unwrap().parse().unwrap())
            .collect();
        assert_eq!(losses.len(), 16);
        losses
    };
    for (native, others) in loss("native").into_iter().zip(loss("flex").into_iter().zip(loss("ndarray"))) {
        assert!((native / others.0 - 1.0).abs() < 1e-4 && (native / others.1 - 1.0).abs() < 1e-4);
    }
}
