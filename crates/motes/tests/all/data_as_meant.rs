//! Data are read as they are meant, or a warning says what was assumed; what no state can give is refused.

use std::io::Write;
use std::process::Stdio;

use crate::common::{Workplace, stderr};
use motes::{Data, Model};
use serde_json::Value;

/// A walk that is measured closely.
const LEVEL: &str = "[initial]\nx = \"normal(0, 1)\"\n[transition]\nx = \"normal(x, 0.5)\"\n[measurement]\ny = \"normal(x, 0.3)\"\n";

/// One that moves less.
const ANIMAL: &str = "[initial]\nx = \"normal(0, 1)\"\n[transition]\nx = \"normal(x, 0.2)\"\n[measurement]\ny = \"normal(x, 0.3)\"\n";

/// Counts of successes of ten.
const SUCCESSES: &str = "[initial]\np = \"uniform(0.4, 0.6)\"\n[transition]\np = \"normal(p, 0.01)\"\n[measurement]\ny = \"binomial(10, p)\"\n";

/// What is said of a CSV text of the walk's.
fn said(text: &str) -> Vec<String> {
    let model = Model::parse(crate::common::WALK, "walk.toml", &[]).unwrap();
    let data = Data::read(text.as_bytes(), "d.csv", &model).unwrap();
    data.warnings().iter().map(ToString::to_string).collect()
}

/// What is said of a carried column with these labels.
fn said_of(column: &str, labels: &str) -> Vec<String> {
    let rows: String = labels.split(',').map(|label| format!("{label},0.5\n")).collect();
    said(&format!("{column},y\n{rows}"))
}

fn json(place: &Workplace, arguments: &[&str]) -> Value {
    serde_json::from_str(&place.printed(arguments)).unwrap()
}

#[test]
fn missing_days_and_a_wrong_order_are_named_and_empty_rows_give_the_exact_evidence() {
    let place = Workplace::new();
    place.write("level.toml", LEVEL);
    place.write(
        "d.csv",
        "date,y\n2024-03-01,0.2\n2024-03-02,0.5\n2024-03-06,2.4\n2024-03-07,2.2\n2024-03-05,1.9\n",
    );
    let line = "column date: steps of 1, 4, 1 and -2 days; line 6 (2024-03-05) is before line 5: rows are taken as consecutive time steps; sort them, \
                and give missing days as rows with empty cells";
    for command in ["filter", "smooth"] {
        let output = place.run(&[command, "level.toml", "d.csv", "-o", "out.csv"]);
        assert!(
            stderr(&output).contains(&format!("motes: warning: {line}\n")) || stderr(&output).ends_with(line),
            "{}",
            stderr(&output)
        );
        assert_eq!(place.run(&[command, "level.toml", "d.csv", "--strict", "-q"]).status.code(), Some(1));
    }
    assert!(place.printed(&["check", "level.toml", "d.csv"]).contains(&format!("warning: {line}\n")));
    let found = json(&place, &["filter", "level.toml", "d.csv", "--json", "--report", "page.html"]);
    assert_eq!(found["warnings"][0], line);
    assert!(place.read("page.html").contains("steps of 1, 4, 1 and -2 days"));
    // As advised. Both numbers are a Kalman filter's.
    let evidence = |rows: &str| {
        place.write("d.csv", format!("date,y\n{rows}"));
        let command =
            ["filter", "level.toml", "d.csv", "--json", "--particles", "20000", "--proposal", "optimal"];
        let found = json(&place, &command);
        (found["log_evidence"].as_f64().unwrap(), found["warnings"].as_array().unwrap().len())
    };
    let (with_gaps, warnings) = evidence(
        "2024-03-01,0.2\n2024-03-02,0.5\n2024-03-03,\n2024-03-04,\n2024-03-05,\n2024-03-06,2.4\n2024-03-07,2.2\n",
    );
    assert!((with_gaps - -4.739309).abs() < 0.05 && warnings == 0, "{with_gaps}, {warnings} warnings");
    let (as_if, warnings) = evidence("2024-03-01,0.2\n2024-03-02,0.5\n2024-03-06,2.4\n2024-03-07,2.2\n");
    assert!((as_if - -7.310641).abs() < 0.05 && warnings == 1, "{as_if}, {warnings} warnings");
}

