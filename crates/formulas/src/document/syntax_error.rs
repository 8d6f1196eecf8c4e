//! Why a text is not TOML, in the words of one who writes formulas.

use crate::error::{Fault, Problem, Section};

/// The fault at a byte of a text, for the parser's reason.
pub(super) fn explain(text: &str, at: Option<usize>, reason: String) -> Fault {
    let Some(at) = at else { return Fault::new(Problem::NotToml(reason)) };
    let at = text.floor_char_boundary(at);
    let start = text[..at].rfind('\n').map_or(0, |newline| newline + 1);
    let line = text[start..].lines().next().unwrap_or_default();
    let assigned = line.split_once('=').map(|(key, value)| (key.trim(), value.trim()));
    let problem = match (reason.as_str(), assigned) {
        ("duplicate key", Some((key, _))) => Problem::TwiceHere(key.trim_matches('"').to_string()),
        ("duplicate key", None) => Problem::TwiceHere(line.trim().to_string()),
        (_, Some((key, value))) if is_formula(value) => {
            Problem::NoQuotes { key: key.to_string(), formula: value.to_string() }
        }
        _ => Problem::NotToml(reason),
    };
    let fault = Fault::at(at, problem);
    let header = |line: &str| Section::ALL.into_iter().find(|section| section.title() == line.trim());
    let last = text[..start].lines().rfind(|line| line.trim_start().starts_with('['));
    match (last.and_then(header), assigned) {
        (Some(section), Some((key, _))) => fault.in_section(section).of_key(key.trim_matches('"')),
        (Some(section), None) if !line.trim_start().starts_with('[') => fault.in_section(section),
        _ => fault,
    }
}

/// Whether a value looks like a formula without quotes.
fn is_formula(value: &str) -> bool {
    value.starts_with(|c: char| c.is_alphanumeric() || "_(-+".contains(c))
        && value.contains(|c: char| c.is_alphabetic() || "+-*/^(".contains(c))
        && !value.contains(['"', '\''])
}
