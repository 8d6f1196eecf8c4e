//! Times that are nearly or exactly the same: values of files at sub-steps, rows at one time, zones, and measurements that are inputs of themselves.

use crate::common::{Workplace, stderr};

fn log_evidence(place: &Workplace, model: &str, data: &str) -> f64 {
    let printed =
        place.printed(&["filter", model, data, "--proposal", "exact", "--json", "--quiet", "-o", "x.csv"]);
    let found: serde_json::Value = serde_json::from_str(&printed).unwrap();
    found["log_evidence"].as_f64().unwrap()
}

fn refusal(place: &Workplace, arguments: &[&str]) -> String {
    let output = place.run(arguments);
    assert_eq!(output.status.code(), Some(2), "{}", stderr(&output));
    stderr(&output)
}

/// The start of a sub-step is a time of the file but for rounding, which must not decide which row is taken.
#[test]
fn a_sub_step_that_begins_at_a_time_of_a_file_has_the_value_of_that_time() {
    let place = Workplace::new();
    let days = 70;
    let date = |day: usize| {
        let (month, day) = if day < 31 {
            (1, day)
        } else if day < 60 {
            (2, day - 31)
        } else {
            (3, day - 60)
        };
        format!("2024-{month:02}-{:02}", day + 1)
    };
    let inputs: String = (0..=days).map(|day| format!("{},{}\n", date(day), (day * 37) % 101)).collect();
    place.write("u.csv", format!("day,u\n{inputs}"));
    let rows: String = (0..=days / 7).map(|week| format!("{},\n", date(7 * week))).collect();
    place.write("d.csv", format!("day,y\n{rows}"));
    let head = "[time]\ncolumn = \"day\"\nunit = \"week\"\nstep = \"1/7\"\n";
    let body = "[initial]\nx = \"0\"\n[transition]\nx = \"x + u\"\n[measurement]\ny = \"normal(x, 1)\"\n";
    for (between, shift) in [("hold", 0), ("next", 1)] {
        let inputs =
            format!("[inputs]\nu = {{ file = \"u.csv\", column = \"u\", between = \"{between}\" }}\n");
        place.write("m.toml", format!("{head}{inputs}{body}"));
        let table = place.printed(&["filter", "m.toml", "d.csv", "--particles", "2", "--quiet"]);
        let at = table.lines().next().unwrap().split(',').position(|name| name == "x_mean").unwrap();
        for (week, row) in table.lines().skip(1).enumerate() {
            let found: f64 = row.split(',').nth(at).unwrap().parse().unwrap();
            let right: usize = (0..7 * week).map(|day| ((day + shift) * 37) % 101).sum();
            assert_eq!(found, right as f64, "{between}, week {week}");
        }
    }
}

/// Two rows at one time are two measurements of one state: what was measured at either begins anew.
#[test]
fn a_total_since_measured_begins_anew_after_two_rows_at_one_time() {
    let place = Workplace::new();
    place.write(
        "m.toml",
        "[time]\ncolumn = \"h\"\n[initial]\nx = \"normal(0, 1)\"\n[transition]\nx = \"normal(x, 1)\"\n\
         [measurement]\ny = \"normal(total_since_measured(x), 0.5)\"\nz = \"normal(x, 1)\"\n",
    );
    place.write("one.csv", "h,y,z\n0,,0.1\n1,0.4,0.2\n2,0.9,0.5\n3,-0.3,0\n");
    place.write("two.csv", "h,y,z\n0,,0.1\n1,0.4,\n1,,0.2\n2,0.9,\n2,,0.5\n3,-0.3,\n3,,0\n");
    let [one, two] = ["one.csv", "two.csv"].map(|data| log_evidence(&place, "m.toml", data));
    assert!((one - two).abs() < 1e-9, "{one} and {two}");
    // No time has passed before the second of two first rows either.
    place.write("first.csv", "h,y,z\n0,,0.1\n0,0.4,\n1,0.9,0.5\n");
    let said = refusal(&place, &["filter", "m.toml", "first.csv"]);
    assert!(said.contains("first.csv, line 3, column y"), "{said}");
}

#[test]
fn zones_of_a_start_and_of_files_are_those_of_rows() {
    let place = Workplace::new();
    let body = "[initial]\nx = \"normal(0, 1)\"\n[transition]\nx = \"normal(x + u, 1)\"\n[measurement]\ny = \"normal(x, 1)\"\n";
    let time = "[time]\ncolumn = \"d\"\nunit = \"day\"\n";
    let own = "[inputs]\nu = { first = 0 }\n";
    place.write("start.toml", format!("{time}start = \"2024-03-30\"\n{own}{body}"));
    place.write("d.csv", "d,u,y\n2024-03-31T00:00+05:00,0,1\n");
    assert_eq!(
        refusal(&place, &["filter", "start.toml", "d.csv"]),
        "motes: d.csv, line 2, column d: 2024-03-31T00:00+05:00 has a zone, and start = \"2024-03-30\" of [time] has none"
    );
    place.write(
        "file.toml",
        format!("{time}[inputs]\nu = {{ file = \"u.csv\", column = \"u\", between = \"hold\" }}\n{body}"),
    );
    place.write("u.csv", "d,u\n2024-03-30T00:00Z,1\n2024-03-31T00:00,2\n");
    let said = refusal(&place, &["filter", "file.toml", "d.csv"]);
    assert!(
        said.contains("line 3, column d: 2024-03-31T00:00 has no zone, and times before it have one"),
        "{said}"
    );
}