#[test]
fn labels_in_blocks_may_be_series_and_then_are_filtered_each_on_its_own() {
    let place = Workplace::new();
    place.write("animal.toml", ANIMAL);
    let text = "animal,y\na,0.9\na,1.1\nb,-1.4\nb,-1.2\nb,-1.1\n";
    place.write("d.csv", text);
    let command =
        ["filter", "animal.toml", "d.csv", "--json", "--particles", "20000", "--proposal", "optimal"];
    let as_one = json(&place, &command);
    assert_eq!(
        as_one["warnings"][0],
        "column animal: a in lines 2 to 3, b in lines 4 to 6: is it series? rows are taken as one sequence; call it series, or give the model [series] by = \"animal\", and each is filtered on its own"
    );
    place.write("d.csv", text.replace("animal", "series"));
    let as_two = json(&place, &command);
    assert_eq!(as_two["warnings"].as_array().unwrap().len(), 0);
    let of = |series: usize| as_two["log_evidence_per_series"][series].as_f64().unwrap();
    // By a Kalman filter.
    assert!((of(0) - -1.655275).abs() < 0.05 && (of(1) - -2.139981).abs() < 0.05, "{as_two}");
}

#[test]
fn equal_steps_of_calendars_and_clocks_are_no_matter_to_warn_of() {
    for (column, labels) in [
        ("date", "2024-01-31,2024-02-29,2024-03-31,2024-04-30"),
        ("date", "2024-01-15,2024-02-15,2024-03-15"),
        ("date", "2024-01-30,2024-02-29,2024-03-30"),
        // The last working days.
        ("date", "2024-01-31,2024-02-29,2024-03-29,2024-04-30"),
        ("date", "2020-01-01,2021-01-01,2022-01-01,2023-01-01"),
        ("date", "2023-12-31,2024-03-31,2024-06-30,2024-09-30"),
        ("date", "2024-01-01,2024-01-08,2024-01-15"),
        ("month", "2023-11,2023-12,2024-01"),
        ("quarter", "2023Q3,2023Q4,2024Q1"),
        // Monday to Friday.
        ("date", "2024-03-01,2024-03-04,2024-03-05,2024-03-06,2024-03-07,2024-03-08,2024-03-11"),
        // A clock that is put forward.
        ("date", "2024-03-30T00:00+01:00,2024-03-31T00:00+01:00,2024-04-01T00:00+02:00"),
        ("date", "2024-03-31T00:00+01:00,2024-03-31T01:00+01:00,2024-03-31T03:00+02:00"),
        ("date", "2024-03-31,2024-03-31 06:00:00,2024-03-31 12:00:00"),
        ("date", "20240130,20240131,20240201"),
        ("stamp", "2024-01-01 00:00:00.01,2024-01-01 00:00:01.002,2024-01-01 00:00:02"),
        ("year", "1871,1872,1873"),
        ("year", "2020.08,2020.17,2020.25,2020.33,2020.42,2020.50"),
        ("time", "0.1,0.2,0.30000000000000004,0.4"),
        ("month", "11,12,1,2,3"),
        ("hour", "22,23,0,1"),
        ("date", "2024-01-01"),
        // What is no time.
        ("temperature", "20.1,19.5,22.3,22.1,18.0,25.3,20.0"),
        ("temperature", "20.1,20.5,22.3"),
        ("note", "a,b,c,d"),
        ("note", "a,b,a,b,a,b"),
        ("note", "a,a,a"),
        ("date", "01/02/2024,03/02/2024,05/02/2024"),
    ] {
        assert_eq!(said_of(column, labels), [""; 0], "{column}: {labels}");
    }
}

#[test]
fn unequal_steps_are_named_with_their_rows() {
    let one = |column: &str, labels: &str| {
        let said = said_of(column, labels);
        assert_eq!(said.len(), 1, "{column}: {labels}: {said:?}");
        said[0].clone()
    };
    let taken = "rows are taken as consecutive time steps";
    for (column, labels, expected) in [
        (
            "month",
            "2024-01,2024-03,2024-04",
            format!("steps of 2 and 1 months: {taken}; give missing months as rows with empty cells"),
        ),
        (
            "q",
            "2023Q4,2024Q2,2024Q1",
            format!("steps of 2 and -1 quarters; line 4 (2024Q1) is before line 3: {taken}; sort them"),
        ),
        (
            "time",
            "0.1,0.2,0.4",
            format!("steps of 0.1 and 0.2: {taken}; give missing times as rows with empty cells"),
        ),
        ("time", "0,0.3,1", format!("steps of 0.3 and 0.7: {taken}")),
        (
            "n",
            "1,2,3,5,6",
            format!("steps of 1, 1, 2 and 1: {taken}; give missing times as rows with empty cells"),
        ),
        (
            "year",
            "2023,2022,2021",
            format!("it goes backwards, from line 2 (2023) to line 4 (2021): {taken}; sort them"),
        ),
        (
            "date",
            "2024-01-05,2024-01-01",
            format!("step of -4 days; line 3 (2024-01-01) is before line 2: {taken}; sort them"),
        ),
        (
            "date",
            "2024-01-01,2024-06-01,2024-01-01,2023-01-01",
            format!(
                "steps of 5, -5 and -12 months; line 4 (2024-01-01) is before line 3 and 1 more; line 4 (2024-01-01) repeats line 2: {taken}; sort \
                 them, and leave one row for each time"
            ),
        ),
        (
            "date",
            "2024-01-01,2024-01-01,2024-01-01,2024-01-01",
            format!("all 4 rows have the same time: {taken}; leave one row for each time"),
        ),
        (
            "date",
            "2024-02-29,2024-03-01,2024-03-04,2024-03-05,2024-03-06,2024-03-08,2024-03-11,2024-03-12",
            format!(
                "steps of 1 working day, but for 1 of 7: 2 working days to line 7 (2024-03-08): {taken}; give missing working days as rows with \
                 empty cells"
            ),
        ),
    ] {
        let in_model = format!(
            "; or name it in the model, [time] column = \"{column}\", and steps are as long as the times say"
        );
        let is_forward = !expected.contains("sort them") && !expected.contains("leave one row");
        let cure = if is_forward { in_model } else { String::new() };
        assert_eq!(one(column, labels), format!("column {column}: {expected}{cure}"));
    }
    assert!(
        one("date", "2024-01-01,2024-01-02,soon,2024-01-03")
            .contains("line 4 (soon) is no date as the others are")
    );
}

