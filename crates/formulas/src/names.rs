//! What a name looks like.

/// Whether a name can begin with it.
pub(crate) fn begins_name(c: char) -> bool {
    c.is_alphabetic() || c == '_'
}

/// Whether it can stand in a name.
pub(crate) fn is_in_name(c: char) -> bool {
    begins_name(c) || c.is_ascii_digit()
}

/// Whether it is a name.
pub(crate) fn is_name(text: &str) -> bool {
    text.starts_with(begins_name) && text.chars().all(is_in_name)
}
