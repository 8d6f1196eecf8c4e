//! State-space models, and what is done with them.

use std::path::PathBuf;
use std::sync::Arc;
use std::time::Instant;

use motes::smc::SmoothedPaths;
use motes::{
    Columns, CompareOptions, LearnedProposal, ProposalName, Smoothed, Table, check, designed_for_recorded,
    learn, log_evidence, simulate, simulate_along, simulate_from_priors, smooth,
};
use numpy::{IntoPyArray, PyArray1, PyReadonlyArray1};
use pyo3::prelude::*;
use pyo3::types::PyBytes;

use crate::arguments::{integer, seed_of, threads_of};
use crate::call::{ForCall, Made};
use crate::card::Card;
use crate::comparison::carded;
use crate::data::Data;
use crate::errors::{in_python, to_python};
use crate::filtered::Filtered;
use crate::learned::{LearnArguments, Proposal};
use crate::options::{FilterOptions, ProposalArgument};
use crate::simulated::{flat, labels};
use crate::work::without_lock;

/// A state-space model.
#[pyclass(frozen, module = "motes._motes")]
pub(crate) struct Model {
    pub(crate) model: Arc<motes::Model>,
    /// Parameters that were given other values.
    pub(crate) set: Vec<(String, f64)>,
    pub(crate) made: Made,
}

/// Which columns measurements are, which ones `series`, `t`, the times and the carried one are, which ones are inputs, and which ones are not used.
type Places = (Vec<usize>, [Option<usize>; 4], Vec<usize>, Vec<String>);

/// States, measurements, times and inputs of simulated series, flat.
type Simulated<'py> = [Bound<'py, PyArray1<f64>>; 4];

/// The parameters that were drawn for a series, with their values.
type Drawn = Vec<(String, f64)>;

/// What a model was parsed of: the text, what errors call it, parameters with other values, and whether a program wrote it.
type Parsed = (String, String, Vec<(String, f64)>, bool);

/// A proposal that was learned, what validation said after so many updates, and how many seconds it took.
type Learned = (Proposal, Vec<(usize, f64)>, Vec<String>, f64);

#[pymethods]
impl Model {
    /// The model of a file.
    #[staticmethod]
    fn read(path: PathBuf, set: Vec<(String, f64)>) -> PyResult<Self> {
        let model = motes::Model::read(&path, &set).map_err(to_python)?;
        let made = Made::Text { called: path.display().to_string(), is_generated: false };
        Ok(Model { model: Arc::new(model), set, made })
    }

    /// The model of a text, which errors call `name`; they do not count its lines if a program wrote it.
    #[staticmethod]
    fn parse(text: &str, name: &str, set: Vec<(String, f64)>, is_generated: bool) -> PyResult<Self> {
        let parse = if is_generated { motes::Model::parse_generated } else { motes::Model::parse };
        let model = parse(text, name, &set).map_err(to_python)?;
        let made = Made::Text { called: name.to_string(), is_generated };
        Ok(Model { model: Arc::new(model), set, made })
    }

    /// What `parse` makes it of again; none of functions.
    #[getter]
    fn source(&self) -> Option<Parsed> {
        let Made::Text { called, is_generated } = &self.made else { return None };
        Some((self.model.text()?.to_string(), called.clone(), self.set.clone(), *is_generated))
    }

    /// Parameters that were given other values.
    #[getter]
    fn set(&self) -> Vec<(String, f64)> {
        self.set.clone()
    }

    #[getter]
    fn name(&self) -> &str {
        self.model.name()
    }

    #[getter]
    fn states(&self) -> Vec<String> {
        self.model.states().to_vec()
    }

    #[getter]
    fn measurements(&self) -> Vec<String> {
        self.model.measurements().to_vec()
    }

    #[getter]
    fn parameters(&self) -> Vec<(String, f64)> {
        self.model.parameters().to_vec()
    }

    /// Its coordinates and what they are distributed as, for people.
    fn describe(&self) -> String {
        self.model.describe().to_string()
    }

