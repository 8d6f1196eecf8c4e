//! Makes the graph of a section from its formulas.

use super::coordinate::{Output, Part};
use super::nodes::{Graph, Id};
use super::parts::Parts;
use crate::error::{Fault, Problem, Section};
use crate::operations::Binary;
use crate::statement::{Line, List, Statement};
use crate::syntax::{Element, Node};
use crate::tables::Range;

/// How many operations the formulas of a section may come to.
const MOST: usize = 2_000_000;

/// Beyond this not every integer is a number.
const LARGEST_INDEX: f64 = (1_u64 << 53) as f64;

/// The graph of a section, and what its coordinates are.
#[derive(Debug)]
pub(crate) struct Built {
    pub(crate) graph: Graph,
    /// Of a transition, what is drawn before the coordinates of the state.
    pub(crate) draws: Vec<Output>,
    pub(crate) coordinates: Vec<Output>,
}

/// Builds the graph of a section: `[initial]`, `[draws]` and `[transition]` together, or `[measurement]`.
pub(crate) fn build(statement: &Statement, section: Section) -> Result<Built, Fault> {
    let (draws, lines): (&[Line], &[Line]) = match section {
        Section::Initial => (&[], &statement.initial),
        Section::Measurement => (&[], &statement.measurement),
        _ => (&statement.draws, &statement.transition),
    };
    let mut used = vec![false; statement.definitions.len()];
    let all = draws.iter().chain(lines);
    all.flat_map(|line| line.formula.definitions()).for_each(|number| used[number] = true);
    for &number in statement.order.iter().rev() {
        if used[number] {
            statement.definitions[number].formula.definitions().for_each(|other| used[other] = true);
        }
    }
    let states = statement.initial.iter().map(Line::coordinates).sum();
    let definitions = vec![Vec::new(); used.len()];
    let mut builder = Builder { graph: Graph::default(), definitions, work: 0, section, states };
    for &number in statement.order.iter().filter(|number| used[**number]) {
        let line = &statement.definitions[number];
        for coordinate in 0..line.coordinates() {
            let (value, _) = builder.of_line(statement, line, Section::Definitions, coordinate)?;
            builder.definitions[number].push(value);
        }
    }
    let draws = builder.of_lines(statement, draws, Section::Draws, Some(states))?;
    let in_order = (section == Section::Initial).then_some(0);
    let coordinates = builder.of_lines(statement, lines, section, in_order)?;
    Ok(Built { graph: builder.graph, draws, coordinates })
}

/// Where a formula names a state or draw, or a definition that does.
fn place_of(line: &Line, state: usize) -> usize {
    let names = |node: &Node| match node {
        Node::State { first, length, .. } => (*first..first + length).contains(&state),
        _ => false,
    };
    let nodes = &line.formula.nodes;
    let definition = || nodes.iter().position(|node| matches!(node, Node::Definition { .. }));
    nodes.iter().position(names).or_else(definition).map_or(0, |node| line.formula.spans[node].start)
}

struct Builder {
    graph: Graph,
    /// The coordinates of each definition that has been built.
    definitions: Vec<Vec<Id>>,
    work: usize,
    section: Section,
    /// How many states there are.
    states: usize,
}

impl Builder {
    /// What the coordinates of lines are. Where `known` is given, so many numbers are known to the first one, and each is known to those below it.
    fn of_lines(
        &mut self,
        statement: &Statement,
        lines: &[Line],
        section: Section,
        known: Option<usize>,
    ) -> Result<Vec<Output>, Fault> {
        let mut outputs: Vec<Output> = Vec::new();
        for line in lines {
            for coordinate in 0..line.coordinates() {
                let (value, random) = self.of_line(statement, line, section, coordinate)?;
                let output = random.map_or(Output::Follows(value), Output::from);
                if let (Output::Follows(id), false) = (&output, section == Section::Measurement)
                    && let Some(value) = self.graph.value(*id).filter(|value| !value.is_finite())
                {
                    let (what, expected) = ("the value".to_string(), Range::Any.words().to_string());
                    return Err(line.fault(section, 0, Problem::OutOfRange { what, value, expected }));
                }
                if let Some(known) = known {
                    let last = output.numbers().filter_map(|number| self.graph.last_state(number)).max();
                    let known = known + outputs.len();
                    if let Some(later) = last.map(|last| last as usize).filter(|last| *last >= known) {
                        let (name, section_name) = (statement.name_of(later), section.title());
                        let problem = Problem::NoValueYet { name, section: section_name };
                        return Err(line.fault(section, place_of(line, later), problem));
                    }
                }
                outputs.push(output);
            }
        }
        Ok(outputs)
    }

