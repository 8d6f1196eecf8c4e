//! A model as the command has it: of a file, or one of a program's own, with names for its coordinates.

use std::fmt;
use std::path::Path;
use std::slice::from_mut;
use std::sync::Arc;

use motes_formulas::{
    Description, FileError, FileModel, FormulaModel, Impossible, ModelFile, Prior, Schedule,
};
use motes_models::{
    LinearGaussian, OwnModel, Simulator, StateGradients, StateSpaceModel, Step, StepRecord, Stream,
};

use crate::error::MotesError;
use crate::exact_system::ExactSystem;
use crate::timeline::{Clock, RowTime, Timeline, TimelineError};

/// A model that proposals can be learned for: it simulates itself, its noise can be transported, its measurements linearised. What states its
/// [`Equations`](motes_models::equations::Equations) is one.
pub trait LearnableModel: OwnModel + StateGradients + Send {}

impl<M: OwnModel + StateGradients + Send> LearnableModel for M {}

/// A model of a file, of a text, or of a program.
#[derive(Clone)]
pub struct Model(Source);

#[derive(Clone)]
enum Source {
    File(ModelFile, Option<Arc<Timeline>>),
    Own(Own),
}

/// A model that a program states itself.
#[derive(Clone)]
struct Own {
    name: String,
    states: Vec<String>,
    measurements: Vec<String>,
    model: Arc<dyn LearnableModel>,
}

/// What kind a model is of.
#[derive(Clone, Copy)]
pub(crate) enum Kind<'a> {
    /// One with equations of any form.
    Learnable(&'a dyn LearnableModel),
    /// A linear Gaussian one by its matrices.
    LinearGaussian(&'a LinearGaussian),
}

impl fmt::Debug for Model {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.debug_struct("Model").field("name", &self.name()).finish_non_exhaustive()
    }
}

impl Model {
    /// Reads a model file; `overrides` replace the values of parameters.
    ///
    /// # Errors
    /// [`FileError`] as [`motes_formulas::read`].
    pub fn read(path: &Path, overrides: &[(String, f64)]) -> Result<Self, FileError> {
        Model::of_file(motes_formulas::read(path, overrides)?, path)
    }

    /// Makes a model of a text, which errors call `name`.
    ///
    /// # Errors
    /// [`FileError`] as [`motes_formulas::parse`].
    pub fn parse(text: &str, name: &str, overrides: &[(String, f64)]) -> Result<Self, FileError> {
        Model::of_file(motes_formulas::parse(text, name, overrides)?, Path::new(name))
    }

    /// [`Model::parse`] of a text that a program wrote: errors, those of filters too, name sections and keys, and no lines.
    ///
    /// # Errors
    /// [`FileError`] as [`motes_formulas::parse_generated`].
    pub fn parse_generated(text: &str, name: &str, overrides: &[(String, f64)]) -> Result<Self, FileError> {
        Model::of_file(motes_formulas::parse_generated(text, name, overrides)?, Path::new(""))
    }

    /// The model of a file, with the files that it names, relative to its folder.
    fn of_file(file: ModelFile, path: &Path) -> Result<Self, FileError> {
        let folder = path.parent().unwrap_or(Path::new(""));
        let timeline = match &file.model {
            FileModel::Formulas(formulas) => Timeline::load(formulas, &file.measurements, folder)
                .map_err(|(file, reason)| FileError::Inputs { file, reason })?,
            FileModel::LinearGaussian(_) => None,
        };
        Ok(Model(Source::File(file, timeline.map(Arc::new))))
    }

