//! What a model says, for people.

use std::fmt;

use motes_models::{LinearGaussian, StateSpaceModel};

use crate::file::{FileModel, ModelFile};
use crate::frame::Frame;
use crate::model::FormulaModel;
use crate::statement::{Between, InputRule, InputSource, Line, TimeLabel, TimeRule, TimeUnit};

/// A model in groups of lines, each group with its title.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Description {
    /// Titles with their lines; no group is empty.
    pub groups: Vec<(String, Vec<String>)>,
}

impl Description {
    fn group(&mut self, title: &str, lines: Vec<String>) {
        if !lines.is_empty() {
            self.groups.push((title.to_string(), lines));
        }
    }
}

impl fmt::Display for Description {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (title, lines) in &self.groups {
            writeln!(formatter, "{title}")?;
            for line in lines {
                writeln!(formatter, "  {line}")?;
            }
        }
        Ok(())
    }
}

/// Keys and formulas, the formulas below each other: what is drawn has the sign ~, what follows the sign =.
fn lines(lines: &[Line]) -> Vec<String> {
    let width = lines.iter().map(|line| line.key.chars().count()).max().unwrap_or(0);
    let line = |line: &Line| {
        let formula: Vec<&str> = line.formula.text.split_whitespace().collect();
        let sign = if line.formula.has_noise() { "~" } else { "=" };
        format!("{:width$} {sign} {}", line.key, formula.join(" "))
    };
    lines.iter().map(line).collect()
}

/// What `[time]` says.
fn times(rule: &TimeRule) -> Vec<String> {
    let mut found = Vec::new();
    let unit = match rule.unit {
        None => "numbers",
        Some(TimeUnit::Day) => "dates, in days",
        Some(TimeUnit::Week) => "dates, in weeks",
        Some(TimeUnit::Year) => "dates, in years",
    };
    found.push(match &rule.column {
        Some(column) => format!("column {column}: {unit}"),
        None => "rows are at 0, 1, 2, …".to_string(),
    });
    found.extend(rule.step.map(|step| format!("sub-steps of at most {step}")));
    found.extend(rule.start.as_ref().map(|start| match start {
        TimeLabel::Number(number) => format!("x_0 is at {number}"),
        TimeLabel::Date(date) => format!("x_0 is at {date}"),
    }));
    found
}

/// What `[inputs]` says of an input.
fn input(rule: &InputRule) -> String {
    let between = match rule.between {
        Between::Hold => "the value before",
        Between::Next => "the next value",
        Between::Linear => "straight lines between values",
    };
    let name = &rule.name;
    match &rule.source {
        InputSource::Column(column) => format!("{name}: column {column}, {between}"),
        InputSource::File { path, column } => format!("{name}: column {column} of {path}, {between}"),
        InputSource::Lag { column, rows: 1, .. } => format!("{name}: column {column}, a row before"),
        InputSource::Lag { column, rows, .. } => format!("{name}: column {column}, {rows} rows before"),
    }
}

impl Frame {
    /// The times and the inputs.
    fn describe_data(&self, description: &mut Description) {
        description.group("times", self.time_rule().map(times).unwrap_or_default());
        description.group("inputs", self.inputs().iter().map(input).collect());
    }

    /// The parameters with their values and priors.
    fn describe_parameters(&self, description: &mut Description) {
        let width = self.parameters().iter().map(|(name, _)| name.chars().count()).max().unwrap_or(0);
        let parameter = |(name, value): &(String, f64)| {
            let prior = self.priors().iter().find(|prior| prior.entries().contains(name));
            let prior = prior.map_or_else(String::new, |prior| format!(", with the prior {}", prior.text()));
            format!("{name:width$} = {value}{prior}")
        };
        description.group("parameters", self.parameters().iter().map(parameter).collect());
    }

    /// What it says around the groups of what it is the frame of.
    pub fn describe(&self, groups: Vec<(String, Vec<String>)>) -> Description {
        let mut description = Description::default();
        self.describe_data(&mut description);
        description.groups.extend(groups);
        self.describe_parameters(&mut description);
        description
    }
}

impl FormulaModel {
    /// The distributions of the coordinates, the definitions, and the parameters with their values.
    pub fn describe(&self) -> Description {
        let mut equations = Description::default();
        let statement = self.statement();
        equations.group("p(x_0)", lines(&statement.initial));
        equations.group("draws of a step", lines(&statement.draws));
        equations.group("p(x_t | x_{t-1})", lines(&statement.transition));
        equations.group("p(y_t | x_t)", lines(&statement.measurement));
        equations.group("definitions", lines(&statement.definitions));
        self.frame().describe(equations.groups)
    }
}

impl ModelFile {
    /// The model's coordinates and what they are distributed as.
    pub fn describe(&self) -> Description {
        match &self.model {
            FileModel::Formulas(model) => model.describe(),
            FileModel::LinearGaussian(model) => of_matrices(self, model),
        }
    }
}

fn of_matrices(file: &ModelFile, model: &LinearGaussian) -> Description {
    let mut description = Description::default();
    let (n, m) = (model.state_dim(), model.measurement_dim());
    description.group("states x", vec![file.states.join(", ")]);
    description.group("measurements y", vec![file.measurements.join(", ")]);
    let equations = [
        "x_0 ~ N(m0, P0)".to_string(),
        format!("x_t = A x_{{t-1}} + N(0, Q), A and Q {n}×{n}"),
        format!("y_t = C x_t + N(0, R), C {m}×{n}, R {m}×{m}"),
    ];
    description.group("equations", equations.to_vec());
    description
}
