//! Times and inputs of data: what is wrong with them, in one line; what simulations and forecasts make of them.

use std::ops::ControlFlow;
use std::path::Path;

use motes::proposals::Family;
use motes::{
    Data, FilterOptions, LearnOptions, Model, MotesError, ProposalName, check, filter, learn, simulate,
    simulate_along,
};

const WALK: &str = "[initial]\nx = \"normal(0, 1)\"\n[transition]\nx = \"normal(x, 0.5*sqrt(dt))\"\n[measurement]\ny = \"normal(x, 0.3)\"\n";

fn model(head: &str, body: &str) -> Model {
    Model::parse(&format!("{head}\n{body}"), "m.toml", &[]).unwrap()
}

fn read(head: &str, body: &str, data: &str) -> Result<Data, String> {
    Data::read(data.as_bytes(), "d.csv", &model(head, body)).map_err(|error| error.to_string())
}

fn refused(head: &str, data: &str) -> String {
    read(head, WALK, data).unwrap_err()
}

#[test]
fn times_that_do_not_come_next_are_refused_with_line_and_column() {
    let numbers = "[time]\ncolumn = \"h\"";
    let days = "[time]\ncolumn = \"day\"\nunit = \"day\"";
    for (head, data, line) in [
        (
            numbers,
            "h,y\n0,1\n2,1\n1,1\n",
            "d.csv, line 4, column h: 1 comes after 2; within a series times increase",
        ),
        (numbers, "h,y\n0,1\n,1\n", "d.csv, line 3, column h: an empty cell is no time; it must be a number"),
        (numbers, "h,y\nnoon,1\n", "d.csv, line 2, column h: noon is no time; it must be a number"),
        (
            numbers,
            "h,y\n2024-03-01,1\n",
            "d.csv, line 2, column h: 2024-03-01 is no time; for dates give unit = \"day\", \"week\" or \"year\" in [time]",
        ),
        (
            days,
            "day,y\n2024-03-01,1\n17,1\n",
            "d.csv, line 3, column day: 17 is no time; it must be a date, as 2024-03-01, since [time] has a unit",
        ),
        (
            days,
            "day,y\n2024-03-02,1\n2024-03-01,1\n",
            "d.csv, line 3, column day: 2024-03-01 comes after 2024-03-02; within a series times increase",
        ),
        (
            days,
            "day,y\n2024-03-01T12:00Z,1\n2024-03-02,1\n",
            "d.csv, line 3, column day: 2024-03-02 has no zone, and a row before has one: which is earlier is not known; write a zone, as +01:00 or Z, in all rows or in none",
        ),
        (
            days,
            "day,y\n2024-03-01 12:00 CET,1\n",
            "d.csv, line 2, column day: 2024-03-01 12:00 CET is no time; a time of a day is written 2024-03-01T12:00, and its zone +01:00 or Z",
        ),
        (
            "[time]\ncolumn = \"day\"\nunit = \"week\"\nstart = \"2024-03-01\"",
            "day,y\n2024-02-01,1\n",
            "d.csv, line 2, column day: the first row is at 2024-02-01, before the start of [time] at 2024-03-01",
        ),
        (
            numbers,
            "t,y\n0,1\n",
            "d.csv, line 1: there is no column h, which [time] of the model names; there are t, y",
        ),
        (
            "[time]\ncolumn = \"h\"\nstart = 5",
            "h,y\n0,1\n",
            "d.csv, line 2, column h: the first row is at 0, before the start of [time] at 5",
        ),
        (
            "[time]\nstart = 5",
            "y\n1\n",
            "d.csv, line 2: the first row is at 0, before the start of [time] at 5",
        ),
        (
            "[time]\ncolumn = \"h\"\nstep = 1e-9",
            "h,y\n0,1\n1,1\n",
            "d.csv, line 3, column h: the gap of 1 before this row has 999999000 sub-steps of 0.000000001, more than 1000000; a longer step in [time], or another unit?",
        ),
        (
            "[series]\nby = \"animal\"",
            "y\n1\n",
            "d.csv, line 1: there is no column animal, which [series] of the model names; there are y",
        ),
    ] {
        assert_eq!(refused(head, data), line);
    }
}

