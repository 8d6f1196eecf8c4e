//! A model as the command has it: of a file, or one of a program's own, with names for its coordinates.

use std::borrow::Cow;
use std::fmt;
use std::path::Path;
use std::sync::Arc;

use motes_formulas::{Description, FileError, FileModel, FormulaModel, Impossible, ModelFile, Prior};
use motes_models::{LinearGaussian, OwnModel, StateGradients};

use crate::error::MotesError;

/// A model that proposals can be learned for: it simulates itself, its noise can be transported, its measurements linearised. What states its
/// [`Equations`](motes_models::equations::Equations) is one.
pub trait LearnableModel: OwnModel + StateGradients + Send {}

impl<M: OwnModel + StateGradients + Send> LearnableModel for M {}

/// A model of a file, of a text, or of a program.
#[derive(Clone)]
pub struct Model(Source);

#[derive(Clone)]
enum Source {
    File(ModelFile),
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
        Ok(Model(Source::File(motes_formulas::read(path, overrides)?)))
    }

    /// Makes a model of a text, which errors call `name`.
    ///
    /// # Errors
    /// [`FileError`] as [`motes_formulas::parse`].
    pub fn parse(text: &str, name: &str, overrides: &[(String, f64)]) -> Result<Self, FileError> {
        Ok(Model(Source::File(motes_formulas::parse(text, name, overrides)?)))
    }

    /// [`Model::parse`] of a text that a program wrote: errors, those of filters too, name sections and keys, and no lines.
    ///
    /// # Errors
    /// [`FileError`] as [`motes_formulas::parse_generated`].
    pub fn parse_generated(text: &str, name: &str, overrides: &[(String, f64)]) -> Result<Self, FileError> {
        Ok(Model(Source::File(motes_formulas::parse_generated(text, name, overrides)?)))
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
            Source::File(file) => &file.name,
            Source::Own(own) => &own.name,
        }
    }

    /// The names of the `N` coordinates of a state.
    pub fn states(&self) -> &[String] {
        match &self.0 {
            Source::File(file) => &file.states,
            Source::Own(own) => &own.states,
        }
    }

    /// The names of the `M` coordinates of a measurement, which are the columns of data.
    pub fn measurements(&self) -> &[String] {
        match &self.0 {
            Source::File(file) => &file.measurements,
            Source::Own(own) => &own.measurements,
        }
    }

    /// The parameters with their values; those of a model of one's own are its own affair.
    pub fn parameters(&self) -> &[(String, f64)] {
        match &self.0 {
            Source::File(file) => &file.parameters,
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
            Source::File(file) => Ok(Model(Source::File(file.with_parameters(values)?))),
            Source::Own(_) => Ok(self.clone()),
        }
    }

    /// The text of the model file; none of a model of one's own.
    pub fn text(&self) -> Option<&str> {
        match &self.0 {
            Source::File(file) => Some(&file.text),
            Source::Own(_) => None,
        }
    }

    /// Its coordinates and what they are distributed as, for people.
    pub fn describe(&self) -> Description {
        match &self.0 {
            Source::File(file) => file.describe(),
            Source::Own(own) => Description {
                groups: vec![
                    ("states".into(), vec![own.states.join(", ")]),
                    ("measurements".into(), vec![own.measurements.join(", ")]),
                ],
            },
        }
    }

    /// The first entry of a measurement (`M`, none where one is missing) that no state can give at a time, as a fraction where counts are measured; none where there may be a
    /// state for each. Of a model of one's own nothing is known.
    pub fn impossible(&self, time: usize, measurement: &[Option<f64>]) -> Option<Impossible> {
        self.formulas()?.impossible(time, measurement)
    }

    /// The model itself, by its kind.
    pub(crate) fn kind(&self) -> Kind<'_> {
        match &self.0 {
            Source::File(ModelFile { model: FileModel::Formulas(formulas), .. }) => Kind::Learnable(formulas),
            Source::File(ModelFile { model: FileModel::LinearGaussian(linear), .. }) => {
                Kind::LinearGaussian(linear)
            }
            Source::Own(own) => Kind::Learnable(&*own.model),
        }
    }

    /// The model as one of matrices, if it is linear and Gaussian: it has exact answers.
    pub(crate) fn linear_gaussian(&self) -> Option<Cow<'_, LinearGaussian>> {
        match self.kind() {
            Kind::LinearGaussian(linear) => Some(Cow::Borrowed(linear)),
            Kind::Learnable(_) => self.formulas()?.linear_gaussian().map(Cow::Owned),
        }
    }

    /// Its formulas, if it is a file of them.
    pub(crate) fn formulas(&self) -> Option<&FormulaModel> {
        match &self.0 {
            Source::File(ModelFile { model: FileModel::Formulas(formulas), .. }) => Some(formulas),
            _ => None,
        }
    }
}
