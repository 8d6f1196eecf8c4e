//! The page of the command line, made of what the command says of itself.

use std::path::Path;
use std::process::Command;

/// A section for each command.
pub(super) fn page(motes: &Path) -> Result<String, String> {
    let mut page = String::new();
    for command in commands(&help(motes, &[])?) {
        let text = help(motes, &[command])?;
        page += &format!("## {command}\n\n```text\n{}\n```\n\n", text.trim_end());
    }
    match page.is_empty() {
        true => Err(format!("{} --help names no command", motes.display())),
        false => Ok(page),
    }
}

/// The names that the list of commands has.
fn commands(help: &str) -> Vec<&str> {
    let list = help.split_once("Commands:\n").map_or("", |(_, list)| list);
    let lines = list.lines().take_while(|line| !line.is_empty());
    // A line that goes on is farther to the right.
    let names = lines.filter_map(|line| line.strip_prefix("  ")?.split(' ').next());
    names.filter(|name| !name.is_empty() && *name != "help").collect()
}

fn help(motes: &Path, command: &[&str]) -> Result<String, String> {
    let output = Command::new(motes).args(command).arg("--help").output();
    let output = output.map_err(|error| format!("{}: {error}", motes.display()))?;
    if !output.status.success() {
        return Err(format!("{} {} --help failed", motes.display(), command.join(" ")));
    }
    String::from_utf8(output.stdout).map_err(|error| error.to_string())
}

#[cfg(test)]
mod tests {
    #[test]
    fn commands_are_those_of_the_list() {
        let help = "About.\n\nUsage: motes <COMMAND>\n\nCommands:\n  filter  Estimate\n          states\n  help    Print\n\nOptions:\n  -h\n";
        assert_eq!(super::commands(help), ["filter"]);
    }
}
