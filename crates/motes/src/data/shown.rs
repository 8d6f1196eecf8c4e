//! What stands in a cell, for a line about it.

/// A cell in one line that is not long.
pub(super) fn shown(text: &str) -> String {
    const LONGEST: usize = 40;
    let text = text.trim();
    match text.char_indices().nth(LONGEST) {
        _ if text.is_empty() => "an empty cell".to_string(),
        None => text.escape_debug().to_string(),
        Some((end, _)) => format!("{}…", text[..end].escape_debug()),
    }
}
