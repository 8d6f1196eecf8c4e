//! Runs the commands and the Python code of pages, each page in a folder of its own, and holds what they print against the page.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Instant;

use super::blocks::blocks;
use super::pages::{CONTENTS, Page, Pages, resolve};
use super::pictures::{figure, pictures};
use super::snippets::Python;
use super::text_file::{read, write};
use super::transcript::{self, is_as_shown, updated};

/// What is run; installations and long runs are not.
const PROGRAMS: [&str; 4] = ["motes", "python3", "cut", "grep"];

/// What pages may read and write.
const COPIED: [&str; 2] = ["examples", "experiments/models"];

/// Runs all pages, or those that are named.
pub(super) fn pages(root: &Path, motes: &Path, only: &[String], update: bool) -> Result<(), String> {
    let python = Python::find(root)?;
    if python.is_none() {
        println!("docs: Python code is left out: cargo xtask python has not built the package here");
    }
    let all = Pages::read(root)?.all;
    if let Some(unknown) = only.iter().find(|name| !all.iter().any(|page| page.file == **name)) {
        return Err(format!("{unknown} is no page; {CONTENTS} names them"));
    }
    let chosen = all.iter().filter(|page| only.is_empty() || only.contains(&page.file));
    let run = |page: &Page| Run::new(root, motes, &page.file, update)?.page(python.as_ref());
    let failed: Vec<String> = chosen.filter_map(|page| run(page).err()).collect();
    if failed.is_empty() { Ok(()) } else { Err(failed.join("\n")) }
}

/// A page that is run.
struct Run<'a> {
    root: &'a Path,
    motes: &'a Path,
    page: &'a str,
    update: bool,
    folder: PathBuf,
}

impl<'a> Run<'a> {
    fn new(root: &'a Path, motes: &'a Path, page: &'a str, update: bool) -> Result<Self, String> {
        let folder = root.join("target/docs/run");
        let _ = std::fs::remove_dir_all(&folder);
        for copied in COPIED {
            let to = folder.join(copied);
            copy(&root.join(copied), &to).map_err(|error| format!("{}: {error}", to.display()))?;
        }
        Ok(Run { root, motes, page, update, folder })
    }

    fn page(&self, python: Option<&Python>) -> Result<(), String> {
        let start = Instant::now();
        let path = self.root.join(self.page);
        let text = read(&path)?;
        let lines: Vec<&str> = text.lines().collect();
        let (mut written, mut from) = (Vec::new(), 0);
        let (mut count, mut report, mut code) = (0, None, String::new());
        for block in blocks(&lines) {
            let content = &lines[block.lines.clone()];
            if block.language == "python" {
                code += &(content.join("\n") + "\n");
            }
            if block.language != "console" {
                continue;
            }
            written.extend(lines[from..block.lines.start].iter().map(|line| line.to_string()));
            from = block.lines.end;
            for mut command in transcript::commands(content) {
                if command.line.split(' ').next().is_some_and(|program| PROGRAMS.contains(&program)) {
                    let printed = match self.run(&command.line)? {
                        Ok(printed) => printed,
                        Err(said) => {
                            println!("docs: the rest of {} is left out: {}: {said}", self.page, command.line);
                            return Ok(());
                        }
                    };
                    self.compare(&mut command, &printed)?;
                    report = report_of(&command.line).map(|name| self.folder.join(name)).or(report);
                    count += 1;
                }
                written.push(format!("$ {}", command.line));
                written.append(&mut command.prints);
            }
        }
        written.extend(lines[from..].iter().map(|line| line.to_string()));
        if let (Some(python), false) = (python, code.is_empty()) {
            python.run(&self.folder, &code).map_err(|said| format!("{}: {said}", self.page))?;
            count += 1;
        }
        self.hold_pictures(&text, report.as_deref())?;
        if self.update {
            write(&path, (written.join("\n") + "\n").as_bytes())?;
        }
        if count > 0 {
            println!("docs: {} ran in {:.0} s", self.page, start.elapsed().as_secs_f64());
        }
        Ok(())
    }

    /// What a command prints; its last line where data cannot be fetched, as without a network.
    fn run(&self, line: &str) -> Result<Result<String, String>, String> {
        let beside = self.motes.parent().unwrap_or(self.root).as_os_str();
        let mut path = beside.to_os_string();
        path.push(":");
        path.push(std::env::var_os("PATH").unwrap_or_default());
        let mut shell = Command::new("sh");
        shell.args(["-c", &format!("exec 2>&1; {line}")]).env("PATH", path).current_dir(&self.folder);
        let output = shell.stdin(std::process::Stdio::null()).output();
        let output = output.map_err(|error| format!("sh: {error}"))?;
        let printed = String::from_utf8_lossy(&output.stdout).into_owned();
        match (output.status.success(), line.starts_with("python3 ")) {
            (true, _) => Ok(Ok(printed)),
            (false, true) => Ok(Err(printed.trim_end().lines().last().unwrap_or("it failed").into())),
            (false, false) => Err(format!("{}: {line}\n{printed}", self.page)),
        }
    }

