//! Makes a program of a graph: coordinate by coordinate, each number as late as it is needed.

use super::instruction::{
    self, Computed, Instruction, MadeTerm, NoiseTerm, PartTerm, Place, PlainStep, Program, Rule, Source,
};
use super::kept::next_program;
use super::registers::Registers;
use crate::graph::{Built, Coordinate, Graph, Id, Made, Operation, Output, Part};
use crate::operations::Binary;
use crate::tables::Wrapping;

/// Compiles the graph of a section of a model with so many states; `in_order` gives each coordinate to those below it.
pub(crate) fn compile(built: &Built, states: usize, in_order: bool) -> Program {
    of_outputs(&built.graph, &built.draws, &built.coordinates, states, in_order)
}

/// Compiles what is needed for some outputs.
fn of_outputs(
    graph: &Graph,
    draws: &[Output],
    coordinates: &[Output],
    states: usize,
    in_order: bool,
) -> Program {
    let uses = count_uses(graph, draws, coordinates);
    let given = states + draws.len();
    let mut compiler = Compiler {
        graph,
        given: given as u32,
        plain: vec![0; uses.len()],
        registers: Registers::default(),
        held: vec![None; uses.len()],
        uses,
        instructions: Vec::new(),
    };
    let (constants, steps) = compiler.plain_numbers();
    let depends_on: Vec<Vec<u32>> = coordinates
        .iter()
        .map(|output| {
            let mut states = graph.states_of(output.numbers().chain(output.densities()));
            // Behind the states stands what was measured, in a log density.
            states.retain(|state| *state < given as u32);
            states
        })
        .collect();
    let draws = draws.iter().map(|output| compiler.output(output)).collect();
    let coordinates = coordinates.iter().map(|output| compiler.output(output)).collect();
    Program {
        number: next_program(),
        given,
        constants,
        steps,
        registers: compiler.registers.count(),
        instructions: compiler.instructions,
        draws,
        coordinates,
        in_order: in_order && depends_on.iter().any(|states| !states.is_empty()),
        depends_on,
    }
}

/// How often each number is an operand of what is needed, or needed itself.
fn count_uses(graph: &Graph, draws: &[Output], coordinates: &[Output]) -> Vec<u32> {
    let mut uses = vec![0; graph.operations().len()];
    for id in draws.iter().chain(coordinates).flat_map(Output::numbers) {
        uses[id.index()] += 1;
    }
    for (at, operation) in graph.operations().iter().enumerate().rev() {
        if uses[at] > 0 {
            operation.operands().for_each(|operand| uses[operand.index()] += 1);
        }
    }
    uses
}

struct Compiler<'a> {
    graph: &'a Graph,
    given: u32,
    /// For each number that is the same for all particles, its place among those.
    plain: Vec<u32>,
    registers: Registers,
    /// The register of each number that has one.
    held: Vec<Option<u32>>,
    /// How often each number is still needed.
    uses: Vec<u32>,
    instructions: Vec<Instruction>,
}

