//! Reads a formula: a Pratt parser, in which each operator binds its operands with a strength of its own.

mod wrapped;

use std::ops::Range;

use super::formula::{Element, Formula, Node, NodeId};
use super::lookup::{Known, called, known};
use super::meaning::Meaning;
use super::scope::{Along, Scope};
use super::token::{Token, next};
use super::total;
use crate::error::{Fault, Problem};
use crate::operations::{Binary, Unary};
use crate::tables::{Argument, Family, Function, Operation, call};

/// How deep parentheses, signs and powers may be nested.
const DEEPEST: usize = 100;

/// How many bytes a formula may have.
const LONGEST: usize = 100_000;

/// How strongly a sign binds what follows it: more than a product, less than a power.
const SIGN: u8 = 13;

/// How strongly `not` binds what follows it: more than `and`, less than a comparison.
const NOT: u8 = 5;

/// An operator between two operands, with how strongly it binds its left and its right one.
fn infix(token: Token) -> Option<(Binary, u8, u8)> {
    match token {
        Token::Or => Some((Binary::Or, 1, 2)),
        Token::And => Some((Binary::And, 3, 4)),
        Token::Less | Token::Greater => Some((Binary::Less, COMPARISON, COMPARISON + 1)),
        Token::AtMost | Token::AtLeast => Some((Binary::AtMost, COMPARISON, COMPARISON + 1)),
        Token::Equal => Some((Binary::Equal, COMPARISON, COMPARISON + 1)),
        Token::NotEqual => Some((Binary::NotEqual, COMPARISON, COMPARISON + 1)),
        Token::Plus => Some((Binary::Add, 9, 10)),
        Token::Minus => Some((Binary::Subtract, 9, 10)),
        Token::Times => Some((Binary::Multiply, 11, 12)),
        Token::Over => Some((Binary::Divide, 11, 12)),
        // x^y^z is x^(y^z).
        Token::Power => Some((Binary::Power, 16, 15)),
        _ => None,
    }
}

/// How strongly a comparison binds its operands.
const COMPARISON: u8 = 7;

/// Reads the formula of a coordinate or definition.
pub(crate) fn parse(text: &str, scope: Scope<'_>) -> Result<Formula, Fault> {
    if text.len() > LONGEST {
        return Err(Fault::new(Problem::TooLong { length: text.chars().count(), longest: LONGEST }));
    }
    let formula =
        Formula { text: text.to_string(), nodes: Vec::new(), spans: Vec::new(), is_random: Vec::new() };
    let (ahead, at) = next(text, 0)?;
    if ahead == Token::End {
        return Err(Fault::at(0, Problem::Empty));
    }
    let mut parser = Parser {
        text,
        scope,
        formula,
        ahead,
        at,
        depth: 0,
        in_index: false,
        along: Vec::new(),
        argument: None,
    };
    parser.expression(0)?;
    if parser.ahead != Token::End {
        return Err(parser.unexpected("an operator or the end"));
    }
    Ok(parser.formula)
}

pub(super) struct Parser<'a> {
    pub(super) text: &'a str,
    pub(super) scope: Scope<'a>,
    pub(super) formula: Formula,
    /// The next word, and where it is.
    pub(super) ahead: Token,
    pub(super) at: Range<usize>,
    depth: usize,
    in_index: bool,
    /// The sums that it is in.
    pub(super) along: Vec<Along<'a>>,
    /// What argument of a distribution of measurements it is in.
    pub(super) argument: Option<Argument>,
}

impl<'a> Parser<'a> {
    pub(super) fn advance(&mut self) -> Result<Range<usize>, Fault> {
        let (ahead, at) = next(self.text, self.at.end)?;
        self.ahead = ahead;
        Ok(std::mem::replace(&mut self.at, at))
    }

    /// The next word in quotes.
    pub(super) fn found(&self) -> String {
        match self.ahead {
            Token::End => "the end".to_string(),
            _ => format!("`{}`", &self.text[self.at.clone()]),
        }
    }

    fn unexpected(&self, expected: &str) -> Fault {
        let expected = expected.to_string();
        Fault::at(self.at.start, Problem::Unexpected { found: self.found(), expected })
    }