#[test]
fn inputs_that_are_missing_where_they_are_needed_are_refused() {
    let body = |used: &str| {
        format!(
            "[initial]\nx = \"normal(0, 1)\"\n[transition]\nx = \"normal(x + {used}, 0.5)\"\n[measurement]\ny = \"normal(x, 0.3)\"\n"
        )
    };
    let of = |head: &str, data: &str| read(head, &body("u"), data).map(drop);
    let hold = "[inputs]\nu = \"hold\"";
    let missing = |line| {
        Err(format!("d.csv, line {line}, column u: the input u has no value here, and [transition] needs it"))
    };
    // What the row before has is needed at the next one; what the last row has is not.
    assert_eq!(
        of(hold, "u,y\n,1\n2,1\n"),
        Err("d.csv, line 3, column u: the input u has no value in the row before this one, and [transition] needs it in the step to this row".into())
    );
    assert_eq!(
        of("[inputs]\nu = \"next\"", "u,y\n1,1\nNaN,1\n"),
        Err("d.csv, line 3, column u: NaN is no number; leave the cell empty where the input is not needed"
            .into())
    );
    assert_eq!(of(hold, "u,y\n1,1\n,1\n"), Ok(()));
    assert_eq!(of("[inputs]\nu = \"next\"", "u,y\n,1\n2,1\n"), Ok(()));
    assert_eq!(of("[inputs]\nu = \"next\"", "u,y\n1,1\n,1\n"), missing(3));
    assert_eq!(
        of(hold, "y\n1\n"),
        Err("d.csv, line 1: there is no column u, which is an input of the model; there are y".into())
    );
    assert_eq!(
        of(hold, "u,y\n1,1\nx,1\n"),
        Err("d.csv, line 3, column u: x is no number; leave the cell empty, or write NA, where a measurement is missing".into())
    );
    let before = "the input u is needed before it has a value, in the step to this row; give it one by first = … in [inputs]";
    assert_eq!(of("[inputs]\nu = { column = \"y\", rows = 1 }", "y\n1\n1\n"), Ok(()));
    let lag = "[inputs]\nu = { column = \"y\", rows = 2 }";
    assert_eq!(of(lag, "y\n1\n1\n"), Err(format!("d.csv, line 3, column y: {before}")));
    assert_eq!(of("[inputs]\nu = { column = \"y\", rows = 2, first = 0 }", "y\n1\n1\n"), Ok(()));
    let start = "[time]\nstart = -1\n[inputs]\nu = \"hold\"";
    assert_eq!(of(start, "u,y\n1,1\n"), Err(format!("d.csv, line 2, column u: {before}")));
    assert_eq!(
        of("[time]\nstart = -1\n[inputs]\nu = { between = \"hold\", first = 3 }", "u,y\n1,1\n"),
        Ok(())
    );
}

#[test]
fn totals_need_a_step_before_them() {
    let body = "[initial]\nx = 1\n[draws]\nn = \"poisson(x*dt)\"\n[transition]\nx = \"x\"\n[measurement]\ny = \"poisson(total(n) + 0.1)\"\n";
    let line = "d.csv, line 2, column y: y looks back at the sub-steps since the row before, and there are none; give the time of x_0 by start = … in [time], or leave the cell empty";
    let last = body.replace("total(n)", "n");
    for body in [body, &last] {
        assert_eq!(read("", body, "y\n1\n2\n").unwrap_err(), line);
    }
    assert!(read("", body, "y,z\n,\n2,\n").is_ok());
    let data = read("[time]\nstart = -1", body, "y\n1\n2\n").unwrap();
    assert_eq!(data.rows.iter().map(|row| row.steps.len()).collect::<Vec<_>>(), [2, 1]);
    assert_eq!(data.steps_before(0), 1);
}

