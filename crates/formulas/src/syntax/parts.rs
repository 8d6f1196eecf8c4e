//! The arguments of a call, before its formula can be read.

use std::ops::Range;

use super::token::{Token, next};
use crate::error::Section;
use crate::tables::{Composition, Compound, compound};

/// Whether a section can have a distribution of several parts: draws can, and so can starts, which take no time in which somebody could leave.
pub(super) fn may_have_parts(compound: &Compound, section: Section) -> bool {
    match section {
        Section::Draws => true,
        Section::Initial => compound.composition != Composition::EulerMultinomial,
        _ => false,
    }
}

/// How many numbers a formula draws, where its distribution has several parts that a section can have. What is no formula is refused where it is read.
pub(crate) fn parts(text: &str, section: Section) -> Option<usize> {
    let (_, name) = next(text, 0).ok().filter(|(token, _)| *token == Token::Name)?;
    let name = &text[name];
    let compound = compound(name).filter(|compound| may_have_parts(compound, section))?;
    let (before, arguments) = (compound.parts?, arguments_of_call(name, text)?);
    if compound.composition == Composition::MvNormal {
        // As many as there are means.
        let (_, open) = next(text, arguments.first()?.start).ok()?;
        return Some(separated(text, open.end)?.len());
    }
    Some(arguments.len().saturating_sub(before).max(1))
}

/// Where the arguments of `name(…)` stand in a text that begins with it; none where it does not, or is not closed.
pub(crate) fn arguments_of_call(name: &str, text: &str) -> Option<Vec<Range<usize>>> {
    let (_, first) =
        next(text, 0).ok().filter(|(token, at)| *token == Token::Name && text[at.clone()] == *name)?;
    let (_, open) = next(text, first.end).ok().filter(|(token, _)| *token == Token::Open)?;
    separated(text, open.end)
}

/// What commas separate from a byte on, until what was opened before it is closed.
fn separated(text: &str, from: usize) -> Option<Vec<Range<usize>>> {
    let (mut depth, mut arguments, mut begin, mut at) = (1_usize, Vec::new(), from, from);
    loop {
        let (token, span) = next(text, at).ok()?;
        at = span.end;
        match token {
            Token::Open | Token::OpenIndex => depth += 1,
            Token::Close | Token::CloseIndex => depth -= 1,
            Token::End => return None,
            _ => {}
        }
        if depth == 0 || (depth == 1 && token == Token::Comma) {
            arguments.push(begin..span.start);
            begin = span.end;
        }
        if depth == 0 {
            return Some(arguments);
        }
    }
}
