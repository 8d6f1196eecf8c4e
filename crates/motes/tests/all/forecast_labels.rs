//! The times of forecasts in tables, and rows that do not say whose they are.

use crate::common::{Workplace, stderr};

const CLOCK: &str = "[time]\ncolumn = \"date\"\n[initial]\nx = \"t\"\n[transition]\nx = \"t\"\n[measurement]\ny = \"normal(x, 1)\"\n";

/// The first cells of the forecasts of two rows.
fn labels(unit: &str, dates: &[&str]) -> Vec<String> {
    let place = Workplace::new();
    let column = "column = \"date\"";
    let model = match unit {
        "" => CLOCK.to_string(),
        unit => CLOCK.replace(column, &format!("{column}\nunit = \"{unit}\"")),
    };
    // y is missing: times alone matter.
    let rows: String = dates.iter().map(|date| format!("{date},\n")).collect();
    place.write("model.toml", model);
    place.write("data.csv", format!("date,y\n{rows}"));
    let table = place.printed(&["filter", "model.toml", "data.csv", "--forecast", "2", "--particles", "2"]);
    let last = table.lines().skip(1 + dates.len());
    last.map(|line| line.split(',').next().unwrap().to_string()).collect()
}

/// Catches labels that go on by days where the model's time goes on by years.
#[test]
fn forecasts_are_labelled_by_the_time_that_they_are_of() {
    for (unit, dates, expected) in [
        ("year", &["2022-01-01", "2023-01-01", "2024-01-01"][..], ["2025-01-01", "2026-01-01"]),
        ("week", &["2024-01-01", "2024-01-08"], ["2024-01-15", "2024-01-22"]),
        ("week", &["2024-01-01", "2024-01-08", "2024-01-10"], ["2024-01-12", "2024-01-14"]),
        ("day", &["2024-01-01T00:00", "2024-01-01T06:00"], ["2024-01-01T12:00", "2024-01-01T18:00"]),
        ("day", &["2024/02/27", "2024/02/28", "2024/02/29"], ["2024/03/01", "2024/03/02"]),
        ("day", &["2024-01-01", "2024-02-01", "2024-03-01"], ["2024-03-30", "2024-04-28"]),
        // The last gap that is one.
        ("day", &["2024-01-01", "2024-01-03", "2024-01-03"], ["2024-01-05", "2024-01-07"]),
        ("", &["2001", "2002", "2004"], ["2006", "2008"]),
        ("", &["0.1", "0.2", "0.3"], ["0.4", "0.5"]),
    ] {
        assert_eq!(labels(unit, dates), expected, "{unit}: {dates:?}");
    }
}

#[test]
fn a_row_without_a_series_and_columns_with_two_meanings_are_refused() {
    let place = Workplace::new();
    let walk = "[initial]\nx = \"normal(0, 1)\"\n[transition]\nx = \"normal(x, 1)\"\n[measurement]\ny = \"normal(x, 1)\"\n";
    place.write("data.csv", "animal,y\na,0.9\n,1.1\n");
    let refused = |head: &str| {
        place.write("model.toml", format!("{head}{walk}"));
        let output = place.run(&["filter", "model.toml", "data.csv"]);
        let said = stderr(&output);
        assert!(output.status.code() == Some(2) && said.lines().count() == 1, "{said}");
        said
    };
    let said = refused("[series]\nby = \"animal\"\n");
    assert!(said.contains("line 3, column animal: the cell is empty"), "{said}");
    let said = refused("[series]\nby = \"y\"\n");
    assert!(said.contains("[series] by: y is a measurement"), "{said}");
    let said = refused("[time]\ncolumn = \"y\"\n");
    assert!(said.contains("[time] column: y is a measurement"), "{said}");
}

#[test]
fn inputs_ahead_need_no_measurements() {
    let place = Workplace::new();
    let fed_back = r#"
[inputs]
u = "next"
before = { column = "y", rows = 1, first = 0 }
[initial]
x = "normal(0, 0.3)"
[transition]
x = "normal(0.5*before + u, 0.3)"
[measurement]
y = "normal(x, 0.1)"
"#;
    place.write("model.toml", fed_back);
    place.write("data.csv", "u,y\n0,0.2\n1,1.0\n0,0.6\n");
    place.write("ahead.csv", "u\n1\n2\n");
    place.write("with.csv", "u,y\n1,\n2,\n");
    let by = |file| place.printed(&["filter", "model.toml", "data.csv", "--inputs", file]);
    let table = by("ahead.csv");
    assert_eq!(table.lines().count(), 6, "{table}");
    assert_eq!(table, by("with.csv"));
    place.write("wrong.csv", "v\n1\n");
    let output = place.run(&["filter", "model.toml", "data.csv", "--inputs", "wrong.csv"]);
    assert!(stderr(&output).contains("there is no column u"), "{}", stderr(&output));
}

/// Catches a proposal that is named for what it does not do.
#[test]
fn a_linearised_proposal_that_sees_nothing_says_so() {
    let place = Workplace::new();
    let volatility = "[initial]\nx = \"normal(0, 1)\"\n[transition]\nx = \"normal(0.9*x, 0.3)\"\n[measurement]\ny = \"normal(0, exp(x/2))\"\n";
    place.write("blind.toml", volatility);
    place.write("seeing.toml", volatility.replace("normal(0, exp", "normal(x, exp"));
    place.write("data.csv", "y\n0.3\n-0.5\n");
    for (model, is_blind) in [("blind.toml", true), ("seeing.toml", false)] {
        let checked = place.printed(&["check", model]);
        let said = "linearised (which is the transition, since no measurement has a location that moves with the state)";
        assert_eq!(checked.contains(said), is_blind, "{checked}");
        let output = place.run(&["filter", model, "data.csv", "--proposal", "linearised"]);
        let said = "--proposal linearised is the transition here";
        assert_eq!(stderr(&output).contains(said), is_blind, "{}", stderr(&output));
    }
}