    /// A model of one's own, with names for the coordinates of its states and of its measurements.
    ///
    /// ```
    /// use motes::prelude::*;
    /// use motes::{Data, FilterOptions, Model, filter};
    ///
    /// /// A random walk.
    /// struct Walk;
    ///
    /// impl Equations for Walk {
    ///     fn dimensions(&self) -> [usize; 2] {
    ///         [1, 1]
    ///     }
    ///
    ///     fn initial<S: Scalar>(&self, _: &Step<'_, S>, draws: &mut impl Draws<S>, x: &mut [S]) {
    ///         x[0] = draws.draw(normal(0.0, 1.0));
    ///     }
    ///
    ///     fn transition<S: Scalar>(&self, _: &Step<'_, S>, before: &[S], draws: &mut impl Draws<S>, x: &mut [S]) {
    ///         x[0] = draws.draw(normal(before[0], 1.0));
    ///     }
    ///
    ///     fn measurement<S: Scalar>(&self, _: &Step<'_, S>, x: &[S], y: &mut impl Coordinates<S>) {
    ///         y.push(normal(x[0], 0.5));
    ///     }
    /// }
    ///
    /// let model = Model::own("walk", &["x"], &["y"], Walk)?;
    /// let data = Data::read("t,y\n0,0.3\n1,\n2,0.7\n".as_bytes(), "walk.csv", &model)?;
    /// let filtered = filter(&model, &data, &FilterOptions::default(), |_| std::ops::ControlFlow::Continue(()))?;
    /// assert!(filtered.log_evidence().is_finite());
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// [`MotesError::Setting`] if there is not one name for each coordinate, or two are the same.
    pub fn own(
        name: &str,
        states: &[impl AsRef<str>],
        measurements: &[impl AsRef<str>],
        model: impl LearnableModel + 'static,
    ) -> Result<Self, MotesError> {
        let names = |names: &[&str], what: &str, expected: usize| {
            if names.len() != expected || expected == 0 {
                let reason = format!("{what}: {} names; the model has {expected} coordinates", names.len());
                return Err(MotesError::Setting(reason));
            }
            Ok(names.iter().map(ToString::to_string).collect::<Vec<String>>())
        };
        let all: [Vec<&str>; 2] =
            [states.iter().map(AsRef::as_ref).collect(), measurements.iter().map(AsRef::as_ref).collect()];
        let both = all.concat();
        let is_name =
            |name: &str| !name.trim().is_empty() && name.trim() == name && !name.contains(char::is_control);
        if let Some(name) = both.iter().find(|name| !is_name(name) || ["t", "series"].contains(name)) {
            let reason = format!(
                "{name:?} names a coordinate; it must be a word, and none of t and series, which data have"
            );
            return Err(MotesError::Setting(reason));
        }
        if let Some(twice) = both.iter().enumerate().find(|(at, name)| both[..*at].contains(name)) {
            return Err(MotesError::Setting(format!("{}: there are two coordinates of that name", twice.1)));
        }
        Ok(Model(Source::Own(Own {
            name: name.to_string(),
            states: names(&all[0], "states", model.state_dim())?,
            measurements: names(&all[1], "measurements", model.measurement_dim())?,
            model: Arc::new(model),
        })))
    }

    /// What it calls itself.
    pub fn name(&self) -> &str {
        match &self.0 {
            Source::File(file, _) => &file.name,
            Source::Own(own) => &own.name,
        }
    }

    /// The names of the `N` coordinates of a state.
    pub fn states(&self) -> &[String] {
        match &self.0 {
            Source::File(file, _) => &file.states,
            Source::Own(own) => &own.states,
        }
    }

    /// The names of the `M` coordinates of a measurement, which are the columns of data.
    pub fn measurements(&self) -> &[String] {
        match &self.0 {
            Source::File(file, _) => &file.measurements,
            Source::Own(own) => &own.measurements,
        }
    }

    /// The parameters with their values; those of a model of one's own are its own affair.
    pub fn parameters(&self) -> &[(String, f64)] {
        match &self.0 {
            Source::File(file, _) => &file.parameters,
            Source::Own(_) => &[],
        }
    }

    /// The priors of parameters that have one, in the order of the file; none of a model of one's own.
    pub fn priors(&self) -> &[Prior] {
        self.formulas().map_or(&[], FormulaModel::priors)
    }

