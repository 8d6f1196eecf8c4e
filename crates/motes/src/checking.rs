//! What a model is, whether it can be simulated and differentiated, and whether data fit it.

use std::ops::ControlFlow;

use motes_models::{GradientError, ModelShape, Seed, StepRecord, check_gradients, check_gradients_from};

use crate::data::Data;
use crate::engine::Running;
use crate::error::MotesError;
use crate::exact_system::ExactSystem;
use crate::long_step::of_step;
use crate::model::{Kind, Model};
use crate::options::{FilterOptions, ProposalName};
use crate::own_model::{LearnableModel, draws_transitions_alone};
use crate::priors::of_starts;
use crate::recorded::has_look_ahead;
use crate::sight::is_blind;
use crate::simulating::{check_draws, schedule, simulate, simulate_along};
use crate::timeline::Timeline;
use crate::warning::Warning;

/// What was looked at, and what is wrong.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct CheckReport {
    /// What is as it should be.
    pub findings: Vec<String>,
    /// What is not.
    pub problems: Vec<String>,
}

/// Series that are drawn, and the times of each.
const SERIES: usize = 20;
const STEPS: usize = 100;

/// Times at which gradients are compared.
const TIMES: usize = 5;

/// How far a gradient may be from its central difference, as a share of the largest.
const TOLERANCE: f64 = 1e-5;

/// Looks at a model, and at data if there are any.
///
/// # Errors
/// [`MotesError::Interrupted`] if `proceed` said to stop.
pub fn check(
    model: &Model,
    data: Option<&Data>,
    seed: u64,
    mut proceed: impl FnMut() -> ControlFlow<()>,
) -> Result<CheckReport, MotesError> {
    check_until(model, data, seed, &mut proceed)
}

/// [`check`], compiled once whatever asks.
fn check_until(
    model: &Model,
    data: Option<&Data>,
    seed: u64,
    proceed: &mut dyn FnMut() -> ControlFlow<()>,
) -> Result<CheckReport, MotesError> {
    let mut checked = CheckReport::default();
    checked.findings.extend(of_starts(model).map(|warning| format!("warning: {warning}")));
    checked.findings.extend(model.formulas().map(|formulas| format!("states: {}", formulas.coordinates())));
    match check_draws(model) {
        Ok(()) => check_drawn(model, data, seed, &mut checked, proceed)?,
        Err(error) => checked.findings.push(format!("simulations: {error}")),
    }
    if let Kind::Learnable(learnable) = model.kind() {
        if draws_transitions_alone(learnable).is_some() {
            checked.findings.push(
                "density: none, because states are known, follow or are counts, or a step has sub-steps; bootstrap alone draws them, smoothed paths follow ancestors".into(),
            );
        } else if learnable.density().is_none() {
            checked.findings.push(
                "density: none, because states follow without noise, share draws, or are counts; proposals draw the noise, smoothed paths follow ancestors".into(),
            );
        }
        checked.findings.extend(of_learning(model, learnable));
    }
    checked.findings.extend(exactly(model, data));
    let has = |proposal: ProposalName| {
        let options = FilterOptions { proposal, particles: 1, ..FilterOptions::default() };
        Running::new(model, &options, 0).map(drop)
    };
    let linearised = match has(ProposalName::Linearised) {
        Err(_) => "",
        Ok(()) if is_blind(model, data) => {
            ", linearised (which is the transition, since no measurement has a location that moves with the state)"
        }
        Ok(()) => ", linearised",
    };
    let ahead = if has_look_ahead(model) { ", look-ahead (of recorded data)" } else { "" };
    checked.findings.push(match (model.measured_exactly(), has(ProposalName::Optimal)) {
        (Some(reason), _) => format!("proposals: exact alone, because {reason}"),
        (None, Ok(())) => format!("proposals: bootstrap{linearised}, optimal{ahead}"),
        (None, Err(error)) => format!("proposals: bootstrap{linearised}{ahead}; no closed form ({error})"),
    });
    if let Some(data) = data {
        check_data(model, data, &mut checked, seed);
    }
    Ok(checked)
}

