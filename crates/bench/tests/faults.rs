//! What long runs meet: being killed at any moment, a disk that fills up, results of other versions, clocks that jump.
#![cfg(unix)]

mod common;

use std::process::{Command, Stdio};
use std::time::{Duration, Instant, SystemTime};

use common::{TINY, Workplace, stderr};
use motes_bench::Store;
use motes_models::Seed;
use rand::RngExt;

/// Ten times the repetitions.
const MANY: usize = 480;

fn many() -> String {
    TINY.replacen("repetitions = 4", "repetitions = 40", 1).replacen(
        "training_steps = 20",
        "training_steps = 60",
        1,
    )
}

#[test]
fn killed_a_hundred_times_at_random() {
    let kills = 100;
    let place = Workplace::new(&many());
    let start = Instant::now();
    assert!(place.run(&["tiny", "--out", "whole", "--jobs", "1"]).status.success());
    // So that all kills together leave something to do, as a rule.
    let mut most = start.elapsed().mul_f64(1.5 / kills as f64).max(Duration::from_millis(20));
    let mut stream = Seed::from_u64(140).stream();
    let (mut killed, mut stored, mut midway, mut idle, mut ended) = (0, 0, 0, 0, 0);
    while killed < kills {
        let mut run = place
            .reproduce(&["tiny", "--out", "killed", "--jobs", "2"])
            .stderr(Stdio::piped())
            .stdout(Stdio::null())
            .spawn()
            .unwrap();
        std::thread::sleep(most.mul_f64(stream.random::<f64>()));
        if run.try_wait().unwrap().is_some() {
            // It was faster than the kill, and is as good as any.
            let output = run.wait_with_output().unwrap();
            assert!(output.status.success(), "{}", stderr(&output));
            assert_eq!(place.tables("killed"), place.tables("whole"));
            std::fs::remove_dir_all(place.path("killed")).unwrap();
            (stored, ended) = (0, ended + 1);
            continue;
        }
        run.kill().unwrap();
        let said = stderr(&run.wait_with_output().unwrap());
        assert!(!said.contains("damaged"), "a partial unit counted as done: {said}");
        let now = place.units("killed");
        assert!(now >= stored, "units were lost: {now} after {stored}");
        // A machine that has become slower needs more time to get anywhere.
        idle = if now == stored { idle + 1 } else { 0 };
        if idle == 5 {
            (idle, most) = (0, most.mul_f64(1.5));
        }
        (killed, stored) = (killed + 1, now);
        midway += usize::from((1..MANY).contains(&now));
    }
    println!(
        "{kills} kills, {midway} of them with some units stored and others not; {ended} runs ended before"
    );
    assert!(midway >= 10);
    let output = place.run(&["tiny", "--out", "killed"]);
    assert!(output.status.success(), "{}", stderr(&output));
    assert_eq!(place.tables("killed"), place.tables("whole"));
    let partial = place.files("killed/tiny/quick/units", "partial");
    assert!(partial.is_empty(), "{partial:?}");
}

#[test]
fn a_file_that_cannot_grow_ends_the_run_and_harms_nothing() {
    let place = Workplace::new(TINY);
    assert!(place.run(&["tiny", "--out", "whole"]).status.success());
    // Units fit into 8 KiB, the table of all of them does not.
    let script = "trap '' XFSZ; ulimit -f 16; exec \"$0\" reproduce tiny --out full";
    let run = |script: &str| {
        let mut command = Command::new("sh");
        command.args(["-c", script, env!("CARGO_BIN_EXE_motes-bench")]);
        command.current_dir(place.folder.path()).output().unwrap()
    };
    let output = run(script);
    let said = stderr(&output);
    assert_eq!(output.status.code(), Some(3), "{said}");
    let line = said.lines().last().unwrap_or_default();
    assert!(line.starts_with("error: full/tiny/quick/units.csv: "), "{said}");
    assert_eq!(place.units("full"), 48);
    assert!(place.files("full/tiny/quick", "partial").is_empty());
    let output = place.run(&["tiny", "--out", "full"]);
    assert!(stderr(&output).contains("48 units are there, 0 to run"), "{}", stderr(&output));
    assert_eq!(place.tables("full"), place.tables("whole"));
}

