//! A model of a program's own with times, inputs and parameters is what a file with these is.

use std::ops::ControlFlow;

use motes::prelude::*;
use motes::{
    Data, EvidenceOptions, FilterOptions, FitOptions, LearnOptions, Model, MotesError, ProposalName, RowTime,
    Running, check, evidence, filter, fit, learn, log_evidence_at, simulate, simulate_along,
    simulate_from_priors, smooth,
};
use motes_models::equations::{BatchDistribution, BatchEquations, Batched, Column, Normal};

const EQUATIONS: &str = "[initial]\nx = \"normal(1, 0.5)\"\n[transition]\nx = \"normal(x + (pump - x*leak)*dt, 0.3*sqrt(dt))\"\n[measurement]\ny = \"normal(x*x/2 + pump + t/100, 0.2)\"\n";
const INPUTS: &str = "[inputs]\npump = { between = \"linear\", simulate = \"normal(0, 1)\" }\n[parameters]\nunused = 3\nleak = \"log_normal(log(0.2), 0.5)\"\n[series]\nby = \"tank\"\n";

/// The same as a program states it.
struct Tank {
    leak: f64,
}

impl Equations for Tank {
    fn dimensions(&self) -> [usize; 2] {
        [1, 1]
    }

    fn inputs(&self) -> &[f64] {
        &[f64::NAN]
    }

    fn initial<S: Scalar>(&self, _: &Step<'_, S>, draws: &mut impl Draws<S>, x: &mut [S]) {
        x[0] = draws.draw(normal(1.0, 0.5));
    }

    fn transition<S: Scalar>(
        &self,
        step: &Step<'_, S>,
        before: &[S],
        draws: &mut impl Draws<S>,
        x: &mut [S],
    ) {
        let change = before[0] * -self.leak + step.inputs[0];
        x[0] = draws.draw(normal(before[0] + change * step.length, step.length.sqrt() * 0.3));
    }

    fn measurement<S: Scalar>(&self, step: &Step<'_, S>, x: &[S], y: &mut impl Coordinates<S>) {
        y.push(normal(x[0] * x[0] / 2.0 + step.inputs[0] + step.time / 100.0, 0.2));
    }
}

/// The same for many particles at a time.
struct Tanks {
    leak: f64,
}

fn normals(mean: Vec<f64>, sd: f64) -> Option<Vec<BatchDistribution>> {
    let family = Distribution::Normal(Normal { mean: Column::each(mean), sd: Column::same(sd) });
    Some(vec![BatchDistribution::new(family)])
}

impl BatchEquations for Tanks {
    fn dimensions(&self) -> [usize; 2] {
        [1, 1]
    }

    fn inputs(&self) -> &[f64] {
        &[f64::NAN]
    }

    fn initial(&self) -> Option<Vec<BatchDistribution>> {
        normals(vec![1.0], 0.5)
    }

    fn transition(&self, step: &Step<'_>, before: &[f64], _: bool) -> Option<Vec<BatchDistribution>> {
        let mean = |x: &f64| x + (x * -self.leak + step.inputs[0]) * step.length;
        normals(before.iter().map(mean).collect(), step.length.sqrt() * 0.3)
    }

    fn measurement(&self, step: &Step<'_>, states: &[f64], _: bool) -> Option<Vec<BatchDistribution>> {
        let mean = |x: &f64| x * x / 2.0 + step.inputs[0] + step.time / 100.0;
        normals(states.iter().map(mean).collect(), 0.2)
    }
}

fn of_file(time: &str) -> Model {
    Model::parse(&format!("{time}{INPUTS}{EQUATIONS}"), "tank", &[]).unwrap()
}

fn of_program(time: &str) -> Model {
    let sections = format!("{time}{INPUTS}");
    Model::own_with("tank", &["x"], &["y"], &sections, |values| Tank { leak: values[1].1 }).unwrap()
}

fn in_columns(time: &str) -> Model {
    let sections = format!("{time}{INPUTS}");
    let make = |values: &[(String, f64)]| Batched::new(Tanks { leak: values[1].1 });
    Model::own_with("tank", &["x"], &["y"], &sections, make).unwrap()
}