    /// What is printed is what the page shows, if it shows anything, or becomes so.
    fn compare(&self, command: &mut transcript::Command, printed: &str) -> Result<(), String> {
        let lines: Vec<&str> = printed.trim_end().lines().map(str::trim_end).collect();
        if command.prints.is_empty() || is_as_shown(&command.prints, &lines) {
            return Ok(());
        }
        if !self.update {
            let shown = command.prints.join("\n");
            return Err(format!(
                "{}: {}\nis said to print\n{shown}\nand prints\n{printed}",
                self.page, command.line
            ));
        }
        if lines.is_empty() {
            return Err(format!("{}: {} prints nothing any more", self.page, command.line));
        }
        command.prints = updated(&command.prints, &lines);
        Ok(())
    }

    /// Each picture is the figure of the report that it is said to be, or becomes so.
    fn hold_pictures(&self, text: &str, report: Option<&Path>) -> Result<(), String> {
        let pictures = pictures(text);
        let Some(report) = report else {
            return match pictures.is_empty() {
                true => Ok(()),
                false => Err(format!("{}: a picture has a title, and no command writes a report", self.page)),
            };
        };
        let report_text = read(report)?;
        for picture in pictures {
            let Some(svg) = figure(&report_text, picture.figure) else {
                return Err(format!("{}: the report has no figure {:?}", self.page, picture.figure));
            };
            let path = self.root.join(resolve(self.page, picture.file));
            let svg = format!("{svg}\n");
            if self.update {
                write(&path, svg.as_bytes())?;
            } else if read(&path)? != svg {
                return Err(format!(
                    "{}: {} is another picture than that of the report",
                    self.page, picture.file
                ));
            }
        }
        Ok(())
    }
}

/// The report that a command writes.
fn report_of(line: &str) -> Option<&str> {
    line.split_once("--report ")?.1.split_whitespace().next()
}

fn copy(from: &Path, to: &Path) -> std::io::Result<()> {
    std::fs::create_dir_all(to)?;
    for entry in std::fs::read_dir(from)? {
        let entry = entry?;
        let to = to.join(entry.file_name());
        match entry.file_type()?.is_dir() {
            true => copy(&entry.path(), &to)?,
            false => std::fs::copy(entry.path(), to).map(drop)?,
        }
    }
    Ok(())
}

#[cfg(all(test, unix))]
mod tests {
    use std::os::unix::fs::PermissionsExt;
    use std::path::Path;

    use super::pages;

    const REPORT: &str = "<svg><text>level</text></svg>";

    /// A project of one page, and a command that writes a report and prints what it was asked for.
    fn project(folder: &Path) -> std::path::PathBuf {
        let write = |name: &str, text: &str| super::write(&folder.join(name), text.as_bytes()).unwrap();
        write("docs/SUMMARY.md", "- [A](a.md)\n");
        write("examples/a.toml", "");
        write("experiments/models/b.toml", "");
        write("docs/a.svg", REPORT);
        write(
            "docs/a.md",
            "# A\n\n```console\n$ motes a --report r.html\na\n$ cargo xtask ci\n```\n![a](a.svg \"level\")\n",
        );
        write("bin/motes", &format!("#!/bin/sh\necho \"$1\"\nls examples >&2\necho '{REPORT}' >r.html\n"));
        let motes = folder.join("bin/motes");
        std::fs::set_permissions(&motes, std::fs::Permissions::from_mode(0o755)).unwrap();
        motes
    }

    #[test]
    fn a_page_is_held_against_what_its_commands_print() {
        let folder = tempfile::tempdir().unwrap();
        let motes = project(folder.path());
        let run = |update: bool| pages(folder.path(), &motes, &[], update);
        let error = run(false).unwrap_err();
        let place = "docs/a.md: motes a --report r.html\nis said to print\na\nand prints\na\na.toml\n";
        assert_eq!(error, place);
        run(true).unwrap();
        let page = std::fs::read_to_string(folder.path().join("docs/a.md")).unwrap();
        assert!(page.contains("r.html\na\na.toml\n$ cargo xtask ci\n```\n![a]"), "{page}");
        run(false).unwrap();
        std::fs::write(folder.path().join("docs/a.svg"), "another").unwrap();
        assert!(run(false).unwrap_err().contains("another picture"));
    }
}
