//! The command `motes`: hidden states, evidence and warnings from a model file and a CSV file.

mod command;

use std::process::ExitCode;

fn main() -> ExitCode {
    command::run()
}
