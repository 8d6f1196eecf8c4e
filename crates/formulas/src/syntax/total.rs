//! What measurements use of the sub-steps since the row before: totals, and draws of the last one.

use super::meaning::Meaning;
use crate::error::Problem;

/// When a total begins anew.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Since {
    /// At each sub-step: it is a value alone, that of the last one.
    SubStep,
    /// At each row.
    Row,
    /// At each row where an entry of the measurement was there.
    Measured(usize),
}

/// A total over sub-steps of a draw or a state, or of all coordinates of a vector one by one.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Total {
    /// As it is written: `total(x)`.
    pub(crate) name: String,
    pub(crate) since: Since,
    /// Whether it is of draws, and not of states.
    pub(crate) is_of_draws: bool,
    /// The first state, or the first draw.
    pub(crate) first: usize,
    pub(crate) length: Option<usize>,
}

impl Total {
    /// How many coordinates it has.
    pub(crate) fn coordinates(&self) -> usize {
        self.length.unwrap_or(1)
    }

    /// The name of a coordinate: `total(x)`, or `total(x[2])`.
    pub(crate) fn coordinate(&self, number: usize) -> String {
        match (self.length, self.name.strip_suffix(')')) {
            (None, _) => self.name.clone(),
            (Some(_), Some(open)) => format!("{open}[{number}])"),
            (Some(_), None) => format!("{}[{number}]", self.name),
        }
    }
}

/// All totals of a model: behind the states, in order.
#[derive(Debug, Clone, Default)]
pub(crate) struct Totals {
    pub(crate) all: Vec<Total>,
    /// How many states there are.
    pub(crate) states: usize,
}

impl Totals {
    /// How many numbers they are.
    pub(crate) fn count(&self) -> usize {
        self.all.iter().map(Total::coordinates).sum()
    }

    /// Where the first coordinate of a total stands behind the states; it is added where it is not there.
    pub(super) fn place_of(&mut self, total: Total) -> usize {
        let known = self.all.iter().position(|known| *known == total);
        let before = known.unwrap_or(self.all.len());
        let place = self.states + self.all[..before].iter().map(Total::coordinates).sum::<usize>();
        if known.is_none() {
            self.all.push(total);
        }
        place
    }

    /// The total of what a name means.
    pub(super) fn of(
        &self,
        function: &'static str,
        name: &str,
        meaning: Option<&Meaning>,
        since: Since,
    ) -> Result<Total, Problem> {
        let (is_of_draws, first, length) = match meaning {
            Some(&Meaning::State { first, length }) => (false, first, length),
            Some(&Meaning::Draw { first, length }) => (true, first - self.states, length),
            _ => return Err(Problem::TotalOf { name: function, found: format!("`{name}`") }),
        };
        let name = if function.is_empty() { name.to_string() } else { format!("{function}({name})") };
        Ok(Total { name, since, is_of_draws, first, length })
    }
}

/// The functions of totals, with what they mean.
pub(super) fn function(name: &str) -> Option<&'static str> {
    ["total", "total_since_measured"].into_iter().find(|known| *known == name)
}
