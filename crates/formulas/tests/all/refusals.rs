//! The page of refusals is what the tests of refusals say: each mistake, its line, and the test that shows it.

use std::fmt::Write;

/// What the files are about, their names and texts.
const FILES: [(&str, &str, &str); 12] = [
    ("Files", "paths", include_str!("refused/paths.rs")),
    ("TOML", "files", include_str!("refused/files.rs")),
    ("Grammar", "formulas", include_str!("refused/formulas.rs")),
    ("Names", "names", include_str!("refused/names.rs")),
    ("Functions of one's own", "functions", include_str!("refused/functions.rs")),
    ("Distributions", "noise", include_str!("refused/noise.rs")),
    ("Distributions of measurements", "wrapped", include_str!("refused/wrapped.rs")),
    ("Vectors and indices", "vectors", include_str!("refused/vectors.rs")),
    ("Matrices", "matrices", include_str!("refused/matrices.rs")),
    ("Times, inputs and series", "times", include_str!("refused/times.rs")),
    ("Priors", "priors", include_str!("refused/priors.rs")),
    ("Parameters set from outside", "overrides", include_str!("refused/overrides.rs")),
];

/// The lines that a test expects.
fn lines(test: &str) -> Vec<&str> {
    let plain = test.split(", @\"").skip(1).filter_map(|rest| rest.split_once("\")").map(|(line, _)| line));
    let raw = test.split(", @r#\"").skip(1).filter_map(|rest| rest.split_once("\"#)").map(|(line, _)| line));
    plain.chain(raw).collect()
}

/// The table of a file's tests.
fn table(file: &str, text: &str) -> String {
    let mut table = "| mistake | the line | test |\n|---|---|---|\n".to_string();
    for test in text.split("#[test]\nfn ").skip(1) {
        let (name, body) = test.split_once("()").unwrap();
        let shown: Vec<String> =
            lines(body).iter().map(|line| format!("`` {} ``", line.replace('|', "\\|"))).collect();
        writeln!(table, "| {} | {} | `{file}::{name}` |", name.replace('_', " "), shown.join("<br>"))
            .unwrap();
    }
    table
}

/// Catches a refusal that the page does not have, or shows otherwise.
#[test]
fn the_page_is_what_the_tests_say() {
    let page = include_str!("../../../../docs/refusals.md");
    let mut count = 0;
    for (title, file, text) in FILES {
        let table = table(file, text);
        let section = format!("## {title}\n\n{table}");
        assert!(page.contains(&section), "docs/refusals.md has to contain:\n{section}");
        count += text.matches("#[test]").count();
    }
    assert_eq!(page.matches("\n| ").count(), count + FILES.len(), "rows without a test");
}
