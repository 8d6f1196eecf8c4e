//! What is called by the names of the file, and distributions that are made of others.

use std::ops::Range;

use super::formula::{Node, NodeId};
use super::lookup::check_index;
use super::parser::Parser;
use super::token::Token;
use super::total::Since;
use crate::error::{ComposedProblem, Fault, Problem, Section};
use crate::tables::{Composition, Compound, call};

/// How many parts a normal number may have: each is computed of all before it.
const MOST: usize = 50;

impl Parser<'_> {
    /// An entry of a list, whose indices are any numbers.
    pub(super) fn entry(
        &mut self,
        list: usize,
        lengths: &[usize],
        name: &str,
        span: Range<usize>,
    ) -> Result<NodeId, Fault> {
        self.advance()?;
        let mut indices = vec![self.expression(0)?];
        while self.ahead == Token::Comma {
            self.advance()?;
            indices.push(self.expression(0)?);
        }
        let close = self.expect(Token::CloseIndex, "a comma or a closing bracket ]")?;
        if indices.len() != lengths.len() {
            let example = format!("{name}[{}]", vec!["0"; lengths.len()].join(", "));
            return Err(Fault::at(span.start, Problem::Indices { name: name.to_string(), example }));
        }
        if let Some(random) = indices.iter().find(|index| self.formula.is_random[**index]) {
            return Err(self.random_inside(*random, "an index".into()));
        }
        for (index, length) in indices.iter().zip(lengths) {
            self.goes_along(*index, *length)?;
        }
        Ok(self.add(Node::Entry { list, indices }, span.start..close.end, false))
    }

    /// A sum over the sub-steps of a draw or a state.
    pub(super) fn total(&mut self, function: &'static str, span: Range<usize>) -> Result<NodeId, Fault> {
        let faulty = |problem| Fault::at(span.start, problem);
        let Some((measured, totals)) = self.scope.totals else {
            return Err(faulty(Problem::TotalElsewhere(function)));
        };
        let since = match (function, self.scope.is_of_several) {
            ("total", _) => Since::Row,
            (_, false) => Since::Measured(measured),
            (_, true) => return Err(faulty(Problem::TotalOfVector)),
        };
        self.advance()?;
        if self.ahead != Token::Name {
            return Err(faulty(Problem::TotalOf { name: function, found: self.found() }));
        }
        let of = self.advance()?;
        let name = &self.text[of.clone()];
        let total = totals.borrow().of(function, name, self.scope.names.get(name), since).map_err(faulty)?;
        let length = total.length;
        check_index(name, length, self.ahead == Token::OpenIndex)
            .map_err(|problem| Fault::at(of.start, problem))?;
        let (element, _) = self.element(of.end)?;
        if self.ahead != Token::Close {
            return Err(faulty(Problem::TotalOf { name: function, found: "a formula".into() }));
        }
        let close = self.advance()?;
        let first = totals.borrow_mut().place_of(total);
        let node = Node::State { first, length: length.unwrap_or(1), element };
        Ok(self.add(node, span.start..close.end, false))
    }

    /// A function of the file.
    pub(super) fn call(
        &mut self,
        name: &str,
        number: usize,
        arguments: &[String],
        span: Range<usize>,
    ) -> Result<NodeId, Fault> {
        let parameters: Vec<&str> = arguments.iter().map(String::as_str).collect();
        let (arguments, end) = self.numbers(name, &parameters, span.start)?;
        Ok(self.add(Node::Call { number, arguments }, span.start..end, false))
    }

    /// A distribution that is made of others stands alone.
    pub(super) fn compound(
        &mut self,
        compound: &'static Compound,
        span: Range<usize>,
    ) -> Result<NodeId, Fault> {
        let (arguments, end) = match compound.composition {
            Composition::MvNormal => self.means_and_covariance(compound, span.start)?,
            _ => self.numbers(compound.name, compound.parameters, span.start)?,
        };
        if !self.text[..span.start].trim().is_empty() || self.ahead != Token::End {
            let moved = |cure| ComposedProblem::CompoundMoved { name: compound.name.to_string(), cure };
            let problem = match self.scope.section {
                Section::Parameters => ComposedProblem::PriorMoved(compound.name.to_string()),
                Section::Initial => moved("formulas of the lines below it may use what it draws"),
                Section::Measurement => {
                    moved("it is measured as it is, not shifted, scaled or inside of another distribution")
                }
                _ => moved("as a line of [draws] its values can be part of any formula of [transition]"),
            };
            return Err(Fault::at(span.start, Problem::Composed(problem)));
        }
        Ok(self.add(Node::Compound(compound, arguments), span.start..end, true))
    }

    /// `([m0, m1], [[a, b], [b, c]])`: all numbers, and the end.
    fn means_and_covariance(
        &mut self,
        compound: &Compound,
        at: usize,
    ) -> Result<(Vec<NodeId>, usize), Fault> {
        self.advance()?;
        let mut numbers = self.list()?;
        let count = numbers.len();
        self.expect(Token::Comma, "a comma and the covariance, by rows")?;
        self.expect(Token::OpenIndex, "the covariance by rows, as in [[1, 0], [0, 1]],")?;
        for row in 0..count {
            if row > 0 {
                self.expect(Token::Comma, "a comma and the next row of the covariance")?;
            }
            let row = self.list()?;
            if row.len() != count {
                let problem =
                    Problem::Composed(ComposedProblem::RowOfCovariance { found: row.len(), expected: count });
                return Err(Fault::at(self.formula.spans[row[0]].start, problem));
            }
            numbers.extend(row);
        }
        self.expect(Token::CloseIndex, "a closing bracket ] behind the last row")?;
        let close = self.expect(Token::Close, "a closing parenthesis")?;
        match numbers.iter().find(|number| self.formula.is_random[**number]) {
            Some(random) => Err(self.random_inside(*random, call(compound.name, compound.parameters))),
            None if count > MOST => Err(Fault::at(at, Problem::TooMany(MOST))),
            None => Ok((numbers, close.end)),
        }
    }

    /// `[a, b]`, one number or more.
    fn list(&mut self) -> Result<Vec<NodeId>, Fault> {
        self.expect(Token::OpenIndex, "a list, as in [0, 1],")?;
        let mut numbers = vec![self.expression(0)?];
        while self.ahead == Token::Comma {
            self.advance()?;
            numbers.push(self.expression(0)?);
        }
        self.expect(Token::CloseIndex, "a comma or a closing bracket ]")?;
        Ok(numbers)
    }
}