    /// Takes a word that must be there.
    pub(super) fn expect(&mut self, token: Token, expected: &str) -> Result<Range<usize>, Fault> {
        if self.ahead == token { self.advance() } else { Err(self.unexpected(expected)) }
    }

    pub(super) fn add(&mut self, node: Node, span: Range<usize>, is_random: bool) -> NodeId {
        self.formula.nodes.push(node);
        self.formula.spans.push(span);
        self.formula.is_random.push(is_random);
        self.formula.root()
    }

    /// An expression whose operators bind at least as strongly as `floor`.
    pub(super) fn expression(&mut self, floor: u8) -> Result<NodeId, Fault> {
        self.depth += 1;
        if self.depth > DEEPEST {
            return Err(Fault::at(self.at.start, Problem::TooDeep(DEEPEST)));
        }
        let mut left = self.operand()?;
        loop {
            if self.ahead.begins_operand() {
                return Err(Fault::at(self.at.start, Problem::NoOperator(self.found())));
            }
            let Some((operator, strength, next)) = infix(self.ahead).filter(|(_, own, _)| *own >= floor)
            else {
                break;
            };
            if self.in_index && !matches!(operator, Binary::Add | Binary::Subtract | Binary::Multiply) {
                return Err(Fault::at(self.at.start, Problem::BadIndex(self.found())));
            }
            debug_assert!(strength >= floor);
            let is_swapped = matches!(self.ahead, Token::Greater | Token::AtLeast);
            self.advance()?;
            let right = self.expression(next)?;
            left = self.of_two(operator, left, right, is_swapped)?;
            let is_comparison = strength == COMPARISON;
            if is_comparison && infix(self.ahead).is_some_and(|(_, own, _)| own == COMPARISON) {
                let problem = Problem::ChainedComparison(self.found());
                return Err(Fault::at(self.at.start, problem));
            }
        }
        self.depth -= 1;
        Ok(left)
    }

    fn operand(&mut self) -> Result<NodeId, Fault> {
        match self.ahead {
            Token::Number(value) => {
                if self.in_index && value.fract() != 0.0 {
                    return Err(Fault::at(self.at.start, Problem::BadIndex(self.found())));
                }
                let span = self.advance()?;
                Ok(self.add(Node::Number(value), span, false))
            }
            Token::Plus => {
                self.advance()?;
                self.expression(SIGN)
            }
            Token::Minus => {
                let sign = self.advance()?;
                let operand = self.expression(SIGN)?;
                let span = sign.start..self.formula.spans[operand].end;
                self.refuse_moved_counts(operand, operand)?;
                let is_random = self.formula.is_random[operand];
                Ok(self.add(Node::OfOne(Unary::Negative, operand), span, is_random))
            }
            Token::Not => {
                let not = self.advance()?;
                let operand = self.expression(NOT)?;
                if self.formula.is_random[operand] {
                    return Err(self.random_inside(operand, "not".into()));
                }
                let span = not.start..self.formula.spans[operand].end;
                Ok(self.add(Node::OfOne(Unary::Not, operand), span, false))
            }
            Token::Open => {
                let open = self.advance()?;
                let inner = self.expression(0)?;
                let close = self.expect(Token::Close, "a closing parenthesis")?;
                self.formula.spans[inner] = open.start..close.end;
                Ok(inner)
            }
            Token::Name => self.name(),
            _ => Err(self.unexpected("a number, a name or an opening parenthesis")),
        }
    }

