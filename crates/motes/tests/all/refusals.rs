//! Bad input: one line, an exit status, nothing written.

use crate::common::{Workplace, stderr};

/// Runs, and expects a status and a line; nothing is on standard output, and the files that were there are as they were.
fn refused(place: &Workplace, arguments: &[&str], status: i32, line: &str) {
    place.write("out.csv", "as it was");
    let output = place.run(arguments);
    assert_eq!(stderr(&output), format!("motes: {line}"), "{arguments:?}");
    assert_eq!(output.status.code(), Some(status), "{arguments:?}: {line}");
    assert!(output.stdout.is_empty(), "{arguments:?}");
    assert_eq!(place.read("out.csv"), "as it was");
}

#[test]
fn data_that_are_no_data() {
    let place = Workplace::new();
    let cases: [(&[u8], &str); 18] = [
        (
            b"y\n1\nNaN\n",
            "d.csv, line 3, column y: NaN is no measurement; leave the cell empty where one is missing",
        ),
        (
            b"y\n-inf\n",
            "d.csv, line 2, column y: -inf is not finite; leave the cell empty where a measurement is missing",
        ),
        (b"y\n1e999\n", "d.csv, line 2, column y: 1e999 is beyond the largest number of 64 bits, 1.8e308"),
        (b"y\n\"3,5\"\n", "d.csv, line 2, column y: 3,5 has a decimal comma; write a point"),
        (
            b"y\n3,5\n",
            "d.csv, line 2: the row has 2 cells, the header 1; a decimal comma, or a comma in a text without quotes?",
        ),
        (b"z\n1\n", "d.csv, line 1: there is no column y, which the model measures; there are z"),
        (b"Y\n1\n", "d.csv, line 1: there is no column y, which the model measures; there are Y; is it Y?"),
        (
            b"a;y\n1;2\n",
            "d.csv, line 1: there is no column y, which the model measures; there are a;y; columns are separated by commas",
        ),
        (b"y,y\n1,2\n", "d.csv, line 1: there are two columns y; names must differ"),
        (b"ess,y\n1,2\n", "d.csv, line 1, column ess: results have a column of that name; give it another"),
        (b"", "d.csv: there are no rows; a header and a row for each time are needed"),
        (b"y\n", "d.csv: there are no rows; a header and a row for each time are needed"),
        (
            b"y\nabc\n",
            "d.csv, line 2, column y: abc is no number; leave the cell empty, or write NA, where a measurement is missing",
        ),
        (b"y\n\xff\n", "d.csv, line 2: this is not UTF-8 text; save the file in that encoding"),
        (b"\xff,y\n1,1\n", "d.csv, line 1: this is not UTF-8 text; save the file in that encoding"),
        (
            b"t,y\n0,1\n2,3\n",
            "d.csv, line 3, column t: 2, where 1 is next; t counts 0, 1, 2, … in each series, and a time without measurement has empty cells",
        ),
        (b"a,y\n1\n", "d.csv, line 2: the row has 1 cells, the header 2"),
        (b"y\n1\n\n2\n", "d.csv, line 3: the line is blank; write NA where a measurement is missing"),
    ];
    for (bytes, line) in cases {
        place.write("d.csv", bytes);
        for command in ["filter", "smooth"] {
            refused(&place, &[command, "walk.toml", "d.csv", "-o", "out.csv"], 2, line);
        }
    }
}

#[test]
fn options_that_cannot_be() {
    let place = Workplace::new();
    let cases: [(&[&str], &str); 13] = [
        (&["--particles", "0"], "--particles 0: it must be an integer from 1 to 1000000000"),
        (&["--particles", "ten"], "--particles ten: it must be an integer from 1 to 1000000000"),
        (
            &["--proposal", "foo"],
            "--proposal foo: there are bootstrap, linearised, optimal, look-ahead, exact, and there is no such folder",
        ),
        (
            &["--proposal", "linearized"],
            "--proposal linearized: did you mean linearised? there are bootstrap, linearised, optimal, look-ahead, exact, and there is no such folder",
        ),
        (&["--defensive", "1"], "--defensive 1: it must be a number from 0 to below 1"),
        (&["--resample-below", "0"], "--resample-below 0: it must be a number above 0 and at most 1"),
        (
            &["--resampling", "sys"],
            "--resampling sys: there are multinomial, systematic, stratified, residual",
        ),
        (&["--set", "noise"], "--set noise: it must be NAME=VALUE"),
        (&["--set", "noise=a"], "--set noise=a: a is no number; it must be NAME=VALUE"),
        (&["--set", "noise=inf"], "--set noise=inf: inf is not finite"),
        (&["--threads", "0"], "--threads 0: it must be an integer from 1 to 1024"),
        (&["--threads", "5000"], "--threads 5000: it must be an integer from 1 to 1024"),
        (
            &["--particles", "999999999"],
            "the number of values in a bank, filters × particles × N is 1 × 999999999 × 1; it must be at least 1 and as many as there is memory for",
        ),
    ];
    for (options, line) in cases {
        refused(&place, &[&["filter", "walk.toml", "d.csv", "-o", "out.csv"], options].concat(), 2, line);
    }
    refused(&place, &[], 2, "no command is given; see motes --help");
    let needed = "the following required arguments were not provided: --steps <T>; see motes --help";
    refused(&place, &["simulate", "walk.toml"], 2, needed);
}

