//! The modules of a crate: what each imports, names and implements.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

use proc_macro2::{TokenStream, TokenTree};
use syn::visit::{self, Visit};
use syn::{Attribute, Expr, ExprLit, Item, ItemImpl, ItemMod, Lit, Macro, Meta, Type, UseTree};

/// One leaf of a `use` declaration.
#[derive(Debug, Clone)]
pub(crate) struct Import {
    pub(crate) path: Vec<String>,
    /// The name that it binds; `*` for all names of a module.
    pub(crate) name: String,
    /// Whether other modules may use the name.
    pub(crate) public: bool,
}

/// A module; inline modules stand in the file of the module around them.
#[derive(Debug, Default)]
pub(crate) struct Module {
    pub(crate) file: PathBuf,
    pub(crate) imports: Vec<Import>,
    /// Paths of at least two segments outside `use` declarations.
    pub(crate) paths: Vec<Vec<String>>,
    /// Types that have an inherent implementation here.
    pub(crate) implements: Vec<Vec<String>>,
    /// First words of all paths outside `use` declarations.
    pub(crate) words: BTreeSet<String>,
    /// Names of the items that are defined here.
    pub(crate) items: BTreeSet<String>,
}

impl Module {
    /// Whether the file is the root of a folder. What it re-exports and does not use itself is a door, not an arrow.
    pub(crate) fn is_door(&self) -> bool {
        ["mod.rs", "lib.rs", "main.rs"]
            .iter()
            .any(|root| self.file.ends_with(root))
    }
}

/// The modules of one crate by their path from its root, without what is compiled for tests only.
#[derive(Debug, Default)]
pub(crate) struct Modules {
    pub(crate) of: BTreeMap<Vec<String>, Module>,
}

/// A file whose modules are still to be read.
struct Unread {
    path: Vec<String>,
    file: PathBuf,
    /// Where its child modules are looked for.
    folder: PathBuf,
}

impl Modules {
    /// Reads the crate whose root is the file `root` of the folder `base`; files are named from there.
    pub(crate) fn read(base: &Path, root: &Path) -> Self {
        let mut modules = Self::default();
        let mut unread = vec![Unread {
            path: Vec::new(),
            file: root.to_path_buf(),
            folder: parent(root),
        }];
        while let Some(next) = unread.pop() {
            let shown = next.file.display();
            let text = fs::read_to_string(base.join(&next.file));
            let text = text.unwrap_or_else(|error| panic!("{shown}: {error}"));
            let parsed = syn::parse_file(&text);
            let parsed = parsed.unwrap_or_else(|error| panic!("{shown}: {error}"));
            let mut reader = Reader {
                path: next.path,
                folder: next.folder,
                file: &next.file,
                base,
                module: Module::default(),
                modules: &mut modules,
                unread: &mut unread,
            };
            reader.items(&parsed.items);
        }
        modules
    }
}

fn parent(file: &Path) -> PathBuf {
    let parent = file.parent().expect("a file stands in a folder");
    parent.to_path_buf()
}

struct Reader<'a> {
    path: Vec<String>,
    /// Where child modules of the present one are looked for.
    folder: PathBuf,
    file: &'a Path,
    base: &'a Path,
    module: Module,
    modules: &'a mut Modules,
    unread: &'a mut Vec<Unread>,
}

/// Whether attributes leave something to tests.
fn is_test(attributes: &[Attribute]) -> bool {
    attributes.iter().any(|attribute| {
        let test = |tokens: &TokenStream| tokens.to_string() == "test";
        attribute.path().is_ident("test")
            || attribute.path().is_ident("cfg")
                && matches!(&attribute.meta, Meta::List(list) if test(&list.tokens))
    })
}

