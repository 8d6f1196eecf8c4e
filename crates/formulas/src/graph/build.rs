//! Makes the graph of a section from its formulas.

use super::compound::CompoundPart;
use super::coordinate::Output;
use super::nodes::{Graph, Id, Operation};
use super::parts::Parts;
use crate::error::{Fault, Problem, Section};
use crate::operations::Binary;
use crate::statement::{Line, List, Statement};
use crate::syntax::{Element, Node, Since, Total};
use crate::tables::Range;

/// Entries of a list.
type Entries = std::ops::Range<usize>;

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

impl Built {
    /// The numbers of the state that draws depend on, and the coordinates before that one.
    pub(crate) fn states_before(&self, end: usize) -> Vec<u32> {
        let before = self.draws.iter().chain(self.coordinates.iter().take(end));
        self.graph.states_of(before.flat_map(|output| output.numbers().chain(output.densities())))
    }

    /// The inputs that it depends on.
    pub(crate) fn inputs(&self) -> Vec<u32> {
        self.graph.inputs_of(self.draws.iter().chain(&self.coordinates).flat_map(Output::numbers))
    }

    /// The inputs that each coordinate depends on, draws aside.
    pub(crate) fn inputs_of_coordinates(&self) -> Vec<Vec<u32>> {
        self.coordinates.iter().map(|output| self.graph.inputs_of(output.numbers())).collect()
    }
}

