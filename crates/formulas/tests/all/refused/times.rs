//! Times, inputs, series and totals: catches rows that are taken for others than they are.

use super::{FILE, MEASURE, changed, refused, transition};

/// [`FILE`] with another section before its states.
fn section(name: &str, lines: &str) -> String {
    changed(FILE, &[("[initial]", &format!("[{name}]\n{lines}\n[initial]"))])
}

fn time(lines: &str) -> String {
    section("time", lines)
}

fn inputs(lines: &str) -> String {
    changed(&section("inputs", lines), &[("normal(x, q)", "normal(x + u, q)")])
}

#[test]
fn a_unit_that_is_none() {
    insta::assert_snapshot!(refused(&time("unit = \"month\"\ncolumn = \"d\"")), @r#"m.toml, line 5, column 8, [time] unit: it is the text "month"; it must be "day", "week" or "year", for times that are dates"#);
}

#[test]
fn a_unit_without_a_column() {
    insta::assert_snapshot!(refused(&time("unit = \"day\"")), @r#"m.toml, line 5, column 8, [time] unit: it is the text "day"; it must be left out, or the column of the dates named beside it by column = …"#);
}

#[test]
fn a_column_that_is_no_name() {
    insta::assert_snapshot!(refused(&time("column = 3")), @"m.toml, line 5, column 10, [time] column: it is the number 3; it must be the name of a column of the data, in quotes");
}

#[test]
fn a_key_of_times_that_there_is_not() {
    insta::assert_snapshot!(refused(&time("colunm = \"d\"")), @"m.toml, line 5, column 1, [time]: a model file has no `colunm` here; did you mean `column`?");
    insta::assert_snapshot!(refused(&time("zone = \"UTC\"")), @"m.toml, line 5, column 1, [time]: a model file has no `zone` here; it has column, unit, step, start");
}

#[test]
fn a_step_that_is_none() {
    insta::assert_snapshot!(refused(&time("step = 0")), @"m.toml, line 5, column 8, [time] step: step is 0; it must be above 0");
    insta::assert_snapshot!(refused(&time("step = \"1/0\"")), @r#"m.toml, line 5, column 8, [time] step: it is the text "1/0", which is inf; it must be finite"#);
    insta::assert_snapshot!(refused(&time("step = \"daily\"")), @"m.toml, line 5, column 8, [time] step: `daily` is not known here; known are q, t, pi");
}

#[test]
fn a_start_that_is_a_date_without_a_unit() {
    insta::assert_snapshot!(refused(&time("column = \"d\"\nstart = \"2024-01-01\"")), @r#"m.toml, line 6, column 9, [time] start: it is the text "2024-01-01"; it must be a number; for dates give unit = "day", "week" or "year", too"#);
}

#[test]
fn a_start_that_is_a_time_of_day() {
    insta::assert_snapshot!(refused(&time("column = \"d\"\nunit = \"day\"\nstart = 12:30:00")), @"m.toml, line 7, column 9, [time] start: it is a date or time; it must be a number, or a date");
}

#[test]
fn an_input_between_rows_in_no_way() {
    insta::assert_snapshot!(refused(&inputs("u = \"cubic\"")), @r#"m.toml, line 5, column 5, [inputs] u: it is the text "cubic"; it must be "hold", "next" or "linear""#);
    insta::assert_snapshot!(refused(&inputs("u = { between = \"cubic\" }")), @r#"m.toml, line 5, column 17, [inputs] u: it is the text "cubic"; it must be "hold", "next" or "linear""#);
}

#[test]
fn an_input_of_a_row_before_that_is_between_rows() {
    insta::assert_snapshot!(refused(&inputs("u = { column = \"y\", between = \"linear\", rows = 1 }")), @"m.toml, line 5, column 21, [inputs] u: `between` is of an input without `rows`; it must be left out here");
}

#[test]
fn an_input_of_no_rows_before() {
    insta::assert_snapshot!(refused(&inputs("u = { column = \"y\", rows = 0 }")), @"m.toml, line 5, column 28, [inputs] u: it is the number 0; it must be a whole number of rows, from 1 to 10000");
}

#[test]
fn an_input_with_a_key_that_there_is_not() {
    insta::assert_snapshot!(refused(&inputs("u = { colum = \"y\" }")), @"m.toml, line 5, column 7, [inputs] u: a model file has no `colum` here; did you mean `column`?");
}

#[test]
fn an_input_that_is_a_state() {
    insta::assert_snapshot!(refused(&inputs("u = \"hold\"\nx = \"hold\"")), @"m.toml, line 8, column 1, [initial] x: `x` stands in [inputs], too; a name can mean one thing only");
}

#[test]
fn a_total_outside_measurements() {
    insta::assert_snapshot!(refused(&transition("normal(total(x), q)")), @"m.toml, line 7, column 13, [transition] x: `total` sums up what came since the row before; it belongs into a measurement");
}

#[test]
fn a_total_of_a_formula() {
    insta::assert_snapshot!(refused(&changed(FILE, &[(MEASURE, "y = \"normal(total(x + 1), 1)\"")])), @"m.toml, line 9, column 13, [measurement] y: `total` is of a formula; it must be of a draw or a state by its name, as in total(x) or total(x[2])");
}

#[test]
fn a_series_that_is_no_column() {
    insta::assert_snapshot!(refused(&section("series", "by = 3")), @"m.toml, line 5, column 6, [series] by: it is the number 3; it must be text in quotes");
    insta::assert_snapshot!(refused(&section("series", "of = \"animal\"")), @"m.toml, line 5, column 1, [series]: a model file has no `of` here; it has by");
}
