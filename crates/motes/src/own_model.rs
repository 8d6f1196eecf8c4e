//! Models that a program states itself.

use std::sync::Arc;

use motes_formulas::{FileError, Frame, Schedule};
use motes_models::{OwnModel, StateGradients};

use crate::error::MotesError;
use crate::scheduled_model::ScheduledModel;
use crate::timeline::Timeline;

/// A model that proposals can be learned for: it simulates itself, its noise can be transported, its measurements linearised. What states its
/// [`Equations`](motes_models::equations::Equations) is one.
pub trait LearnableModel: OwnModel + StateGradients + Send {}

impl<M: OwnModel + StateGradients + Send> LearnableModel for M {}

/// Why nothing but the transition can be drawn, and nothing learned, if it is so.
pub(crate) fn draws_transitions_alone(model: &dyn LearnableModel) -> Option<&'static str> {
    let has_neither = model.density().is_none() && model.noise_space().is_none();
    has_neither.then_some(
        "states have no density, because they are known, follow or are counts, or a step has sub-steps, and nobody knows the noise that functions of many particles make of them",
    )
}

/// Makes a model of values of parameters.
pub(crate) type Maker = dyn Fn(&[(String, f64)]) -> Arc<dyn LearnableModel> + Send + Sync;

/// A model that a program states itself, with names for its coordinates.
#[derive(Clone)]
pub(crate) struct Own {
    pub(crate) name: String,
    pub(crate) states: Vec<String>,
    pub(crate) measurements: Vec<String>,
    /// What the program stated, or that with the steps that its sections or a schedule give.
    pub(crate) model: Arc<dyn LearnableModel>,
    pub(crate) sections: Option<OwnSections>,
}

/// What a program says of times, inputs and parameters of its model.
#[derive(Clone)]
pub(crate) struct OwnSections {
    pub(crate) text: String,
    pub(crate) frame: Frame,
    pub(crate) timeline: Option<Arc<Timeline>>,
    make: Arc<Maker>,
}

impl Own {
    /// A model without sections.
    ///
    /// # Errors
    /// [`MotesError::Setting`] as [`Model::own`](crate::Model::own).
    pub(crate) fn new(
        name: &str,
        [states, measurements]: [Vec<String>; 2],
        model: Arc<dyn LearnableModel>,
    ) -> Result<Self, MotesError> {
        check_names(&states, &measurements)?;
        check_sizes([&states, &measurements], &*model)?;
        Ok(Own { name: name.into(), states, measurements, model, sections: None })
    }

    /// A model with sections, which `make` makes of the values of parameters.
    ///
    /// # Errors
    /// [`MotesError`] as [`Model::own_with`](crate::Model::own_with).
    pub(crate) fn with_sections(
        name: &str,
        [states, measurements]: [Vec<String>; 2],
        text: &str,
        make: Arc<Maker>,
    ) -> Result<Self, MotesError> {
        check_names(&states, &measurements)?;
        let names = states.iter().chain(&measurements).map(String::as_str);
        let frame = Frame::parse(text, name, names, &[])?;
        let timeline = Timeline::load(&frame, &measurements, "".as_ref());
        let timeline = timeline.map_err(|(file, reason)| FileError::Inputs { file, reason })?.map(Arc::new);
        let stated = make(frame.parameters());
        check_sizes([&states, &measurements], &*stated)?;
        check_steps(&frame, &*stated)?;
        let model = with_steps(stated, &frame, None);
        let sections = OwnSections { text: text.into(), frame, timeline, make };
        Ok(Own { name: name.into(), states, measurements, model, sections: Some(sections) })
    }