impl Compiler<'_> {
    /// Numbers that are the same for all particles: constants, and steps for the others.
    fn plain_numbers(&mut self) -> (Vec<f64>, Vec<PlainStep>) {
        let (mut constants, mut steps) = (Vec::new(), Vec::new());
        let needed: Vec<usize> = (0..self.uses.len()).filter(|at| self.uses[*at] > 0).collect();
        let operations = self.graph.operations();
        for &at in &needed {
            if let Operation::Constant(bits) = operations[at] {
                self.plain[at] = constants.len() as u32;
                constants.push(f64::from_bits(bits));
            }
        }
        for &at in &needed {
            let place = |id: Id| self.plain[id.index()];
            let step = match operations[at] {
                Operation::Time => PlainStep::Time,
                Operation::Length => PlainStep::Length,
                Operation::Input(number) => PlainStep::Input(number),
                Operation::First => PlainStep::First,
                Operation::OfOne(operation, a) if !self.graph.varies(a) => {
                    PlainStep::OfOne(operation, place(a))
                }
                Operation::Integer(a, n) if !self.graph.varies(a) => PlainStep::Integer(place(a), n),
                Operation::OfTwo(operation, a, b) if !self.graph.varies(a) && !self.graph.varies(b) => {
                    PlainStep::OfTwo(operation, place(a), place(b))
                }
                Operation::If(c, a, b) if ![c, a, b].iter().any(|operand| self.graph.varies(*operand)) => {
                    PlainStep::If(place(c), place(a), place(b))
                }
                _ => continue,
            };
            self.plain[at] = (constants.len() + steps.len()) as u32;
            steps.push(step);
        }
        (constants, steps)
    }

    /// The instructions for a coordinate's numbers, and what it is.
    fn output(&mut self, output: &Output) -> instruction::Output {
        let made = match output {
            Output::Made(made) => made.numbers(),
            Output::Computed { shares, .. } => shares.clone(),
            Output::Drawn(_) | Output::Follows(_) => Vec::new(),
        };
        let before = output.drawn_from().into_iter().flat_map(Coordinate::numbers).chain(made);
        before.for_each(|number| self.compute(number));
        let mut end = self.instructions.len();
        let rule = match output {
            Output::Drawn(coordinate) => Rule::Noise(self.noise_term(coordinate)),
            Output::Follows(id) => {
                self.compute(*id);
                end = self.instructions.len();
                Rule::Formula(self.source(*id))
            }
            Output::Computed { coordinate, drawn, value, shares } => {
                let shares = shares.iter().map(|share| self.source(*share)).collect();
                let (term, register) = (self.noise_term(coordinate), self.registers.take());
                self.held[drawn.index()] = Some(register);
                self.compute(*value);
                let (value, end) = (self.source(*value), self.instructions.len());
                Rule::Computed(Computed { term, shares, register, end, value })
            }
            Output::Made(made) => Rule::Made(Box::new(self.made_term(made))),
        };
        output.numbers().for_each(|number| self.release(number));
        instruction::Output { end, rule }
    }

    /// Where the numbers of a distribution that is made of others are.
    fn made_term(&self, made: &Made) -> MadeTerm {
        // What it does not have is some other number.
        let mut numbers = [Source::Plain(0); 2];
        for (source, number) in numbers.iter_mut().zip(&made.numbers) {
            *source = self.source(*number);
        }
        let part = |part: &Part| match part {
            Part::Plain(coordinate) => PartTerm::Plain(self.noise_term(coordinate)),
            Part::Made(made) => PartTerm::Made(self.made_term(made)),
        };
        // The measurement is one state more.
        let states = self.given as usize + 1;
        let program = |id: Id| of_outputs(self.graph, &[], &[Output::Follows(id)], states, false);
        MadeTerm {
            wrapping: made.wrapper.wrapping,
            numbers,
            shares: match made.wrapper.wrapping {
                Wrapping::Categorical => made.numbers.iter().map(|share| self.source(*share)).collect(),
                _ => Vec::new(),
            },
            parts: made.parts.iter().map(part).collect(),
            density: made.density.map(program),
        }
    }

    /// Where the numbers of a distribution are.
    fn noise_term(&self, coordinate: &Coordinate) -> NoiseTerm {
        // What the family does not take is some other number of it.
        let mut parameters = [self.source(coordinate.parameters[0]); 3];
        for (source, parameter) in parameters.iter_mut().zip(&coordinate.parameters) {
            *source = self.source(*parameter);
        }
        NoiseTerm {
            family: coordinate.family,
            parameters,
            scale: coordinate.scale.map(|scale| self.source(scale)),
            shift: coordinate.shift.map(|shift| self.source(shift)),
        }
    }

    /// Where a number of each particle is, once it is computed.
    fn place(&self, id: Id) -> Place {
        match self.graph.operation(id) {
            Operation::State(number) => number,
            _ => self.given + self.held[id.index()].unwrap_or_default(),
        }
    }

    /// Where a number is, once it is computed.
    fn source(&self, id: Id) -> Source {
        if self.graph.varies(id) {
            Source::Varied(self.place(id))
        } else {
            Source::Plain(self.plain[id.index()])
        }
    }

    /// A use of a number is over.
    fn release(&mut self, id: Id) {
        let at = id.index();
        self.uses[at] -= 1;
        if let (0, Some(register)) = (self.uses[at], self.held[at]) {
            self.registers.give_back(register);
        }
    }

    /// Appends the instructions for a number that are not there yet.
    fn compute(&mut self, id: Id) {
        let is_there = |compiler: &Self, id: Id| {
            let at = id.index();
            let operation = compiler.graph.operation(id);
            !compiler.graph.varies(id)
                || matches!(operation, Operation::State(_))
                || compiler.held[at].is_some()
        };
        let mut waiting = vec![id];
        while let Some(&next) = waiting.last() {
            if is_there(self, next) {
                waiting.pop();
                continue;
            }
            let operation = self.graph.operation(next);
            let missing = operation.operands().find(|operand| !is_there(self, *operand));
            if let Some(missing) = missing {
                waiting.push(missing);
                continue;
            }
            self.append(next, operation);
            waiting.pop();
        }
    }

    /// Appends the instruction of a number whose operands are there.
    fn append(&mut self, id: Id, operation: Operation) {
        // The result may take the register of an operand.
        operation.operands().for_each(|operand| self.release(operand));
        let out = self.registers.take();
        self.held[id.index()] = Some(out);
        self.instructions.extend(match operation {
            // These have no instruction.
            Operation::Constant(_)
            | Operation::Time
            | Operation::Length
            | Operation::Input(_)
            | Operation::First
            | Operation::State(_)
            | Operation::Drawn(_) => None,
            Operation::OfOne(operation, a) => Some(Instruction::OfOne(operation, out, self.place(a))),
            Operation::Integer(a, n) => Some(Instruction::Integer(out, self.place(a), n)),
            Operation::OfTwo(operation, a, b) => Some(of_two(operation, out, self.source(a), self.source(b))),
            Operation::If(c, a, b) => {
                Some(Instruction::If(out, self.source(c), self.source(a), self.source(b)))
            }
        });
    }
}

