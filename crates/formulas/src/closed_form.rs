//! Whether the best proposal is known in closed form.

use thiserror::Error;

use crate::error::{Section, in_line};
use crate::graph::{Built, Coordinate, Degree, Output};
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
            other => {
                let what = if other.drawn_from().is_some() { "is not normal" } else { "has no noise" };
                let reason = format!("`{text}` {what}; the closed form is for normal distributions");
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

/// Of a model whose steps are cut into sub-steps: the first line of `[transition]`.
pub(crate) fn of_sub_steps(file: &str, line: &Line) -> NoClosedForm {
    let reason = "it is made of several sub-steps between two rows; in the closed form it is one";
    refusal(file, Section::Transition, line, 0, reason.to_string())
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

/// Whether a section is linear with Gaussian noise: what is drawn is normal, with a mean that is linear in states and draws, and a standard deviation without them; what
/// follows is linear in them.
pub(crate) fn is_linear(built: &Built) -> bool {
    let degrees = built.graph.degrees();
    let degree =
        |coordinate: &Coordinate, parameter: usize| degrees[coordinate.parameters[parameter].index()];
    built.draws.iter().chain(&built.coordinates).all(|output| match output {
        Output::Follows(id) => degrees[id.index()] <= Degree::One,
        Output::Computed { .. } | Output::Made(_) => false,
        Output::Drawn(coordinate) => {
            matches!(coordinate.family.kind, Kind::Normal | Kind::Exact)
                && degree(coordinate, 0) <= Degree::One
                && degree(coordinate, 1) == Degree::Zero
        }
    })
}

/// The first coordinate whose standard deviation is 0, whatever the states are.
pub(crate) fn without_noise(built: &Built) -> Option<usize> {
    built.coordinates.iter().position(|output| match output {
        Output::Drawn(coordinate) => coordinate.family.kind == Kind::Exact,
        _ => false,
    })
}

/// Whether all that is drawn has finitely many values: it is a bernoulli, a binomial, or made of such, or a categorical.
pub(crate) fn is_finite(built: &Built) -> bool {
    built.draws.iter().chain(&built.coordinates).all(|output| match output {
        Output::Follows(_) | Output::Computed { .. } => true,
        Output::Drawn(coordinate) => matches!(coordinate.family.kind, Kind::Bernoulli | Kind::Binomial),
        Output::Made(_) => false,
    })
}