    /// The same with other values of parameters; those that are not given stay as they are.
    ///
    /// # Errors
    /// [`FileError`] if there is no such parameter, or what is made with these values has other numbers of states, measurements or inputs.
    pub(crate) fn with_parameters(&self, values: &[(String, f64)]) -> Result<Self, FileError> {
        let Some(OwnSections { text, frame, timeline, make }) = &self.sections else {
            return match values.first() {
                None => Ok(self.clone()),
                // A text without parameters says that there is none of that name.
                Some(_) => Frame::parse("", &self.name, [], values).map(|_| self.clone()),
            };
        };
        let mut all = frame.parameters().to_vec();
        all.extend(values.iter().cloned());
        let names = self.states.iter().chain(&self.measurements).map(String::as_str);
        let frame = Frame::parse(text, &self.name, names, &all)?;
        let stated = make(frame.parameters());
        let sizes = check_sizes([&self.states, &self.measurements], &*stated);
        sizes
            .and_then(|()| check_steps(&frame, &*stated))
            .map_err(|error| FileError::Inputs { file: self.name.clone(), reason: error.to_string() })?;
        let timeline = timeline.as_ref().map(|timeline| Arc::new(timeline.of_model(&frame)));
        let (model, text, make) = (with_steps(stated, &frame, None), text.clone(), Arc::clone(make));
        let sections = Some(OwnSections { text, frame, timeline, make });
        Ok(Own { model, sections, ..self.clone() })
    }

    /// The same with the steps of a schedule as its own; none of a model without times or inputs.
    pub(crate) fn along(&self, schedule: Schedule) -> Option<Self> {
        let sections = self.sections.as_ref().filter(|sections| sections.timeline.is_some())?;
        let model = with_steps(Arc::clone(&self.model), &sections.frame, Some(schedule));
        Some(Own { model, ..self.clone() })
    }
}

/// A model with the steps that its sections, or a schedule, say that it has.
fn with_steps(
    model: Arc<dyn LearnableModel>,
    frame: &Frame,
    schedule: Option<Schedule>,
) -> Arc<dyn LearnableModel> {
    match schedule.is_some() || frame.time_rule().is_some() {
        true => Arc::new(ScheduledModel::new(model, frame, schedule)),
        false => model,
    }
}

/// Refuses names that are none, or that two things have.
fn check_names(states: &[String], measurements: &[String]) -> Result<(), MotesError> {
    let both: Vec<&String> = states.iter().chain(measurements).collect();
    let is_name =
        |name: &str| !name.trim().is_empty() && name.trim() == name && !name.contains(char::is_control);
    if let Some(name) = both.iter().find(|name| !is_name(name) || ["t", "series"].contains(&name.as_str())) {
        let reason = format!(
            "{name:?} names a coordinate; it must be a word, and none of t and series, which data have"
        );
        return Err(MotesError::Setting(reason));
    }
    match both.iter().enumerate().find(|(at, name)| both[..*at].contains(name)) {
        Some((_, twice)) => {
            Err(MotesError::Setting(format!("{twice}: there are two coordinates of that name")))
        }
        None => Ok(()),
    }
}

/// Refuses names of which there is not one for each coordinate.
fn check_sizes(names: [&[String]; 2], model: &dyn LearnableModel) -> Result<(), MotesError> {
    let sizes = [("states", model.state_dim()), ("measurements", model.measurement_dim())];
    for (names, (what, expected)) in names.into_iter().zip(sizes) {
        if names.len() != expected || expected == 0 {
            let reason = format!("{what}: {} names; the model has {expected} coordinates", names.len());
            return Err(MotesError::Setting(reason));
        }
    }
    Ok(())
}

/// Refuses a model that takes other inputs than its sections name, or parameters of steps, which sections give to who makes it.
fn check_steps(frame: &Frame, model: &dyn LearnableModel) -> Result<(), MotesError> {
    let (named, taken) = (frame.input_dim(), model.input_dim());
    if named != taken {
        let reason = format!("[inputs] names {named} inputs, and the model takes {taken} in a step");
        return Err(MotesError::Setting(reason));
    }
    match model.step_of_index(0).parameters.len() {
        0 => Ok(()),
        count => Err(MotesError::Setting(format!(
            "the model takes {count} parameters of its steps; name them in [parameters], whose values it is made of"
        ))),
    }
}
