//! The modules of a crate as its files state them: what each declares, imports and names.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use proc_macro2::{TokenStream, TokenTree};
use syn::visit::{Visit, visit_impl_item_fn, visit_item};
use syn::{Attribute, ImplItemFn, Item, ItemMod, ItemUse, Macro, UseTree, Visibility};

/// A `use` of one name.
pub(crate) struct Import {
    /// What is imported; its last part is `*` for all of a module.
    pub(crate) path: Vec<String>,
    /// What it is called here.
    pub(crate) name: String,
    /// Whether others see it through this module.
    pub(crate) reexported: bool,
}

/// A module outside tests.
pub(crate) struct Module {
    /// Its path from the root of the crate, which is called `crate` itself.
    pub(crate) name: String,
    pub(crate) parent: Option<usize>,
    pub(crate) children: BTreeMap<String, usize>,
    pub(crate) imports: Vec<Import>,
    /// The paths that its code names.
    pub(crate) paths: Vec<Vec<String>>,
}

/// The text of a file, if the file is there.
type Read<'a> = dyn Fn(&Path) -> Option<String> + 'a;

/// All modules that a root file declares, itself first.
pub(crate) fn modules(root: &Path, read: &Read) -> Vec<Module> {
    let mut tree = Tree { read, modules: Vec::new() };
    let folder = root.parent().expect("a file is in a folder");
    tree.add(None, "crate", &parsed(root, read).expect("the root file is there"), root, folder);
    tree.modules
}

fn parsed(file: &Path, read: &Read) -> Option<Vec<Item>> {
    let text = read(file)?;
    Some(syn::parse_file(&text).unwrap_or_else(|error| panic!("{}: {error}", file.display())).items)
}

struct Tree<'a> {
    read: &'a Read<'a>,
    modules: Vec<Module>,
}

impl Tree<'_> {
    /// Adds the module of these items, and the modules that they declare; their files are in `folder`.
    fn add(&mut self, parent: Option<usize>, name: &str, items: &[Item], file: &Path, folder: &Path) {
        let mut found = Collector::default();
        items.iter().for_each(|item| found.visit_item(item));
        let at = self.modules.len();
        let Collector { imports, paths, declared } = found;
        self.modules.push(Module { name: name.into(), parent, children: BTreeMap::new(), imports, paths });
        for child in declared {
            let called = child.ident.to_string();
            let name = if at == 0 { called.clone() } else { format!("{name}::{called}") };
            let number = self.modules.len();
            self.modules[at].children.insert(called.clone(), number);
            let inner = folder.join(&called);
            match &child.content {
                Some((_, items)) => self.add(Some(at), &name, items, file, &inner),
                None => {
                    let (items, file, folder) = self.file_of(&child.attrs, &called, file, folder);
                    self.add(Some(at), &name, &items, &file, &folder);
                }
            }
        }
    }

    /// The items of a module with a file of its own, that file, and the folder of its children.
    fn file_of(
        &self,
        attributes: &[Attribute],
        called: &str,
        from: &Path,
        folder: &Path,
    ) -> (Vec<Item>, PathBuf, PathBuf) {
        let mut candidates = vec![folder.join(format!("{called}.rs")), folder.join(called).join("mod.rs")];
        candidates.extend(stated_path(attributes).map(|path| from.with_file_name(path)));
        for file in candidates {
            if let Some(items) = parsed(&file, self.read) {
                let of_children =
                    if file.ends_with("mod.rs") { file.with_file_name("") } else { file.with_extension("") };
                return (items, file, of_children);
            }
        }
        panic!("there is no file of the module {called} that {} declares", from.display());
    }
}

/// The file that `#[path = "…"]` names.
fn stated_path(attributes: &[Attribute]) -> Option<String> {
    let path = attributes.iter().find(|attribute| attribute.path().is_ident("path"))?;
    let syn::Expr::Lit(value) = &path.meta.require_name_value().ok()?.value else { return None };
    match &value.lit {
        syn::Lit::Str(path) => Some(path.value()),
        _ => None,
    }
}

/// Whether something is compiled for tests only.
fn for_tests(attributes: &[Attribute]) -> bool {
    attributes.iter().any(|attribute| {
        let of_cfg = || attribute.meta.require_list().map(|list| list.tokens.to_string());
        attribute.path().is_ident("test")
            || attribute.path().is_ident("cfg") && of_cfg().is_ok_and(|of| of == "test" || of == "doctest")
    })
}