/// The instruction for an operation, where one operand at least is a number of each particle.
fn of_two(operation: Binary, out: u32, a: Source, b: Source) -> Instruction {
    use Source::{Plain, Varied};
    match (operation, a, b) {
        (Binary::Add, Varied(a), Varied(b)) => Instruction::Add(out, a, b),
        (Binary::Add, Varied(a), Plain(b)) | (Binary::Add, Plain(b), Varied(a)) => {
            Instruction::AddPlain(out, a, b)
        }
        (Binary::Subtract, Varied(a), Varied(b)) => Instruction::Subtract(out, a, b),
        (Binary::Subtract, Varied(a), Plain(b)) => Instruction::SubtractPlain(out, a, b),
        (Binary::Subtract, Plain(a), Varied(b)) => Instruction::SubtractFrom(out, b, a),
        (Binary::Multiply, Varied(a), Varied(b)) => Instruction::Multiply(out, a, b),
        (Binary::Multiply, Varied(a), Plain(b)) | (Binary::Multiply, Plain(b), Varied(a)) => {
            Instruction::MultiplyPlain(out, a, b)
        }
        (Binary::Divide, Varied(a), Varied(b)) => Instruction::Divide(out, a, b),
        (Binary::Divide, Varied(a), Plain(b)) => Instruction::DividePlain(out, a, b),
        (Binary::Divide, Plain(a), Varied(b)) => Instruction::DivideInto(out, b, a),
        _ => Instruction::OfTwo(operation, out, a, b),
    }
}
