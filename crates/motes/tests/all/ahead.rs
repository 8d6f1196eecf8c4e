//! Rows after the data: which of a file are predicted, and which files are refused; series that keep their names.

use crate::common::{Workplace, stderr};

const DRIVEN: &str = "[inputs]\nu = \"next\"\n[initial]\nx = 0\n[transition]\nx = \"x + u\"\n[measurement]\ny = \"normal(x, 0.1)\"\n";

/// Catches rows of the past that are taken for those of the future, and a file that ends before it is asked for.
#[test]
fn rows_of_a_whole_period_are_taken_from_where_the_data_end() {
    let place = Workplace::new();
    place.write("m.toml", DRIVEN);
    place.write("d.csv", "t,u,y\n0,100,0\n1,1,1\n2,2,3\n");
    place.write("whole.csv", "t,u\n0,100\n1,1\n2,2\n3,10\n4,20\n");
    place.write("future.csv", "u\n10\n20\n");
    place.write("gap.csv", "t,u\n4,20\n");
    let filter = |more: &[&str]| {
        let base = ["filter", "m.toml", "d.csv", "--proposal", "exact", "--quiet"];
        place.run(&[&base, more].concat())
    };
    let last = |more: &[&str]| {
        let output = filter(more);
        assert!(output.status.success(), "{}", stderr(&output));
        let table = String::from_utf8(output.stdout).unwrap();
        let row: Vec<String> = table.lines().last().unwrap().split(',').map(String::from).collect();
        (row[0].clone(), row[1].clone())
    };
    let expected = ("4".to_string(), "33".to_string());
    assert_eq!(last(&["--inputs", "whole.csv"]), expected);
    assert_eq!(last(&["--inputs", "future.csv"]), expected);
    assert_eq!(last(&["--inputs", "whole.csv", "--forecast", "1"]), ("3".to_string(), "13".to_string()));
    let refused = |more: &[&str]| {
        let output = filter(more);
        assert_eq!(output.status.code(), Some(2));
        stderr(&output)
    };
    assert_eq!(
        refused(&["--inputs", "gap.csv"]),
        "motes: --inputs: gap.csv has no row at t = 3, where the data end, or not all after it"
    );
    assert_eq!(
        refused(&["--inputs", "future.csv", "--forecast", "3"]),
        "motes: --inputs: future.csv has 2 rows after the data, and --forecast asks for 3"
    );
}

#[test]
fn rows_ahead_of_another_series_are_refused() {
    let place = Workplace::new();
    place.write("m.toml", DRIVEN);
    place.write("d.csv", "series,u,y\na,0,0\na,1,1\n");
    place.write("future.csv", "series,u\na,10\nb,20\n");
    let output = place.run(&["filter", "m.toml", "d.csv", "--proposal", "exact", "--inputs", "future.csv"]);
    let line = "motes: --inputs: future.csv has the series b, and the data have none of that name";
    assert_eq!((output.status.code(), stderr(&output).as_str()), (Some(2), line));
}

/// Catches series that get the inputs of others when what was simulated is read again.
#[test]
fn simulated_series_keep_the_names_that_inputs_of_files_go_by() {
    let place = Workplace::new();
    place.write(
        "m.toml",
        "[inputs]\nf = { file = \"f.csv\", between = \"hold\" }\n[initial]\nx = \"normal(0, 1)\"\n[transition]\nx = \"normal(x, 1)\"\n[measurement]\ny = \"normal(x + f, 1)\"\n",
    );
    place.write("f.csv", "t,series,f\n0,1,1000\n2,1,1000\n0,0,0\n2,0,0\n");
    place.write("times.csv", "series\n1\n1\n0\n0\n");
    place.printed(&["simulate", "m.toml", "--inputs", "times.csv", "-o", "sim.csv", "--quiet"]);
    let table = place.read("sim.csv");
    assert!(table.lines().nth(1).is_some_and(|line| line.starts_with("1,0,")), "{table}");
    let json = place.printed(&["filter", "m.toml", "sim.csv", "--proposal", "exact", "--json", "--quiet"]);
    let json: serde_json::Value = serde_json::from_str(&json).unwrap();
    assert!(json["log_evidence"].as_f64().unwrap() > -30.0, "{json}");
    let copies = ["simulate", "m.toml", "--inputs", "times.csv", "--series", "2", "--quiet"];
    let table = place.printed(&copies);
    let names: Vec<&str> =
        table.lines().skip(1).step_by(2).map(|line| line.split(',').next().unwrap()).collect();
    assert_eq!(names, ["1.0", "1.1", "0.0", "0.1"]);
}

/// What a step to a row leads to is the value of that row, whether it is a column of the data or of a file.
#[test]
fn the_next_value_of_a_file_is_that_of_a_column() {
    let place = Workplace::new();
    let body = "[time]\ncolumn = \"h\"\n[initial]\nx = 0\n[transition]\nx = \"x + u\"\n[measurement]\ny = \"normal(x + u, 1)\"\n";
    place.write("column.toml", format!("[inputs]\nu = \"next\"\n{body}"));
    place.write("file.toml", format!("[inputs]\nu = {{ file = \"d.csv\", between = \"next\" }}\n{body}"));
    place.write("d.csv", "h,u,y\n0,1,0\n1,10,20\n2.5,100,200\n");
    let of = |model: &str| place.printed(&["filter", model, "d.csv", "--proposal", "exact", "--quiet"]);
    assert_eq!(of("column.toml"), of("file.toml"));
    assert!(of("file.toml").lines().nth(3).is_some_and(|line| line.starts_with("2.5,2.5,110,")));
}

#[test]
fn zones_of_files_are_those_of_the_rows() {
    let place = Workplace::new();
    place.write(
        "m.toml",
        "[time]\ncolumn = \"d\"\nunit = \"day\"\n[inputs]\nu = { file = \"f.csv\", between = \"linear\" }\n[initial]\nx = 0\n[transition]\nx = \"x + u\"\n[measurement]\ny = \"normal(x, 1)\"\n",
    );
    place.write("d.csv", "d,y\n2024-01-02T00:00+09:00,0\n2024-01-02T12:00+09:00,1\n");
    place.write("f.csv", "d,u\n2024-01-01T00:00,0\n2024-01-03T00:00,48\n");
    let output = place.run(&["filter", "m.toml", "d.csv"]);
    assert_eq!(
        stderr(&output),
        "motes: d.csv, line 3, column d: f.csv has times with no zone, and the rows have times with a zone: which is earlier is not known; write zones in both or in none"
    );
    assert_eq!(output.status.code(), Some(2));
    let output = place.run(&["simulate", "m.toml", "--steps", "3"]);
    let line = "motes: the times in the column d are dates, and the model says of none when it is; give those of the rows by --inputs, or that of x_0 by start = 2024-01-01 in [time]";
    assert_eq!((output.status.code(), stderr(&output).as_str()), (Some(2), line));
}
