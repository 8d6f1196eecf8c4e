//! A run in one line, and the command that made it.

/// The figures in one line.
pub(super) fn in_one_line(figures: &[(String, String)]) -> String {
    figures.iter().map(|(name, value)| format!("{name} {value}")).collect::<Vec<_>>().join(", ")
}

/// The command as it was given.
pub(super) fn command_line() -> String {
    let quoted =
        |argument: String| match argument.chars().all(|c| c.is_alphanumeric() || "-_./=,:+".contains(c)) {
            true => argument,
            false => format!("'{}'", argument.replace('\'', "'\\''")),
        };
    let arguments =
        std::env::args_os().skip(1).map(|argument| quoted(argument.to_string_lossy().into_owned()));
    std::iter::once("motes".to_string()).chain(arguments).collect::<Vec<_>>().join(" ")
}
