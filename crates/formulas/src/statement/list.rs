//! Parameters that are lists.

use crate::document::{Found, Value};
use crate::error::Problem;

/// How deep lists of lists may be.
const DEEPEST: usize = 3;

/// A parameter that is a list of numbers, or of lists of the same length.
#[derive(Debug, Clone)]
pub(crate) struct List {
    pub(crate) name: String,
    /// Where its entries stand among all parameters.
    pub(super) start: usize,
    /// How many entries there are along each index.
    pub(crate) lengths: Vec<usize>,
    /// The last index varies first.
    pub(crate) values: Vec<f64>,
    /// For each entry, the number of the state that it is, where each particle has one of its own.
    pub(crate) states: Vec<Option<usize>>,
}

impl List {
    pub(super) fn new(name: &str, start: usize, lengths: Vec<usize>, values: Vec<f64>) -> Self {
        List { name: name.to_string(), start, lengths, states: vec![None; values.len()], values }
    }

    /// Whether one of its entries stands at that place among all parameters.
    pub(super) fn has(&self, place: usize) -> bool {
        (self.start..self.start + self.values.len()).contains(&place)
    }

    /// The entry with these indices, if there is one.
    pub(crate) fn entry(&self, indices: &[f64]) -> Option<f64> {
        let mut at = 0;
        for (index, length) in indices.iter().zip(&self.lengths) {
            if index.fract() != 0.0 || !(0.0..*length as f64).contains(index) {
                return None;
            }
            at = at * length + *index as usize;
        }
        self.values.get(at).copied()
    }

    /// The names of the entries: `a[0]`, `a[0,1]`.
    pub(super) fn names(&self) -> impl Iterator<Item = String> {
        (0..self.values.len()).map(|at| {
            let (mut rest, mut indices) = (at, Vec::new());
            for length in self.lengths.iter().rev() {
                indices.push((rest % length).to_string());
                rest /= length;
            }
            indices.reverse();
            format!("{}[{}]", self.name, indices.join(","))
        })
    }

    /// Reads a list, all of whose lists have the same length, and says where entries are that are no numbers but may be priors.
    ///
    /// # Errors
    /// The byte of an entry, and what is wrong with it.
    pub(super) fn read<'v>(
        name: &str,
        value: &'v Value,
        start: usize,
    ) -> Result<(List, EntriesWithPriors<'v>), (usize, Problem)> {
        let mut read = Entries::default();
        read.add(value, 0)?;
        Ok((List::new(name, start, read.lengths, read.values), read.priors))
    }
}

/// Where in a list entries stand that are no numbers, and what is there.
type EntriesWithPriors<'v> = Vec<(usize, &'v Value)>;

/// The entries of a list as they are read.
#[derive(Default)]
struct Entries<'v> {
    lengths: Vec<usize>,
    values: Vec<f64>,
    priors: EntriesWithPriors<'v>,
}

impl<'v> Entries<'v> {
    /// Adds those of a list that stands so deep in others.
    fn add(&mut self, value: &'v Value, depth: usize) -> Result<(), (usize, Problem)> {
        let refuse = |expected: String| Err((value.at, Problem::Value { found: value.words(), expected }));
        match &value.found {
            Found::List(list) if depth < DEEPEST && !list.is_empty() => {
                if depth == self.lengths.len() && self.values.is_empty() {
                    self.lengths.push(list.len());
                }
                match self.lengths.get(depth) {
                    Some(length) if *length == list.len() => {}
                    Some(length) => return refuse(format!("a list of {length}, as the first one")),
                    None => return refuse("a finite number, as the entries before".to_string()),
                }
                list.iter().try_for_each(|value| self.add(value, depth + 1))
            }
            Found::Number(number, _) if number.is_finite() && depth == self.lengths.len() => {
                self.values.push(*number);
                Ok(())
            }
            Found::Text { .. } | Found::Table(_) if depth == self.lengths.len() => {
                self.priors.push((self.values.len(), value));
                self.values.push(f64::NAN);
                Ok(())
            }
            Found::List(list) if list.is_empty() => refuse("a list of one number or more".to_string()),
            Found::List(_) => refuse(format!("a list of numbers, or of lists, up to {DEEPEST} deep")),
            _ => refuse("a list of finite numbers".to_string()),
        }
    }
}
