//! A model of the study with its data, its exact answers, and filters of it.

use std::path::{Path, PathBuf};
use std::sync::{Mutex, OnceLock};

use motes::formulas::{self, FileModel, FormulaModel};
use motes::{FilterOptions, LearnOptions, Model, MotesError, ProposalName, learn, on_threads};
use motes_cli::Interrupt;
use motes_models::{Seed, simulate};

use super::error::StudyError;
use super::file::{StudyModel, StudyProposal};
use super::runs::{Figures, Run, run};
use crate::key::key_of;

/// The version of what a run means: raised whenever the same files and seed give other numbers than before.
const FORMAT: u32 = 3;

/// A model with its data and its exact answers.
pub(super) struct Case<'s> {
    of: &'s StudyModel,
    model: Model,
    measurements: Vec<Vec<Option<f64>>>,
    log_evidence: f64,
    /// Of the last state given all measurements.
    deviations: Option<Vec<f64>>,
    learned: OnceLock<ProposalName>,
}

/// The filters of a case that are run together.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Cell {
    pub(super) proposal: StudyProposal,
    pub(super) particles: usize,
    pub(super) seed: u64,
    /// What determines its numbers, as a hash.
    pub(super) key: String,
}

impl Cell {
    /// That of a model in a folder.
    ///
    /// # Errors
    /// [`StudyError::File`] if one of its files cannot be read.
    pub(super) fn new(
        home: &Path,
        model: &StudyModel,
        proposal: StudyProposal,
        particles: usize,
        seed: u64,
    ) -> Result<Self, StudyError> {
        let [filtering, truth] = files(home, model).map(|path| {
            let text = std::fs::read_to_string(&path);
            text.map_err(|error| StudyError::File { path, reason: error.to_string() })
        });
        let key = key_of(&(FORMAT, model, filtering?, truth?, proposal, particles, seed));
        Ok(Cell { proposal, particles, seed, key })
    }
}

/// The files of the model that filters and of the one that made the data.
fn files(home: &Path, model: &StudyModel) -> [PathBuf; 2] {
    [&model.name, model.truth.as_ref().unwrap_or(&model.name)].map(|name| home.join(format!("{name}.toml")))
}

impl<'s> Case<'s> {
    /// Simulates the data of a model in a folder, and finds the exact answers.
    ///
    /// # Errors
    /// [`StudyError`] if a file cannot be read, or there is no exact answer.
    pub(super) fn new(home: &Path, of: &'s StudyModel) -> Result<Self, StudyError> {
        let failed = |source| StudyError::Exact { model: of.name.clone(), source };
        let [filtering, truth] = files(home, of);
        let mut stream = Seed::from_u64(1).child("data").child(&of.name).stream();
        let drawn = simulate(&formulas_of(&truth)?, of.steps, &mut stream).map_err(failed)?;
        let answers = of.exact.of(&formulas_of(&filtering)?, &drawn.measurements);
        let (log_evidence, deviations) = answers.map_err(failed)?;
        let measurements = drawn.measurements.rows().map(|row| row.iter().copied().map(Some).collect());
        Ok(Case {
            of,
            model: Model::read(&filtering, &[])?,
            measurements: measurements.collect(),
            log_evidence,
            deviations,
            learned: OnceLock::new(),
        })
    }

