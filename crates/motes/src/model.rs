//! A model as the command has it: of a file, or one of a program's own, with names for its coordinates.

use std::fmt;
use std::path::Path;
use std::slice::from_mut;
use std::sync::Arc;

use motes_formulas::{
    Description, FileError, FileModel, FormulaModel, Frame, Impossible, ModelFile, Prior, Schedule,
};
use motes_models::{LinearGaussian, Simulator, Step, Stream};

use crate::error::MotesError;
use crate::exact_system::ExactSystem;
use crate::own_model::{LearnableModel, Own};
use crate::timeline::Timeline;

/// A model of a file, of a text, or of a program.
#[derive(Clone)]
pub struct Model(Source);

#[derive(Clone)]
enum Source {
    File(ModelFile, Option<Arc<Timeline>>),
    Own(Own),
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
            FileModel::Formulas(formulas) => Timeline::load(formulas.frame(), &file.measurements, folder)
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
        let names = [listed(states), listed(measurements)];
        Ok(Model(Source::Own(Own::new(name, names, Arc::new(model))?)))
    }

    /// [`Model::own`] with times, inputs and parameters: `sections` is a text with the sections `[time]`, `[inputs]`, `[parameters]` and `[series]` of a model file, as many of them as there are, and
    /// `make` gives the model with these values of the parameters, in the order of the text. It is called again where they have others, as in a fit.
    ///
    /// The inputs of a step are in the order of `[inputs]`. Each needs a value in all steps and at all rows, whatever the equations use; in `x_0` it is NaN where it has none.
    ///
    /// ```
    /// use motes::prelude::*;
    /// use motes::{Data, FitOptions, Model, fit};
    /// use std::ops::ControlFlow;
    ///
    /// /// A level that a pump fills, in metres.
    /// struct Tank {
    ///     leak: f64,
    /// }
    ///
    /// impl Equations for Tank {
    ///     fn dimensions(&self) -> [usize; 2] {
    ///         [1, 1]
    ///     }
    ///
    ///     fn inputs(&self) -> &[f64] {
    ///         &[f64::NAN]
    ///     }
    ///
    ///     fn initial<S: Scalar>(&self, _: &Step<'_, S>, draws: &mut impl Draws<S>, x: &mut [S]) {
    ///         x[0] = draws.draw(normal(1.0, 0.5));
    ///     }
    ///
    ///     fn transition<S: Scalar>(&self, step: &Step<'_, S>, before: &[S], draws: &mut impl Draws<S>, x: &mut [S]) {
    ///         let change = before[0] * -self.leak + step.inputs[0];
    ///         x[0] = draws.draw(normal(before[0] + change * step.length, 0.1 * step.length.sqrt()));
    ///     }
    ///
    ///     fn measurement<S: Scalar>(&self, _: &Step<'_, S>, x: &[S], y: &mut impl Coordinates<S>) {
    ///         y.push(normal(x[0], 0.05));
    ///     }
    /// }
    ///
    /// let sections = r#"
    ///     [time]
    ///     column = "hour"
    ///     step = 0.5
    ///     [inputs]
    ///     pump = "hold"
    ///     [parameters]
    ///     leak = "log_normal(log(0.2), 0.5)"
    /// "#;
    /// let model = Model::own_with("tank", &["level"], &["gauge"], sections, |values| Tank { leak: values[0].1 })?;
    /// let data = Data::read("hour,pump,gauge\n0,0.3,1.2\n1.5,0.1,1.4\n4,0,1.1\n".as_bytes(), "tank.csv", &model)?;
    /// let options = FitOptions { draws: Some(40), particles: Some(50), ..FitOptions::default() };
    /// let found = fit(&model, &data, &options, &|| ControlFlow::Continue(()), &mut |_| Ok(()))?;
    /// assert_eq!(found.names, ["leak"]);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// [`MotesError::Model`] for another section, or for what is wrong in one of these; [`MotesError::Setting`] as [`Model::own`], and if the model takes another number of inputs, or
    /// parameters of its steps.
    pub fn own_with<M: LearnableModel + 'static>(
        name: &str,
        states: &[impl AsRef<str>],
        measurements: &[impl AsRef<str>],
        sections: &str,
        make: impl Fn(&[(String, f64)]) -> M + Send + Sync + 'static,
    ) -> Result<Self, MotesError> {
        let names = [listed(states), listed(measurements)];
        let make =
            Arc::new(move |values: &[(String, f64)]| -> Arc<dyn LearnableModel> { Arc::new(make(values)) });
        Ok(Model(Source::Own(Own::with_sections(name, names, sections, make)?)))
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

    /// The parameters with their values.
    pub fn parameters(&self) -> &[(String, f64)] {
        match &self.0 {
            Source::File(file, _) => &file.parameters,
            Source::Own(_) => self.frame().map_or(&[], Frame::parameters),
        }
    }

    /// The priors of parameters that have one, in the order of the file.
    pub fn priors(&self) -> &[Prior] {
        self.frame().map_or(&[], Frame::priors)
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
                let timeline =
                    timeline.as_ref().map(|timeline| Arc::new(timeline.of_model(formulas.frame())));
                Ok(Model(Source::File(file, timeline)))
            }
            Source::Own(own) => Ok(Model(Source::Own(own.with_parameters(values)?))),
        }
    }

    /// Its formulas in which each particle has these parameters of its own.
    ///
    /// # Errors
    /// Why that cannot be: it is no file of formulas, or a parameter says what must be known before there are particles.
    pub(crate) fn with_parameters_of_particles(&self, names: &[String]) -> Result<FormulaModel, String> {
        match &self.0 {
            Source::File(file, _) => {
                file.with_parameters_of_particles(names).map_err(|error| error.to_string())
            }
            Source::Own(own) => Err(format!("the equations of {} are functions", own.name)),
        }
    }

    /// The text of the model file, or of the sections of a model of one's own, if it has such.
    pub fn text(&self) -> Option<&str> {
        match &self.0 {
            Source::File(file, _) => Some(&file.text),
            Source::Own(own) => own.sections.as_ref().map(|sections| sections.text.as_str()),
        }
    }

    /// Its coordinates and what they are distributed as, for people.
    pub fn describe(&self) -> Description {
        match &self.0 {
            Source::File(file, _) => file.describe(),
            Source::Own(own) => {
                let names = [("states", &own.states), ("measurements", &own.measurements)];
                let groups = names.map(|(title, names)| (title.into(), vec![names.join(", ")])).to_vec();
                match self.frame() {
                    Some(frame) => frame.describe(groups),
                    None => Description { groups },
                }
            }
        }
    }

    /// The column of data that tells series apart: `series`, unless the model names another.
    pub fn series_column(&self) -> &str {
        self.frame().and_then(Frame::series_column).unwrap_or("series")
    }

    /// The same model with the steps of a sequence as its own, for who simulates it many times; none of a model without times or inputs.
    pub(crate) fn along(&self, schedule: Schedule) -> Option<Model> {
        let (file, timeline) = match &self.0 {
            Source::File(file, timeline) => (file, timeline.as_ref()?),
            Source::Own(own) => return own.along(schedule).map(|own| Model(Source::Own(own))),
        };
        let FileModel::Formulas(formulas) = &file.model else { return None };
        let model = FileModel::Formulas(formulas.along(schedule));
        Some(Model(Source::File(ModelFile { model, ..file.clone() }, Some(Arc::clone(timeline)))))
    }

    /// Its times and inputs, with the files that it names.
    pub(crate) fn timeline(&self) -> Option<&Timeline> {
        match &self.0 {
            Source::File(_, timeline) => timeline.as_deref(),
            Source::Own(own) => own.sections.as_ref()?.timeline.as_deref(),
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

    /// Its times, inputs and parameters, if it is no file of matrices alone and says anything of these.
    pub(crate) fn frame(&self) -> Option<&Frame> {
        match &self.0 {
            Source::File(ModelFile { model: FileModel::Formulas(formulas), .. }, _) => Some(formulas.frame()),
            Source::File(..) => None,
            Source::Own(own) => own.sections.as_ref().map(|sections| &sections.frame),
        }
    }

    /// Its formulas, if it is a file of them.
    pub(crate) fn formulas(&self) -> Option<&FormulaModel> {
        match &self.0 {
            Source::File(ModelFile { model: FileModel::Formulas(formulas), .. }, _) => Some(formulas),
            _ => None,
        }
    }
}

/// Names as texts of their own.
fn listed(names: &[impl AsRef<str>]) -> Vec<String> {
    names.iter().map(|name| name.as_ref().to_string()).collect()
}
