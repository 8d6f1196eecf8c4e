//! How soon a stream is answered: `cargo bench -p motes --bench stream`.
//!
//! A filter reads measurements from a pipe. A line is written, its answer awaited, and the next one written. The time between is printed, with and without
//! the second opinion, which is a bootstrap filter that runs beside.

use std::io::{BufRead, BufReader, Write};
use std::process::{Command, Stdio};
use std::time::Instant;

const MODEL: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../examples/nile.toml");
const LINES: usize = 2000;

/// Microseconds from each line to its answer, sorted.
fn latencies(particles: &str, more: &[&str]) -> Vec<f64> {
    let mut motes = Command::new(env!("CARGO_BIN_EXE_motes"))
        .args(["filter", MODEL, "-", "--proposal", "linearised", "--particles", particles])
        .args(more)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::null())
        .spawn()
        .expect("the command runs");
    let mut input = motes.stdin.take().expect("a pipe");
    let mut output = BufReader::new(motes.stdout.take().expect("a pipe"));
    let mut answer = String::new();
    writeln!(input, "flow").expect("a header");
    let mut found = Vec::new();
    for line in 0..LINES {
        let flow = 900.0 + 200.0 * (0.1 * line as f64).sin();
        let start = Instant::now();
        writeln!(input, "{flow}").expect("a line");
        // The header stands before the first answer.
        for _ in 0..if line == 0 { 2 } else { 1 } {
            answer.clear();
            output.read_line(&mut answer).expect("an answer");
        }
        found.push(start.elapsed().as_secs_f64() * 1e6);
    }
    drop(input);
    motes.wait().expect("it ends");
    found.sort_by(f64::total_cmp);
    found
}

fn main() {
    for (name, more) in [("with a second opinion", &[][..]), ("without", &["--no-check"][..])] {
        for particles in ["10", "1000"] {
            let found = latencies(particles, more);
            let at = |share: f64| found[(share * (LINES - 1) as f64) as usize];
            println!(
                "K = {particles:<5} {name:<22} median {:6.0} µs, 99 of 100 within {:6.0} µs",
                at(0.5),
                at(0.99)
            );
        }
    }
}