fn attributes(item: &Item) -> &[Attribute] {
    match item {
        Item::Const(item) => &item.attrs,
        Item::Enum(item) => &item.attrs,
        Item::Fn(item) => &item.attrs,
        Item::Impl(item) => &item.attrs,
        Item::Macro(item) => &item.attrs,
        Item::Mod(item) => &item.attrs,
        Item::Static(item) => &item.attrs,
        Item::Struct(item) => &item.attrs,
        Item::Trait(item) => &item.attrs,
        Item::Type(item) => &item.attrs,
        Item::Use(item) => &item.attrs,
        _ => &[],
    }
}

/// What one module has, without the modules inside it.
#[derive(Default)]
struct Collector<'ast> {
    imports: Vec<Import>,
    paths: Vec<Vec<String>>,
    declared: Vec<&'ast ItemMod>,
}

impl<'ast> Visit<'ast> for Collector<'ast> {
    fn visit_item(&mut self, item: &'ast Item) {
        if !for_tests(attributes(item)) {
            visit_item(self, item);
        }
    }

    fn visit_impl_item_fn(&mut self, function: &'ast ImplItemFn) {
        if !for_tests(&function.attrs) {
            visit_impl_item_fn(self, function);
        }
    }

    fn visit_item_mod(&mut self, module: &'ast ItemMod) {
        self.declared.push(module);
    }

    fn visit_item_use(&mut self, item: &'ast ItemUse) {
        if item.leading_colon.is_none() {
            let reexported = !matches!(item.vis, Visibility::Inherited);
            flatten(&item.tree, &mut Vec::new(), reexported, &mut self.imports);
        }
    }

    fn visit_path(&mut self, path: &'ast syn::Path) {
        if path.leading_colon.is_none() {
            self.paths.push(path.segments.iter().map(|segment| segment.ident.to_string()).collect());
        }
        syn::visit::visit_path(self, path);
    }

    /// `pub(super)` says who sees a thing; it depends on nothing.
    fn visit_visibility(&mut self, _: &'ast Visibility) {}

    fn visit_macro(&mut self, of: &'ast Macro) {
        self.visit_path(&of.path);
        paths_in(of.tokens.clone(), &mut self.paths);
    }
}

/// The single names of a `use`.
fn flatten(tree: &UseTree, before: &mut Vec<String>, reexported: bool, imports: &mut Vec<Import>) {
    let mut add = |last: String, name: String| {
        let mut path = before.clone();
        // `a::{self}` is `a`.
        let name = if last == "self" { path.last().cloned().unwrap_or(name) } else { name };
        if last != "self" {
            path.push(last);
        }
        imports.push(Import { path, name, reexported });
    };
    match tree {
        UseTree::Path(path) => {
            before.push(path.ident.to_string());
            flatten(&path.tree, before, reexported, imports);
            before.pop();
        }
        UseTree::Name(name) => add(name.ident.to_string(), name.ident.to_string()),
        UseTree::Rename(name) => add(name.ident.to_string(), name.rename.to_string()),
        UseTree::Glob(_) => add("*".into(), "*".into()),
        UseTree::Group(group) => {
            group.items.iter().for_each(|tree| flatten(tree, before, reexported, imports));
        }
    }
}

/// The paths in the arguments of a macro, which may be any tokens: names joined by `::` that do not follow a dot.
fn paths_in(tokens: TokenStream, paths: &mut Vec<Vec<String>>) {
    let (mut current, mut colons, mut dots) = (Vec::new(), 0, 0);
    for token in tokens {
        match token {
            TokenTree::Ident(name) => {
                if colons != 2 {
                    paths.extend(Some(std::mem::take(&mut current)).filter(|path| !path.is_empty()));
                }
                if dots != 1 && (colons != 2 || !current.is_empty()) {
                    current.push(name.to_string());
                }
                (colons, dots) = (0, 0);
            }
            TokenTree::Punct(mark) if mark.as_char() == ':' => colons += 1,
            other => {
                paths.extend(Some(std::mem::take(&mut current)).filter(|path| !path.is_empty()));
                let dot = matches!(&other, TokenTree::Punct(mark) if mark.as_char() == '.');
                (colons, dots) = (0, if dot { dots + 1 } else { 0 });
                if let TokenTree::Group(group) = other {
                    paths_in(group.stream(), paths);
                }
            }
        }
    }
    paths.extend(Some(current).filter(|path| !path.is_empty()));
}
