//! The house: which crate may know which, what stays out of the light ones, and what stays out of all.

use std::path::{Path, PathBuf};
use std::process::Command;

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap().to_path_buf()
}

/// The `motes-` crates that a manifest depends on outside tests.
fn known_to(manifest: &str) -> Vec<String> {
    let text = std::fs::read_to_string(root().join(manifest)).unwrap();
    let manifest: toml::Table = toml::from_str(&text).unwrap();
    let dependencies =
        manifest.get("dependencies").and_then(|table| table.as_table()).cloned().unwrap_or_default();
    let of_ours = |name: &&String| *name == "motes" || name.starts_with("motes-");
    dependencies.keys().filter(of_ours).cloned().collect()
}

#[test]
fn arrows_go_one_way() {
    let known = [
        ("models", &[][..]),
        ("formulas", &["models"]),
        ("inference", &["models"]),
        ("smc", &["models"]),
        ("motes", &["cli", "formulas", "inference", "models", "proposals", "smc", "train"]),
        ("networks", &["models"]),
        ("proposals", &["models", "networks", "smc"]),
        ("train", &["models", "proposals", "smc"]),
        ("cli", &[]),
        // The facade, whose functions benchmarks call as anybody would.
        ("bench", &["", "cli", "models", "proposals", "smc", "train"]),
        ("speed", &["cli", "models", "proposals", "smc", "train"]),
        // Python has what the facade has, and nothing of its own.
        ("python", &[""]),
    ];
    for (name, expected) in known {
        let expected: Vec<String> = expected
            .iter()
            .map(|name| if name.is_empty() { "motes".into() } else { format!("motes-{name}") })
            .collect();
        assert_eq!(known_to(&format!("crates/{name}/Cargo.toml")), expected, "{name}");
    }
    assert_eq!(known_to("xtask/Cargo.toml"), ["motes-cli"], "xtask builds the others and links none of them");
}

/// The packages in the normal dependency tree of one package.
fn tree(package: &str, more: &[&str]) -> Vec<String> {
    let arguments = ["tree", "--offline", "--package", package, "--edges", "normal", "--prefix", "none"];
    let output = Command::new(env!("CARGO")).current_dir(root()).args(arguments).args(more).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let text = String::from_utf8(output.stdout).unwrap();
    text.lines().filter_map(|line| line.split(' ').next()).map(String::from).collect()
}

#[test]
fn the_light_crates_and_xtask_are_light() {
    for package in ["motes-models", "motes-formulas", "motes-inference", "motes-smc", "xtask"] {
        let tree = tree(package, &[]);
        assert!(tree.len() > 5, "the tree of {package} is suspiciously small: {tree:?}");
        let heavy = ["burn", "cubecl", "ndarray", "plotters", "indicatif", "rayon"];
        // Waiting threads, and nothing of rayon's iterators.
        let allowed =
            |name: &String| ["motes-smc", "motes-inference"].contains(&package) && name == "rayon-core";
        for name in tree.iter().filter(|name| !allowed(name)) {
            assert!(!heavy.iter().any(|heavy| name.starts_with(heavy)), "{package} depends on {name}");
            assert!(package == "xtask" || !name.starts_with("clap"), "{package} depends on {name}");
        }
    }
}

#[test]
fn burn_is_there_for_who_asks_for_it() {
    let has_burn = |package, more| tree(package, more).iter().any(|name| name.starts_with("burn"));
    assert!(!has_burn("motes", &[]), "the command depends on burn");
    for package in ["motes-networks", "motes-proposals", "motes-train", "motes-bench"] {
        assert!(!has_burn(package, &[]), "{package} depends on burn");
        assert!(has_burn(package, &["--features", "burn"]), "{package} has no burn to offer");
    }
}

fn sources(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            sources(&path, found);
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            found.push(path);
        }
    }
}

/// Every Rust file below these folders with its text.
fn texts(folders: &[&str]) -> Vec<(PathBuf, String)> {
    let mut found = Vec::new();
    folders.iter().for_each(|folder| sources(&root().join(folder), &mut found));
    assert!(!found.is_empty());
    found.into_iter().map(|path| (path.clone(), std::fs::read_to_string(path).unwrap())).collect()
}

/// The lines that are code: what comments and documentation say is their own business.
fn code(text: &str) -> impl Iterator<Item = &str> {
    text.lines().filter(|line| !line.trim_start().starts_with("//"))
}