/// What a proposal can be learned of, and how trajectories are smoothed.
fn of_learning(model: &Model, learnable: &dyn LearnableModel) -> [String; 2] {
    let draws = ModelShape::of(learnable).draws.map_or(0, |[_, later]| later);
    let fed_back = |column: &str| format!("the measurement {column} is an input of later steps");
    let reason = model
        .measured_exactly()
        .or_else(|| check_draws(model).err().map(|error| error.to_string()))
        .or_else(|| model.fed_back_measurement().map(fed_back))
        .or_else(|| draws_transitions_alone(learnable).map(str::to_string));
    let learned = match reason {
        Some(reason) => format!("nothing, because {reason}"),
        None if learnable.density().is_some() => "a proposal of the states".to_string(),
        None if draws == 0 => "nothing, because no state is drawn after the first".to_string(),
        None => format!("a proposal of the noise, {draws} numbers for a step of one unit of time"),
    };
    // Of discrete states it is said below whether they are few enough.
    let linear = model.exact_system().filter(|system| !matches!(system, ExactSystem::Finite(_)));
    let smoothed = match (linear, learnable.density()) {
        (Some(_), Some(_)) => "backward simulation, or exactly by --proposal exact",
        (Some(_), None) => "along the filter's ancestors, or exactly by --proposal exact",
        (None, Some(_)) => "backward simulation",
        (None, None) => "along the filter's ancestors",
    };
    [format!("learned: {learned}"), format!("smoothed: {smoothed}")]
}

/// Whether the model has exact answers, over the rows of the data, or else over so many as are drawn.
fn exactly(model: &Model, data: Option<&Data>) -> Option<String> {
    let answers = "--proposal exact filters and smooths without particles";
    match model.exact_system() {
        None => return Some("exact: no, because the model is neither linear with Gaussian noise nor one of few discrete states".into()),
        Some(ExactSystem::Linear(_)) => {
            return Some(format!("exact: the model is linear with Gaussian noise; {answers}"));
        }
        Some(ExactSystem::Finite(_)) => (),
    }
    let options = FilterOptions { proposal: ProposalName::Exact, ..FilterOptions::default() };
    let mut running = Running::new(model, &options, 0).ok()?;
    let nothing = vec![None; model.measurements().len()];
    let reached = match data {
        Some(data) => {
            let rows = data.of_series(0).take(STEPS);
            rows.map(|row| running.advance_by(&row.steps, &nothing)).collect::<Result<Vec<()>, _>>()
        }
        // Neither times nor inputs are known.
        None if model.time_column().is_some() || !model.input_columns().is_empty() => return None,
        None => (0..STEPS).map(|_| running.advance(&nothing)).collect(),
    };
    Some(match reached {
        Ok(_) => format!("exact: the states are discrete, and few can be reached; {answers}"),
        Err(error) => format!("exact: no, although the states are discrete: {error}"),
    })
}

