//! The order of definitions: each after those that it uses.

use super::lines::Line;
use crate::error::{ComposedProblem, Problem};

/// Whether a definition has been ordered.
#[derive(Clone, Copy, PartialEq)]
enum Mark {
    New,
    /// Those that it uses are being ordered.
    Open,
    Done,
}

/// How deep functions may call each other.
const DEEPEST: usize = 100;

/// The numbers of the definitions in an order in which they can be computed, or one that is in a circle.
pub(super) fn of(definitions: &[Line]) -> Result<Vec<usize>, (usize, Problem)> {
    let uses: Vec<Vec<usize>> = definitions.iter().map(|line| line.formula.definitions().collect()).collect();
    let mut marks = vec![Mark::New; definitions.len()];
    let mut order = Vec::with_capacity(definitions.len());
    for start in 0..definitions.len() {
        // Those that are open, each with how many of those that it uses have been looked at.
        let mut open = if marks[start] == Mark::New { vec![(start, 0)] } else { Vec::new() };
        while let Some((number, seen)) = open.last_mut() {
            let number = *number;
            marks[number] = Mark::Open;
            let Some(&used) = uses[number].get(*seen) else {
                marks[number] = Mark::Done;
                order.push(number);
                open.pop();
                continue;
            };
            *seen += 1;
            match marks[used] {
                Mark::New => open.push((used, 0)),
                Mark::Done => {}
                Mark::Open => {
                    let from = open.iter().position(|(number, _)| *number == used).unwrap_or(0);
                    let circle = open[from..].iter().map(|(number, _)| *number).chain([used]);
                    let names: Vec<&str> = circle.map(|number| definitions[number].name.as_str()).collect();
                    return Err((used, Problem::Cycle(names.join(" → "))));
                }
            }
        }
    }
    let mut depths = vec![0; definitions.len()];
    for &number in &order {
        // The value of a definition is known before it is used.
        if !definitions[number].arguments.is_empty() {
            depths[number] = 1 + uses[number].iter().map(|used| depths[*used]).max().unwrap_or(0);
        }
        if depths[number] > DEEPEST {
            return Err((number, Problem::Composed(ComposedProblem::CallsTooDeep(DEEPEST))));
        }
    }
    Ok(order)
}
