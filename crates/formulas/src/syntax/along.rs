//! Sums along vectors and lists, which are read once for each value of their index.

use std::ops::Range;

use super::formula::{Node, NodeId};
use super::parser::Parser;
use super::scope::Along;
use super::token::Token;
use crate::error::{ComposedProblem, Fault, Problem};
use crate::operations::Binary;
use crate::tables::reserved;

/// How many nodes a formula may have.
const MOST: usize = 500_000;

impl<'a> Parser<'a> {
    /// The value of the index of a sum of that name.
    pub(super) fn index_of_sum(&self, name: &str) -> Option<usize> {
        self.along.iter().find(|sum| sum.index == name).map(|sum| sum.value)
    }

    /// Takes notice of an index of a vector: where it is that of a sum alone, the sum goes along the vector.
    pub(super) fn goes_along(&mut self, index: NodeId, length: usize) -> Result<(), Fault> {
        let at = self.formula.spans[index].clone();
        let name = &self.text[at.clone()];
        let Some(sum) = self.along.iter_mut().find(|sum| sum.index == name) else { return Ok(()) };
        match sum.length {
            Some(other) if other != length => {
                let index = name.to_string();
                Err(Fault::at(
                    at.start,
                    Problem::Composed(ComposedProblem::SumOfTwoLengths { index, lengths: [other, length] }),
                ))
            }
            _ => {
                sum.length = Some(length);
                Ok(())
            }
        }
    }

    /// `sum(j, x[j])`, behind its name.
    pub(super) fn sum(&mut self, span: Range<usize>) -> Result<NodeId, Fault> {
        let alone = || Problem::NotCalled { name: "sum".to_string(), call: "sum(j, x[j])".to_string() };
        if self.ahead != Token::Open {
            return Err(Fault::at(span.start, alone()));
        }
        self.advance()?;
        let at = self.at.clone();
        let index = &self.text[at.clone()];
        let is_name = self.ahead == Token::Name;
        self.advance()?;
        if !is_name || self.ahead != Token::Comma {
            return Err(Fault::at(span.start, alone()));
        }
        let is_taken = self.scope.names.contains_key(index)
            || self.scope.arguments.iter().any(|argument| argument == index)
            || self.index_of_sum(index).is_some();
        let what = match reserved(index) {
            // Outside of vectors it is free.
            Some(_) if index == "i" && !self.scope.is_vector => None,
            None if is_taken => Some("a name that is taken"),
            what => what,
        };
        if let Some(what) = what {
            return Err(Fault::at(at.start, Problem::Reserved { name: index.to_string(), what }));
        }
        self.advance()?;
        let start = (self.ahead, self.at.clone());
        self.along.push(Along { index, value: 0, length: None });
        let mut all: Option<NodeId> = None;
        loop {
            let term = self.expression(0)?;
            if self.formula.is_random[term] {
                return Err(self.random_inside(term, "a sum".to_string()));
            }
            let whole = span.start..self.at.end;
            all = Some(match all {
                Some(before) => self.add(Node::OfTwo(Binary::Add, before, term), whole, false),
                None => term,
            });
            if self.formula.nodes.len() > MOST {
                return Err(Fault::at(span.start, Problem::TooLarge(MOST)));
            }
            let Some(sum) = self.along.last_mut() else { break };
            let Some(length) = sum.length else {
                return Err(Fault::at(
                    at.start,
                    Problem::Composed(ComposedProblem::SumAlongNothing(index.to_string())),
                ));
            };
            sum.value += 1;
            if sum.value == length || self.ahead != Token::Close {
                break;
            }
            (self.ahead, self.at) = start.clone();
        }
        self.along.pop();
        self.expect(Token::Close, "a closing parenthesis")?;
        // There is one term or more.
        Ok(all.unwrap_or_default())
    }
}