const WHOLE: &str = "[time]\ncolumn = \"hour\"\n";
const STARTED: &str = "[time]\ncolumn = \"hour\"\nstart = -1\n";
const IN_PARTS: &str = "[time]\ncolumn = \"hour\"\nstep = 0.5\n";

/// Two series at irregular times, with a gap in the measurements.
fn data(model: &Model) -> Data {
    let mut text = String::from("tank,hour,pump,y\n");
    for tank in ["a", "b"] {
        for row in 0..12_u32 {
            let hour = f64::from(row) + f64::from(row * row % 7) / 10.0;
            let pump = f64::from(row % 3) / 5.0;
            let y = 0.5 + f64::from(row * 5 % 4) / 4.0;
            let y = if row == 4 { String::new() } else { format!("{y}") };
            text += &format!("{tank},{hour},{pump},{y}\n");
        }
    }
    Data::read(text.as_bytes(), "tank.csv", model).unwrap()
}

fn go_on(_: usize) -> ControlFlow<()> {
    ControlFlow::Continue(())
}

fn options(proposal: ProposalName) -> FilterOptions {
    FilterOptions { proposal, particles: 400, predictive: true, ..FilterOptions::default() }
}

#[test]
fn it_is_what_a_file_is_to_the_last_bit() {
    for time in [WHOLE, IN_PARTS] {
        let (file, program) = (of_file(time), of_program(time));
        let data = data(&file);
        assert_eq!(data.rows, self::data(&program).rows);
        assert_eq!(file.parameters(), program.parameters());
        assert_eq!(program.time_column(), Some("hour"));
        let both = [&file, &program];
        for name in [ProposalName::Bootstrap, ProposalName::Linearised] {
            let [expected, found] =
                both.map(|model| filter(model, &data, &options(name.clone()), go_on).unwrap());
            assert_eq!(expected, found, "{name} {time}");
        }
        let [expected, found] = both
            .map(|model| smooth(model, &data, &options(ProposalName::Bootstrap), 20, |_| go_on(0)).unwrap());
        assert_eq!(expected, found);
        // But for the inputs at the start, which formulas that do not use them are not given.
        let [expected, found] = both.map(|model| simulate(model, 15, 2, 3, go_on).unwrap());
        assert_eq!(expected.series, found.series);
        let [expected, found] = both.map(|model| simulate_along(model, &data, 2, 3, go_on).unwrap());
        assert_eq!(expected.series, found.series);
        let [expected, found] = both.map(|model| simulate_from_priors(model, None, 15, 2, 3, go_on).unwrap());
        assert_eq!((expected.series, expected.parameters), (found.series, found.parameters));
        let checked = check(&program, Some(&data), 1, || ControlFlow::Continue(())).unwrap();
        assert!(checked.problems.is_empty(), "{:?}", checked.problems);
        let [expected, found] = both.map(|model| {
            let at = [0.1, 0.2, 0.4];
            let names = ["leak".to_string()];
            let options = options(ProposalName::Bootstrap);
            log_evidence_at(model, &data, &options, &names, &at, &|| ControlFlow::Continue(())).unwrap()
        });
        assert_eq!(expected, found);
        assert!(found[0] != found[1]);
    }
}