    /// A name, with its arguments or its index.
    fn name(&mut self) -> Result<NodeId, Fault> {
        let span = self.advance()?;
        let name = &self.text[span.clone()];
        let faulty = |problem| Fault::at(span.start, problem);
        if let Some(value) = self.index_of_sum(name).filter(|_| self.ahead != Token::Open) {
            return match self.ahead {
                Token::OpenIndex => Err(faulty(Problem::NotAVector(name.to_string()))),
                _ => Ok(self.add(Node::Named(value as f64), span.clone(), false)),
            };
        }
        if name == "sum" {
            return match self.in_index {
                true => Err(faulty(Problem::BadIndex("`sum(…)`".to_string()))),
                false => self.sum(span.clone()),
            };
        }
        if self.ahead == Token::Open {
            if let Some(function) = total::function(name) {
                return self.total(function, span);
            }
            return match called(name, self.scope).map_err(faulty)? {
                _ if self.in_index => Err(faulty(Problem::BadIndex(format!("`{name}(…)`")))),
                Known::Function(function) => self.function(function, span.clone()),
                Known::Own(number, arguments) => self.call(name, number, arguments, span.clone()),
                Known::Family(family) => self.random(family, span.clone()),
                Known::Compound(compound) => self.compound(compound, span.clone()),
                Known::Wrapper(wrapper) => self.wrapped(wrapper, span.clone()),
            };
        }
        let is_end = self.argument == Some(Argument::End) && !self.in_index;
        if name == "inf" && is_end && !self.scope.names.contains_key(name) {
            return Ok(self.add(Node::Number(f64::INFINITY), span, false));
        }
        if name == self.scope.own && self.argument == Some(Argument::Formula) {
            return self.own(span);
        }
        let node = known(name, self.scope, self.in_index, self.ahead == Token::OpenIndex).map_err(faulty)?;
        if let (Node::Entry { list, .. }, Some(Meaning::List { lengths, .. })) =
            (&node, self.scope.names.get(name))
        {
            return self.entry(*list, lengths, name, span.clone());
        }
        let (element, end) = self.element(span.end)?;
        if let (Element::At(index), Node::State { length, .. } | Node::Definition { length, .. }) =
            (element, &node)
        {
            self.goes_along(index, *length)?;
        }
        let node = match node {
            Node::State { first, length, .. } => Node::State { first, length, element },
            Node::Definition { number, length, .. } => Node::Definition { number, length, element },
            other => other,
        };
        Ok(self.add(node, span.start..end, false))
    }

    /// The index of a name that ended at a byte, and where that ends.
    pub(super) fn element(&mut self, end: usize) -> Result<(Element, usize), Fault> {
        if self.ahead != Token::OpenIndex {
            return Ok((Element::Whole, end));
        }
        self.advance()?;
        self.in_index = true;
        let index = self.expression(0)?;
        self.in_index = false;
        let close = self.expect(Token::CloseIndex, "a closing bracket ]")?;
        Ok((Element::At(index), close.end))
    }

    /// The arguments of what is called, and the end of its closing parenthesis.
    fn arguments(&mut self) -> Result<(Vec<NodeId>, usize), Fault> {
        self.advance()?;
        let mut arguments = Vec::new();
        if self.ahead != Token::Close {
            arguments.push(self.expression(0)?);
            while self.ahead == Token::Comma {
                self.advance()?;
                arguments.push(self.expression(0)?);
            }
        }
        let close = self.expect(Token::Close, "a comma or a closing parenthesis")?;
        Ok((arguments, close.end))
    }

    /// The arguments of what takes so many, none of them random.
    pub(super) fn numbers(
        &mut self,
        name: &str,
        parameters: &[&str],
        at: usize,
    ) -> Result<(Vec<NodeId>, usize), Fault> {
        let (arguments, end) = self.arguments()?;
        let call = call(name, parameters);
        let is_open = parameters.last() == Some(&"…");
        let fits = match is_open {
            true => arguments.len() + 1 >= parameters.len(),
            false => arguments.len() == parameters.len(),
        };
        if !fits {
            let expected = match parameters.len() {
                _ if is_open => format!("{} arguments or more", parameters.len() - 1),
                1 => "one argument".to_string(),
                count => format!("{count} arguments"),
            };
            return Err(Fault::at(at, Problem::Arity { call, expected, found: arguments.len() }));
        }
        match arguments.iter().find(|argument| self.formula.is_random[**argument]) {
            Some(random) => Err(self.random_inside(*random, call)),
            None => Ok((arguments, end)),
        }
    }