/// Two rows at one time are two measurements of one state.
#[test]
fn two_rows_at_one_time_are_one_state() {
    let head = "[time]\ncolumn = \"h\"";
    let twice = read(head, WALK, "h,y\n0,0.2\n1,0.5\n1,0.7\n2,0.1\n").unwrap();
    let walk = model(head, WALK);
    let options = FilterOptions { proposal: ProposalName::Exact, ..Default::default() };
    let exact = filter(&walk, &twice, &options, |_| ControlFlow::Continue(())).unwrap();
    let both = "[initial]\nx = \"normal(0, 1)\"\n[transition]\nx = \"normal(x, 0.5)\"\n[measurement]\ny = \"normal(x, 0.3)\"\nz = \"normal(x, 0.3)\"\n";
    let columns = read("", both, "y,z\n0.2,\n0.5,0.7\n0.1,\n").unwrap();
    let expected = filter(&model("", both), &columns, &options, |_| ControlFlow::Continue(())).unwrap();
    assert!((exact.log_evidence() - expected.log_evidence()).abs() < 1e-9);
    for proposal in [ProposalName::Bootstrap, ProposalName::Linearised, ProposalName::Optimal] {
        let options = FilterOptions { proposal, particles: 20_000, ..Default::default() };
        let found = filter(&walk, &twice, &options, |_| ControlFlow::Continue(())).unwrap();
        let error = found.log_evidence() - expected.log_evidence();
        assert!(error.abs() < 4.0 * found.standard_error().unwrap() + 0.005, "{error}");
    }
}

/// What `simulate` writes with inputs is data of the model, and its times and inputs are those that were given.
#[test]
fn simulations_take_the_times_and_inputs_that_are_given() {
    let head = "[time]\ncolumn = \"h\"\n[inputs]\nu = \"hold\"";
    let body = "[initial]\nx = 0\n[transition]\nx = \"x + u*dt\"\n[measurement]\ny = \"normal(x, 0.001)\"\n";
    let driven = model(head, body);
    let proceed = |_| ControlFlow::Continue(());
    let refused = simulate(&driven, 3, 1, 1, proceed).unwrap_err();
    assert!(matches!(refused, MotesError::Timeline(_)));
    assert_eq!(
        refused.to_string(),
        "the model has the input u; give its values by --inputs, or simulate = \"normal(0, 1)\" in [inputs]"
    );
    let inputs = Data::read("h,u,y\n0,1,\n0.5,2,\n2,0,\n".as_bytes(), "inputs.csv", &driven).unwrap();
    let drawn = simulate_along(&driven, &inputs, 2, 1, proceed).unwrap();
    assert_eq!(drawn.series[1].states.values(), [0.0, 0.5, 3.5]);
    let times: Vec<f64> = drawn.rows[0].iter().map(motes::SimulatedRow::time).collect();
    assert_eq!(times, [0.0, 0.5, 2.0]);
    let table = motes::output::simulated_table(&driven, &drawn);
    assert!(table.starts_with("series,h,u,x,y\n0,0,1,0,"), "{table}");
    let back = Data::read(table.as_bytes(), "simulated.csv", &driven).unwrap();
    assert_eq!(back.rows[2].steps, inputs.rows[2].steps);
}

#[test]
fn check_counts_the_sub_steps_between_rows() {
    for (start, count) in [("", 6), ("start = -0.5\n", 7)] {
        let head = format!("[time]\ncolumn = \"h\"\nstep = 0.5\n{start}");
        let data = read(&head, WALK, "h,y\n0,0.2\n1,0.5\n3,0.7\n").unwrap();
        let found = check(&model(&head, WALK), Some(&data), 1, || ControlFlow::Continue(())).unwrap();
        let line = format!("data: up to 4 sub-steps between two rows, {count} in all");
        assert!(found.findings.contains(&line), "{:?}", found.findings);
    }
}