#[test]
fn times_that_begin_again_may_be_of_several_series() {
    let hint = "are they several? put each row's into a column called series";
    for (column, labels, found) in [
        (
            "date",
            "2024-01-01,2024-01-02,2024-01-03,2024-01-01,2024-01-02",
            "it begins again at line 5 (2024-01-01)",
        ),
        ("day", "1,2,3,1,2,3", "it begins again at line 5 (1)"),
        ("date", "2024-01-01,2024-01-01,2024-01-02,2024-01-02", "each value stands in 2 rows"),
    ] {
        let said = said_of(column, labels);
        assert_eq!(said.len(), 1, "{said:?}");
        assert!(said[0].contains(found) && said[0].contains(hint), "{said:?}");
    }
    // Where series are told apart there is nothing to ask.
    assert_eq!(
        said("series,date,y\na,2024-01-01,1\na,2024-01-02,1\nb,2024-01-01,1\nb,2024-01-02,1\n"),
        [""; 0]
    );
    assert_eq!(said("series,kind,y\na,u,1\na,u,1\nb,v,1\nb,v,1\n"), [""; 0]);
    // A year and a month are one time.
    assert_eq!(said("year,month,y\n2024,1,0\n2024,2,0\n2025,1,0\n2025,2,0\n"), [""; 0]);
}

#[test]
fn each_series_has_a_line_and_many_have_one_together() {
    let text = |series: usize| {
        let rows = |series: usize| {
            format!("s{series},2024-01-01,1\ns{series},2024-01-02,1\ns{series},2024-01-04,1\n")
        };
        format!("series,date,y\n{}", (0..series).map(rows).collect::<String>())
    };
    let two = said(&text(2));
    assert_eq!(two.len(), 2);
    assert!(two[1].starts_with("series s1: column date: steps of 1 and 2 days:"), "{two:?}");
    let many = said(&text(50));
    assert_eq!(many.len(), 1);
    assert!(
        many[0].starts_with(
            "column date: the times of 50 of 50 series are not one step apart; in the first of them, s0: steps of 1 and 2 days:"
        ),
        "{many:?}"
    );
}

/// Catches a panic, and a line that is no line.
#[test]
fn any_labels_are_read() {
    let labels = [
        "",
        " ",
        "0",
        "-1",
        "1e308",
        "-1e308",
        "nan",
        "2024-03-01",
        "2024-03-01T23:59:60",
        "0000-01-01",
        "9999-12-31",
        "262143-01-01",
        "2024-02-30",
        "2024-13",
        "2024Q9",
        "2024-03-01 12:00+25:00",
        "T",
        "é",
        "\u{202e}x",
        "20240301",
        "99999999",
        "2024-03-01T00:00:00.123456789Z",
        "1 may",
        "-9223372036854775808",
        "0.1",
    ];
    let mut number = 7_usize;
    for length in 1..40 {
        let rows: String = (0..length)
            .map(|_| {
                number = (number * 1_103_515_245 + 12_345) % (1 << 31);
                format!("\"{}\",1\n", labels[(number >> 8) % labels.len()])
            })
            .collect();
        for name in ["date", "x1"] {
            assert!(said(&format!("{name},y\n{rows}")).iter().all(|line| !line.contains('\n')));
        }
    }
}

