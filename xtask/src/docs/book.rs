//! The sources of the site: pages under new names, their links led along, pictures beside them.

use std::path::Path;

use super::markdown;
use super::pages::{CONTENTS, Page, Pages, relative, resolve};
use super::text_file::{read, write};

/// Where a page has what the command says of itself.
const HELP: &str = "<!-- help -->";

/// How a line begins that stands for a file of the repository, such as a model.
const FILE: &str = "<!-- file ";

/// Writes into `folder` what mdbook makes the site of.
pub(super) fn assemble(
    root: &Path,
    folder: &Path,
    pages: &Pages,
    repository: &str,
    help: &str,
) -> Result<(), String> {
    let sources = folder.join("src");
    if sources.exists() {
        std::fs::remove_dir_all(&sources).map_err(|error| format!("{}: {error}", sources.display()))?;
    }
    for settings in ["book.toml", "site.css"] {
        write(&folder.join(settings), read(&root.join("docs").join(settings))?.as_bytes())?;
    }
    let contents = Page { file: CONTENTS.into(), place: "SUMMARY.md".into() };
    for page in pages.all.iter().chain([&contents]) {
        let text = with_files(root, &read(&root.join(&page.file))?)?;
        let text =
            markdown::rewrite_links(&text, &mut |link| led(root, &sources, pages, page, repository, link))?;
        write(&sources.join(&page.place), text.replace(HELP, help).as_bytes())?;
    }
    Ok(())
}

/// A page with the files that it names in full.
fn with_files(root: &Path, text: &str) -> Result<String, String> {
    let mut written = String::new();
    for line in text.split_inclusive('\n') {
        match line.strip_prefix(FILE).and_then(|rest| rest.split(' ').next()) {
            Some(file) => {
                let language = file.rsplit('.').next().unwrap_or_default();
                written += &format!("```{language}\n{}\n```\n", read(&root.join(file))?.trim_end());
            }
            None => written += line,
        }
    }
    Ok(written)
}

/// What a link of a page is in the site.
fn led(
    root: &Path,
    sources: &Path,
    pages: &Pages,
    page: &Page,
    repository: &str,
    link: &str,
) -> Result<String, String> {
    let (path, anchor) = link.split_at(link.find('#').unwrap_or(link.len()));
    if path.is_empty() || path.contains("://") {
        return Ok(link.to_string());
    }
    let path = resolve(&page.file, path);
    if let Some(other) = pages.find(&path) {
        return Ok(relative(&page.place, &other.place) + anchor);
    }
    let file = root.join(&path);
    if !file.exists() {
        return Err(format!("{}: {link} is not there", page.file));
    }
    if path.ends_with(".svg") || path.ends_with(".png") {
        let place = format!("pictures/{}", path.replace('/', "-"));
        let content = std::fs::read(&file).map_err(|error| format!("{}: {error}", file.display()))?;
        write(&sources.join(&place), &content)?;
        return Ok(relative(&page.place, &place));
    }
    // The site of a repository shows the files of its main branch.
    let folder = if repository.starts_with("file:") { "" } else { "/blob/HEAD" };
    Ok(format!("{repository}{folder}/{path}{anchor}"))
}
