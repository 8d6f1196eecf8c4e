//! What becomes of each coordinate of the state in a step.

use std::fmt;

use crate::model::FormulaModel;
use crate::statement::Line;

/// The coordinates of the state by what becomes of them in a step, each by its name; a vector by its own.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Coordinates {
    /// Those with a distribution.
    pub drawn: Vec<String>,
    /// Those with a formula.
    pub followed: Vec<String>,
    /// Those that stay what they are.
    pub constant: Vec<String>,
}

impl fmt::Display for Coordinates {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let groups = [
            (&self.drawn, ["is drawn", "are drawn"]),
            (&self.followed, ["follows", "follow"]),
            (&self.constant, ["is constant", "are constant"]),
        ];
        let groups = groups.into_iter().filter(|(names, _)| !names.is_empty());
        let groups: Vec<String> = groups
            .map(|(names, [one, more])| {
                format!("{} {}", names.join(", "), if names.len() == 1 { one } else { more })
            })
            .collect();
        formatter.write_str(&groups.join("; "))
    }
}

impl FormulaModel {
    /// What becomes of each coordinate in a step.
    pub fn coordinates(&self) -> Coordinates {
        let mut coordinates = Coordinates::default();
        for line in &self.statement().transition {
            let group = match line.formula.has_noise() {
                true => &mut coordinates.drawn,
                false if is_itself(line) => &mut coordinates.constant,
                false => &mut coordinates.followed,
            };
            group.push(line.key.clone());
        }
        coordinates
    }
}

/// Whether a coordinate is what it was: `k = "k"`, or `x[3] = "x[i]"`.
fn is_itself(line: &Line) -> bool {
    let text: String = line.formula.text.split_whitespace().collect();
    match line.length {
        None => text == line.name,
        Some(_) => text == format!("{}[i]", line.name),
    }
}
