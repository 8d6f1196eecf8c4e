//! Which modules of a crate depend on which, and the circles among them.

use std::collections::{BTreeSet, VecDeque};
use std::path::Path;

use crate::module_tree::{Module, modules};

/// The modules of a crate, and for each those that it depends on.
///
/// A module depends on those whose items it imports or names. An item that is reached through a re-export belongs to the module that
/// defines it. A module that declares others and re-exports what they define does not depend on them, unless its own code uses it.
pub struct ModuleGraph {
    names: Vec<String>,
    edges: Vec<BTreeSet<usize>>,
}

impl ModuleGraph {
    /// The graph of the crate with this root file.
    ///
    /// # Panics
    /// If a file is missing or is not Rust.
    pub fn of(root: &Path) -> Self {
        ModuleGraph::read(root, &|file| std::fs::read_to_string(file).ok())
    }

    fn read(root: &Path, read: &dyn Fn(&Path) -> Option<String>) -> Self {
        let modules = modules(root, read);
        let edges = (0..modules.len()).map(|at| dependencies(&modules, at)).collect();
        ModuleGraph { names: modules.into_iter().map(|module| module.name).collect(), edges }
    }

    /// Each set of modules that all depend on each other, in words, with one of its shortest circles.
    pub fn circles(&self) -> Vec<String> {
        let reached: Vec<BTreeSet<usize>> = (0..self.names.len()).map(|at| self.reached_from(at)).collect();
        let mut seen = BTreeSet::new();
        let mut found = Vec::new();
        for at in 0..self.names.len() {
            if !reached[at].contains(&at) || !seen.insert(at) {
                continue;
            }
            let set: Vec<usize> =
                reached[at].iter().copied().filter(|other| reached[*other].contains(&at)).collect();
            seen.extend(&set);
            let shortest = set.iter().map(|&at| self.circle_through(at)).min_by_key(Vec::len);
            let names = |modules: &[usize], between: &str| {
                modules.iter().map(|&at| self.names[at].as_str()).collect::<Vec<_>>().join(between)
            };
            let circle = names(&shortest.unwrap_or_default(), " → ");
            found.push(match set.len() {
                2 => circle,
                count => format!("{circle} (one of {count} modules: {})", names(&set, ", ")),
            });
        }
        found
    }

    fn reached_from(&self, start: usize) -> BTreeSet<usize> {
        let (mut reached, mut next) = (BTreeSet::new(), vec![start]);
        while let Some(at) = next.pop() {
            next.extend(self.edges[at].iter().filter(|to| reached.insert(**to)));
        }
        reached
    }

    /// The shortest way from a module back to itself, both ends included.
    fn circle_through(&self, start: usize) -> Vec<usize> {
        let mut ways = VecDeque::from([vec![start]]);
        let mut seen = BTreeSet::new();
        while let Some(way) = ways.pop_front() {
            for &to in &self.edges[way[way.len() - 1]] {
                let longer = [way.as_slice(), &[to]].concat();
                if to == start {
                    return longer;
                }
                if seen.insert(to) {
                    ways.push_back(longer);
                }
            }
        }
        Vec::new()
    }
}

/// The modules that a module depends on.
fn dependencies(modules: &[Module], at: usize) -> BTreeSet<usize> {
    let module = &modules[at];
    let mut found = BTreeSet::new();
    for import in &module.imports {
        let targets = resolve(modules, at, &import.path, 0);
        let passed_on = import.reexported && targets.iter().all(|&target| is_below(modules, target, at));
        if !passed_on || module.paths.iter().any(|path| path[0] == import.name) {
            found.extend(targets);
        }
    }
    // A name alone may be a variable; what it was imported from is known from above.
    for path in module.paths.iter().filter(|path| path.len() > 1) {
        found.extend(resolve(modules, at, path, 0));
    }
    found.remove(&at);
    found
}

fn is_below(modules: &[Module], module: usize, above: usize) -> bool {
    let mut parents = std::iter::successors(modules[module].parent, |&at| modules[at].parent);
    parents.any(|parent| parent == above)
}

/// Imports of imports that are followed before it must be a circle of re-exports.
const DEEPEST: usize = 20;

