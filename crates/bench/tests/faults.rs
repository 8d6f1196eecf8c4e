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

/// How often a run set lines aside that a killed one had begun to write; nothing else may ever be set aside.
fn lines_begun(said: &str) -> usize {
    let aside: Vec<&str> = said.lines().filter(|line| line.contains("set aside")).collect();
    let is_torn = |line: &&str| line.starts_with("lines that a killed run had begun set aside in ");
    assert!(aside.iter().all(is_torn), "a partial unit counted as done: {said}");
    aside.len()
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
    let (mut killed, mut stored, mut midway, mut torn, mut idle, mut ended) = (0, 0, 0, 0, 0, 0);
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
            lines_begun(&stderr(&output));
            assert_eq!(place.tables("killed"), place.tables("whole"));
            std::fs::remove_dir_all(place.path("killed")).unwrap();
            (stored, ended) = (0, ended + 1);
            continue;
        }
        run.kill().unwrap();
        torn += lines_begun(&stderr(&run.wait_with_output().unwrap()));
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
        "{kills} kills, {midway} of them with some units stored and others not; \
        {torn} runs found lines begun; {ended} runs ended before"
    );
    assert!(midway >= 10);
    let output = place.run(&["tiny", "--out", "killed"]);
    assert!(output.status.success(), "{}", stderr(&output));
    lines_begun(&stderr(&output));
    assert_eq!(place.tables("killed"), place.tables("whole"));
    for left in ["partial", "part.jsonl"] {
        let left = place.files("killed/tiny/quick", left);
        assert!(left.is_empty(), "{left:?}");
    }
}

#[test]
fn a_file_that_cannot_grow_ends_the_run_and_harms_nothing() {
    let place = Workplace::new(TINY);
    assert!(place.run(&["tiny", "--out", "whole"]).status.success());
    // Some units fit into 8 KiB.
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
    assert!(line.starts_with("error: full/tiny/quick/units-"), "{said}");
    let stored = place.units("full");
    assert!((1..48).contains(&stored), "{stored} units");
    let output = place.run(&["tiny", "--out", "full"]);
    let said = stderr(&output);
    assert!(said.contains(&format!("{stored} units are there, {} to run", 48 - stored)), "{said}");
    assert!(!said.contains("set aside"), "{said}");
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
    if mounting().is_none() {
        // Where a user may mount nothing, a file that cannot grow stands for it.
        println!("skipped: no file system can be mounted here");
        return;
    }
    let place = Workplace::new(TINY);
    assert!(place.run(&["tiny", "--out", "whole"]).status.success());
    std::fs::create_dir(place.path("full")).unwrap();
    // Disks with room for some of the units, and for all of them but not for merging them; then they are made larger.
    for (size, least, most) in [("24k", 1, 47), ("96k", 48, 48)] {
        let script = format!(
            "mount -t tmpfs -o size={size} none full || exit 99
            \"$0\" reproduce tiny --out full 2>first; echo $? >statuses
            cp -r full stored
            mount -o remount,size=64m full
            \"$0\" reproduce tiny --out full 2>second; echo $? >>statuses
            rm -rf kept; cp -r full kept"
        );
        let mut command = mounting().expect("a file system can be mounted");
        command.args([&script, env!("CARGO_BIN_EXE_motes-bench")]).current_dir(place.folder.path());
        let output = command.output().unwrap();
        assert!(output.status.success(), "{}", stderr(&output));
        let read = |name: &str| std::fs::read_to_string(place.path(name)).unwrap();
        assert_eq!(read("statuses"), "3\n0\n", "{} / {}", read("first"), read("second"));
        let first = read("first");
        let line = first.trim().lines().last().unwrap_or_default();
        assert!(line.starts_with("error: full/tiny/quick/"), "{first}");
        assert!(line.ends_with("No space left on device (os error 28)"), "{first}");
        let stored = place.units("stored");
        assert!((least..=most).contains(&stored), "{stored} units on a disk of {size}");
        assert!(place.files("stored/tiny/quick", "partial").is_empty());
        assert!(read("second").contains(&format!("{stored} units are there, {} to run", 48 - stored)));
        assert!(!read("second").contains("set aside"));
        assert_eq!(place.tables("kept"), place.tables("whole"));
        std::fs::remove_dir_all(place.path("stored")).unwrap();
    }
}

#[test]
fn units_of_another_format_are_not_taken_for_ones_of_this() {
    let place = Workplace::new(TINY);
    assert!(place.run(&["tiny", "--methods", "bootstrap"]).status.success());
    let expected = place.tables("runs");
    let mut store = Store::open(&place.path("runs/tiny/quick")).unwrap();
    for mut record in store.read().unwrap().records {
        store.remove([&record.config]).unwrap();
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
    // A third of the units in each of three files.
    let folder = place.path("runs/tiny/quick");
    let merged = std::fs::read_to_string(folder.join("units.jsonl")).unwrap();
    let lines: Vec<&str> = merged.split_inclusive('\n').collect();
    let year = Duration::from_secs(365 * 24 * 3600);
    for (lines, (name, time)) in lines.chunks(16).zip([
        ("units.jsonl", SystemTime::UNIX_EPOCH),
        ("units-1-1.part.jsonl", SystemTime::now() - year),
        ("units-2-1.part.jsonl", SystemTime::now() + 50 * year),
    ]) {
        let path = folder.join(name);
        std::fs::write(&path, lines.concat()).unwrap();
        std::fs::File::options().append(true).open(path).unwrap().set_modified(time).unwrap();
    }
    let output = place.run(&["tiny"]);
    assert!(stderr(&output).contains("48 units are there, 0 to run"), "{}", stderr(&output));
    assert_eq!(place.tables("runs"), expected);
    assert_eq!(std::fs::read_to_string(folder.join("units.jsonl")).unwrap(), merged);
}
