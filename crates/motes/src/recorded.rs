//! A series of data as a filter takes it, step by step, and a filter that may know all of it before it starts.

use motes_models::StepRecord;
use motes_smc::{LookAhead, LookAheadError, RecordedStep};

use crate::data::Data;
use crate::engine::Running;
use crate::error::MotesError;
use crate::known_inputs::without_unknown;
use crate::model::{Kind, Model};
use crate::options::{FilterOptions, ProposalName};
use crate::own_model::LearnableModel;

/// The steps of a series whose rows stand at `places`, each with what is measured then.
pub(crate) fn recorded_steps(data: &Data, places: &[usize]) -> Vec<RecordedStep> {
    let rows = places.iter().map(|at| &data.rows[*at]);
    rows.flat_map(|row| steps_to_row(&row.steps, &row.measurement)).collect()
}

/// The steps that lead to a row: the last one with all of its measurement, those before with nothing.
pub(crate) fn steps_to_row<'a>(
    steps: &'a [StepRecord],
    measurement: &'a [Option<f64>],
) -> impl Iterator<Item = RecordedStep> + 'a {
    steps.iter().enumerate().map(move |(number, step)| {
        let is_last = number + 1 == steps.len();
        let measurement = if is_last { measurement.to_vec() } else { vec![None; measurement.len()] };
        let step = without_unknown(&step.step()).unwrap_or_else(|| step.clone());
        RecordedStep { step, measurement }
    })
}

/// What recorded data are looked at by, where a proposal is asked for: a learned one hands out the potentials of a smoother where these did better, and else finds its units once for all series.
///
/// # Errors
/// [`MotesError::Proposal`] if it was learned for another model.
pub(crate) fn of_recorded(proposal: ProposalName, model: &Model) -> Result<ProposalName, MotesError> {
    match proposal {
        ProposalName::Learned(learned) if learned.hands_out_look_ahead() => {
            learned.check_model(model)?;
            Ok(ProposalName::LookAhead)
        }
        ProposalName::Learned(learned) => learned.prepared(model).map(ProposalName::Learned),
        proposal => Ok(proposal),
    }
}

/// Potentials of a series, if the proposal has any: by a smoother, or by networks that were learned for the model.
///
/// # Errors
/// [`MotesError::Proposal`] for a model without derivatives or another one than networks were learned for, and where a linearised smoother does not come through.
pub(crate) fn look_ahead(
    proposal: &ProposalName,
    model: &Model,
    steps: &[RecordedStep],
) -> Result<Option<LookAhead>, MotesError> {
    match proposal {
        ProposalName::LookAhead => designed(model, steps).map(Some),
        ProposalName::Learned(learned) => learned.look_ahead(model, steps),
        _ => Ok(None),
    }
}

/// Potentials by a smoother.
fn designed(model: &Model, steps: &[RecordedStep]) -> Result<LookAhead, MotesError> {
    LookAhead::new(with_derivatives(model)?, steps)
        .map_err(|error| no_look_ahead(format!("{error}; take --proposal linearised or bootstrap")))
}

/// A model that a smoother can be tried for.
///
/// # Errors
/// [`MotesError::Proposal`] for one without derivatives, or that does not say how its states are made of noise.
pub(crate) fn with_derivatives(model: &Model) -> Result<&dyn LearnableModel, MotesError> {
    let reason = match model.kind() {
        Kind::Learnable(learnable) if !learnable.has_gradients() => {
            "the model has no derivatives; take --proposal bootstrap, or one that is learned".into()
        }
        Kind::Learnable(learnable) if learnable.noise_space().is_some() => return Ok(learnable),
        Kind::Learnable(_) => format!("{}; take --proposal linearised or bootstrap", LookAheadError::NoNoise),
        Kind::LinearGaussian(_) => {
            "kind = \"linear-gaussian\" has exact answers; take --proposal exact".into()
        }
    };
    Err(no_look_ahead(reason))
}

/// Whether a smoother can be tried for a model.
pub(crate) fn has_look_ahead(model: &Model) -> bool {
    with_derivatives(model).is_ok()
}

fn no_look_ahead(reason: String) -> MotesError {
    MotesError::Proposal { proposal: ProposalName::LookAhead.to_string(), reason }
}

/// A filter for the series of that number, which will take in just its rows, at `places`.
///
/// # Errors
/// As [`Running::new`], and as [`look_ahead`] for a proposal that does.
pub(crate) fn running_over<'m>(
    model: &'m Model,
    options: &FilterOptions,
    series: usize,
    data: &Data,
    places: &[usize],
) -> Result<Running<'m>, MotesError> {
    let proposal = of_recorded(options.proposal.clone(), model)?;
    let ahead = look_ahead(&proposal, model, &recorded_steps(data, places))?;
    Running::with_seed(model, options, Running::seed(options, series), ahead.as_ref())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_before_a_row_have_no_measurement() {
        let text = "[time]\ncolumn = \"time\"\nstep = 1\n[initial]\nx = \"normal(0, 1)\"\n[transition]\nx = \"normal(x, 1)\"\n[measurement]\ny = \"normal(x, 1)\"\n";
        let model = Model::parse(text, "walk", &[]).unwrap();
        let data = Data::read("time,y\n0,1\n1,\n3,2\n".as_bytes(), "y.csv", &model).unwrap();
        let steps = recorded_steps(&data, &[0, 1, 2]);
        let measured: Vec<Option<f64>> = steps.iter().map(|step| step.measurement[0]).collect();
        assert_eq!(measured.iter().flatten().count(), 2);
        assert_eq!(measured.first().zip(measured.last()), Some((&Some(1.0), &Some(2.0))));
        assert!(steps.iter().enumerate().all(|(at, step)| step.step.step().index == at));
    }
}
