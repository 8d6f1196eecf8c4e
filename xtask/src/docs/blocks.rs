//! Blocks of code in a page.

use std::ops::Range;

/// A block: its language, and which lines of the page it has.
pub(super) struct Block<'a> {
    pub(super) language: &'a str,
    pub(super) lines: Range<usize>,
}

/// The blocks of a page, in order.
pub(super) fn blocks<'a>(lines: &[&'a str]) -> Vec<Block<'a>> {
    let mut blocks = Vec::new();
    let mut open: Option<(&str, usize)> = None;
    for (at, line) in lines.iter().enumerate() {
        let Some(language) = line.strip_prefix("```") else { continue };
        open = match open {
            None => Some((language, at + 1)),
            Some((language, start)) => {
                blocks.push(Block { language, lines: start..at });
                None
            }
        };
    }
    blocks
}