#[test]
fn no_measurement_is_measured_by_itself() {
    let place = Workplace::new();
    let model = |input: &str, mean: &str, other: &str| {
        format!(
            "[inputs]\nbefore = {input}\n[initial]\nx = \"normal(0, 1)\"\n[transition]\nx = \"normal({mean}, 1)\"\n\
             [measurement]\nr = \"normal(x, 1)\"\ns = \"normal({other}, 1)\"\n"
        )
    };
    place.write("d.csv", "r,s\n1,2\n0.5,1\n");
    for (name, input, mean, other, is_refused) in [
        ("itself", "{ column = \"s\", between = \"hold\", first = 0 }", "x", "0.1*before + x", true),
        ("state", "{ column = \"r\", between = \"next\", first = 0 }", "x + before", "x", true),
        ("other", "{ column = \"r\", between = \"hold\", first = 0 }", "x", "0.1*before + x", false),
        ("row before", "{ column = \"s\", rows = 1, first = 0 }", "x", "0.1*before + x", false),
    ] {
        place.write("m.toml", model(input, mean, other));
        let output = place.run(&["filter", "m.toml", "d.csv", "-o", "x.csv"]);
        let said = stderr(&output);
        assert_eq!(output.status.code() == Some(2), is_refused, "{name}: {said}");
        assert_eq!(said.contains("rows = 1 takes that of the row before"), is_refused, "{name}: {said}");
    }
}

/// Where the model names a column of times, a column `t` is one like others.
#[test]
fn a_column_t_beside_a_named_column_of_times_counts_nothing() {
    let place = Workplace::new();
    place.write(
        "m.toml",
        "[time]\ncolumn = \"h\"\n[initial]\nx = \"normal(0, 1)\"\n[transition]\nx = \"normal(x, 1)\"\n[measurement]\ny = \"normal(x, 1)\"\n",
    );
    place.write("with.csv", "h,t,y\n0,5,1\n1,7,2\n");
    place.write("without.csv", "h,y\n0,1\n1,2\n");
    let [with, without] = ["with.csv", "without.csv"].map(|data| log_evidence(&place, "m.toml", data));
    assert_eq!(with, without);
}

/// Each coordinate of a measured vector may have a line of its own, and then a total of its own.
#[test]
fn a_coordinate_of_a_measured_vector_has_a_total_since_it_was_measured() {
    let place = Workplace::new();
    let model = |first: &str, second: &str| {
        format!(
            "[time]\nstart = -1\n[initial]\nx = 0\n[draws]\ne = \"normal(1, 1)\"\n[transition]\nx = \"e\"\n\
             [measurement]\n{first} = \"normal(total_since_measured(e), 1)\"\n{second} = \"normal(x, 1)\"\n"
        )
    };
    place.write("vector.toml", model("y[0]", "y[1]"));
    place.write("names.toml", model("a", "b"));
    place.write("vector.csv", "y[0],y[1]\n1,2\n,3\n2,1\n");
    place.write("names.csv", "a,b\n1,2\n,3\n2,1\n");
    let found =
        ["vector", "names"].map(|name| log_evidence(&place, &format!("{name}.toml"), &format!("{name}.csv")));
    assert_eq!(found[0], found[1]);
    place.write("both.toml", model("y[0..2]", "y[2]"));
    let said = refusal(&place, &["check", "both.toml"]);
    assert!(said.contains("a vector of them takes a line for each coordinate"), "{said}");
}

/// What is missing in a row that was given for the future is named there, and not asked for again.
#[test]
fn an_input_that_is_blank_in_a_row_ahead_is_named_with_the_row() {
    let place = Workplace::new();
    place.write("d.csv", "d,v,y\n2024-03-01,0,1\n2024-03-02,0,2\n");
    place.write("ahead.csv", "d,v\n2024-03-03,0\n2024-03-04,\n2024-03-05,1\n");
    for (rule, expected) in [
        ("hold", "v has no value in the row before 2024-03-05"),
        ("next", "v has no value at 2024-03-04, a row of --inputs"),
    ] {
        place.write(
            "m.toml",
            format!("[time]\ncolumn = \"d\"\nunit = \"day\"\n[inputs]\nv = \"{rule}\"\n[initial]\nx = \"normal(0, 1)\"\n[transition]\nx = \"normal(x + v, 1)\"\n[measurement]\ny = \"normal(x, 1)\"\n"),
        );
        let said = refusal(&place, &["filter", "m.toml", "d.csv", "--inputs", "ahead.csv", "-o", "x.csv"]);
        assert!(said.contains(expected) && !said.contains("give its values by --inputs"), "{said}");
    }
}

/// Three rows before any time has passed: nothing is expected of a sum over a step.
#[test]
fn what_is_made_of_a_step_is_not_predicted_before_one() {
    let place = Workplace::new();
    place.write(
        "m.toml",
        "[time]\ncolumn = \"h\"\n[initial]\nx = \"normal(0, 1)\"\n[transition]\nx = \"normal(x, 1)\"\n\
         [measurement]\ny = \"normal(total(x), 0.5)\"\nz = \"normal(x, 1)\"\n",
    );
    place.write("d.csv", "h,y,z\n0,,0.1\n0,,0.2\n0,,0.3\n1,0.4,0.2\n");
    let table = place.printed(&["filter", "m.toml", "d.csv", "--predictive", "--quiet"]);
    let at = table.lines().next().unwrap().split(',').position(|name| name == "y_mean").unwrap();
    let means: Vec<&str> = table.lines().skip(1).map(|row| row.split(',').nth(at).unwrap()).collect();
    assert!(means[..3].iter().all(|mean| mean.is_empty()) && !means[3].is_empty(), "{means:?}");
}