/// The file that an attribute names for a module.
fn given(attributes: &[Attribute]) -> Option<String> {
    let mut named = attributes
        .iter()
        .filter(|known| known.path().is_ident("path"));
    match &named.next()?.meta.require_name_value().ok()?.value {
        Expr::Lit(ExprLit {
            lit: Lit::Str(text),
            ..
        }) => Some(text.value()),
        _ => None,
    }
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

/// The name that an item defines.
fn defined(item: &Item) -> Option<String> {
    Some(match item {
        Item::Const(item) => item.ident.to_string(),
        Item::Enum(item) => item.ident.to_string(),
        Item::Fn(item) => item.sig.ident.to_string(),
        Item::Macro(item) => item.ident.as_ref()?.to_string(),
        Item::Static(item) => item.ident.to_string(),
        Item::Struct(item) => item.ident.to_string(),
        Item::Trait(item) => item.ident.to_string(),
        Item::Type(item) => item.ident.to_string(),
        _ => return None,
    })
}

fn segments(path: &syn::Path) -> Vec<String> {
    let segments = path.segments.iter();
    segments.map(|part| part.ident.to_string()).collect()
}

/// The leaves of a tree of a `use` declaration.
fn leaves(tree: &UseTree, path: &[String], public: bool, imports: &mut Vec<Import>) {
    let with = |name: &dyn ToString| {
        // `a::{self, b}` binds `a`
        let own = Some(name.to_string()).filter(|name| name != "self" || path.is_empty());
        [path, own.as_slice()].concat()
    };
    let mut leaf = |path: Vec<String>, name: Option<String>| {
        let name = name.or(path.last().cloned()).unwrap_or_default();
        imports.push(Import { path, name, public });
    };
    match tree {
        UseTree::Path(tree) => leaves(&tree.tree, &with(&tree.ident), public, imports),
        UseTree::Name(tree) => leaf(with(&tree.ident), None),
        UseTree::Rename(tree) => leaf(with(&tree.ident), Some(tree.rename.to_string())),
        UseTree::Glob(_) => leaf(path.to_vec(), Some("*".to_owned())),
        UseTree::Group(tree) => {
            let each = tree.items.iter();
            each.for_each(|tree| leaves(tree, path, public, imports));
        }
    }
}

impl Reader<'_> {
    /// Reads the items of a module.
    fn items(&mut self, items: &[Item]) {
        let around = std::mem::take(&mut self.module);
        self.module.file = self.file.to_path_buf();
        items.iter().for_each(|item| self.visit_item(item));
        let module = std::mem::replace(&mut self.module, around);
        self.modules.of.insert(self.path.clone(), module);
    }

    fn name(&mut self, path: Vec<String>) {
        self.module.words.extend(path.first().cloned());
        if path.len() > 1 {
            self.module.paths.push(path);
        }
    }

    /// Paths in the tokens of a macro.
    fn tokens(&mut self, tokens: TokenStream) {
        let mut path: Vec<String> = Vec::new();
        let mut colons = 0;
        for token in tokens {
            match token {
                TokenTree::Punct(mark) if mark.as_char() == ':' && !path.is_empty() => colons += 1,
                TokenTree::Ident(word) if colons == 2 || path.is_empty() => {
                    path.push(word.to_string());
                    colons = 0;
                }
                token => {
                    self.name(std::mem::take(&mut path));
                    colons = 0;
                    match token {
                        TokenTree::Group(group) => self.tokens(group.stream()),
                        TokenTree::Ident(word) => path.push(word.to_string()),
                        _ => {}
                    }
                }
            }
        }
        self.name(path);
    }
}

impl<'ast> Visit<'ast> for Reader<'_> {
    fn visit_item(&mut self, item: &'ast Item) {
        if is_test(attributes(item)) {
            return;
        }
        self.module.items.extend(defined(item));
        if let Item::Use(item) = item {
            let public = !matches!(item.vis, syn::Visibility::Inherited);
            leaves(&item.tree, &[], public, &mut self.module.imports);
        } else {
            visit::visit_item(self, item);
        }
    }

    fn visit_item_mod(&mut self, item: &'ast ItemMod) {
        let name = item.ident.to_string();
        self.path.push(name.clone());
        if let Some((_, items)) = &item.content {
            self.folder.push(&name);
            self.items(items);
            self.folder.pop();
        } else {
            let beside = self.folder.join(format!("{name}.rs"));
            let given = given(&item.attrs);
            let file = match &given {
                Some(given) => parent(self.file).join(given),
                None if self.base.join(&beside).exists() => beside,
                None => self.folder.join(&name).join("mod.rs"),
            };
            let is_root = file.ends_with("mod.rs") || given.is_some();
            self.unread.push(Unread {
                path: self.path.clone(),
                folder: if is_root {
                    parent(&file)
                } else {
                    self.folder.join(&name)
                },
                file,
            });
        }
        self.path.pop();
    }

    fn visit_item_impl(&mut self, item: &'ast ItemImpl) {
        if let (None, Type::Path(of)) = (&item.trait_, &*item.self_ty) {
            self.module.implements.push(segments(&of.path));
        }
        visit::visit_item_impl(self, item);
    }

    fn visit_path(&mut self, path: &'ast syn::Path) {
        self.name(segments(path));
        visit::visit_path(self, path);
    }

    fn visit_macro(&mut self, found: &'ast Macro) {
        self.tokens(found.tokens.clone());
        visit::visit_macro(self, found);
    }
}