    /// The designed proposals that it has.
    #[getter]
    fn proposals(&self) -> PyResult<Vec<String>> {
        let call = self.for_call()?;
        let there = motes::designed(&call.model, &motes::FilterOptions::default());
        call.failure.or(Ok(there.iter().map(ToString::to_string).collect()))
    }

    /// What the columns of a table are for.
    fn columns(&self, header: Vec<String>) -> PyResult<Places> {
        let columns = Columns::of(&header, "data", &self.model).map_err(to_python)?;
        let [series, time, carried] = columns.others();
        let others = [series, time, columns.clock(), carried];
        let inputs = columns.inputs().iter().flatten().copied().collect();
        Ok((columns.measurements().to_vec(), others, inputs, columns.ignored.clone()))
    }

    /// Data of a table: its header, the measurements row by row, the columns `series`, `t` and the carried one, an index of dates without a name, the column of times
    /// that the model names, and the inputs row by row.
    #[pyo3(signature = (header, measurements, series, times, carried, index=None, clock=None, inputs=None))]
    #[expect(clippy::too_many_arguments, reason = "a table in parts, as Python hands it over")]
    fn data(
        &self,
        header: Vec<String>,
        measurements: PyReadonlyArray1<'_, f64>,
        series: Option<Vec<String>>,
        times: Option<Vec<f64>>,
        carried: Option<Vec<String>>,
        index: Option<Vec<String>>,
        clock: Option<Vec<String>>,
        inputs: Option<PyReadonlyArray1<'_, f64>>,
    ) -> PyResult<Data> {
        let table = Table {
            name: "data",
            header: &header,
            measurements: measurements.as_slice()?,
            series: series.as_deref(),
            times: times.as_deref(),
            clock: clock.as_deref(),
            inputs: inputs.as_ref().map(PyReadonlyArray1::as_slice).transpose()?.unwrap_or_default(),
            carried: carried.as_deref(),
            index: index.as_deref(),
        };
        motes::Data::of_table(&table, &self.model).map(Data).map_err(to_python)
    }

    /// Data of a CSV file.
    fn open(&self, path: PathBuf) -> PyResult<Data> {
        motes::Data::open(&path, &self.model).map(Data).map_err(to_python)
    }

    /// The column of data that tells series apart.
    #[getter]
    fn series_column(&self) -> &str {
        self.model.series_column()
    }

    /// The column of data that has the times of rows, where the model names one.
    #[getter]
    fn time_column(&self) -> Option<&str> {
        self.model.time_column()
    }

    /// The columns of data that inputs come from.
    #[getter]
    fn input_columns(&self) -> Vec<String> {
        self.model.input_columns().to_vec()
    }

