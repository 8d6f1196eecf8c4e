//! The words of a formula.

use std::ops::Range;

use crate::error::{Fault, Problem};
use crate::names::{begins_name, is_in_name};

/// A word.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Token {
    Number(f64),
    Name,
    Plus,
    Minus,
    Times,
    Over,
    Power,
    Open,
    Close,
    OpenIndex,
    CloseIndex,
    Comma,
    Less,
    AtMost,
    Greater,
    AtLeast,
    Equal,
    NotEqual,
    And,
    Or,
    Not,
    End,
}

impl Token {
    /// Whether an operand begins with it, if it does not end an expression.
    pub(super) fn begins_operand(self) -> bool {
        matches!(self, Token::Number(_) | Token::Name | Token::Open | Token::Not)
    }
}

/// What to do instead of a character that formulas do not have.
fn advice(found: char) -> &'static str {
    match found {
        '!' => "write not, or != for what differs",
        '?' => "a choice is written if(c, a, b)",
        '&' => "write and, as in x > 0 and x < 1",
        '|' => "write or, as in x < 0 or x > 1",
        '=' => "arguments have no names, and equality is written ==",
        '·' | '×' | '∙' => "a product is written with *",
        '÷' => "a quotient is written with /",
        '−' | '–' => "a minus is written -",
        '²' | '³' => "a power is written x^2",
        '√' => "the square root is written sqrt(x)",
        '{' | '}' => "parentheses are written ( and )",
        '%' => "a remainder is written mod(x, n)",
        '.' => "numbers are written 0.5, 10, 1e-3",
        '~' => "the distribution is written alone, as in \"normal(0, 1)\"",
        ';' | ':' => "arguments are separated by commas",
        _ => "it has names, numbers, + - * / ^ ( ) [ ] and commas",
    }
}

/// Whether a text begins with a number: with a digit, or with a point and a digit.
fn begins_number(text: &str) -> bool {
    text.strip_prefix('.').unwrap_or(text).starts_with(|first: char| first.is_ascii_digit())
}

/// The end of the number at the beginning of a text.
fn end_of_number(text: &str) -> usize {
    let bytes = text.as_bytes();
    let digits = |from: usize| {
        let count = bytes[from..].iter().take_while(|byte| byte.is_ascii_digit() || **byte == b'_').count();
        from + count
    };
    let mut end = digits(0);
    if bytes.get(end) == Some(&b'.') {
        end = digits(end + 1);
    }
    if matches!(bytes.get(end), Some(b'e' | b'E')) {
        let sign = usize::from(matches!(bytes.get(end + 1), Some(b'+' | b'-')));
        if bytes.get(end + 1 + sign).is_some_and(u8::is_ascii_digit) {
            end = digits(end + 1 + sign);
        }
    }
    // A second point belongs to it, too: what stands there is refused as a whole.
    while end > 0 && bytes.get(end) == Some(&b'.') {
        end = digits(end + 1);
    }
    end
}

/// The value of a number as TOML writes numbers; `.5` and `5.` are numbers, too, as in most languages.
fn number(written: &str) -> Result<f64, Problem> {
    let bad = || Problem::BadNumber(written.to_string());
    let bytes = written.as_bytes();
    let is_digit = |at: Option<usize>| at.and_then(|at| bytes.get(at)).is_some_and(u8::is_ascii_digit);
    for (at, byte) in bytes.iter().enumerate() {
        let between = is_digit(at.checked_sub(1)) && is_digit(Some(at + 1));
        let beside = is_digit(at.checked_sub(1)) || is_digit(Some(at + 1));
        if (*byte == b'_' && !between) || (*byte == b'.' && !beside) {
            return Err(bad());
        }
    }
    let value: f64 = written.replace('_', "").parse().map_err(|_| bad())?;
    if value.is_finite() { Ok(value) } else { Err(Problem::NumberTooLarge(written.to_string())) }
}

/// The first word of `text` from a byte on, and where it is.
pub(super) fn next(text: &str, from: usize) -> Result<(Token, Range<usize>), Fault> {
    let rest = text[from..].trim_start();
    let start = text.len() - rest.len();
    let Some(first) = rest.chars().next() else { return Ok((Token::End, start..start)) };
    let one = |token| Ok((token, start..start + 1));
    let two = |token| Ok((token, start..start + 2));
    match first {
        '+' => one(Token::Plus),
        '-' => one(Token::Minus),
        '*' if rest.starts_with("**") => {
            let (found, expected) = ("`**`".to_string(), "the power ^".to_string());
            Err(Fault::at(start, Problem::Unexpected { found, expected }))
        }
        '*' => one(Token::Times),
        '/' => one(Token::Over),
        '^' => one(Token::Power),
        '(' => one(Token::Open),
        ')' => one(Token::Close),
        '[' => one(Token::OpenIndex),
        ']' => one(Token::CloseIndex),
        ',' => one(Token::Comma),
        '<' if rest.starts_with("<=") => two(Token::AtMost),
        '<' => one(Token::Less),
        '>' if rest.starts_with(">=") => two(Token::AtLeast),
        '>' => one(Token::Greater),
        '=' if rest.starts_with("==") => two(Token::Equal),
        '!' if rest.starts_with("!=") => two(Token::NotEqual),
        _ if begins_number(rest) => {
            let end = end_of_number(rest);
            let value = number(&rest[..end]).map_err(|problem| Fault::at(start, problem))?;
            Ok((Token::Number(value), start..start + end))
        }
        _ if begins_name(first) => {
            let end = rest.find(|c| !is_in_name(c)).unwrap_or(rest.len());
            let token = match &rest[..end] {
                "and" => Token::And,
                "or" => Token::Or,
                "not" => Token::Not,
                _ => Token::Name,
            };
            Ok((token, start..start + end))
        }
        found => Err(Fault::at(start, Problem::UnexpectedCharacter { found, advice: advice(found) })),
    }
}