    /// The value of a formula for a coordinate of a vector, and its distribution, if it has one.
    fn of_line(
        &mut self,
        statement: &Statement,
        line: &Line,
        section: Section,
        coordinate: usize,
    ) -> Result<(Id, Option<Part>), Fault> {
        let formula = &line.formula;
        self.work += formula.nodes.len();
        if self.work > MOST {
            return Err(line.fault(section, 0, Problem::TooLarge(MOST)));
        }
        // What is random has a number in `random`; the one here is not used.
        let nothing = self.graph.constant(f64::NAN);
        let mut parts = Parts::default();
        let mut values: Vec<Id> = Vec::with_capacity(formula.nodes.len());
        for (at, node) in formula.nodes.iter().enumerate() {
            let value = match node {
                _ if formula.is_random[at] => {
                    let found = parts.add(&mut self.graph, node, at, &formula.is_random, &values);
                    found.map_err(|(at, problem)| line.fault(section, formula.spans[at].start, problem))?;
                    nothing
                }
                Node::Number(value) | Node::Named(value) => self.graph.constant(*value),
                Node::Time if self.section == Section::Initial => self.graph.constant(0.0),
                Node::Time => self.graph.time(),
                Node::Coordinate => self.graph.constant((line.first + coordinate) as f64),
                Node::State { first, length, element } => {
                    let element = self
                        .element(element, *length, &values)
                        .map_err(|problem| line.fault(section, formula.spans[at].start, problem))?;
                    self.graph.state(first + element)
                }
                Node::Definition { number, length, element } => {
                    let element = self
                        .element(element, *length, &values)
                        .map_err(|problem| line.fault(section, formula.spans[at].start, problem))?;
                    self.definitions[*number][element]
                }
                Node::Entry { list, indices } => {
                    let list = &statement.lists[*list];
                    let indices: Vec<Id> = indices.iter().map(|index| values[*index]).collect();
                    self.entry(list, &list.values, &list.lengths, &indices)
                        .map_err(|problem| line.fault(section, formula.spans[at].start, problem))?
                }
                Node::OfOne(operation, a) => self.graph.of_one(*operation, values[*a]),
                Node::OfTwo(operation, a, b) => self.graph.of_two(*operation, values[*a], values[*b]),
                Node::If([condition, then, otherwise]) => {
                    self.graph.choice(values[*condition], values[*then], values[*otherwise])
                }
                Node::Own => self.graph.state(self.states),
                Node::Random(..) | Node::Wrapped(..) => nothing,
            };
            values.push(value);
        }
        let random = parts.finish(&mut self.graph, formula.root());
        let random = random.map_err(|(at, problem)| line.fault(section, formula.spans[at].start, problem))?;
        Ok((values.last().copied().unwrap_or(nothing), random))
    }

    /// An entry of a list: chosen among all where an index is not known; NaN where there is none.
    fn entry(
        &mut self,
        list: &List,
        values: &[f64],
        lengths: &[usize],
        indices: &[Id],
    ) -> Result<Id, Problem> {
        let ([length, lengths @ ..], [index, indices @ ..]) = (lengths, indices) else {
            return Ok(self.graph.constant(values.first().copied().unwrap_or(f64::NAN)));
        };
        let each = values.len() / length;
        if let Some(known) = self.graph.value(*index) {
            if !(0.0..*length as f64).contains(&known) || known.fract() != 0.0 {
                let name = list.name.clone();
                return Err(Problem::BeyondList { name, index: known, last: length - 1 });
            }
            let at = known as usize;
            return self.entry(list, &values[at * each..][..each], lengths, indices);
        }
        self.work += 2 * length;
        if self.work > MOST {
            return Err(Problem::TooLarge(MOST));
        }
        let mut chosen = self.graph.constant(f64::NAN);
        for at in (0..*length).rev() {
            let entry = self.entry(list, &values[at * each..][..each], lengths, indices)?;
            let number = self.graph.constant(at as f64);
            let is_meant = self.graph.of_two(Binary::Equal, *index, number);
            chosen = self.graph.choice(is_meant, entry, chosen);
        }
        Ok(chosen)
    }

    /// Which coordinate of a vector an index means.
    fn element(&self, element: &Element, length: usize, values: &[Id]) -> Result<usize, Problem> {
        let Element::At(index) = element else { return Ok(0) };
        // Indices are made of constants.
        let index = self.graph.value(values[*index]).unwrap_or(f64::NAN);
        if index.abs() < LARGEST_INDEX {
            return Ok((index as i64).rem_euclid(length as i64) as usize);
        }
        Err(Problem::BadIndex(format!("{index}")))
    }
}
