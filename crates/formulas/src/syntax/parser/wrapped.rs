//! Reads distributions of measurements that are made of others.

use std::ops::Range;

use super::super::formula::{Node, NodeId};
use super::super::token::Token;
use super::Parser;
use crate::error::{Fault, Problem};
use crate::tables::{Argument, Wrapper, Wrapping, call};

impl Parser<'_> {
    /// The measurement in its own log density.
    pub(super) fn own(&mut self, span: Range<usize>) -> Result<NodeId, Fault> {
        let mut end = span.end;
        if self.ahead == Token::OpenIndex {
            let own = || Fault::at(span.start, Problem::OwnIndex(self.scope.own.to_string()));
            self.advance()?;
            if !self.scope.is_vector || self.ahead != Token::Name || &self.text[self.at.clone()] != "i" {
                return Err(own());
            }
            self.advance()?;
            end = self.expect(Token::CloseIndex, "a closing bracket ]")?.end;
        }
        Ok(self.add(Node::Own, span.start..end, false))
    }

    /// A distribution that is made of others, with its arguments.
    pub(super) fn wrapped(&mut self, wrapper: &'static Wrapper, span: Range<usize>) -> Result<NodeId, Fault> {
        let outer = self.argument;
        let mut arguments = Vec::new();
        self.advance()?;
        while self.ahead != Token::Close {
            self.argument = wrapper.arguments.get(arguments.len()).copied();
            arguments.push(self.expression(0)?);
            self.argument = outer;
            if self.ahead != Token::Comma {
                break;
            }
            self.advance()?;
        }
        let end = self.expect(Token::Close, "a comma or a closing parenthesis")?.end;
        let call = || call(wrapper.name, wrapper.parameters);
        if arguments.len() != wrapper.arguments.len() {
            let expected = match wrapper.arguments.len() {
                1 => "one argument".to_string(),
                count => format!("{count} arguments"),
            };
            return Err(Fault::at(
                span.start,
                Problem::Arity { call: call(), expected, found: arguments.len() },
            ));
        }
        for ((argument, kind), parameter) in arguments.iter().zip(wrapper.arguments).zip(wrapper.parameters) {
            match (*kind == Argument::Distribution, self.formula.is_random[*argument]) {
                (true, false) => {
                    let found = self.formula.text_of(*argument).to_string();
                    let problem = Problem::NoDistribution { found, parameter, call: call() };
                    return Err(Fault::at(self.formula.spans[*argument].start, problem));
                }
                (false, true) => return Err(self.random_inside(*argument, call())),
                (true, true) if wrapper.needs_masses() => self.check_masses(*argument, wrapper)?,
                _ => {}
            }
        }
        Ok(self.add(Node::Wrapped(wrapper, arguments), span.start..end, true))
    }

    /// Refuses what has no distribution function that serves the outer one.
    fn check_masses(&self, inner: NodeId, outer: &'static Wrapper) -> Result<(), Fault> {
        let Node::Wrapped(wrapper, arguments) = &self.formula.nodes[inner] else { return Ok(()) };
        if !wrapper.has_masses_for(outer.wrapping) {
            let others = match outer.wrapping {
                Wrapping::Rounded => "all but von_mises, floored and log_density",
                _ => "rounded, truncated and mixture",
            };
            let call = call(outer.name, outer.parameters);
            let problem = Problem::NoMasses { inner: wrapper.name, call, others };
            return Err(Fault::at(self.formula.spans[inner].start, problem));
        }
        // What is rounded or truncated has been looked at.
        let are_parts = matches!(wrapper.wrapping, Wrapping::Mixture | Wrapping::ZeroInflated);
        let parts =
            arguments.iter().zip(wrapper.arguments).filter(|(_, kind)| **kind == Argument::Distribution);
        parts.filter(|_| are_parts).try_for_each(|(part, _)| self.check_masses(*part, outer))
    }
}
