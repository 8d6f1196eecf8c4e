//! Reads the distribution of a prior.

use std::collections::BTreeMap;
use std::ops::Range as Span;

use motes_models::equations::{Distribution, Scalar, gamma, normal, student_t};

use super::law::{Law, Truncated};
use crate::error::{ComposedProblem, Fault, Problem, Section};
use crate::operations::{Binary, Unary, choice, integer_exponent};
use crate::syntax::{Formula, Meaning, Node, NodeId, Scope, arguments_of_call, parse};
use crate::tables::{Composition, Kind, PriorKind, Range, call, compound};

/// What priors know by name: numbers, and entries of lists by the number of the list and their indices.
pub(crate) struct Names<'a> {
    pub(crate) names: &'a BTreeMap<String, Meaning>,
    pub(crate) entry: &'a dyn Fn(usize, &[f64]) -> Option<f64>,
}

/// The distribution that a text states; none where it is a formula without one. Faults have bytes of the text.
pub(crate) fn law_of(text: &str, names: &Names<'_>) -> Result<Option<Law>, Fault> {
    law_within(text, 0..text.len(), names)
}

/// That of a part of a text.
fn law_within(text: &str, span: Span<usize>, names: &Names<'_>) -> Result<Option<Law>, Fault> {
    let part = &text[span.clone()];
    let shifted = |fault: Fault| Fault { at: fault.at.map(|at| at + span.start), ..fault };
    if let Some(arguments) = arguments_of_call("truncated", part) {
        let arguments = arguments.into_iter().map(|of| span.start + of.start..span.start + of.end);
        return truncated(text, span.start, &arguments.collect::<Vec<_>>(), names).map(Some);
    }
    let scope = Scope {
        own: "",
        names: names.names,
        section: Section::Parameters,
        is_vector: false,
        is_of_several: false,
        totals: None,
        arguments: &[],
    };
    let formula = parse(part, scope).map_err(shifted)?;
    if !formula.has_noise() {
        return Ok(None);
    }
    let values = values(&formula, names);
    distribution(&formula, &values)
        .map(Some)
        .map_err(|(node, problem)| Fault::at(span.start + formula.spans[node].start, problem))
}

/// `truncated(d, low, high)`.
fn truncated(text: &str, at: usize, arguments: &[Span<usize>], names: &Names<'_>) -> Result<Law, Fault> {
    let call = compound("truncated").map_or_else(String::new, |row| call(row.name, row.parameters));
    let [inner, low, high] = arguments else {
        let (expected, found) = ("3 arguments".to_string(), arguments.len());
        return Err(Fault::at(at, Problem::Arity { call, expected, found }));
    };
    let none = || {
        let expected = "the distribution of one number that is no count".to_string();
        let found = format!("`{}`", text[inner.clone()].trim());
        Fault::at(inner.start, Problem::Unexpected { found, expected })
    };
    let law = law_within(text, inner.clone(), names)?.ok_or_else(none)?;
    if law.is_discrete() || matches!(law, Law::Dirichlet(_)) {
        return Err(none());
    }
    let [low, high] = [number(text, low, names)?, number(text, high, names)?];
    Truncated::new(law, [low, high])
        .map(|truncated| Law::Truncated(Box::new(truncated)))
        .ok_or_else(|| Fault::at(at, Problem::Composed(ComposedProblem::NothingBetween { low, high })))
}

/// An end of what is truncated.
fn number(text: &str, span: &Span<usize>, names: &Names<'_>) -> Result<f64, Fault> {
    let part = &text[span.clone()];
    match part.trim() {
        "inf" => return Ok(f64::INFINITY),
        "-inf" => return Ok(f64::NEG_INFINITY),
        _ => {}
    }
    let scope = Scope {
        own: "",
        names: names.names,
        section: Section::Parameters,
        is_vector: false,
        is_of_several: false,
        totals: None,
        arguments: &[],
    };
    let shifted = |fault: Fault| Fault { at: fault.at.map(|at| at + span.start), ..fault };
    let formula = parse(part, scope).map_err(shifted)?;
    let value = values(&formula, names).last().copied().unwrap_or(f64::NAN);
    if value.is_finite() {
        return Ok(value);
    }
    let (what, expected) = ("it".to_string(), "a finite number, inf or -inf".to_string());
    Err(Fault::at(span.start, Problem::OutOfRange { what, value, expected }))
}

