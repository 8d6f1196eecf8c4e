//! Links of a page in Markdown.

/// The page with each target of a link replaced by what `target` makes of it; code stays as it is.
pub(super) fn rewrite_links(
    text: &str,
    target: &mut dyn FnMut(&str) -> Result<String, String>,
) -> Result<String, String> {
    let mut written = String::new();
    let mut in_block = false;
    for line in text.split_inclusive('\n') {
        let is_fence = line.trim_start().starts_with("```");
        if is_fence || in_block {
            written.push_str(line);
        } else {
            rewrite_line(line, target, &mut written)?;
        }
        in_block ^= is_fence;
    }
    Ok(written)
}

fn rewrite_line(
    line: &str,
    target: &mut dyn FnMut(&str) -> Result<String, String>,
    written: &mut String,
) -> Result<(), String> {
    let mut rest = line;
    while let Some(at) = [rest.find('`'), rest.find("](")].into_iter().flatten().min() {
        let (before, found) = rest.split_at(at);
        written.push_str(before);
        rest = match found.strip_prefix("](") {
            Some(link) => {
                // A title may follow the target.
                let (link, after) = link.split_at(link.find([')', ' ']).unwrap_or(link.len()));
                written.push_str(&format!("]({}", target(link)?));
                after
            }
            None => {
                let (code, after) = found.split_at(code_length(found));
                written.push_str(code);
                after
            }
        };
    }
    written.push_str(rest);
    Ok(())
}

/// The length of the code that a text begins with, or of its backticks where they are never closed.
fn code_length(text: &str) -> usize {
    let ticks = text.len() - text.trim_start_matches('`').len();
    let mut at = ticks;
    while let Some(next) = text[at..].find('`') {
        let start = at + next;
        let run = text[start..].len() - text[start..].trim_start_matches('`').len();
        at = start + run;
        if run == ticks {
            return at;
        }
    }
    ticks
}

#[cfg(test)]
mod tests {
    use super::rewrite_links;

    #[test]
    fn links_are_found_but_not_in_code() {
        let text = "[a](b.md#c) `[x](y)` ``[`x`](y)`` [`code`](d.md) ![p](e.svg \"title (it)\")\n```toml\n[x](y)\n```\n[f](g)\n";
        let mut found = Vec::new();
        let written = rewrite_links(text, &mut |link| {
            found.push(link.to_string());
            Ok(format!("<{link}>"))
        });
        assert_eq!(found, ["b.md#c", "d.md", "e.svg", "g"]);
        let written = written.unwrap();
        assert!(
            written.contains("![p](<e.svg> \"title (it)\")\n```toml\n[x](y)\n```\n[f](<g>)\n"),
            "{written}"
        );
    }
}