#[test]
fn it_is_forecast_fitted_and_learned_for() {
    for time in [WHOLE, IN_PARTS] {
        let (file, program) = (of_file(time), of_program(time));
        let (data, both) = (data(&file), [&file, &program]);
        let ahead = both.map(|model| {
            let options = options(ProposalName::Bootstrap);
            let mut running = Running::new(model, &options, 0).unwrap();
            for row in data.of_series(0) {
                running.advance_by(&row.steps, &row.measurement).unwrap();
            }
            let mut alone = Running::new(model, &options, 0).unwrap();
            alone.step_row(RowTime { label: Some("0"), columns: &[Some(0.3)] }, &[Some(1.0)]).unwrap();
            let next = RowTime { label: Some("1.7"), columns: &[Some(0.1)] };
            let forecast = alone.predict_row(Some(next)).unwrap();
            let ends = (0..2).any(|_| alone.predict_row(None).is_err());
            (running.means().to_vec(), forecast.estimate.state, ends)
        });
        assert_eq!(ahead[0], ahead[1]);
        assert!(ahead[0].2, "the input is not known ahead");
        let [expected, found] = both.map(|model| {
            let options = FitOptions {
                proposal: Some(ProposalName::Bootstrap),
                draws: Some(30),
                particles: Some(50),
                chains: 2,
                ..FitOptions::default()
            };
            fit(model, &data, &options, &|| ControlFlow::Continue(()), &mut |_| Ok(())).unwrap()
        });
        assert_eq!(expected.names, ["leak"]);
        assert_eq!(expected.chains, found.chains);
        // Gaps with other numbers of sub-steps have other numbers of draws, of which no network is learned.
        let along = (time == WHOLE).then_some(&data);
        let [expected, found] = both.map(|model| {
            let options = LearnOptions { updates: 60, steps: 12, ..LearnOptions::default() };
            let learned = learn(model, along, &options, |_, _| ControlFlow::Continue(())).unwrap();
            filter(model, &data, &self::options(ProposalName::Learned(learned.proposal)), go_on).unwrap()
        });
        assert_eq!(expected, found);
    }
}

#[test]
fn functions_of_many_particles_take_inputs_and_sub_steps() {
    for time in [WHOLE, IN_PARTS] {
        let (program, batched) = (of_program(time), in_columns(time));
        let (data, both) = (data(&program), [&program, &batched]);
        let sampling = FilterOptions { particles: 4000, ..options(ProposalName::Bootstrap) };
        let [expected, found] = both.map(|model| filter(model, &data, &sampling, go_on).unwrap());
        if time == WHOLE {
            assert_eq!(expected.estimates, found.estimates);
            let [expected, found] = both.map(|model| simulate_along(model, &data, 2, 3, go_on).unwrap());
            assert_eq!(expected, found);
        }
        // They take random numbers sub-step by sub-step, and not particle by particle.
        let error = found.standard_error().unwrap().max(0.05);
        let difference = found.log_evidence() - expected.log_evidence();
        assert!(difference.abs() < 4.0 * error, "{difference} with a standard error of {error}");
        let options = FilterOptions { particles: 1000, ..sampling };
        let smoothed = smooth(&batched, &data, &options, 200, |_| go_on(0)).unwrap();
        assert!(smoothed.estimates.iter().flat_map(|estimate| &estimate.state).all(|x| x.mean.is_finite()));
        let checked = check(&batched, Some(&data), 1, || ControlFlow::Continue(())).unwrap();
        assert!(checked.problems.is_empty(), "{:?}", checked.problems);
    }
    // Of a whole step the states have a density, of one in parts they have none, and nobody knows the noise.
    let options = LearnOptions { updates: 20, steps: 12, ..LearnOptions::default() };
    let learned =
        |model: &Model| learn(model, Some(&data(model)), &options, |_, _| ControlFlow::Continue(()));
    learned(&in_columns(WHOLE)).unwrap();
    let refused = learned(&in_columns(IN_PARTS)).unwrap_err().to_string();
    assert!(refused.contains("no density"), "{refused}");
}

#[test]
fn the_start_comes_before_the_first_row() {
    let sections = |inputs: &str| format!("{STARTED}{inputs}");
    let with_first = INPUTS.replace("between = \"linear\"", "between = \"hold\", first = 0.3");
    let file = Model::parse(&format!("{}{EQUATIONS}", sections(&with_first)), "tank", &[]).unwrap();
    let make = |values: &[(String, f64)]| Tank { leak: values[1].1 };
    let program = Model::own_with("tank", &["x"], &["y"], &sections(&with_first), make).unwrap();
    let data = data(&file);
    let [expected, found] = [&file, &program].map(|model| {
        let found = evidence(model, &data, &EvidenceOptions::default(), || go_on(0)).unwrap();
        (found.log_evidence(), filter(model, &data, &options(ProposalName::Bootstrap), go_on).unwrap())
    });
    assert_eq!(expected, found);
    let without = Model::own_with("tank", &["x"], &["y"], &sections(INPUTS), make).unwrap();
    let text = "tank,hour,pump,y\na,0,0.2,1\n";
    let refused = Data::read(text.as_bytes(), "tank.csv", &without).unwrap_err();
    assert!(refused.to_string().contains("give it one by first"), "{refused}");
}

