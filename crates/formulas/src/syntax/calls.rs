//! What is called by the names of the file, and distributions that are made of others.

use std::ops::Range;

use super::formula::{Node, NodeId};
use super::parser::Parser;
use super::token::Token;
use crate::error::{Fault, Problem, Section};
use crate::tables::Compound;

impl Parser<'_> {
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
        let (arguments, end) = self.numbers(compound.name, compound.parameters, span.start)?;
        if !self.text[..span.start].trim().is_empty() || self.ahead != Token::End {
            let name = compound.name.to_string();
            let problem = match self.scope.section {
                Section::Parameters => Problem::PriorMoved(name),
                _ => Problem::CompoundMoved(name),
            };
            return Err(Fault::at(span.start, problem));
        }
        Ok(self.add(Node::Compound(compound, arguments), span.start..end, true))
    }
}