/// Builds the graph of a section: `[initial]`, `[draws]` and `[transition]` together, `[measurement]`, or how inputs are simulated.
pub(crate) fn build(statement: &Statement, section: Section) -> Result<Built, Fault> {
    let (draws, lines): (&[Line], &[Line]) = match section {
        Section::Initial => (&[], &statement.initial),
        Section::Inputs => (&[], &statement.simulated.1),
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
    let (graph, definitions) = (Graph::default(), vec![Vec::new(); used.len()]);
    let states = statement.dimension();
    let may_be_exact = statement.may_be_exact && section == Section::Measurement;
    let mut builder = Builder { graph, definitions, work: 0, section, number: 0, states, may_be_exact };
    for &number in statement.order.iter().filter(|number| used[**number]) {
        let line = &statement.definitions[number];
        // A function has a value where it is called.
        for coordinate in (0..line.coordinates()).filter(|_| line.arguments.is_empty()) {
            let value = builder.of_line(statement, line, Section::Definitions, coordinate, &[])?.value();
            builder.definitions[number].extend(value);
        }
    }
    let totals: usize = statement.totals.iter().map(Total::coordinates).sum();
    let mut draws = builder.of_lines(statement, draws, Section::Draws, Some(states))?;
    let in_order = (section == Section::Initial).then_some(0);
    let mut coordinates = builder.of_lines(statement, lines, section, in_order)?;
    match section {
        Section::Initial => {
            let nothing = builder.graph.constant(0.0);
            coordinates.extend((0..totals).map(|_| Output::Follows(nothing)));
        }
        Section::Transition => builder.add_totals(statement, &mut draws, &mut coordinates),
        _ => {}
    }
    if matches!(section, Section::Initial | Section::Transition) {
        let own = statement.first_parameter()..states;
        coordinates.extend(own.map(|number| Output::Follows(builder.graph.state(number))));
    }
    Ok(Built { graph: builder.graph, draws, coordinates })
}

/// Where a formula names a state or draw, or a definition that does.
fn place_of(line: &Line, state: usize) -> usize {
    let names = |node: &Node| match node {
        Node::State { first, length, .. } => (*first..first + length).contains(&state),
        _ => false,
    };
    let nodes = &line.formula.nodes;
    let definition =
        || nodes.iter().position(|node| matches!(node, Node::Definition { .. } | Node::Call { .. }));
    nodes.iter().position(names).or_else(definition).map_or(0, |node| line.formula.spans[node].start)
}

/// The draw of several parts that begins with that state or draw, or the vector whose parts have formulas of their own: neither goes round.
fn parts(statement: &Statement, first: usize) -> Option<&Line> {
    let mut at = 0;
    for line in &statement.transition {
        if at == first && line.length.is_some_and(|length| is_in_parts(statement, line, length)) {
            return Some(line);
        }
        at += line.coordinates();
    }
    let mut begin = statement.dimension();
    let mut of_that_begin = statement.draws.iter().filter(|line| {
        let own = begin;
        begin += line.coordinates();
        own == first
    });
    of_that_begin.next().filter(|line| line.formula.has_parts())
}

/// Whether a line of a vector is one of several.
fn is_in_parts(statement: &Statement, line: &Line, length: usize) -> bool {
    let of_vector = statement.transition.iter().filter(|other| other.name == line.name);
    of_vector.map(Line::coordinates).sum::<usize>() > length
}

struct Builder {
    graph: Graph,
    /// The coordinates of each definition that has been built.
    definitions: Vec<Vec<Id>>,
    work: usize,
    section: Section,
    /// Which coordinate is built, among all that formulas of the section can name.
    number: usize,
    /// How many states there are.
    states: usize,
    /// Whether what is drawn may have a standard deviation of 0.
    may_be_exact: bool,
}

impl Builder {
    /// Adds the totals over sub-steps behind the coordinates of the state.
    fn add_totals(&mut self, statement: &Statement, draws: &mut Vec<Output>, coordinates: &mut Vec<Output>) {
        let behind = statement.dimension();
        let resets = statement.resets();
        for total in &statement.totals {
            for coordinate in total.first..total.first + total.coordinates() {
                let value = if total.is_of_draws {
                    self.graph.state(behind + coordinate)
                } else {
                    match &coordinates[coordinate] {
                        Output::Follows(value) => *value,
                        drawn @ (Output::Drawn(_) | Output::Computed { .. } | Output::Made(_)) => {
                            // What is drawn has a number only as a draw.
                            draws.push(drawn.clone());
                            let value = self.graph.state(behind + draws.len() - 1);
                            coordinates[coordinate] = Output::Follows(value);
                            value
                        }
                    }
                };
                let before = self.graph.state(coordinates.len());
                let first = self.graph.of_step(Operation::First);
                let begins = match total.since {
                    Since::SubStep => {
                        coordinates.push(Output::Follows(value));
                        continue;
                    }
                    Since::Row => first,
                    Since::Measured(entry) => {
                        let flag = resets.iter().position(|reset| *reset == entry).unwrap_or_default();
                        let number = (statement.inputs.len() + flag) as u32;
                        let measured = self.graph.of_step(Operation::Input(number));
                        self.graph.of_two(Binary::And, first, measured)
                    }
                };
                let nothing = self.graph.constant(0.0);
                let kept = self.graph.choice(begins, nothing, before);
                coordinates.push(Output::Follows(self.graph.of_two(Binary::Add, kept, value)));
            }
        }
    }

    /// What the coordinates of lines are. Where `known` is given, so many numbers are known to the first one, and each is known to those below it.
    fn of_lines(
        &mut self,
        statement: &Statement,
        lines: &[Line],
        section: Section,
        known: Option<usize>,
    ) -> Result<Vec<Output>, Fault> {
        let mut outputs: Vec<Output> = Vec::new();
        // Parameters that are numbers of the state are known from the beginning.
        let unknown_to = match section {
            Section::Initial => statement.first_parameter() as u32,
            _ => u32::MAX,
        };
        for line in lines {
            for coordinate in 0..line.coordinates() {
                self.number = known.unwrap_or_default() + outputs.len();
                let output = self.of_line(statement, line, section, coordinate, &[])?;
                if let (Output::Follows(id), false) = (&output, section == Section::Measurement)
                    && let Some(value) = self.graph.value(*id).filter(|value| !value.is_finite())
                {
                    let (what, expected) = ("the value".to_string(), Range::Any.words().to_string());
                    return Err(line.fault(section, 0, Problem::OutOfRange { what, value, expected }));
                }
                if let Some(known) = known {
                    let last = output.numbers().filter_map(|number| self.graph.last_state(number)).max();
                    let last = last.filter(|last| *last < unknown_to);
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

    /// What a formula says of a coordinate of a vector, or of a function of `arguments`.
    fn of_line(
        &mut self,
        statement: &Statement,
        line: &Line,
        section: Section,
        coordinate: usize,
        arguments: &[Id],
    ) -> Result<Output, Fault> {
        let formula = &line.formula;
        self.work += formula.nodes.len();
        if self.work > MOST {
            return Err(line.fault(section, 0, Problem::TooLarge(MOST)));
        }
        // What is random has a number in `random`; the one here is not used.
        let nothing = self.graph.constant(f64::NAN);
        let mut distributions = Parts::of(self.may_be_exact);
        let mut values: Vec<Id> = Vec::with_capacity(formula.nodes.len());
        for (at, node) in formula.nodes.iter().enumerate() {
            let value = match node {
                Node::Compound(compound, arguments) => {
                    let arguments: Vec<Id> = arguments.iter().map(|argument| values[*argument]).collect();
                    let (arguments, number) = (&arguments, self.number);
                    let is_measured = self.section == Section::Measurement;
                    let part = CompoundPart { compound, arguments, part: coordinate, number, is_measured };
                    self.work += arguments.len();
                    // It is all of the formula.
                    return part
                        .output(&mut self.graph)
                        .map_err(|problem| line.fault(section, formula.spans[at].start, problem));
                }
                _ if formula.is_random[at] => {
                    let found = distributions.add(&mut self.graph, node, at, &formula.is_random, &values);
                    found.map_err(|(at, problem)| line.fault(section, formula.spans[at].start, problem))?;
                    nothing
                }
                Node::Number(value) | Node::Named(value) => self.graph.constant(*value),
                Node::Time if self.section == Section::Initial && statement.time.is_none() => {
                    self.graph.constant(0.0)
                }
                Node::Time => self.graph.of_step(Operation::Time),
                Node::Length => self.graph.of_step(Operation::Length),
                Node::Input(number) => self.graph.of_step(Operation::Input(*number as u32)),
                Node::Coordinate => self.graph.constant((line.first + coordinate) as f64),
                Node::Argument(number) => arguments[*number],
                Node::Call { number, arguments } => {
                    let function = &statement.definitions[*number];
                    let arguments: Vec<Id> = arguments.iter().map(|argument| values[*argument]).collect();
                    let output = self.of_line(statement, function, Section::Definitions, 0, &arguments)?;
                    output.value().unwrap_or(nothing)
                }
                Node::State { first, length, element } => {
                    let parts = matches!(element, Element::At(_)).then(|| parts(statement, *first)).flatten();
                    let element = self
                        .element(element, *length, parts, &values)
                        .map_err(|problem| line.fault(section, formula.spans[at].start, problem))?;
                    self.graph.state(first + element)
                }
                Node::Definition { number, length, element } => {
                    let element = self
                        .element(element, *length, None, &values)
                        .map_err(|problem| line.fault(section, formula.spans[at].start, problem))?;
                    self.definitions[*number][element]
                }
                Node::Entry { list, indices } => {
                    let list = &statement.lists[*list];
                    let indices: Vec<Id> = indices.iter().map(|index| values[*index]).collect();
                    self.entry(list, 0..list.values.len(), &list.lengths, &indices)
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
        let random = distributions.finish(&mut self.graph, formula.root());
        let random = random.map_err(|(at, problem)| line.fault(section, formula.spans[at].start, problem))?;
        let value = Output::Follows(values.last().copied().unwrap_or(nothing));
        Ok(random.map_or(value, Output::from))
    }

    /// An entry of a list: chosen among all where an index is not known; NaN where there is none.
    fn entry(
        &mut self,
        list: &List,
        entries: Entries,
        lengths: &[usize],
        indices: &[Id],
    ) -> Result<Id, Problem> {
        let ([length, lengths @ ..], [index, indices @ ..]) = (lengths, indices) else {
            return Ok(match list.states.get(entries.start) {
                Some(Some(state)) => self.graph.state(*state),
                _ => self.graph.constant(list.values.get(entries.start).copied().unwrap_or(f64::NAN)),
            });
        };
        let each = entries.len() / length;
        let part = |at: usize| entries.start + at * each..entries.start + (at + 1) * each;
        if let Some(known) = self.graph.value(*index) {
            if !(0.0..*length as f64).contains(&known) || known.fract() != 0.0 {
                let name = list.name.clone();
                return Err(Problem::BeyondList { name, index: known, last: length - 1 });
            }
            let at = known as usize;
            return self.entry(list, part(at), lengths, indices);
        }
        self.work += 2 * length;
        if self.work > MOST {
            return Err(Problem::TooLarge(MOST));
        }
        let mut chosen = self.graph.constant(f64::NAN);
        for at in (0..*length).rev() {
            let entry = self.entry(list, part(at), lengths, indices)?;
            let number = self.graph.constant(at as f64);
            let is_meant = self.graph.of_two(Binary::Equal, *index, number);
            chosen = self.graph.choice(is_meant, entry, chosen);
        }
        Ok(chosen)
    }

    /// Which coordinate of a vector an index means, which goes round unless it is one of the parts of a line.
    fn element(
        &self,
        element: &Element,
        length: usize,
        parts: Option<&Line>,
        values: &[Id],
    ) -> Result<usize, Problem> {
        let Element::At(index) = element else { return Ok(0) };
        // Indices are made of constants, unless a function is given something else.
        let no_integer = || Problem::BadIndex("what the function is given".to_string());
        let index = self.graph.value(values[*index]).ok_or_else(no_integer)?;
        if let Some(line) = parts.filter(|_| !(0.0..length as f64).contains(&index)) {
            return Err(Problem::BeyondList { name: line.name.clone(), index, last: length - 1 });
        }
        if index.abs() < LARGEST_INDEX && index.fract() == 0.0 {
            return Ok((index as i64).rem_euclid(length as i64) as usize);
        }
        Err(Problem::BadIndex(format!("{index}")))
    }
}
