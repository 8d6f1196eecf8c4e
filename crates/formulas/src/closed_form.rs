//! Whether the best proposal is known in closed form.

use thiserror::Error;

use crate::error::{Section, in_line};
use crate::graph::{Built, Coordinate, Degree, Operation, Output};
use crate::statement::Line;
use crate::tables::Kind;

/// The first line because of which `p(x_t | x_{t−1}, y_t)` is no Gaussian in closed form.
#[derive(Debug, Clone, PartialEq, Error)]
#[error("{file}{}, {section} {key}: {reason}", in_line(*line))]
pub struct NoClosedForm {
    /// The model file.
    pub file: String,
    /// The line, from 1; none of a text that a program wrote.
    pub line: Option<usize>,
    /// The section, as `[measurement]`.
    pub section: &'static str,
    /// The coordinate: `y`, or `y[3]`.
    pub key: String,
    /// What the line has, and what it would need.
    pub reason: String,
}

/// Looks for the first coordinate of a section that stands in the way.
pub(crate) fn check(file: &str, section: Section, lines: &[Line], built: &Built) -> Result<(), NoClosedForm> {
    let degrees = built.graph.degrees();
    let names = lines.iter().flat_map(|line| (0..line.coordinates()).map(move |number| (line, number)));
    for ((line, number), output) in names.zip(&built.coordinates) {
        let text = line.formula.text.trim();
        let coordinate = match output {
            Output::Drawn(coordinate) => coordinate,
            Output::Made(made) => {
                let name = made.wrapper.name;
                let reason = format!("`{name}` is not normal; the closed form is for normal distributions");
                return Err(refusal(file, section, line, number, reason));
            }
            Output::Follows(_) => {
                let reason = format!("`{text}` has no noise; the closed form is for normal distributions");
                return Err(refusal(file, section, line, number, reason));
            }
        };
        let degree = |parameter: usize| degrees[coordinate.parameters[parameter].index()];
        let name = coordinate.family.name;
        let reason = if section == Section::Initial && varies(built, output) {
            format!("`{text}` depends on a coordinate above it; in the closed form it does not")
        } else if coordinate.family.kind != Kind::Normal {
            format!("`{name}` is not normal; the closed form is for normal distributions")
        } else if section != Section::Measurement {
            continue;
        } else if degree(0) == Degree::Other {
            format!("the mean of `{text}` is not linear in the states; the closed form needs it to be")
        } else if degree(1) != Degree::Zero {
            format!("the standard deviation of `{text}` depends on states; in the closed form it does not")
        } else {
            continue;
        };
        return Err(refusal(file, section, line, number, reason));
    }
    Ok(())
}

/// Of a model whose steps have draws: the first of them.
pub(crate) fn of_draws(file: &str, draw: &Line) -> NoClosedForm {
    let reason = format!(
        "`{}` is drawn apart from the coordinates; in the closed form each coordinate has its own distribution",
        draw.formula.text.trim()
    );
    refusal(file, Section::Draws, draw, 0, reason)
}

fn refusal(file: &str, section: Section, line: &Line, number: usize, reason: String) -> NoClosedForm {
    let (section, key) = (section.title(), line.coordinate(number));
    NoClosedForm { file: file.to_string(), line: Some(line.number), section, key, reason }
}

/// Whether a coordinate depends on states.
fn varies(built: &Built, output: &Output) -> bool {
    output.numbers().any(|number| built.graph.varies(number))
}

/// Whether the coordinates of a state have densities given the state before: each is drawn, independently of the others, and none is a count.
pub(crate) fn has_density(section: Section, built: &Built) -> bool {
    let is_continuous = |output: &Output| output.drawn().is_some_and(|drawn| !drawn.family.is_of_counts());
    let is_apart = |output: &Output| section != Section::Initial || !varies(built, output);
    built.draws.is_empty() && built.coordinates.iter().all(|output| is_continuous(output) && is_apart(output))
}

/// Whether a section is linear with constant Gaussian noise: normal coordinates with means that are linear in the states, standard deviations without them, and
/// no time.
pub(crate) fn is_linear(section: Section, built: &Built) -> bool {
    let degrees = built.graph.degrees();
    let degree =
        |coordinate: &Coordinate, parameter: usize| degrees[coordinate.parameters[parameter].index()];
    let is_constant = !built.graph.operations().iter().any(|operation| matches!(operation, Operation::Time));
    is_constant
        && (section == Section::Measurement || has_density(section, built))
        && !built.coordinates.iter().any(|output| matches!(output, Output::Made(_)))
        && built.coordinates.iter().filter_map(Output::drawn).all(|coordinate| {
            coordinate.family.kind == Kind::Normal
                && degree(coordinate, 0) <= Degree::One
                && degree(coordinate, 1) == Degree::Zero
        })
}
