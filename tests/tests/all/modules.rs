//! The modules of each crate: none depends on itself by way of others.

use std::path::{Path, PathBuf};

use motes_tests::ModuleGraph;

/// The folders of the crates, each with what it is called.
fn crates() -> Vec<(String, PathBuf)> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap();
    let folders = std::fs::read_dir(root.join("crates")).unwrap().map(|entry| entry.unwrap().path());
    let name = |folder: &Path| folder.file_name().unwrap().to_str().unwrap().to_string();
    folders.chain([root.join("xtask")]).map(|folder| (name(&folder), folder)).collect()
}

#[test]
fn no_two_modules_depend_on_each_other() {
    for (name, folder) in crates() {
        let roots = ["src/lib.rs", "src/main.rs"].map(|file| folder.join(file));
        let roots: Vec<PathBuf> = roots.into_iter().filter(|root| root.exists()).collect();
        assert!(!roots.is_empty(), "{name} has no root file");
        let circles: Vec<String> = roots.iter().flat_map(|root| ModuleGraph::of(root).circles()).collect();
        assert!(circles.is_empty(), "modules of {name} in circles:\n{}", circles.join("\n"));
    }
}