/// Where a measurement can lie depends on an input, which a file of inputs has no measurement beside.
#[test]
fn inputs_that_measurements_use_are_given_by_a_file() {
    let home = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/models/surveys");
    let surveys = Model::read(&home.join("model.toml"), &[]).unwrap();
    let inputs = Data::open_inputs(&home.join("inputs.csv"), &surveys).unwrap();
    let drawn = simulate_along(&surveys, &inputs, 2, 1, |_| ControlFlow::Continue(())).unwrap();
    let table = motes::output::simulated_table(&surveys, &drawn);
    let data = Data::read(table.as_bytes(), "simulated.csv", &surveys).unwrap();
    assert_eq!(data.rows.len(), 6);
    let too_many = "tested,positive\n10,11\n";
    let refused = Data::read(too_many.as_bytes(), "d.csv", &surveys).unwrap_err().to_string();
    assert!(refused.starts_with("d.csv, line 2, column positive: 11 is no value of binomial"), "{refused}");
}

#[test]
fn forecasts_go_on_by_the_last_gap_or_by_given_rows() {
    let head = "[time]\ncolumn = \"h\"";
    let data = read(head, WALK, "h,y\n0,0.2\n1,0.5\n3,0.7\n").unwrap();
    let walk = model(head, WALK);
    let options = FilterOptions { forecast: 2, proposal: ProposalName::Exact, ..Default::default() };
    let proceed = |_| ControlFlow::Continue(());
    let found = filter(&walk, &data, &options, proceed).unwrap();
    assert_eq!(found.forecasts[0].iter().map(|ahead| ahead.time).collect::<Vec<_>>(), [5.0, 7.0]);
    let spread = |at: usize| found.forecasts[0][at].estimate.state[0].sd.powi(2);
    assert!((spread(1) - spread(0) - 0.5).abs() < 1e-9, "0.25 for each unit of time");
    let driven = "[inputs]\nu = \"next\"";
    let body = "[initial]\nx = \"normal(0, 1)\"\n[transition]\nx = \"x + u\"\n[measurement]\ny = \"normal(x, 0.3)\"\n";
    let data = read(driven, body, "u,y\n0,0.2\n1,0.5\n").unwrap();
    let pushed = model(driven, body);
    let refused = filter(&pushed, &data, &options, proceed).unwrap_err().to_string();
    assert_eq!(refused, "a forecast: the input u is not known ahead; give its values by --inputs");
    let rows = Data::read("u,y\n5,\n7,\n".as_bytes(), "ahead.csv", &pushed).unwrap();
    let options = FilterOptions { forecast: 0, ahead: Some(std::sync::Arc::new(rows)), ..options };
    let found = filter(&pushed, &data, &options, proceed).unwrap();
    let mean = |at: usize| found.forecasts[0][at].estimate.state[0].mean;
    let last = found.estimates[1].state[0].mean;
    assert!((mean(0) - last - 5.0).abs() < 1e-9 && (mean(1) - last - 12.0).abs() < 1e-9);
}

/// A step in another unit than the times cuts no gap.
#[test]
fn a_step_that_is_longer_than_all_gaps_is_said() {
    let said = |step: &str| {
        let head = format!("[time]\ncolumn = \"h\"\nstep = {step}");
        let data = read(&head, WALK, "h,y\n0,0.2\n1,0.5\n3,0.7\n").unwrap();
        let walk = model(&head, WALK);
        let found = filter(&walk, &data, &FilterOptions::default(), |_| ControlFlow::Continue(())).unwrap();
        let checked = check(&walk, Some(&data), 1, || ControlFlow::Continue(())).unwrap();
        let warnings: Vec<String> = found.warnings.iter().map(|warning| warning.text.clone()).collect();
        assert_eq!(
            checked.findings.iter().any(|line| line.contains("each gap is one step")),
            !warnings.is_empty()
        );
        warnings
    };
    assert!(said("2").is_empty());
    assert_eq!(
        said("24"),
        [
            "the step of [time] is 24, and the longest gap between rows 2: each gap is one step; is it in the unit of the times?"
        ]
    );
}

