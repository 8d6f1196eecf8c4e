//! Programs: what is computed once for all particles, and what for each.

use crate::operations::{Binary, Unary};
use crate::tables::{Family, Wrapping};

/// What a section computes.
#[derive(Debug, Clone)]
pub(crate) struct Program {
    /// A number of its own; copies, which compute the same, have the same.
    pub(super) number: u64,
    /// How many numbers of each particle it is given: states, and behind them draws.
    pub(super) given: usize,
    /// The first plain numbers; the others are computed by `steps`, one each.
    pub(super) constants: Vec<f64>,
    pub(super) steps: Vec<PlainStep>,
    /// How many numbers of each particle it keeps at a time.
    pub(super) registers: usize,
    pub(super) instructions: Vec<Instruction>,
    /// What is drawn before the coordinates: each becomes one of the numbers that it is given.
    pub(super) draws: Vec<Output>,
    pub(super) coordinates: Vec<Output>,
    /// Whether coordinates are given to those below them.
    pub(super) in_order: bool,
    /// The states that each coordinate depends on, in ascending order.
    pub(super) depends_on: Vec<Vec<u32>>,
}

/// How the next plain number is computed, from those before it.
#[derive(Debug, Clone, Copy)]
pub(super) enum PlainStep {
    Time,
    /// The length of a sub-step.
    Length,
    Input(u32),
    /// Whether it is the first sub-step of a step.
    First,
    OfOne(Unary, u32),
    Integer(u32, i32),
    OfTwo(Binary, u32, u32),
    If(u32, u32, u32),
}

/// A number of each particle: one that is given, or after those of a register.
pub(super) type Place = u32;

/// Where a number is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Source {
    /// It is the same for all particles.
    Plain(u32),
    Varied(Place),
}

/// An operation on numbers of each particle; the first number says to which register the result goes.
#[derive(Debug, Clone, Copy)]
pub(super) enum Instruction {
    Add(u32, Place, Place),
    AddPlain(u32, Place, u32),
    Subtract(u32, Place, Place),
    SubtractPlain(u32, Place, u32),
    /// A plain number less one of each particle.
    SubtractFrom(u32, Place, u32),
    Multiply(u32, Place, Place),
    MultiplyPlain(u32, Place, u32),
    Divide(u32, Place, Place),
    DividePlain(u32, Place, u32),
    /// A plain number divided by one of each particle.
    DivideInto(u32, Place, u32),
    OfOne(Unary, u32, Place),
    Integer(u32, Place, i32),
    OfTwo(Binary, u32, Source, Source),
    If(u32, Source, Source, Source),
}

/// What a coordinate is.
#[derive(Debug, Clone)]
pub(super) struct Output {
    /// The instructions up to here come before it.
    pub(super) end: usize,
    pub(super) rule: Rule,
}

/// What makes a coordinate: noise, or a number without it.
#[derive(Debug, Clone)]
pub(super) enum Rule {
    Noise(NoiseTerm),
    Made(Box<MadeTerm>),
    Formula(Source),
    Computed(Computed),
}

/// A number that is computed of what is drawn.
#[derive(Debug, Clone)]
pub(super) struct Computed {
    pub(super) term: NoiseTerm,
    /// What it chooses among, in proportion to these numbers.
    pub(super) shares: Vec<Source>,
    /// The register that what is drawn goes to.
    pub(super) register: u32,
    /// The instructions up to here come after the draw.
    pub(super) end: usize,
    pub(super) value: Source,
}

/// A distribution that is made of others.
#[derive(Debug, Clone)]
pub(super) struct MadeTerm {
    pub(super) wrapping: Wrapping,
    /// Its numbers, in order; what it does not have is some other one.
    pub(super) numbers: [Source; 2],
    /// Of a categorical, its probabilities.
    pub(super) shares: Vec<Source>,
    pub(super) parts: Vec<PartTerm>,
    /// The log density as a program of the states and, behind them, the measurement.
    pub(super) density: Option<Program>,
}

/// What it is made of.
#[derive(Debug, Clone)]
pub(super) enum PartTerm {
    Plain(NoiseTerm),
    Made(MadeTerm),
}

/// The distribution of a coordinate.
#[derive(Debug, Clone, Copy)]
pub(super) struct NoiseTerm {
    pub(super) family: &'static Family,
    pub(super) parameters: [Source; 3],
    pub(super) scale: Option<Source>,
    pub(super) shift: Option<Source>,
}