#[test]
fn files_that_cannot_be_read_or_written() {
    let place = Workplace::new();
    refused(&place, &["filter", "walk.toml", "."], 3, ".: this is a folder; data are a file");
    refused(&place, &["filter", "walk.toml", "none.csv"], 3, "none.csv: there is no such file");
    refused(&place, &["filter", ".", "d.csv"], 3, ".: this is a folder; a model is a file");
    refused(&place, &["filter", "none.toml", "d.csv"], 3, "none.toml: there is no such file");
    let nowhere = "none/out.csv: No such file or directory (os error 2)";
    refused(&place, &["filter", "walk.toml", "d.csv", "-o", "none/out.csv"], 3, nowhere);
    refused(
        &place,
        &["filter", "walk.toml", "d.csv", "-o", "out.csv", "--report", "none/out.csv"],
        3,
        nowhere,
    );
    refused(&place, &["simulate", "walk.toml", "--steps", "3", "-o", "none/out.csv"], 3, nowhere);
    refused(&place, &["filter", "walk.toml", "d.csv", "-o", "."], 3, ".: is a directory");
}

#[test]
fn measurements_that_no_state_explains() {
    let place = Workplace::new();
    place.write("d.csv", "series,y\na,1\nb,2\nb,1e300\n");
    let line = "d.csv, series b, line 4, t = 1: no particle explains the measurement: y is 1e300, where the particles predict ";
    let output = place.run(&["filter", "walk.toml", "d.csv", "-o", "out.csv"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(stderr(&output).starts_with(&format!("motes: {line}")), "{}", stderr(&output));
    assert!(!place.path("out.csv").exists());
}

#[test]
fn a_formula_that_leaves_its_domain_is_named() {
    let place = Workplace::new();
    let text = "[initial]\nx = \"normal(1, 0.1)\"\n[transition]\nx = \"normal(sqrt(x) - 0.5, 0.1)\"\n[measurement]\ny = \"normal(x, 1)\"\n";
    place.write("root.toml", text);
    place.write("d.csv", "y\n1\n0.5\n0.3\n0.2\n0.1\n0\n");
    let output = place.run(&["filter", "root.toml", "d.csv"]);
    assert_eq!(output.status.code(), Some(2));
    let said = stderr(&output);
    assert!(
        said.starts_with("motes: d.csv, line ")
            && said.contains(": root.toml, line 4, [transition] x: `sqrt(x)` is NaN where x = -"),
        "{said}"
    );
}

#[test]
fn a_proposal_that_the_model_does_not_have() {
    let place = Workplace::new();
    place.write("square.toml", crate::common::WALK.replace("normal(x, noise)", "normal(x^2, noise)"));
    let line = "--proposal optimal: square.toml, line 9, [measurement] y: the mean of `normal(x^2, noise)` is not linear in the states; the closed form \
                needs it to be; take --proposal linearised";
    refused(&place, &["filter", "square.toml", "d.csv", "--proposal", "optimal"], 2, line);
}

#[test]
fn states_that_are_too_many_for_exact_answers() {
    let place = Workplace::new();
    place.write(
        "epidemic.toml",
        "[initial]\nI = 2000\n[transition]\nI = \"binomial(2*I, 0.6)\"\n[measurement]\ny = \"poisson(I + 1)\"\n",
    );
    let rows = ["2000"; 4].join("\n");
    place.write("d.csv", format!("y\n{rows}\n"));
    let output = place.run(&["filter", "epidemic.toml", "d.csv", "--proposal", "exact"]);
    assert_eq!(output.status.code(), Some(2));
    let said = stderr(&output);
    assert!(said.contains("; take --proposal bootstrap") && said.contains(" is above "), "{said}");
    let checked = place.printed(&["check", "epidemic.toml"]);
    assert!(checked.contains("exact: no, although the states are discrete: t = "), "{checked}");
}

/// A name that formulas do not know may be a column of the data.
#[test]
fn a_column_that_is_no_input() {
    let place = Workplace::new();
    place.write("walk.toml", crate::common::WALK.replace("0.9*x", "0.9*x + u"));
    place.write("d.csv", "y,u\n1,2\n");
    let line = "walk.toml, line 7, column 21, [transition] x: `u` is a column of d.csv; formulas can use it where [inputs] has it, as in u = \"hold\"";
    for command in ["filter", "smooth", "check"] {
        refused(&place, &[command, "walk.toml", "d.csv"], 2, line);
    }
    let line =
        "walk.toml, line 7, column 21, [transition] x: `u` is not known here; known are noise, x, t, pi";
    refused(&place, &["check", "walk.toml"], 2, line);
}

/// Each of what `[time]` and `[inputs]` can get wrong with a file of inputs.
#[test]
fn a_file_of_inputs_that_does_not_reach() {
    let place = Workplace::new();
    let model = |rule: &str| {
        format!(
            "[time]\ncolumn = \"day\"\nunit = \"day\"\n[inputs]\nu = {{ file = \"u.csv\", between = \"linear\"{rule} }}\n[initial]\nx = 0\n[transition]\nx = \"x + u\"\n[measurement]\ny = \"normal(x, 1)\"\n"
        )
    };
    place.write("d.csv", "day,y\n2024-03-01,1\n2024-03-02,1\n2024-03-03,1\n2024-03-04,1\n");
    place.write("u.csv", "day,u\n2024-03-01,1\n2024-03-02,2\n");
    place.write("m.toml", model(""));
    let cure =
        "give it more rows, or beyond = \"hold\" in [inputs], which takes its first and its last value there";
    let line = format!(
        "d.csv, line 5, column day: u.csv has u from 2024-03-01 to 2024-03-02, and 2024-03-03 is needed; {cure}"
    );
    refused(&place, &["filter", "m.toml", "d.csv"], 2, &line);
    // Behind it the series goes on, and another one even farther.
    place.write(
        "two.csv",
        "series,day,y\na,2024-03-01,1\na,2024-03-03,1\na,2024-03-05,1\na,2024-03-06,1\nb,2024-04-01,1\n",
    );
    let line = format!(
        "two.csv, line 4, column day: u.csv has u from 2024-03-01 to 2024-03-02, and 2024-03-03 is needed, and the rows go on to 2024-03-06; {cure}"
    );
    refused(&place, &["filter", "m.toml", "two.csv"], 2, &line);
    place.write("m.toml", model(", lag = 4"));
    let line = format!(
        "d.csv, line 3, column day: u.csv has u from 2024-03-01 to 2024-03-02, and 2024-02-26 is needed, as it lags by 4; {cure}"
    );
    refused(&place, &["filter", "m.toml", "d.csv"], 2, &line);
    place.write("u.csv", "day,u\n2024-03-01,1\n2024-03-02,\n");
    let line = "u.csv: line 3, column u: an empty cell is no number; an input has one in each row";
    refused(&place, &["filter", "m.toml", "d.csv"], 2, line);
}

/// Probabilities and indices at a particle.
#[test]
fn numbers_that_particles_cannot_have() {
    let place = Workplace::new();
    let model = |step: &str, y: &str| {
        format!(
            "[parameters]\nm = [1, 2]\n[initial]\nx = 0\n[transition]\nx = \"{step}\"\n[measurement]\ny = \"{y}\"\n"
        )
    };
    place.write("d.csv", "y\n1\n2\n3\n");
    for (step, y, line) in [
        (
            "x + 1",
            "normal(m[x], 1)",
            "d.csv, line 4, t = 2: m.toml, line 8, [measurement] y: an index of m[x], `x`, is 2; it must be an integer from 0 to 1",
        ),
        (
            "x + 0.5",
            "normal(m[x], 1)",
            "d.csv, line 3, t = 1: m.toml, line 8, [measurement] y: an index of m[x], `x`, is 0.5; it must be an integer from 0 to 1",
        ),
        (
            "categorical(0.6, 0.6 + 0*x)",
            "normal(x, 1)",
            "d.csv, line 3, t = 1: m.toml, line 6, [transition] x: the sum of the probabilities, `categorical(0.6, 0.6 + 0*x)`, is 1.2 where x = 0; it must be 1",
        ),
        (
            "categorical(0.6, 0.6)",
            "normal(x, 1)",
            "m.toml, line 6, column 6, [transition] x: the sum of the probabilities of categorical(p0, p1, …) is 1.2; it must be 1",
        ),
    ] {
        place.write("m.toml", model(step, y));
        for proposal in ["bootstrap", "exact"] {
            refused(&place, &["filter", "m.toml", "d.csv", "--proposal", proposal], 2, line);
        }
    }
    place.write("m.toml", model("x", "binomial(10, 0.5)"));
    for value in ["4.5", "11", "-1"] {
        place.write("d.csv", format!("y\n5\n{value}\n"));
        let line = format!(
            "d.csv, line 3, column y: {value} is no value of binomial(10, 0.5): a count is a whole number from 0 to 10"
        );
        refused(&place, &["filter", "m.toml", "d.csv"], 2, &line);
    }
}
