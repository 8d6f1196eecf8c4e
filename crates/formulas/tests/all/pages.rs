//! What people read: a model described, and the reference of functions and distributions.

use motes_formulas::{parse, reference};

/// Catches a line that is lost, or in the wrong section.
#[test]
fn a_model_is_described() {
    let text = r#"
name = "m"
[parameters]
q = 10.0
rate = 0.5
[initial]
x[3] = "normal(0, sqrt(q))"
level = "gamma(2, 1)"
[definitions]
mean_x = """x[0]
    + x[1]"""
[transition]
level = "level*log_normal(0, 0.1)"
x[3] = "normal(rate*x[i-1], 1)"
[measurement]
count = "poisson(level)"
"#;
    let file = parse(text, "m.toml", &[("q".into(), 0.25)]).unwrap();
    insta::assert_snapshot!(file.describe(), @r"
    p(x_0)
      x[3]  ~ normal(0, sqrt(q))
      level ~ gamma(2, 1)
    p(x_t | x_{t-1})
      x[3]  ~ normal(rate*x[i-1], 1)
      level ~ level*log_normal(0, 0.1)
    p(y_t | x_t)
      count ~ poisson(level)
    definitions
      mean_x = x[0] + x[1]
    parameters
      q    = 0.25
      rate = 0.5
    ");
}

#[test]
fn matrices_are_described() {
    let text = "kind = 'linear-gaussian'\nstates = ['a', 'b']\nmeasurements = ['y']\nm0 = [0, 0]\nP0 = [[1, 0], [0, 1]]\n\
                A = [[1, 0], [0, 1]]\nQ = [[1, 0], [0, 1]]\nC = [[1, 0]]\nR = [[1]]";
    insta::assert_snapshot!(parse(text, "m.toml", &[]).unwrap().describe(), @r"
    states x
      a, b
    measurements y
      y
    equations
      x_0 ~ N(m0, P0)
      x_t = A x_{t-1} + N(0, Q), A and Q 2×2
      y_t = C x_t + N(0, R), C 1×2, R 1×1
    ");
}

/// Catches a row that the parser does not know, and one that it knows otherwise.
#[test]
fn the_reference_is_what_the_parser_accepts() {
    let page = reference();
    let rows: Vec<&str> = page.lines().filter(|line| line.starts_with("| `")).collect();
    assert_eq!(rows.len(), 25 + 2 + 12 + 8 + 8, "{page}");
    for row in rows {
        let call = row.split('`').nth(1).unwrap();
        let (name, parameters) = call.split_once('(').unwrap_or((call, ")"));
        let parameters = parameters.trim_end_matches(')').split(", ");
        let count = parameters.filter(|name| !name.is_empty() && *name != "…").count();
        let arguments = match name {
            "mvnormal" => "[0], [[1]]".to_string(),
            _ => ["0.25", "0.5", "1"][..count].join(", "),
        };
        // Trials are an integer, probabilities add up to 1, and a sum goes along a vector.
        let used = format!("{name}({arguments})")
            .replace("nomial(0.25, 0.5)", "nomial(1, 0.5)")
            .replace("categorical(0.25", "categorical(0.5")
            .replace("truncated(0.25", "truncated(normal(0, 1)")
            .replace("sum(0.25, 0.5)", "sum(j, x[j])")
            .replace("pi()", "pi");
        let tables: Vec<&str> = page.split("|---|---|").collect();
        let wrapped = tables[3].contains(row);
        // Distributions and ends that are in order.
        let used = if wrapped {
            let argument = |name: &str| match name {
                "d" | "d1" | "d2" => "normal(x[0], 1)",
                "low" => "-inf",
                _ => "0.5",
            };
            let (_, rest) = call.split_once('(').unwrap();
            let arguments: Vec<&str> = rest.trim_end_matches(')').split(", ").map(argument).collect();
            format!("{name}({})", arguments.join(", "))
        } else {
            used
        };
        let is_distribution = wrapped || tables[2].contains(row);
        let is_drawn = row.contains("for draws") || row.contains("states and draws");
        let (more, formula) = match is_distribution {
            true if row.contains("for priors") => {
                (format!("[parameters]\nq = \"{used}\""), "normal(0, 1)".into())
            }
            true if is_drawn => (format!("[draws]\nd = \"{used}\""), "normal(0, 1)".into()),
            true => (String::new(), used),
            false => (String::new(), format!("normal({used}, 1)")),
        };
        let text = format!(
            "[initial]\nx[1] = \"normal(0, 1)\"\n[transition]\nx[1] = \"normal(x[0], 1)\"\n[measurement]\ny = \"{formula}\"\n{more}\n"
        );
        if let Err(error) = parse(&text, "m.toml", &[]) {
            panic!("{error}");
        }
    }
}

/// The page is made of what the parser accepts: its tables are those of [`reference`], and its examples are models.
#[test]
fn the_page_on_model_files_is_current() {
    let page = include_str!("../../../../docs/model-files.md");
    let tables = reference();
    assert!(page.ends_with(&tables), "docs/model-files.md has to end with:\n{tables}");
    let blocks = page.split("```toml\n").skip(1).map(|block| block.split("```").next().unwrap());
    let mut count = 0;
    for block in blocks {
        parse(block, "model-files.md", &[]).unwrap();
        count += 1;
    }
    assert_eq!(count, 8);
}

#[test]
fn the_recipes_are_models() {
    let page = include_str!("../../../../docs/recipes.md");
    let blocks: Vec<&str> =
        page.split("```toml\n").skip(1).map(|block| block.split("```").next().unwrap()).collect();
    assert_eq!(blocks.len(), page.matches("\n## ").count());
    for block in blocks {
        let file = parse(block, "recipes.md", &[]).unwrap();
        assert!(file.text.lines().count() <= 14, "{block}");
    }
}