    fn function(&mut self, function: &'static Function, span: Range<usize>) -> Result<NodeId, Fault> {
        let (arguments, end) = self.numbers(function.name, function.parameters, span.start)?;
        let node = match (function.operation, arguments.as_slice()) {
            (Operation::OfOne(operation), [a]) => Node::OfOne(operation, *a),
            (Operation::OfTwo(operation) | Operation::OfMany(operation), [a, b]) => {
                Node::OfTwo(operation, *a, *b)
            }
            (Operation::OfMany(operation), [first, rest @ ..]) => {
                return Ok(rest.iter().fold(*first, |left, right| {
                    self.add(Node::OfTwo(operation, left, *right), span.start..end, false)
                }));
            }
            (Operation::If, [condition, then, otherwise]) => Node::If([*condition, *then, *otherwise]),
            // The table's parameters are those of its operations.
            _ => Node::Number(f64::NAN),
        };
        Ok(self.add(node, span.start..end, false))
    }

    fn random(&mut self, family: &'static Family, span: Range<usize>) -> Result<NodeId, Fault> {
        let (arguments, end) = self.numbers(family.name, family.parameters, span.start)?;
        Ok(self.add(Node::Random(family, arguments), span.start..end, true))
    }

    /// An operation on what stands on its left and on its right, whose operands are `is_swapped`: `a > b` is `b < a`.
    fn of_two(
        &mut self,
        operator: Binary,
        left: NodeId,
        right: NodeId,
        is_swapped: bool,
    ) -> Result<NodeId, Fault> {
        let is_random = [left, right].map(|operand| self.formula.is_random[operand]);
        let span = self.formula.spans[left].start..self.formula.spans[right].end;
        match (operator, is_random) {
            (_, [false, false]) => {}
            (_, [true, true]) => {
                let (family, at) = self.family_in(right);
                return Err(Fault::at(at, Problem::TwoDistributions(family)));
            }
            (Binary::Divide, [_, true]) => return Err(self.random_inside(right, "a divisor".into())),
            (Binary::Power, [left_is, _]) => {
                return Err(self.random_inside(if left_is { left } else { right }, "a power".into()));
            }
            (Binary::Add | Binary::Subtract | Binary::Multiply | Binary::Divide, _) => {
                self.refuse_moved_counts(left, right)?;
            }
            (_, [left_is, _]) => {
                let random = if left_is { left } else { right };
                return Err(self.random_inside(random, "a comparison".into()));
            }
        }
        let (first, second) = if is_swapped { (right, left) } else { (left, right) };
        Ok(self.add(Node::OfTwo(operator, first, second), span, is_random.contains(&true)))
    }

    /// The name of the distribution in a node, and where it is.
    fn family_in(&self, random: NodeId) -> (String, usize) {
        let span = &self.formula.spans[random];
        if let Node::Wrapped(wrapper, _) = &self.formula.nodes[random] {
            return (wrapper.name.to_string(), span.start);
        }
        let inside = self.formula.nodes.iter().zip(&self.formula.spans).find_map(|(node, at)| match node {
            Node::Random(family, _) if at.start >= span.start && at.end <= span.end => {
                Some((family.name.to_string(), at.start))
            }
            _ => None,
        });
        inside.unwrap_or_default()
    }

    pub(super) fn random_inside(&self, random: NodeId, inside: String) -> Fault {
        let (family, at) = self.family_in(random);
        Fault::at(at, Problem::RandomInside { family, inside })
    }

    /// Counts stand alone, and what is made of other distributions.
    fn refuse_moved_counts(&self, left: NodeId, right: NodeId) -> Result<(), Fault> {
        let random = [left, right].into_iter().find(|operand| self.formula.is_random[*operand]);
        let Some(random) = random else { return Ok(()) };
        match self.formula.nodes[random] {
            Node::Random(family, _) if family.is_of_counts() => {
                Err(Fault::at(self.formula.spans[random].start, Problem::CountsMoved(family.name.into())))
            }
            Node::Wrapped(wrapper, _) => {
                Err(Fault::at(self.formula.spans[random].start, Problem::WrapperMoved(wrapper.name.into())))
            }
            _ => Ok(()),
        }
    }
}