/// `unshare` with what lets this user mount a file system for himself: nothing more for root, a user namespace for others.
fn mounting() -> Option<Command> {
    let unshare = |more: &[&str]| {
        let mut command = Command::new("unshare");
        command.args(more).args(["--mount", "sh", "-c"]);
        command
    };
    [&[][..], &["--user", "--map-root-user"]].into_iter().find_map(|more| {
        let tried = unshare(more).arg("mount -t tmpfs -o size=64k none /mnt").output();
        tried.is_ok_and(|output| output.status.success()).then(|| unshare(more))
    })
}

#[test]
fn a_full_disk_ends_the_run_and_harms_nothing() {
    let Some(mut command) = mounting() else {
        // Where a user may mount nothing, a file that cannot grow stands for it.
        println!("skipped: no file system can be mounted here");
        return;
    };
    let place = Workplace::new(TINY);
    assert!(place.run(&["tiny", "--out", "whole"]).status.success());
    std::fs::create_dir(place.path("full")).unwrap();
    // A disk with room for some of the units, which is then made larger.
    let script = "mount -t tmpfs -o size=96k none full || exit 99
        \"$0\" reproduce tiny --out full 2>first; echo $? >>statuses
        ls full/tiny/quick/units >stored
        mount -o remount,size=64m full
        \"$0\" reproduce tiny --out full 2>second; echo $? >>statuses
        cp -r full kept";
    command.args([script, env!("CARGO_BIN_EXE_motes-bench")]).current_dir(place.folder.path());
    let output = command.output().unwrap();
    assert!(output.status.success(), "{}", stderr(&output));
    let read = |name: &str| std::fs::read_to_string(place.path(name)).unwrap();
    assert_eq!(read("statuses"), "3\n0\n", "{} / {}", read("first"), read("second"));
    let first = read("first");
    let line = first.trim().lines().last().unwrap_or_default();
    assert!(line.starts_with("error: full/tiny/quick/"), "{first}");
    assert!(line.ends_with("No space left on device (os error 28)"), "{first}");
    let stored = read("stored").lines().filter(|name| name.ends_with(".json")).count();
    assert!((1..48).contains(&stored), "{stored} units");
    assert!(!read("stored").contains("partial"));
    assert!(read("second").contains(&format!("{stored} units are there, {} to run", 48 - stored)));
    assert!(!read("second").contains("damaged"));
    assert_eq!(place.tables("kept"), place.tables("whole"));
}

#[test]
fn units_of_another_format_are_not_taken_for_ones_of_this() {
    let place = Workplace::new(TINY);
    assert!(place.run(&["tiny", "--methods", "bootstrap"]).status.success());
    let expected = place.tables("runs");
    let store = Store::open(&place.path("runs/tiny/quick")).unwrap();
    for mut record in store.read().unwrap().records {
        store.remove(&record.config).unwrap();
        record.config.format -= 1;
        store.write(&record).unwrap();
    }
    drop(store);
    let output = place.run(&["tiny", "--methods", "bootstrap"]);
    let said = stderr(&output);
    assert!(
        said.contains(
            "16 units in runs/tiny/quick are of another run and not used: format is 3 there and 4 here"
        ),
        "{said}"
    );
    assert!(said.contains("16 units to run"), "{said}");
    assert_eq!(place.tables("runs"), expected);
}

#[test]
fn no_timestamp_decides_anything() {
    let place = Workplace::new(TINY);
    assert!(place.run(&["tiny"]).status.success());
    let expected = place.tables("runs");
    let units = place.files("runs/tiny/quick/units", "json");
    let year = Duration::from_secs(365 * 24 * 3600);
    for (at, path) in units.iter().enumerate() {
        let time = match at % 3 {
            0 => SystemTime::UNIX_EPOCH,
            1 => SystemTime::now() - year,
            _ => SystemTime::now() + 50 * year,
        };
        std::fs::File::options().append(true).open(path).unwrap().set_modified(time).unwrap();
    }
    let output = place.run(&["tiny"]);
    assert!(stderr(&output).contains("48 units are there, 0 to run"), "{}", stderr(&output));
    assert_eq!(place.tables("runs"), expected);
}
