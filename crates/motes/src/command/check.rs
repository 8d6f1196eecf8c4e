//! `motes check`.

use motes::output::Output;
use motes::{check, on_threads};
use motes_cli::Interrupt;

use super::args::CheckArgs;
use super::failure::Failure;
use super::input;
use super::say::write;

pub(super) fn run(args: &CheckArgs, interrupt: &Interrupt) -> Result<u8, Failure> {
    let model = args.model.read_beside(args.data.as_deref())?;
    let data = args.data.as_ref().map(|path| input::data(path, &model, interrupt)).transpose()?;
    let checked = on_threads(args.model.threads, || {
        check(&model, data.as_ref(), args.model.seed, || interrupt.check())
    })??;
    let mut text = format!("{}\n\n{}\n", model.name(), model.describe());
    checked.findings.iter().for_each(|finding| text += &format!("{finding}\n"));
    checked.problems.iter().for_each(|problem| text += &format!("problem: {problem}\n"));
    write(&Output::Standard, &text)?;
    match checked.problems.len() {
        0 => Ok(0),
        1 => Err(Failure::new(2, format!("{}: there is a problem", args.model.model.display()))),
        count => Err(Failure::new(2, format!("{}: there are {count} problems", args.model.model.display()))),
    }
}