/// Simulates the model, and compares its gradients with differences: with the times and inputs of the data, if it has such.
fn check_drawn(
    model: &Model,
    data: Option<&Data>,
    seed: u64,
    checked: &mut CheckReport,
    proceed: &mut dyn FnMut() -> ControlFlow<()>,
) -> Result<(), MotesError> {
    let along = data.filter(|_| model.timeline().is_some());
    let drawn = match along {
        Some(data) => simulate_along(model, data, 1, seed, |_| proceed()),
        None => simulate(model, STEPS, SERIES, seed, |_| proceed()),
    };
    match drawn {
        Ok(drawn) => {
            let (series, times) = (drawn.series.len(), drawn.rows.iter().map(Vec::len).max().unwrap_or(0));
            checked.findings.push(format!("simulations: {series} series of {times} times stay finite"));
        }
        Err(MotesError::Interrupted) => return Err(MotesError::Interrupted),
        Err(MotesError::Timeline(error)) => {
            checked.findings.push(format!("simulations: none, because {error}"));
        }
        Err(error) => checked.problems.push(format!("simulations: {error}")),
    }
    let mut stream = Seed::from_u64(seed).child("check").stream();
    let scheduled = schedule(model, along, STEPS, &Seed::from_u64(seed)).ok().flatten();
    let scheduled = scheduled.and_then(|schedule| model.along(schedule));
    if let Some(reason) = model.measured_exactly() {
        checked.findings.push(format!("gradients: not compared, because {reason}"));
        return Ok(());
    }
    let compared = match scheduled.as_ref().unwrap_or(model).kind() {
        Kind::Learnable(_) if model.timeline().is_some() && scheduled.is_none() => None,
        Kind::Learnable(learnable) => {
            // x_0 is not measured where it comes before the first row.
            let measured = usize::from(model.timeline().is_some_and(Timeline::has_start));
            let compare = || check_gradients_from(learnable, measured, TIMES, TOLERANCE, &mut stream);
            learnable.has_gradients().then(compare)
        }
        Kind::LinearGaussian(linear) => Some(check_gradients(linear, TIMES, TOLERANCE, &mut stream)),
    };
    match compared {
        None if model.timeline().is_some() => {
            checked.findings.push("gradients: not compared, because times or inputs are not known".into());
        }
        None => checked.findings.push("gradients: the model has none".into()),
        Some(Ok(report)) => checked.findings.push(format!(
            "gradients{}: {} compared with central differences, the largest relative error is {:.1e}; {} have a kink or an edge",
            if report.of_states { "" } else { " of the measurement" },
            report.compared,
            report.worst.relative_error,
            report.skipped
        )),
        Some(Err(error @ GradientError::Wrong(_))) => checked.problems.push(format!("gradients: {error}")),
        // Counts and bounded noise have no differences to compare with.
        Some(Err(error)) => checked.findings.push(format!("gradients: not compared everywhere: {error}")),
    }
    Ok(())
}

/// Whether some particle can explain each measurement: values that no state can give, as a fraction for counts, have density 0 everywhere.
fn check_data(model: &Model, data: &Data, checked: &mut CheckReport, seed: u64) {
    let missing = data.rows.iter().flat_map(|row| &row.measurement).filter(|value| value.is_none()).count();
    checked.findings.push(format!(
        "data: {} series, {} times, {missing} of {} entries missing",
        data.series.len(),
        data.rows.len(),
        data.rows.len() * model.measurements().len()
    ));
    let steps = data.rows.iter().flat_map(|row| row.steps.last()).map(StepRecord::step);
    // The first state is drawn without one.
    let sub_steps = steps.filter(|step| step.index > 0).map(|step| step.sub_steps);
    if let Some(most) = sub_steps.clone().max().filter(|most| *most > 1) {
        checked.findings.push(format!(
            "data: up to {most} sub-steps between two rows, {} in all",
            sub_steps.sum::<usize>()
        ));
    }
    if !data.columns.ignored.is_empty() {
        checked
            .findings
            .push(format!("data: columns that are not used: {}", data.columns.ignored.join(", ")));
    }
    let warnings: Vec<Warning> = of_step(model, data).into_iter().chain(data.warnings()).collect();
    checked.findings.extend(warnings.iter().map(|warning| format!("warning: {warning}")));
    let proposal = match model.measured_exactly() {
        Some(_) => ProposalName::Exact,
        None => ProposalName::Bootstrap,
    };
    let gets_through = match proposal {
        ProposalName::Exact => "data: the exact filter gets through them",
        _ => "data: a bootstrap filter gets through them",
    };
    let options = FilterOptions { seed, proposal, ..FilterOptions::default() };
    for (series, name) in data.series.iter().enumerate() {
        let Ok(mut running) = Running::new(model, &options, series) else { return };
        for row in data.of_series(series) {
            if let Err(error) = running.advance_by(&row.steps, &row.measurement) {
                let of = if data.columns.has_series() { format!(" of series {name}") } else { String::new() };
                checked.problems.push(format!("data, {} {}{of}: {error}", data.source.counted, row.line));
                break;
            }
        }
    }
    if checked.problems.is_empty() {
        checked.findings.push(gets_through.into());
    }
}
