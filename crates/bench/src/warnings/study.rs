//! The study from its file to its tables.

use std::fs::File;
use std::path::Path;

use motes_cli::{Interrupt, one_of, result, status};

use super::case::{Case, Cell};
use super::error::StudyError;
use super::file::Study;
use super::runs::Run;
use super::table::table;
use crate::config::{ReproduceArgs, check_output, read_toml};
use crate::durable;
use crate::progress::Progress;

/// What the study is called.
const NAME: &str = "warnings";

/// Whether a name is that of the study.
pub fn is_study(name: &str) -> bool {
    name == NAME
}

/// Runs what is missing of the study, and writes `runs.csv` and `table.md`.
///
/// Runs of a model, a proposal and a number of particles are kept as soon as they are finished; the same command goes on from there. Those of other files or another
/// seed are never mixed with them.
///
/// # Errors
/// [`StudyError`] if an argument or a file is wrong, a filter or learning failed, or results cannot be written.
pub fn run_study(args: &ReproduceArgs, interrupt: &Interrupt) -> Result<(), StudyError> {
    let home = args.experiments.join(NAME);
    let study: Study = read_toml(&home.join("study.toml"))?;
    let Some(profile) = study.profile.get(&args.profile) else {
        let names: Vec<&str> = study.profile.keys().map(String::as_str).collect();
        return Err(StudyError::Setting(format!("--profile: {}", one_of(&args.profile, names))));
    };
    let count = args.repetitions.unwrap_or(profile.runs);
    let proposals =
        chosen("--methods", &args.methods, &profile.proposals, |proposal| proposal.name().into())?;
    let models = chosen("--panels", &args.panels, &study.model, |model| model.name.clone())?;
    let sizes = chosen("--x", &args.x, &profile.particles, usize::to_string)?;
    // Few particles first: what takes long comes last.
    let mut asked = Vec::new();
    for particles in &sizes {
        for model in &models {
            for proposal in &proposals {
                asked.push((*model, Cell::new(&home, model, **proposal, **particles, args.seed)?));
            }
        }
    }
    let folder = args.out.join(NAME).join(&args.profile);
    let path = folder.join("runs.csv");
    let mut all = if args.fresh { vec![] } else { read_runs(&path)? };
    let is_there = |all: &[Run], key: &str| all.iter().filter(|run| run.key == key).count() >= count;
    let missing: Vec<_> = asked.iter().filter(|(_, cell)| !is_there(&all, &cell.key)).collect();
    let text = format!(
        "{NAME} {}: {} models, {} filters, of which {} are missing",
        args.profile,
        models.len(),
        asked.len() * count,
        missing.len() * count
    );
    if args.dry_run {
        result(&text);
        return Ok(());
    }
    check_output(&folder)?;
    status(&text);
    let cost = |steps: usize, cell: &Cell| (cell.particles * steps) as f64 * cell.proposal.cost();
    let total = missing.iter().map(|(model, cell)| cost(model.steps, cell)).sum();
    let mut progress = Progress::start(missing.len(), total);
    let mut cases: Vec<Option<Case<'_>>> = study.model.iter().map(|_| None).collect();
    for (model, cell) in &missing {
        let name = format!("{} {} {}", model.name, cell.proposal.name(), cell.particles);
        progress.started(&name);
        let at = study.model.iter().position(|other| other.name == model.name).unwrap_or_default();
        let case = match &mut cases[at] {
            Some(case) => case,
            none => none.insert(Case::new(&home, model)?),
        };
        let found = case.runs(cell, count, args.jobs, interrupt)?;
        // Of other files, another seed, or fewer of them.
        let is_replaced = |run: &Run| {
            run.model == model.name && run.proposal == cell.proposal.name() && run.particles == cell.particles
        };
        let before = all.len();
        all.retain(|run| !is_replaced(run));
        if all.len() < before {
            status(&format!("{name}: {} runs of another configuration are replaced", before - all.len()));
        }
        all.extend(found);
        write_runs(&path, &all)?;
        progress.ended(&name, cost(model.steps, cell), None);
    }
    progress.finish();
    all.retain(|run| asked.iter().any(|(_, cell)| cell.key == run.key));
    let place = |run: &Run| {
        let model = study.model.iter().position(|model| model.name == run.model);
        let proposal = profile.proposals.iter().position(|proposal| proposal.name() == run.proposal);
        (model, proposal, run.particles, run.run)
    };
    all.sort_by_key(place);
    let text = table(&all);
    write(&folder.join("table.md"), text.as_bytes())?;
    result(text.trim_end());
    Ok(())
}

/// Those that an argument chooses by their names; all of them where it says nothing.
fn chosen<'c, T>(
    argument: &str,
    asked: &[String],
    all: &'c [T],
    name: impl Fn(&T) -> String,
) -> Result<Vec<&'c T>, StudyError> {
    let names: Vec<String> = all.iter().map(&name).collect();
    if let Some(unknown) = asked.iter().find(|name| !names.contains(name)) {
        let there = names.iter().map(String::as_str);
        return Err(StudyError::Setting(format!("{argument}: {}", one_of(unknown, there))));
    }
    Ok(all.iter().filter(|one| asked.is_empty() || asked.contains(&name(one))).collect())
}

fn read_runs(path: &Path) -> Result<Vec<Run>, StudyError> {
    let failed = |reason: String| StudyError::File { path: path.to_path_buf(), reason };
    let file = match File::open(path) {
        Ok(file) => file,
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(vec![]),
        Err(error) => return Err(failed(error.to_string())),
    };
    let rows = csv::Reader::from_reader(file).into_deserialize().collect::<Result<Vec<Run>, _>>();
    rows.map_err(|error| failed(error.to_string()))
}

fn write_runs(path: &Path, runs: &[Run]) -> Result<(), StudyError> {
    let failed = |reason: String| StudyError::File { path: path.to_path_buf(), reason };
    let mut writer = csv::Writer::from_writer(Vec::new());
    runs.iter().try_for_each(|run| writer.serialize(run)).map_err(|error| failed(error.to_string()))?;
    let bytes = writer.into_inner().map_err(|error| failed(error.to_string()))?;
    write(path, &bytes)
}

fn write(path: &Path, bytes: &[u8]) -> Result<(), StudyError> {
    durable::write(path, &[bytes])
        .map_err(|error| StudyError::File { path: path.to_path_buf(), reason: error.to_string() })
}