/// Where x_0 comes before the first row, a total has no value there, and derivatives of measurements are compared from the first row on.
#[test]
fn gradients_are_compared_where_totals_have_a_value() {
    let model = model(
        "[time]\nstart = -1",
        "[initial]\nx = 2\n[draws]\ne = \"gamma(2, 1)\"\n[transition]\nx = \"0.5*x + e\"\n[measurement]\ny = \"gamma(total(e), x)\"\n",
    );
    let found = check(&model, None, 1, || ControlFlow::Continue(())).unwrap();
    assert!(found.problems.is_empty(), "{found:?}");
    let line = found.findings.iter().find(|line| line.starts_with("gradients")).unwrap();
    assert!(
        line.starts_with("gradients of the measurement: ") && line.contains(" compared with central"),
        "{line}"
    );
}

/// The noise of a step is learned for a number of sub-steps, which the proposal keeps; steps with another number are said.
#[test]
fn a_learned_proposal_is_for_its_number_of_sub_steps() {
    let head = "[time]\ncolumn = \"h\"\nstep = 0.5";
    let body = "[initial]\nx = 0\nv = \"normal(0, 1)\"\n[transition]\nx = \"x + v*dt\"\nv = \"normal(v, sqrt(dt))\"\n\
                [measurement]\ny = \"normal(x, 0.5)\"\n";
    let model = model(head, body);
    let even = read(head, body, "h,y\n0,0.1\n1,0.5\n2,0.4\n3,1\n").unwrap();
    let options =
        LearnOptions { updates: 20, steps: 4, widths: Some(vec![64, 64]), ..LearnOptions::default() };
    let learned = learn(&model, Some(&even), &options, |_, _| ControlFlow::Continue(())).unwrap().proposal;
    assert_eq!(learned.proposal().unwrap().config().sub_steps, 2);
    let said = |data: &Data| -> Vec<String> {
        let proposal = ProposalName::Learned(learned.clone());
        let options = FilterOptions { proposal, particles: 200, ..FilterOptions::default() };
        let found = filter(&model, data, &options, |_| ControlFlow::Continue(())).unwrap();
        found
            .warnings
            .into_iter()
            .map(|warning| warning.text)
            .filter(|text| text.contains("sub-step"))
            .collect()
    };
    assert_eq!(said(&even), [""; 0]);
    let uneven = read(head, body, "h,y\n0,0.1\n1,0.5\n1.5,0.4\n3,1\n").unwrap();
    assert_eq!(
        said(&uneven),
        [
            "--proposal learned was learned for steps of 2 sub-steps, and 2 of 3 have another number: there particles come from the transition"
        ]
    );
}

/// Days and weeks count from the first row, as `t` does; a date says itself when it is.
#[test]
fn a_start_in_days_is_before_the_first_row() {
    let body = "[initial]\nx = 0\n[transition]\nx = \"x + dt\"\n[measurement]\ny = \"normal(x, 0.3)\"\n";
    let rows = "day,y\n2024-03-01,3\n2024-03-02,4\n";
    let lengths = |start: &str| {
        let head = format!("[time]\ncolumn = \"day\"\nunit = \"day\"\nstart = {start}");
        let data = read(&head, body, rows).unwrap();
        data.rows.iter().flat_map(|row| &row.steps).map(|step| step.step().length).collect::<Vec<_>>()
    };
    assert_eq!(lengths("-3")[1..], [3.0, 1.0]);
    assert_eq!(lengths("\"2024-02-27\"")[1..], [3.0, 1.0]);
    assert_eq!(lengths("2024-02-27")[1..], [3.0, 1.0]);
    assert_eq!(
        refused("[time]\ncolumn = \"day\"\nunit = \"day\"\nstart = 2", rows),
        "d.csv, line 2, column day: the first row is at 2024-03-01, before the start of [time] at 2024-03-03"
    );
}