    /// The same model with other values of parameters.
    ///
    /// # Errors
    /// [`FileError`] if there is no such parameter, or it is no model with these values.
    pub fn with_parameters(&self, values: &[(String, f64)]) -> Result<Self, FileError> {
        match &self.0 {
            Source::File(file, timeline) => {
                let file = file.with_parameters(values)?;
                let FileModel::Formulas(formulas) = &file.model else {
                    return Ok(Model(Source::File(file, timeline.clone())));
                };
                let timeline = timeline.as_ref().map(|timeline| Arc::new(timeline.of_model(formulas)));
                Ok(Model(Source::File(file, timeline)))
            }
            Source::Own(_) => Ok(self.clone()),
        }
    }

    /// The text of the model file; none of a model of one's own.
    pub fn text(&self) -> Option<&str> {
        match &self.0 {
            Source::File(file, _) => Some(&file.text),
            Source::Own(_) => None,
        }
    }

    /// Its coordinates and what they are distributed as, for people.
    pub fn describe(&self) -> Description {
        match &self.0 {
            Source::File(file, _) => file.describe(),
            Source::Own(own) => Description {
                groups: vec![
                    ("states".into(), vec![own.states.join(", ")]),
                    ("measurements".into(), vec![own.measurements.join(", ")]),
                ],
            },
        }
    }

    /// The column of data that tells series apart: `series`, unless the model names another.
    pub fn series_column(&self) -> &str {
        self.formulas().and_then(FormulaModel::series_column).unwrap_or("series")
    }

    /// The column of data that has the times of rows, where the model names one.
    pub fn time_column(&self) -> Option<&str> {
        self.timeline().and_then(Timeline::time_column)
    }

    /// The columns of data that the model's inputs come from; some may be measurements.
    pub fn input_columns(&self) -> &[String] {
        self.timeline().map_or(&[], Timeline::columns)
    }

    /// The steps to the next row of a series, all but the last of which have no measurement.
    ///
    /// # Errors
    /// [`TimelineError`] if the row's time does not come next, or an input is missing.
    pub fn next_steps(&self, clock: &mut Clock, row: RowTime<'_>) -> Result<Vec<StepRecord>, TimelineError> {
        match self.timeline() {
            Some(timeline) => clock.next(timeline, row),
            None => Ok(vec![StepRecord::of(&self.step_of_index(clock.count()))]),
        }
    }

    /// The steps to a row after the last one, at which nothing is measured: one with this time and these inputs, or a gap as the last one ahead. An input of the measurement
    /// that is not known then is NaN.
    ///
    /// # Errors
    /// [`TimelineError::Ahead`] if an input is not known then, and as [`Model::next_steps`].
    pub fn steps_ahead(
        &self,
        clock: &mut Clock,
        row: Option<RowTime<'_>>,
    ) -> Result<Vec<StepRecord>, TimelineError> {
        match self.timeline() {
            Some(timeline) => clock.ahead(timeline, row),
            None => Ok(vec![StepRecord::of(&self.step_of_index(clock.count()))]),
        }
    }

    /// An input of the measurement that is not known at the end of a step.
    pub(crate) fn unknown_input(&self, step: &Step<'_>) -> Option<String> {
        let formulas = self.formulas()?;
        let of_measurement = step.end(formulas.input_dim()).inputs;
        let unknown = of_measurement.iter().position(|value| value.is_nan())?;
        formulas.inputs().get(unknown).map(|input| input.name.clone())
    }

    /// Takes in what was measured at the row that [`Model::next_steps`] led to.
    ///
    /// # Errors
    /// [`TimelineError::NoStepBefore`].
    pub fn measured(&self, clock: &mut Clock, measurement: &[Option<f64>]) -> Result<(), TimelineError> {
        match self.timeline() {
            Some(timeline) => clock.measured(timeline, measurement),
            None => Ok(()),
        }
    }