#[test]
fn parameters_are_given_to_who_makes_the_model() {
    let program = of_program(IN_PARTS);
    assert_eq!(program.priors()[0].name(), "leak");
    let other = program.with_parameters(&[("leak".into(), 0.7)]).unwrap();
    assert_eq!(other.parameters()[1], ("leak".to_string(), 0.7));
    assert_eq!(other.parameters()[0], ("unused".to_string(), 3.0));
    let refused = program.with_parameters(&[("leek".into(), 0.7)]).unwrap_err().to_string();
    assert!(refused.contains("did you mean `leak`?"), "{refused}");
    let text = program.describe().to_string();
    assert!(text.contains("column hour") && text.contains("with the prior log_normal"), "{text}");
}

#[test]
fn sections_that_functions_have_not_are_refused() {
    let refused = |sections: &str| {
        let made = Model::own_with("tank", &["x"], &["y"], sections, |_| Tank { leak: 0.2 });
        made.unwrap_err().to_string()
    };
    let inputs = "[inputs]\nu = \"hold\"\n";
    for (sections, line) in [
        ("[initial]\nx = 1\n".to_string(), "tank: functions state what [initial] does in a model file"),
        ("[definitions]\na = 1\n".to_string(), "functions state what [definitions] does"),
        ("[tine]\nstep = 1\n".to_string(), "did you mean `time`?"),
        ("name = \"tank\"\n".to_string(), "beside functions it has [time], [inputs], [parameters], [series]"),
        (format!("{inputs}[parameters]\nx = 1\n"), "`x` stands in the coordinates, too"),
        ("[inputs]\ny = \"hold\"\n".to_string(), "`y` stands in the coordinates, too"),
        (format!("{inputs}[parameters]\nu = 1\n"), "`u` stands in [parameters], too"),
        (format!("{inputs}[parameters]\nq = \"normal(0, -1)\"\n"), "tank, [parameters] q"),
        ("[parameters]\nq = 1\n".to_string(), "[inputs] names 0 inputs, and the model takes 1 in a step"),
        (format!("{inputs}[time]\nstep = 0\n"), "tank, [time] step"),
        ("[inputs]\nu = { file = \"nowhere.csv\", between = \"hold\" }\n".to_string(), "nowhere.csv"),
    ] {
        let refused = refused(&sections);
        assert!(refused.contains(line), "{refused} has no {line}");
    }
    /// It takes parameters of its steps.
    struct OfSteps;
    impl Equations for OfSteps {
        fn dimensions(&self) -> [usize; 2] {
            [1, 1]
        }
        fn parameters(&self) -> &[f64] {
            &[0.5]
        }
        fn initial<S: Scalar>(&self, step: &Step<'_, S>, draws: &mut impl Draws<S>, x: &mut [S]) {
            x[0] = draws.draw(Distribution::Normal(Normal { mean: S::from(0.0), sd: step.parameters[0] }));
        }
        fn transition<S: Scalar>(&self, _: &Step<'_, S>, x: &[S], draws: &mut impl Draws<S>, to: &mut [S]) {
            to[0] = draws.draw(normal(x[0], 1.0));
        }
        fn measurement<S: Scalar>(&self, _: &Step<'_, S>, x: &[S], y: &mut impl Coordinates<S>) {
            y.push(normal(x[0], 1.0));
        }
    }
    let made = Model::own_with("steps", &["x"], &["y"], "[time]\nstep = 1\n", |_| OfSteps);
    assert!(matches!(made, Err(MotesError::Setting(reason)) if reason.contains("1 parameters of its steps")));
}