/// What follows a start by the calendar has dates, and is data of the model with the same steps.
#[test]
fn simulations_go_on_from_a_date() {
    for (unit, last) in [("day", "2024-03-01"), ("week", "2024-03-19"), ("year", "2027-02-26T20:15:44.262")] {
        let head = format!("[time]\ncolumn = \"day\"\nunit = \"{unit}\"\nstart = 2024-02-27");
        let walk = model(&head, WALK);
        let drawn = simulate(&walk, 3, 2, 1, |_| ControlFlow::Continue(())).unwrap();
        let table = motes::output::simulated_table(&walk, &drawn);
        assert!(table.lines().nth(6).is_some_and(|line| line.starts_with(&format!("1,{last},"))), "{table}");
        let back = Data::read(table.as_bytes(), "simulated.csv", &walk).unwrap();
        for (row, drawn) in back.rows.iter().zip(&drawn.rows[0]) {
            let lengths = |steps: &[motes::models::StepRecord]| -> Vec<f64> {
                steps.iter().map(|step| step.step().length).collect()
            };
            let (back, drawn) = (lengths(&row.steps), lengths(&drawn.steps));
            assert_eq!(back.len(), drawn.len());
            // A year is one of the calendar, cut to seconds where a label is written.
            assert!(back.iter().zip(&drawn).all(|(a, b)| (a - b).abs() < 1e-6), "{back:?} {drawn:?}");
        }
    }
}

#[test]
fn an_input_of_a_measurement_that_is_missing_is_not_needed() {
    let body = "[inputs]\nu = \"hold\"\n[initial]\nx = \"normal(0, 1)\"\n[transition]\nx = \"normal(0.9*x, 1)\"\n[measurement]\ny = \"normal(x + u, 1)\"\nz = \"normal(x, 1)\"\n";
    let of = |data: &str| Data::read(data.as_bytes(), "d.csv", &model("", body));
    let (blank, filled) = ("u,y,z\n1,0.5,1\n,,2\n3,2,1\n", "u,y,z\n1,0.5,1\n7,,2\n3,2,1\n");
    for proposal in ["bootstrap", "linearised", "exact"] {
        let options = FilterOptions {
            proposal: proposal.parse().unwrap(),
            predictive: true,
            ..FilterOptions::default()
        };
        let [blank, filled] = [blank, filled].map(|data| {
            filter(&model("", body), &of(data).unwrap(), &options, |_| ControlFlow::Continue(())).unwrap()
        });
        assert_eq!(blank.log_evidence(), filled.log_evidence(), "{proposal}");
        // What y would have been is not known without u, and z has nothing to do with it.
        let [of_blank, of_filled] = [&blank, &filled].map(|filtered| &filtered.estimates[1].predictive);
        assert!(of_blank[0].mean.is_nan() && of_blank[0].pit.is_none(), "{proposal}");
        assert!((of_filled[0].mean - of_filled[1].mean - 7.0).abs() < 1e-9, "{proposal}");
        assert_eq!(of_blank[1], of_filled[1], "{proposal}");
    }
    let needed = "d.csv, line 3, column u: the input u has no value here, and [measurement] needs it";
    assert_eq!(of("u,y,z\n1,0.5,1\n,3,2\n").unwrap_err().to_string(), needed);
    // A simulation measures all there is; those that a proposal learns from go on with the value before.
    let rows = of(blank).unwrap();
    let refused = simulate_along(&model("", body), &rows, 1, 0, |_| ControlFlow::Continue(()));
    assert!(refused.unwrap_err().to_string().contains("[measurement] needs it"));
    let learned = LearnOptions { updates: 20, steps: 20, ..LearnOptions::default() };
    learn(&model("", body), Some(&rows), &learned, |_, _| ControlFlow::Continue(())).unwrap();
}