#[test]
fn a_stream_says_once_that_rows_come_in_a_wrong_order() {
    let place = Workplace::new();
    let rows = "date,y\n2024-03-02,1\n2024-03-01,1\n2024-02-01,1\n2024-02-01,1\n2024-02-01,1\n";
    for (more, status) in [(&["-o", "out.csv"][..], 0), (&["-o", "out.csv", "--strict"], 1)] {
        let mut command = place.motes(&[&["filter", "walk.toml", "-"], more].concat());
        let mut running = command.stdin(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        running.stdin.take().unwrap().write_all(rows.as_bytes()).unwrap();
        let output = running.wait_with_output().unwrap();
        let said = stderr(&output);
        assert_eq!(said.matches("column date: line 3 (2024-03-01) is before line 2").count(), 1, "{said}");
        assert_eq!(said.matches("column date: line 5 (2024-02-01) repeats line 4").count(), 1, "{said}");
        assert_eq!(said.matches("is before").count() + said.matches("repeats").count(), 2, "{said}");
        assert_eq!(output.status.code(), Some(status));
    }
}

/// Catches one that is left to the filter, which asks for more particles.
#[test]
fn a_value_that_no_state_can_give_is_refused_by_every_command_with_its_place() {
    let place = Workplace::new();
    place.write("m.toml", SUCCESSES);
    let line = |value: &str| {
        format!(
            "motes: d.csv, line 3, column y: {value} is no value of binomial(10, p): a count is a whole number from 0 to 10"
        )
    };
    for value in ["4.5", "-1", "11", "0.9999999999"] {
        place.write("d.csv", format!("y\n5\n{value}\n6\n"));
        let commands: [&[&str]; 5] = [
            &["filter", "m.toml", "d.csv"],
            &["smooth", "m.toml", "d.csv"],
            &["compare", "m.toml", "d.csv"],
            &["learn", "m.toml", "d.csv", "-o", "learned"],
            &["check", "m.toml", "d.csv"],
        ];
        for command in commands {
            let output = place.run(command);
            assert_eq!(stderr(&output), line(value), "{command:?}");
            assert_eq!(output.status.code(), Some(2));
            assert!(output.stdout.is_empty());
        }
    }
    let mut command = place.motes(&["filter", "m.toml", "-"]);
    let mut running =
        command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    running.stdin.take().unwrap().write_all(b"y\n5\n4.5\n").unwrap();
    let output = running.wait_with_output().unwrap();
    assert_eq!(stderr(&output), line("4.5").replace("d.csv", "standard input"));
}

#[test]
fn a_measurement_far_off_is_shown_beside_what_the_particles_predict() {
    let place = Workplace::new();
    place.write(
        "m.toml",
        "[initial]\nx = \"normal(0, 1)\"\n[transition]\nx = \"normal(0.9*x, 0.5)\"\n[measurement]\nz = \"normal(x, 1)\"\ny = \"uniform(x - 1, x + 1)\"\n",
    );
    place.write("d.csv", "z,y\n0.1,0.2\n0.3,30\n");
    for command in ["filter", "smooth"] {
        let output = place.run(&[command, "m.toml", "d.csv"]);
        let said = stderr(&output);
        let begin = "motes: d.csv, line 3, t = 1: no particle explains the measurement: y is 30, where the particles predict ";
        assert!(said.starts_with(begin) && !said.contains("z is"), "{said}");
        let numbers: Vec<&str> = said[begin.len()..].split_whitespace().collect();
        let (mean, sd): (f64, f64) =
            (numbers[0].parse().unwrap(), numbers[2].trim_end_matches(',').parse().unwrap());
        assert!(said.contains(", and its distribution is uniform("), "{said}");
        assert!(mean.abs() < 1.0 && (0.4..1.5).contains(&sd), "{said}");
        assert!(said.ends_with("take more particles or --proposal linearised, or give the measurement more noise or heavier tails"));
        assert_eq!(output.status.code(), Some(2));
    }
}

/// Catches a line that ends where nothing can be predicted, and advice that does not help there.
#[test]
fn a_measurement_that_no_particle_can_draw_is_named() {
    let place = Workplace::new();
    place.write(
        "m.toml",
        "[inputs]\nn = \"next\"\n[initial]\nx = \"normal(0, 1)\"\n[transition]\nx = \"normal(x, 1)\"\n[measurement]\ny = \"binomial(n, 0.5)\"\n",
    );
    place.write("d.csv", "n,y\n9,4\n-9,4\n");
    assert_eq!(
        stderr(&place.run(&["filter", "m.toml", "d.csv"])),
        "motes: d.csv, line 3, t = 1: no particle explains the measurement: y is 4, and no particle can draw it; its distribution is binomial(-9, 0.5) at the nearest (the effective sample size before was 1000); look at the parameters of its \
         distribution there, and at the inputs of this row"
    );
}