    /// Simulated series, flat, of `steps` rows or at the times and with the inputs of data; the parameters of each that were drawn from their priors; and what their times are called, where they
    /// have names.
    #[pyo3(signature = (steps, series, seed, inputs=None, prior=false))]
    fn simulate<'py>(
        &self,
        py: Python<'py>,
        steps: i64,
        series: i64,
        seed: i128,
        inputs: Option<&Bound<'_, Data>>,
        prior: bool,
    ) -> PyResult<(Simulated<'py>, Vec<Drawn>, Option<Vec<String>>)> {
        let steps = integer("steps", steps, 1, 1_000_000_000)?;
        let inputs = inputs.map(|data| &data.get().0);
        let series = integer("series", series, 1, 1_000_000_000)?;
        let seed = seed_of(seed)?;
        let ForCall { model, failure, .. } = self.for_simulations()?;
        let drawn = without_lock(py, Some(1), &failure.stop, || match (prior, inputs) {
            (true, inputs) => simulate_from_priors(&model, inputs, steps, series, seed, |_| failure.asked()),
            (false, Some(inputs)) => simulate_along(&model, inputs, series, seed, |_| failure.asked()),
            (false, None) => simulate(&model, steps, series, seed, |_| failure.asked()),
        })?;
        let drawn = failure.or(drawn)?;
        let labels = labels(&drawn);
        Ok((flat(&drawn).map(|values| values.into_pyarray(py)), drawn.parameters, labels))
    }

    /// What is as it should be, and what is not.
    fn check(
        &self,
        py: Python<'_>,
        data: Option<&Bound<'_, Data>>,
        seed: i128,
    ) -> PyResult<(Vec<String>, Vec<String>)> {
        let seed = seed_of(seed)?;
        let (call, data) = (self.for_simulations()?, data.map(|data| &data.get().0));
        let ForCall { model, failure, .. } = &call;
        let checked = without_lock(py, call.threads(None), &failure.stop, || {
            check(model, data, seed, || failure.asked())
        })?;
        let checked = failure.or(checked)?;
        let in_python = |lines: Vec<String>| lines.iter().map(|line| in_python(line)).collect();
        Ok((in_python(checked.findings), in_python(checked.problems)))
    }

    /// The log-evidence of all series; with −∞ where no particle explains a measurement, and which one that is.
    fn log_evidence(
        &self,
        py: Python<'_>,
        data: &Bound<'_, Data>,
        options: &Bound<'_, FilterOptions>,
    ) -> PyResult<(f64, Option<String>)> {
        let FilterOptions { options, threads } = options.get();
        let (call, rows) = (self.for_call()?, &data.get().0);
        let (ForCall { model, failure, .. }, threads) = (&call, call.threads(*threads));
        let found = without_lock(py, threads, &failure.stop, || {
            log_evidence(model, rows, options, |_| failure.asked())
        })?;
        let found = failure.or(found)?;
        Ok((found.value, found.impossible.map(|warning| in_python(&warning.to_string()))))
    }

    /// Filters each series and draws trajectories backwards.
    fn smooth(
        &self,
        py: Python<'_>,
        data: Py<Data>,
        options: &Bound<'_, FilterOptions>,
        paths: i64,
    ) -> PyResult<Filtered> {
        let FilterOptions { options, threads } = options.get();
        let paths = integer("paths", paths, 1, 1_000_000_000)?;
        let (call, rows) = (self.for_call()?, &data.get().0);
        let (ForCall { model, failure, .. }, threads) = (&call, call.threads(*threads));
        let start = Instant::now();
        let smoothed = without_lock(py, threads, &failure.stop, || {
            smooth(model, rows, options, paths, |_| failure.asked())
        })?;
        let Smoothed { estimates, paths, filtered } = failure.or(smoothed)?;
        Ok(self.found(data, options, start, filtered, Some((estimates, paths))))
    }

    /// Reads the proposal in a folder, which was learned for this model; `to_tune` one whose model may have had other parameters.
    fn load_proposal(&self, folder: PathBuf, to_tune: bool) -> PyResult<Proposal> {
        let read = if to_tune { LearnedProposal::load_to_tune } else { LearnedProposal::load };
        let call = self.for_call()?;
        call.failure.or(read(&folder, &call.model).map(Proposal))
    }

    /// Writes a proposal that was learned for this model into a folder.
    fn save_proposal(&self, proposal: &Bound<'_, Proposal>, folder: PathBuf) -> PyResult<()> {
        let call = self.for_call()?;
        call.failure.or(proposal.get().0.save(&folder, &call.model))
    }

    /// A proposal that was learned for this model as bytes.
    fn proposal_bytes<'py>(
        &self,
        py: Python<'py>,
        proposal: &Bound<'_, Proposal>,
    ) -> PyResult<Bound<'py, PyBytes>> {
        let call = self.for_call()?;
        let bytes = call.failure.or(proposal.get().0.to_bytes(&call.model))?;
        Ok(PyBytes::new(py, &bytes))
    }

    /// The proposal of which `proposal_bytes` made these.
    fn proposal_of_bytes(&self, bytes: &[u8]) -> PyResult<Proposal> {
        let call = self.for_call()?;
        call.failure.or(LearnedProposal::from_bytes(bytes, &call.model).map(Proposal))
    }

    /// Learns a proposal; `arguments` are those of the Python function. With it comes what validation said, step by step.
    fn learn(
        &self,
        py: Python<'_>,
        data: Option<&Bound<'_, Data>>,
        arguments: LearnArguments<'_>,
        threads: Option<i64>,
    ) -> PyResult<Learned> {
        let options = arguments.options()?;
        let (ForCall { model, failure, .. }, data) =
            (self.for_simulations()?, data.map(|data| &data.get().0));
        let learned = without_lock(py, threads_of(threads)?, &failure.stop, || {
            learn(&model, data, &options, |_, _| failure.asked())
        })?;
        let all = failure.or(learned)?;
        Ok((Proposal(all.proposal.clone()), all.validation(), all.warnings(), all.training_seconds))
    }

    /// Holds a proposal that was learned against the designed ones.
    #[expect(clippy::too_many_arguments, reason = "each is an argument of the Python function with its name")]
    fn card(
        &self,
        py: Python<'_>,
        proposal: &Bound<'_, Proposal>,
        particles: i64,
        sequences: i64,
        steps: i64,
        seed: i128,
        threads: Option<i64>,
        training_seconds: f64,
    ) -> PyResult<Card> {
        let particles = integer("particles", particles, 1, 1_000_000_000)?;
        let learned = proposal.get().0.clone();
        let threads = threads_of(threads)?;
        let options = CompareOptions {
            sequences: integer("sequences", sequences, 1, 1_000_000)?,
            steps: integer("steps", steps, 2, 1_000_000)?,
            timed_threads: threads.unwrap_or(1),
            ..CompareOptions::of_learned(&self.for_call()?.model, learned, particles, seed_of(seed)?)
        };
        carded(&self.for_call()?, py, None, options, threads, Some(training_seconds))
    }

    /// Holds proposals against each other; all designed ones that the model has if none is named.
    #[expect(clippy::too_many_arguments, reason = "each is an argument of the Python function with its name")]
    fn compare(
        &self,
        py: Python<'_>,
        data: Option<&Bound<'_, Data>>,
        proposals: Vec<ProposalArgument<'_>>,
        filter: &Bound<'_, FilterOptions>,
        sweep: Vec<i64>,
        sequences: i64,
        steps: i64,
    ) -> PyResult<Card> {
        let FilterOptions { options: filter, threads } = filter.get();
        let named: Vec<ProposalName> =
            proposals.iter().map(ProposalArgument::name).collect::<PyResult<_>>()?;
        let call = self.for_call()?;
        let proposals = if named.is_empty() { designed_for_recorded(&call.model, filter) } else { named };
        call.failure.or(Ok(()))?;
        let sweep = sweep.iter().map(|count| integer("sweep", *count, 1, 1_000_000_000));
        let options = CompareOptions {
            proposals,
            filter: filter.clone(),
            particles: sweep.collect::<PyResult<_>>()?,
            sequences: integer("sequences", sequences, 1, 1_000_000)?,
            steps: integer("steps", steps, 2, 1_000_000_000)?,
            inputs: None,
            particles_up_to: None,
            reference_particles: CompareOptions::REFERENCE_PARTICLES,
            reference_filters: 1,
            reference_error: None,
            references: None,
            timed_threads: threads.unwrap_or(1),
        };
        carded(&call, py, data.map(|data| &data.get().0), options, *threads, None)
    }
}

impl Model {
    /// The model itself.
    pub(crate) fn motes(&self) -> &motes::Model {
        &self.model
    }

    /// This model for one call.
    pub(crate) fn for_call(&self) -> PyResult<ForCall> {
        ForCall::new(&self.model, &self.made, &self.set, false)
    }

    /// This model for one call that simulates series, which may overflow.
    fn for_simulations(&self) -> PyResult<ForCall> {
        ForCall::new(&self.model, &self.made, &self.set, true)
    }

    /// What was found, by work that began at `start`, with what there is to say of it.
    fn found(
        &self,
        data: Py<Data>,
        options: &motes::FilterOptions,
        start: Instant,
        filtered: motes::Filtered,
        smoothed: Option<(Vec<motes::Estimate>, Vec<SmoothedPaths>)>,
    ) -> Filtered {
        let seconds = start.elapsed().as_secs_f64();
        Filtered::new(&self.model, &self.set, data, options, filtered, smoothed, seconds)
    }
}