/// The values of all nodes; NaN for what is random.
fn values(formula: &Formula, names: &Names<'_>) -> Vec<f64> {
    let mut values: Vec<f64> = Vec::with_capacity(formula.nodes.len());
    for node in &formula.nodes {
        values.push(match node {
            Node::Number(value) | Node::Named(value) => *value,
            Node::Entry { list, indices } => {
                let indices: Vec<f64> = indices.iter().map(|index| values[*index]).collect();
                (names.entry)(*list, &indices).unwrap_or(f64::NAN)
            }
            Node::OfOne(operation, a) => operation.of(values[*a]),
            Node::OfTwo(Binary::Power, a, b) => match integer_exponent(values[*b]) {
                Some(exponent) => Scalar::powi(values[*a], exponent),
                None => values[*a].pow(values[*b]),
            },
            Node::OfTwo(operation, a, b) => operation.of(values[*a], values[*b]),
            Node::If([condition, then, otherwise]) => {
                choice(values[*condition], values[*then], values[*otherwise])
            }
            // A prior knows nothing else.
            _ => f64::NAN,
        });
    }
    values
}

/// The distribution of a formula with noise, or what is wrong at a node.
fn distribution(formula: &Formula, values: &[f64]) -> Result<Law, (NodeId, Problem)> {
    let refuse = |node: NodeId, what: String, value: f64, expected: &str| {
        Err((node, Problem::OutOfRange { what, value, expected: expected.to_string() }))
    };
    // What is random is multiplied by the first and shifted by the second, from the outside in.
    let ([mut scale, mut shift], mut node) = ([1.0, 0.0], formula.root());
    loop {
        let (a, b) = match &formula.nodes[node] {
            Node::OfOne(Unary::Negative, a) => {
                (scale, node) = (-scale, *a);
                continue;
            }
            Node::OfTwo(_, a, b) => (*a, *b),
            _ => break,
        };
        let is_left = formula.is_random[a];
        let (random, by) = if is_left { (a, values[b]) } else { (b, values[a]) };
        match &formula.nodes[node] {
            Node::OfTwo(Binary::Add, ..) => shift += scale * by,
            Node::OfTwo(Binary::Subtract, ..) if is_left => shift -= scale * by,
            Node::OfTwo(Binary::Subtract, ..) => (shift, scale) = (shift + scale * by, -scale),
            Node::OfTwo(Binary::Multiply, ..) => scale *= by,
            _ => scale /= by,
        }
        node = random;
    }
    let (name, parameters, arguments) = match &formula.nodes[node] {
        Node::Random(family, arguments) => (family.name, family.parameters, arguments),
        Node::Compound(compound, arguments) => (compound.name, compound.parameters, arguments),
        _ => return refuse(node, "it".to_string(), f64::NAN, "a distribution"),
    };
    let call = call(name, parameters);
    for (number, argument) in arguments.iter().enumerate() {
        let (name, range) = match &formula.nodes[node] {
            Node::Compound(compound, _) => (compound.parameter(number), compound.range(number)),
            Node::Random(family, _) => (family.parameters[number], family.ranges[number]),
            _ => continue,
        };
        if !range.has(values[*argument]) {
            return refuse(*argument, format!("the {name} of {call}"), values[*argument], range.words());
        }
    }
    if !Range::Any.has(shift) || !Range::Any.has(scale) || scale == 0.0 {
        let value = if scale == 0.0 { scale } else { shift + scale };
        return refuse(formula.root(), "what it is moved by".to_string(), value, "a finite number but 0");
    }
    let at = |number: usize| arguments.get(number).map_or(f64::NAN, |argument| values[*argument]);
    let half = |law: Distribution<f64>| {
        let half = Truncated::new(Law::Of(law), [0.0, f64::INFINITY]);
        half.map(|half| Law::Truncated(Box::new(half)))
    };
    let law = match &formula.nodes[node] {
        Node::Random(family, _) => {
            if family.kind == Kind::Uniform && at(0) >= at(1) {
                return refuse(
                    node,
                    format!("the high of {call}"),
                    at(1),
                    &format!("above low, which is {}", at(0)),
                );
            }
            let is_moved = (scale != 1.0).then_some(scale);
            let shift = (shift != 0.0).then_some(shift);
            Some(Law::Of(family.kind.moved([at(0), at(1), at(2)], is_moved, shift)))
        }
        Node::Compound(compound, _) => match compound.composition {
            Composition::Prior(PriorKind::InverseGamma) => Some(Law::Inverse(gamma(at(0), 1.0 / at(1)))),
            Composition::Prior(PriorKind::HalfNormal) => half(normal(0.0, at(0))),
            Composition::Prior(PriorKind::HalfCauchy) => half(student_t(1.0, 0.0, at(0))),
            Composition::Dirichlet => Some(Law::Dirichlet((0..arguments.len()).map(at).collect())),
            _ => None,
        },
        _ => None,
    };
    let none = || (node, Problem::Composed(ComposedProblem::NoPrior(name.to_string())));
    law.filter(|law| law.centre().iter().all(|start| start.is_finite())).ok_or_else(none)
}
