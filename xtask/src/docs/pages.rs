//! Which pages the site has, and where each of them lies in it.

use std::path::Path;

use super::markdown;
use super::text_file::read;

/// The list of pages, with their order and titles.
pub(super) const CONTENTS: &str = "docs/SUMMARY.md";

/// A page: its file in the repository, and in the sources of the site.
pub(super) struct Page {
    pub(super) file: String,
    pub(super) place: String,
}

/// All pages, in order.
pub(super) struct Pages {
    pub(super) all: Vec<Page>,
}

impl Pages {
    /// The pages that the list of contents links to.
    pub(super) fn read(root: &Path) -> Result<Self, String> {
        let mut all = Vec::new();
        markdown::rewrite_links(&read(&root.join(CONTENTS))?, &mut |link| {
            let file = resolve(CONTENTS, link);
            all.push(Page { place: place(&file), file });
            Ok(link.to_string())
        })?;
        Ok(Pages { all })
    }

    /// The page of a file, or of the folder whose README it is.
    pub(super) fn find(&self, path: &str) -> Option<&Page> {
        let readme = format!("{path}/README.md");
        self.all.iter().find(|page| page.file == path || page.file == readme)
    }
}

/// `docs/` is the site's root; a README is the page of its folder, and that of the repository the front page.
fn place(file: &str) -> String {
    let inside = match file.strip_prefix("docs/") {
        Some(inside) => inside.to_string(),
        None => file
            .rsplit_once('/')
            .map_or(file, |(folder, name)| match name {
                "README.md" => folder.rsplit('/').next().unwrap_or(folder),
                _ => name,
            })
            .to_lowercase(),
    };
    match inside.as_str() {
        "readme.md" => "index.md".into(),
        inside if inside.ends_with(".md") => inside.replace("/README.md", ".md"),
        folder => format!("{folder}.md"),
    }
}

/// The path from the repository's root that a link in a file means.
pub(super) fn resolve(file: &str, link: &str) -> String {
    let mut parts: Vec<&str> = file.split('/').collect();
    parts.pop();
    for part in link.trim_end_matches('/').split('/') {
        match part {
            "." => {}
            ".." => drop(parts.pop()),
            part => parts.push(part),
        }
    }
    parts.join("/")
}

/// A link from a place of the site to another.
pub(super) fn relative(from: &str, to: &str) -> String {
    format!("{}{to}", "../".repeat(from.matches('/').count()))
}

#[cfg(test)]
mod tests {
    use super::{place, relative, resolve};

    #[test]
    fn files_have_their_places() {
        for (file, expected) in [
            ("README.md", "index.md"),
            ("CONTRIBUTING.md", "contributing.md"),
            ("docs/guide.md", "guide.md"),
            ("docs/gallery/README.md", "gallery.md"),
            ("docs/gallery/nile.md", "gallery/nile.md"),
            ("crates/python/README.md", "python.md"),
        ] {
            assert_eq!(place(file), expected);
        }
    }

    #[test]
    fn links_lead_from_place_to_place() {
        assert_eq!(resolve("docs/gallery/nile.md", "../../examples/nile.toml"), "examples/nile.toml");
        assert_eq!(resolve("README.md", "examples/"), "examples");
        assert_eq!(relative("gallery/nile.md", "guide.md"), "../guide.md");
        assert_eq!(relative("index.md", "gallery/nile.md"), "gallery/nile.md");
    }
}
