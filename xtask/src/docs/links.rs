//! Follows the links of a finished site: every file and every place in a page has to be there.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Component, Path, PathBuf};

use super::text_file::read;

/// Pages that are made for other readers: of links from anywhere, and of all sidebars.
const SKIPPED: [&str; 2] = ["404.html", "toc.html"];

/// The number of links that were followed.
pub(super) fn check(site: &Path) -> Result<usize, String> {
    let mut files = Vec::new();
    walk(site, &mut files).map_err(|error| format!("{}: {error}", site.display()))?;
    let mut pages = BTreeMap::new();
    for file in files.iter().filter(|file| file.extension().is_some_and(|ending| ending == "html")) {
        if !SKIPPED.iter().any(|name| file.ends_with(name)) {
            pages.insert(file.clone(), read(file)?);
        }
    }
    let places: BTreeMap<&PathBuf, BTreeSet<String>> =
        pages.iter().map(|(page, text)| (page, values(text, "id").collect())).collect();
    let mut count = 0;
    let mut broken = Vec::new();
    for (page, text) in &pages {
        for link in ["href", "src"].into_iter().flat_map(|name| values(text, name)) {
            if link.contains(':') {
                continue;
            }
            let (path, anchor) = link.split_once('#').unwrap_or((&link, ""));
            let path = path.split('?').next().unwrap_or(path);
            let target = match path {
                "" => page.clone(),
                path => cleaned(&page.parent().unwrap_or(site).join(path)),
            };
            let is_there = anchor.is_empty() || places.get(&target).is_some_and(|ids| ids.contains(anchor));
            if !target.is_file() || !is_there {
                broken.push(format!("{}: {link}", page.strip_prefix(site).unwrap_or(page).display()));
            }
            count += 1;
        }
    }
    match broken.is_empty() {
        true => Ok(count),
        false => Err(format!("links that lead nowhere:\n{}", broken.join("\n"))),
    }
}

fn walk(folder: &Path, files: &mut Vec<PathBuf>) -> std::io::Result<()> {
    for entry in std::fs::read_dir(folder)? {
        let path = entry?.path();
        match path.is_dir() {
            true => walk(&path, files)?,
            false => files.push(path),
        }
    }
    Ok(())
}

/// The values of an attribute, as text.
fn values<'a>(html: &'a str, attribute: &str) -> impl Iterator<Item = String> + 'a {
    let start = format!(" {attribute}=\"");
    let parts: Vec<&str> = html.split(&start).skip(1).collect();
    parts
        .into_iter()
        .filter_map(|rest| rest.split('"').next())
        .map(|value| plain(&value.replace("&amp;", "&")))
}

/// Without percent signs: `%C3%A9` is `é`.
fn plain(link: &str) -> String {
    let mut bytes = Vec::new();
    let mut rest = link.as_bytes();
    while let Some((&first, after)) = rest.split_first() {
        let code =
            after.get(..2).and_then(|code| u8::from_str_radix(std::str::from_utf8(code).ok()?, 16).ok());
        match code.filter(|_| first == b'%') {
            Some(byte) => {
                bytes.push(byte);
                rest = &after[2..];
            }
            None => {
                bytes.push(first);
                rest = after;
            }
        }
    }
    String::from_utf8_lossy(&bytes).into_owned()
}

/// A path without `..`.
fn cleaned(path: &Path) -> PathBuf {
    let mut cleaned = PathBuf::new();
    for part in path.components() {
        match part {
            Component::ParentDir => drop(cleaned.pop()),
            part => cleaned.push(part),
        }
    }
    cleaned
}

#[cfg(test)]
mod tests {
    use super::check;

    #[test]
    fn a_link_that_leads_nowhere_is_named() {
        let site = tempfile::tempdir().unwrap();
        let write = |name: &str, text: &str| std::fs::write(site.path().join(name), text).unwrap();
        std::fs::create_dir(site.path().join("a")).unwrap();
        write(
            "index.html",
            "<a href=\"a/b.html#th%C3%A9\"></a><a href=\"https://there\"></a><h2 id=\"top\">",
        );
        write("a/b.html", "<h2 id=\"thé\"></h2><a href=\"../index.html#top\"></a>");
        assert_eq!(check(site.path()), Ok(2));
        write("a/b.html", "<a href=\"../index.html#end\"></a><a href=\"c.html\"></a>");
        let broken = "links that lead nowhere:\na/b.html: ../index.html#end\na/b.html: c.html\nindex.html: a/b.html#thé";
        assert_eq!(check(site.path()), Err(broken.into()));
    }
}