    /// So many filters, side by side on so many threads; their seeds do not depend on how many there are.
    ///
    /// # Errors
    /// [`StudyError`] if a filter or learning failed for another reason than that no particle explains a measurement.
    pub(super) fn runs(
        &self,
        cell: &Cell,
        count: usize,
        jobs: Option<usize>,
        interrupt: &Interrupt,
    ) -> Result<Vec<Run>, StudyError> {
        let failed = |source: MotesError| match source {
            MotesError::Interrupted => StudyError::Interrupted,
            source => StudyError::Filter { model: self.of.name.clone(), source: Box::new(source) },
        };
        let proposal = self.proposal(cell.proposal, interrupt).map_err(failed)?;
        let (next, found) = (Mutex::new(0..count), Mutex::new(Vec::with_capacity(count)));
        let work = || -> Result<(), MotesError> {
            loop {
                let number = next.lock().unwrap_or_else(|poisoned| poisoned.into_inner()).next();
                let Some(number) = number else { return Ok(()) };
                let seed = cell.seed.wrapping_mul(1_000_003).wrapping_add(number as u64);
                let options = FilterOptions {
                    proposal: proposal.clone(),
                    particles: cell.particles,
                    seed,
                    ..FilterOptions::default()
                };
                let figures = run(&self.model, &options, &self.measurements, &|| interrupt.check())?;
                let run = self.judged(cell, number, figures);
                found.lock().unwrap_or_else(|poisoned| poisoned.into_inner()).push(run);
            }
        };
        let (first, second) = on_threads(jobs, || rayon_core::join(work, work)).map_err(failed)?;
        first.and(second).map_err(failed)?;
        let mut found = found.into_inner().unwrap_or_else(|poisoned| poisoned.into_inner());
        found.sort_by_key(|run| run.run);
        Ok(found)
    }

    fn proposal(&self, proposal: StudyProposal, interrupt: &Interrupt) -> Result<ProposalName, MotesError> {
        Ok(match proposal {
            StudyProposal::Bootstrap => ProposalName::Bootstrap,
            StudyProposal::Linearised => ProposalName::Linearised,
            StudyProposal::Learned => match self.learned.get() {
                Some(learned) => learned.clone(),
                None => {
                    let learned =
                        learn(&self.model, None, &LearnOptions::default(), |_, _| interrupt.check())?;
                    self.learned.get_or_init(|| ProposalName::Learned(learned.proposal)).clone()
                }
            },
        })
    }

    /// What a filter said beside what is exact.
    fn judged(&self, cell: &Cell, number: usize, figures: Figures) -> Run {
        let ratios = self.deviations.iter().flatten().zip(&figures.deviations);
        let ratios = ratios.map(|(exact, found)| (found / exact).max(exact / found));
        Run {
            half: self.of.half.clone(),
            model: self.of.name.clone(),
            proposal: cell.proposal.name().into(),
            particles: cell.particles,
            run: number,
            error: figures.log_evidence - self.log_evidence,
            standard_error: figures.standard_error,
            deviation_ratio: ratios.reduce(f64::max),
            warnings: figures.warnings,
            key: cell.key.clone(),
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::warnings::exact::Exact;

    /// Bootstrap filters of a model of counts.
    fn runs(
        name: &str,
        steps: usize,
        grid: [f64; 2],
        points: usize,
        particles: usize,
        count: usize,
    ) -> Vec<Run> {
        let model = StudyModel {
            name: name.into(),
            truth: Some(format!("{name}-truth")),
            half: "set".into(),
            steps,
            exact: Exact::Quadrature { low: grid[0], high: grid[1], points },
        };
        let home = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../experiments/warnings");
        let cell = Cell::new(&home, &model, StudyProposal::Bootstrap, particles, 1).unwrap();
        Case::new(&home, &model).unwrap().runs(&cell, count, Some(2), &Interrupt::default()).unwrap()
    }

    #[test]
    fn a_rate_of_counts_that_rises_tenfold_at_once_is_never_silent() {
        for particles in [100, 1000] {
            for run in runs("rate-jump", 120, [-2.0, 4.0], 1201, particles, 5) {
                assert!(run.error < -100.0 && run.warnings.contains("surprise"), "{run:?}");
            }
        }
    }

    #[test]
    fn counts_of_a_slow_rate_that_is_stirred_again_and_again_are_not_silent() {
        let runs = runs("whisker", 300, [-6.0, 6.0], 1601, 100, 20);
        assert!(runs.iter().any(|run| run.error < -5.0));
        assert!(!runs.iter().any(Run::is_silent), "{runs:?}");
    }
}
