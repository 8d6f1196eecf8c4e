//! Keys of vectors and functions, `x[40] = …` and `f(x) = …`, which TOML wants in quotes.

use std::borrow::Cow;

use crate::names::is_in_name;

/// A text whose keys of vectors and functions are in quotes, and the way back to the text without them.
pub(super) struct QuotedText<'t> {
    text: Cow<'t, str>,
    /// The bytes of the new text that are not of the old one, in order.
    added: Vec<usize>,
}

impl<'t> QuotedText<'t> {
    /// Puts `x[40]` or `f(x)` in quotes where a line begins with it and goes on with `=`.
    pub(super) fn of(text: &'t str) -> Self {
        if !text.contains(['[', '(']) {
            return QuotedText { text: Cow::Borrowed(text), added: Vec::new() };
        }
        let mut quoted = String::with_capacity(text.len());
        let mut added = Vec::new();
        for line in text.split_inclusive('\n') {
            let start = line.len() - line.trim_start_matches(['\u{feff}', ' ', '\t']).len();
            match vector_key(&line[start..]) {
                None => quoted.push_str(line),
                Some(length) => {
                    let (indent, rest) = line.split_at(start);
                    let (key, rest) = rest.split_at(length);
                    quoted.push_str(indent);
                    added.push(quoted.len());
                    quoted.push('"');
                    quoted.push_str(key);
                    added.push(quoted.len());
                    quoted.push('"');
                    quoted.push_str(rest);
                }
            }
        }
        QuotedText { text: Cow::Owned(quoted), added }
    }

    pub(super) fn text(&self) -> &str {
        &self.text
    }

    /// The byte of the old text for one of the new.
    pub(super) fn original(&self, byte: usize) -> usize {
        byte - self.added.partition_point(|added| *added < byte)
    }
}

/// The length of the key of a vector or function at the beginning of a line.
fn vector_key(line: &str) -> Option<usize> {
    let name = line.find(|c| !is_in_name(c)).filter(|end| *end > 0)?;
    let open = line[name..].trim_start_matches([' ', '\t']);
    let (inside, end) = match (open.strip_prefix('['), open.strip_prefix('(')) {
        (Some(inside), _) => (inside, ']'),
        (None, inside) => (inside?, ')'),
    };
    let close = inside.find([end, '"', '\'', '=', '#'])?;
    let after = inside[close..].strip_prefix(end)?;
    // A formula of several lines may compare: `x[0] == 1`.
    let value = after.trim_start_matches([' ', '\t']).strip_prefix('=')?;
    (!value.starts_with('=')).then(|| line.len() - after.len())
}