/// The modules that define what a path in a module means; none for what is not of this crate.
fn resolve(modules: &[Module], from: usize, path: &[String], depth: usize) -> BTreeSet<usize> {
    if depth > DEEPEST {
        return BTreeSet::new();
    }
    let mut at = from;
    let mut rest = path;
    match path[0].as_str() {
        "crate" => (at, rest) = (0, &path[1..]),
        "self" => rest = &path[1..],
        "super" => {
            while rest.first().is_some_and(|part| part == "super") {
                (at, rest) = (modules[at].parent.expect("a root has no super"), &rest[1..]);
            }
        }
        name if modules[from].children.contains_key(name) => {}
        // A module under another name, or a type whose module is known from its import.
        name => {
            let import = modules[from].imports.iter().find(|import| import.name == name);
            return match import {
                Some(import) if import.path != path => {
                    let whole = [import.path.as_slice(), &path[1..]].concat();
                    resolve(modules, from, &whole, depth + 1)
                }
                _ => BTreeSet::new(),
            };
        }
    }
    while let Some((part, more)) = rest.split_first() {
        if part == "*" {
            let shown = modules[at].imports.iter().filter(|import| import.reexported);
            let mut all: BTreeSet<usize> =
                shown.flat_map(|import| resolve(modules, at, &import.path, depth + 1)).collect();
            all.insert(at);
            return all;
        }
        let child = modules[at].children.get(part).copied();
        let import = modules[at].imports.iter().find(|import| import.name == *part);
        // A function may be called as its module is: at the end of a path it is what is meant.
        match (child, import) {
            (Some(child), None) => at = child,
            (Some(child), Some(_)) if !more.is_empty() => at = child,
            (_, Some(import)) => {
                let whole = [import.path.as_slice(), more].concat();
                return resolve(modules, at, &whole, depth + 1);
            }
            (None, None) => return BTreeSet::from([at]),
        }
        rest = more;
    }
    BTreeSet::from([at])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn circles(files: &[(&str, &str)]) -> Vec<String> {
        let read = |file: &Path| {
            let found = files.iter().find(|(path, _)| Path::new(path) == file)?;
            Some(found.1.to_string())
        };
        ModuleGraph::read(Path::new("src/lib.rs"), &read).circles()
    }

    #[test]
    fn a_planted_circle_is_found_by_each_way_to_name_a_module() {
        let root = "mod a; mod b; mod c; pub use a::A; pub use c::Other as C;";
        let with = |c| {
            let (a, b) = ("use crate::b::B; pub struct A(B);", "use crate::c::C; pub struct B(C);");
            circles(&[("src/lib.rs", root), ("src/a.rs", a), ("src/b.rs", b), ("src/c.rs", c)])
        };
        for c in [
            "use crate::a::A; pub struct C(A);",
            "use crate::A; pub struct C(A);",
            "use super::{a::{A as Renamed}}; pub struct C(Renamed);",
            "pub struct C(crate::a::A);",
            "use crate::a; pub struct C(a::A);",
            "use crate::a::*; pub struct C(A);",
            "pub fn c() { use crate::A; }",
            "pub fn c() { assert!(x.y(), \"{}\", crate::A::new()); }",
        ] {
            assert_eq!(with(c), ["a → b → c → a (one of 3 modules: a, b, c)"], "{c}");
        }
        // What b imports from c is a's.
        assert_eq!(with("pub use crate::a::A as C;"), ["a → b → a"]);
        assert_eq!(with("pub struct C;"), [""; 0]);
    }

    #[test]
    fn a_parent_may_pass_on_what_its_children_define_and_not_use_it() {
        let child = ("src/p/child.rs", "use super::Own; pub struct Part(Own);");
        let of = |p: &'static str| circles(&[("src/lib.rs", "mod p;"), ("src/p.rs", p), child]);
        assert_eq!(of("mod child; pub use child::Part; pub struct Own;"), [""; 0]);
        for uses in [
            "mod child; use child::Part; pub struct Own; fn f() -> Part { todo!() }",
            "mod child; pub use child::Part; pub struct Own; fn f() -> Part { todo!() }",
            "mod child; pub struct Own; fn f() -> child::Part { todo!() }",
        ] {
            assert_eq!(of(uses), ["p → p::child → p"], "{uses}");
        }
    }

    #[test]
    fn what_tests_import_and_what_siblings_share_is_no_circle() {
        let found = circles(&[
            ("src/lib.rs", "mod a; mod b; mod inner { pub mod deep; }\npub use a::A;"),
            ("src/a/mod.rs", "pub(crate) struct A; #[cfg(test)] mod tests { use crate::b::B; }"),
            ("src/b.rs", "use crate::A; pub struct B(A); impl B { #[cfg(test)] fn f() { crate::c() } }"),
            ("src/inner/deep.rs", "use crate::b::B; use std::fmt; pub fn deep(b: B) { b.a.c(fmt::x) }"),
        ]);
        assert_eq!(found, [""; 0]);
    }
}
