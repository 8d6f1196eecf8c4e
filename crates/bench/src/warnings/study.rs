//! The study from its file to its tables.

use std::collections::BTreeMap;
use std::fs::File;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::sync::Mutex;

use motes::formulas::{self, FileModel, FormulaModel};
use motes::{FilterOptions, LearnOptions, Model, MotesError, ProposalName, learn, on_threads};
use motes_cli::{Interrupt, one_of, result};
use motes_models::{Seed, simulate};
use serde::Deserialize;

use super::error::StudyError;
use super::exact::Exact;
use super::runs::{self, Run};
use super::table::table;
use crate::config::{ReproduceArgs, check_output, read_toml};
use crate::durable;

/// What the study is called.
const NAME: &str = "warnings";

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Study {
    profile: BTreeMap<String, Profile>,
    model: Vec<StudyModel>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Profile {
    particles: Vec<usize>,
    runs: usize,
    proposals: Vec<String>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct StudyModel {
    name: String,
    /// The file that data are simulated from, if it is another.
    truth: Option<String>,
    half: String,
    steps: usize,
    exact: Exact,
}

/// Whether a name is that of the study.
pub fn is_study(name: &str) -> bool {
    name == NAME
}

/// Runs what is missing of the study, and writes `runs.csv` and `table.md`.
///
/// Runs of a model, a proposal and a number of particles are kept as soon as they are finished; the same command goes on from there.
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
    let proposals = chosen("--methods", &args.methods, &profile.proposals)?;
    let names: Vec<String> = study.model.iter().map(|model| model.name.clone()).collect();
    let models = chosen("--panels", &args.panels, &names)?;
    let sizes: Vec<String> = profile.particles.iter().map(usize::to_string).collect();
    let sizes = chosen("--x", &args.x, &sizes)?;
    if args.dry_run {
        let filters = models.len() * proposals.len() * sizes.len() * count;
        result(&format!("{NAME} {}: {} models, {filters} filters", args.profile, models.len()));
        return Ok(());
    }
    let folder = args.out.join(NAME).join(&args.profile);
    check_output(&folder)?;
    let path = folder.join("runs.csv");
    let mut all = if args.fresh { vec![] } else { read_runs(&path)? };
    // Small filters first: what takes long comes last.
    for particles in profile.particles.iter().filter(|size| sizes.contains(&size.to_string())) {
        for model in study.model.iter().filter(|model| models.contains(&model.name)) {
            let prepared = Prepared::new(&home, model)?;
            for proposal in &proposals {
                let is_of = |run: &Run| {
                    run.model == model.name && run.proposal == *proposal && run.particles == *particles
                };
                if all.iter().filter(|run| is_of(run)).count() >= count {
                    continue;
                }
                all.retain(|run| !is_of(run));
                all.extend(prepared.runs(model, proposal, *particles, count, args, interrupt)?);
                write_runs(&path, &all)?;
            }
        }
    }
    let place = |run: &Run| {
        let model = study.model.iter().position(|model| model.name == run.model);
        let proposal = profile.proposals.iter().position(|proposal| *proposal == run.proposal);
        (model, proposal, run.particles, run.run)
    };
    all.sort_by_key(place);
    write_runs(&path, &all)?;
    let text = table(&all);
    write(&folder.join("table.md"), text.as_bytes())?;
    result(text.trim_end());
    Ok(())
}

/// Those of the names that an argument chooses; all of them where it says nothing.
fn chosen(argument: &str, asked: &[String], names: &[String]) -> Result<Vec<String>, StudyError> {
    if let Some(unknown) = asked.iter().find(|name| !names.contains(name)) {
        let there = names.iter().map(String::as_str);
        return Err(StudyError::Setting(format!("{argument}: {}", one_of(unknown, there))));
    }
    Ok(names.iter().filter(|name| asked.is_empty() || asked.contains(name)).cloned().collect())
}

/// A model with its data and its exact answers.
struct Prepared {
    model: Model,
    measurements: Vec<Vec<Option<f64>>>,
    log_evidence: f64,
    deviations: Option<Vec<f64>>,
}

impl Prepared {
    fn new(home: &Path, model: &StudyModel) -> Result<Self, StudyError> {
        let failed = |source| StudyError::Exact { model: model.name.clone(), source };
        let file = |name: &str| home.join(format!("{name}.toml"));
        let filtering = formulas_of(&file(&model.name))?;
        let truth = formulas_of(&file(model.truth.as_ref().unwrap_or(&model.name)))?;
        let mut stream = Seed::from_u64(1).child("data").child(&model.name).stream();
        let drawn = simulate(&truth, model.steps, &mut stream).map_err(failed)?;
        let (log_evidence, deviations) = model.exact.of(&filtering, &drawn.measurements).map_err(failed)?;
        Ok(Prepared {
            model: Model::read(&file(&model.name), &[])?,
            measurements: drawn
                .measurements
                .rows()
                .map(|row| row.iter().copied().map(Some).collect())
                .collect(),
            log_evidence,
            deviations,
        })
    }

    /// So many filters, side by side.
    fn runs(
        &self,
        model: &StudyModel,
        proposal: &str,
        particles: usize,
        count: usize,
        args: &ReproduceArgs,
        interrupt: &Interrupt,
    ) -> Result<Vec<Run>, StudyError> {
        let failed = |source: MotesError| match source {
            MotesError::Interrupted => StudyError::Interrupted,
            source => StudyError::Filter { model: model.name.clone(), source: Box::new(source) },
        };
        let found = Mutex::new(Vec::with_capacity(count));
        let all = || -> Result<(), MotesError> {
            let name = self.proposal(proposal, interrupt)?;
            let next = Mutex::new(0..count);
            let work = || -> Result<(), MotesError> {
                loop {
                    let Some(number) = next.lock().unwrap_or_else(|poisoned| poisoned.into_inner()).next()
                    else {
                        return Ok(());
                    };
                    let seed = args.seed.wrapping_mul(1_000_003).wrapping_add(number as u64);
                    let options =
                        FilterOptions { proposal: name.clone(), particles, seed, ..FilterOptions::default() };
                    let figures =
                        runs::run(&self.model, &options, &self.measurements, &|| interrupt.check())?;
                    let run = self.judged(model, proposal, particles, number, figures);
                    found.lock().unwrap_or_else(|poisoned| poisoned.into_inner()).push(run);
                }
            };
            let (first, second) = rayon_core::join(work, work);
            first.and(second)
        };
        on_threads(args.jobs, all).map_err(failed)?.map_err(failed)?;
        let mut found = found.into_inner().unwrap_or_else(|poisoned| poisoned.into_inner());
        found.sort_by_key(|run| run.run);
        Ok(found)
    }

    fn proposal(&self, name: &str, interrupt: &Interrupt) -> Result<ProposalName, MotesError> {
        if name != "learned" {
            return name.parse().map_err(MotesError::Setting);
        }
        let proceed = |_: usize, _: usize| -> ControlFlow<()> { interrupt.check() };
        let learned = learn(&self.model, None, &LearnOptions::default(), proceed)?;
        Ok(ProposalName::Learned(learned.proposal))
    }

    fn judged(
        &self,
        model: &StudyModel,
        proposal: &str,
        particles: usize,
        number: usize,
        figures: runs::Figures,
    ) -> Run {
        let ratios = self.deviations.iter().flatten().zip(&figures.deviations);
        let ratios = ratios.map(|(exact, found)| (found / exact).max(exact / found));
        Run {
            half: model.half.clone(),
            model: model.name.clone(),
            proposal: proposal.into(),
            particles,
            run: number,
            error: figures.log_evidence - self.log_evidence,
            standard_error: figures.standard_error,
            deviation_ratio: ratios.reduce(f64::max),
            warnings: figures.warnings,
        }
    }
}

fn formulas_of(path: &Path) -> Result<FormulaModel, StudyError> {
    match formulas::read(path, &[])?.model {
        FileModel::Formulas(formulas) => Ok(formulas),
        FileModel::LinearGaussian(_) => {
            Err(StudyError::Setting(format!("{}: the study takes models of formulas", path.display())))
        }
    }
}

fn read_runs(path: &PathBuf) -> Result<Vec<Run>, StudyError> {
    let failed = |reason: String| StudyError::File { path: path.clone(), reason };
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
