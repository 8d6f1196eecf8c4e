//! What a page shows of a terminal: commands, and what they print.

/// A command, which may go on after a backslash at the end of a line, and the lines below it.
#[derive(Debug, PartialEq)]
pub(super) struct Command {
    pub(super) line: String,
    pub(super) prints: Vec<String>,
}

/// The commands of a block.
pub(super) fn commands(lines: &[&str]) -> Vec<Command> {
    let mut commands: Vec<Command> = Vec::new();
    for line in lines {
        match (line.strip_prefix("$ "), commands.last_mut()) {
            (Some(line), _) => commands.push(Command { line: line.into(), prints: vec![] }),
            (None, Some(command)) if command.line.ends_with('\\') && command.prints.is_empty() => {
                command.line += &format!("\n{line}");
            }
            (None, Some(command)) => command.prints.push((*line).into()),
            (None, None) => {}
        }
    }
    commands
}

/// Whether what was printed is what the page shows: `…` stands for any text, and for any lines where it is alone.
pub(super) fn is_as_shown(shown: &[String], printed: &[&str]) -> bool {
    let Some((first, rest)) = shown.split_first() else { return printed.is_empty() };
    if first == "…" {
        return (0..=printed.len()).any(|skipped| is_as_shown(rest, &printed[skipped..]));
    }
    printed
        .split_first()
        .is_some_and(|(line, others)| is_line_as_shown(first, line) && is_as_shown(rest, others))
}

/// What is printed, with `…` where the page shows it: for lines that are left out, and for what differs from run to run.
pub(super) fn updated(shown: &[String], printed: &[&str]) -> Vec<String> {
    let omitted = shown.iter().position(|line| line == "…").map(|at| [at, shown.len() - at - 1]);
    let lines: Vec<&str> = match omitted {
        Some([before, after]) if before + after <= printed.len() => {
            let (start, end) = (&printed[..before], &printed[printed.len() - after..]);
            start.iter().chain(&["…"]).chain(end).copied().collect()
        }
        _ => printed.to_vec(),
    };
    let of_line = |(at, line): (usize, &str)| match shown.get(at) {
        Some(shown) if is_line_as_shown(shown, line) => shown.clone(),
        // Seconds.
        Some(shown) if shown.ends_with("; … s") && line.ends_with(" s") => {
            line.rsplit_once("; ").map_or(line.into(), |(start, _)| format!("{start}; … s"))
        }
        _ => line.into(),
    };
    lines.into_iter().enumerate().map(of_line).collect()
}

fn is_line_as_shown(shown: &str, printed: &str) -> bool {
    let mut parts = shown.split('…');
    let Some(mut rest) = parts.next().and_then(|start| printed.strip_prefix(start)) else { return false };
    let Some(end) = parts.next_back() else { return rest.is_empty() };
    for part in parts {
        let Some((_, after)) = rest.split_once(part) else { return false };
        rest = after;
    }
    rest.ends_with(end)
}

#[cfg(test)]
mod tests {
    use super::{Command, commands, is_as_shown, updated};

    #[test]
    fn commands_have_what_they_print() {
        let found = commands(&["$ motes a", "one", "two", "$ motes \\", "  b"]);
        let command = |line: &str, prints: &[&str]| Command {
            line: line.into(),
            prints: prints.iter().map(|line| line.to_string()).collect(),
        };
        assert_eq!(found, [command("motes a", &["one", "two"]), command("motes \\\n  b", &[])]);
    }

    #[test]
    fn dots_stand_for_anything() {
        let is = |shown: &[&str], printed: &[&str]| {
            is_as_shown(&shown.iter().map(|line| line.to_string()).collect::<Vec<_>>(), printed)
        };
        assert!(is(&["a … c", "…", "end"], &["a b c", "x", "y", "end"]));
        assert!(is(&["in … s, … left"], &["in 2 s, 3 left"]));
        assert!(!is(&["a … c"], &["a b d"]) && !is(&["a"], &["a", "b"]) && !is(&["a", "…", "b"], &["a"]));
    }

    #[test]
    fn what_is_updated_keeps_what_is_left_out() {
        let shown = ["one 1; … s", "…", "end 1"].map(String::from);
        let found = updated(&shown, &["one 2; 3.0 s", "two", "three", "end 2"]);
        assert_eq!(found, ["one 2; … s", "…", "end 2"]);
        assert_eq!(updated(&["a …".into()], &["a b"]), ["a …"]);
    }
}
