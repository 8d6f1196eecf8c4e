//! What errors call the text of a model, and whether they count its lines.

/// A text as errors speak of it.
#[derive(Clone, Copy)]
pub(crate) struct Text<'a> {
    /// What it is called.
    pub(crate) file: &'a str,
    /// Whether somebody sees its lines: those of a text that a program wrote nobody does.
    pub(crate) has_lines: bool,
}