#[test]
fn what_learns_cannot_be_handed_states() {
    for (path, text) in texts(&["crates/proposals/src", "crates/train/src"]) {
        let named = ["Trajectory", "Sequence", "simulate", "Simulator"];
        let line = code(&text).find(|line| named.iter().any(|name| line.contains(name)));
        assert_eq!(line, None, "{}", path.display());
    }
}

#[test]
fn nothing_draws_from_a_hidden_generator() {
    let hidden = [
        "thread_rng",
        "ThreadRng",
        "rand::rng(",
        "rand::rng;",
        "make_rng",
        "rand::random",
        "SysRng",
        "OsRng",
        "from_os_rng",
        "Tensor::random",
        "tensor::Distribution",
        ".seed(",
    ];
    for (path, text) in texts(&["crates", "xtask/src"]) {
        let line = code(&text).find(|line| hidden.iter().any(|name| line.contains(name)));
        assert_eq!(line, None, "{}", path.display());
    }
}

#[test]
fn every_file_says_what_it_is_and_stays_small() {
    for (path, text) in texts(&["crates", "xtask", "tests"]) {
        assert!(text.starts_with("//! "), "{} does not begin with its purpose", path.display());
        let lines = text.lines().count();
        assert!(lines <= 420, "{} has {lines} lines: more than one idea?", path.display());
    }
}

#[test]
fn the_version_of_burn_is_stated_rightly() {
    let text = std::fs::read_to_string(root().join("Cargo.toml")).unwrap();
    let stated = format!("burn = {{ version = \"={}\"", motes_proposals::networks::BURN_VERSION);
    assert!(
        text.contains(&stated),
        "Cargo.toml does not pin burn to {}",
        motes_proposals::networks::BURN_VERSION
    );
}

/// What stands above the function of that name in a text, from the function before it on.
fn above<'a>(text: &'a str, test: &str) -> Option<&'a str> {
    let (before, _) = text.split_once(&format!("fn {test}("))?;
    Some(before.rfind('}').map_or(before, |end| &before[end..]))
}

/// The pages that people read.
fn pages() -> Vec<PathBuf> {
    let mut pages =
        ["README.md", "ARCHITECTURE.md", "CONTRIBUTING.md"].map(|name| root().join(name)).to_vec();
    let docs = std::fs::read_dir(root().join("docs")).unwrap().map(|entry| entry.unwrap().path());
    pages.extend(docs.filter(|path| path.extension().is_some_and(|extension| extension == "md")));
    pages
}

/// What a line has in backticks of the form `file::test`. Types are in capitals, so that `smc::Bootstrap` is none.
fn named(line: &str) -> impl Iterator<Item = (&str, &str)> {
    let is_name = |name: &str| {
        let is_of_it = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '_';
        !name.is_empty() && name.chars().all(is_of_it)
    };
    let codes = line.split('`').skip(1).step_by(2).filter_map(|code| code.split_once("::"));
    codes.filter(move |(file, test)| is_name(file) && is_name(test))
}

#[test]
fn pages_name_tests_that_exist() {
    let texts = texts(&["crates", "tests", "xtask"]);
    for page in pages() {
        let text = std::fs::read_to_string(&page).unwrap();
        for (line, file, test) in text.lines().flat_map(|line| named(line).map(move |(a, b)| (line, a, b))) {
            let of_file: Vec<&str> = texts
                .iter()
                .filter(|(path, text)| {
                    path.file_stem().is_some_and(|stem| stem == file) && text.contains("#[test]")
                })
                .map(|(_, text)| text.as_str())
                .collect();
            // The path of a function, as `motes::learn`.
            if of_file.is_empty() {
                continue;
            }
            let mut found = of_file.iter().filter_map(|text| above(text, test));
            let Some(above) = found.find(|above| above.contains("#[test]")) else {
                panic!("{}: there is no test {file}::{test}", page.display());
            };
            // Tests that only the thorough run has are said to be.
            assert!(!above.contains("#[ignore") || line.contains("thorough"), "{file}::{test}: {line}");
        }
    }
}

#[test]
fn pages_link_to_what_is_there() {
    for page in pages() {
        let text = std::fs::read_to_string(&page).unwrap();
        let links = text.split("](").skip(1).filter_map(|rest| rest.split_once(')')).map(|(link, _)| link);
        let paths = links.filter(|link| !link.contains("://")).map(|link| link.split('#').next().unwrap());
        for path in paths {
            let target = page.parent().unwrap().join(path);
            assert!(target.exists(), "{}: {path} is not there", page.display());
        }
    }
}