    /// The same model with the steps of a sequence as its own, for who simulates it many times; none of a model without times or inputs.
    pub(crate) fn along(&self, schedule: Schedule) -> Option<Model> {
        let Source::File(file, Some(timeline)) = &self.0 else { return None };
        let FileModel::Formulas(formulas) = &file.model else { return None };
        let model = FileModel::Formulas(formulas.along(schedule));
        Some(Model(Source::File(ModelFile { model, ..file.clone() }, Some(Arc::clone(timeline)))))
    }

    /// A measurement that is an input of later steps, if there is one.
    pub(crate) fn fed_back_measurement(&self) -> Option<&str> {
        let measurements = self.measurements();
        self.input_columns().iter().find(|column| measurements.contains(column)).map(String::as_str)
    }

    /// The column of data that an input comes from.
    pub(crate) fn input_column(&self, input: &str) -> Option<String> {
        self.timeline()?.column_of(input).map(str::to_string)
    }

    pub(crate) fn timeline(&self) -> Option<&Timeline> {
        match &self.0 {
            Source::File(_, timeline) => timeline.as_deref(),
            Source::Own(_) => None,
        }
    }

    /// The step of an index where nobody says more.
    pub(crate) fn step_of_index(&self, index: usize) -> Step<'_> {
        match self.kind() {
            Kind::Learnable(learnable) => learnable.step_of_index(index),
            Kind::LinearGaussian(linear) => linear.step_of_index(index),
        }
    }

    /// The first entry of a measurement (`M`, none where one is missing) that no state can give in a step, as a fraction where counts are measured; none where there may be a
    /// state for each. Of a model of one's own nothing is known.
    pub fn impossible(&self, step: &Step<'_>, measurement: &[Option<f64>]) -> Option<Impossible> {
        self.formulas()?.impossible(step, measurement)
    }

    /// The model itself, by its kind.
    pub(crate) fn kind(&self) -> Kind<'_> {
        match &self.0 {
            Source::File(ModelFile { model: FileModel::Formulas(formulas), .. }, _) => {
                Kind::Learnable(formulas)
            }
            Source::File(ModelFile { model: FileModel::LinearGaussian(linear), .. }, _) => {
                Kind::LinearGaussian(linear)
            }
            Source::Own(own) => Kind::Learnable(&*own.model),
        }
    }

    /// Draws a measurement (`M`) of a state (`N`).
    pub(crate) fn sample_measurement(
        &self,
        step: &Step<'_>,
        state: &[f64],
        stream: &mut Stream,
        out: &mut [f64],
    ) {
        match self.kind() {
            Kind::Learnable(learnable) => learnable.sample_measurements(step, state, from_mut(stream), out),
            Kind::LinearGaussian(linear) => linear.sample_measurements(step, state, from_mut(stream), out),
        }
    }

    /// The model as one that has exact answers, if it is: it is linear with Gaussian noise, or its states are discrete.
    pub(crate) fn exact_system(&self) -> Option<ExactSystem<'_>> {
        if let Kind::LinearGaussian(linear) = self.kind() {
            return Some(ExactSystem::Linear(linear));
        }
        let formulas = self.formulas()?;
        let linear = formulas.linear_system().map(ExactSystem::Linear);
        linear.or_else(|| formulas.finite_system().map(ExactSystem::Finite))
    }

    /// Why no particle meets a measurement, where one is without error.
    pub(crate) fn measured_exactly(&self) -> Option<String> {
        let entry = self.formulas()?.measured_exactly()?;
        let name = &self.measurements()[entry];
        Some(format!("{name} is measured without error, as R says, and no particle is where it was measured"))
    }

    /// Its formulas, if it is a file of them.
    pub(crate) fn formulas(&self) -> Option<&FormulaModel> {
        match &self.0 {
            Source::File(ModelFile { model: FileModel::Formulas(formulas), .. }, _) => Some(formulas),
            _ => None,
        }
    }
}
