//! The modules of a crate: what each imports, names and implements.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

use crate::tokens::{Token, tokens};

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
    /// Every word outside `use` declarations.
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
        let folder = root.parent().expect("a file stands in a folder");
        let mut unread = vec![Unread {
            path: Vec::new(),
            file: root.to_path_buf(),
            folder: folder.to_path_buf(),
        }];
        while let Some(next) = unread.pop() {
            let text = fs::read_to_string(base.join(&next.file))
                .unwrap_or_else(|error| panic!("{}: {error}", next.file.display()));
            let mut reader = Reader {
                tokens: tokens(&text),
                at: 0,
                base,
                file: &next.file,
                modules: &mut modules,
                unread: &mut unread,
            };
            reader.module(next.path, &next.folder);
        }
        modules
    }
}

struct Reader<'a> {
    tokens: Vec<Token>,
    at: usize,
    base: &'a Path,
    file: &'a Path,
    modules: &'a mut Modules,
    unread: &'a mut Vec<Unread>,
}

/// What the attributes before an item say.
#[derive(Default)]
struct Attributes {
    test: bool,
    path: Option<String>,
}

impl Reader<'_> {
    fn word(&self, ahead: usize) -> Option<&str> {
        self.tokens.get(self.at + ahead).and_then(Token::word)
    }

    fn is(&self, ahead: usize, mark: char) -> bool {
        self.tokens
            .get(self.at + ahead)
            .is_some_and(|token| token.is(mark))
    }

    /// Reads a module up to the brace that closes it, or the end of the file.
    fn module(&mut self, path: Vec<String>, folder: &Path) {
        let mut module = Module {
            file: self.file.to_path_buf(),
            ..Module::default()
        };
        let mut depth = 0;
        let mut public = false;
        while self.at < self.tokens.len() {
            if self.is(0, '#') && (self.is(1, '[') || self.is(1, '!')) {
                let attributes = self.attributes();
                if attributes.test {
                    self.skip_item();
                } else if attributes.path.is_some() {
                    self.child(&path, folder, attributes.path.as_deref());
                }
                continue;
            }
            match self.word(0) {
                Some("pub") => {
                    public = true;
                    self.at += 1;
                    if self.is(0, '(') {
                        self.skip_group();
                    }
                    continue;
                }
                Some("use") if self.word(1).is_some() || self.is(1, ':') || self.is(1, '{') => {
                    self.at += 1;
                    self.import(&[], public, &mut module.imports);
                }
                Some("mod") if self.word(1).is_some() && (self.is(2, ';') || self.is(2, '{')) => {
                    self.child(&path, folder, None);
                }
                Some("impl") => {
                    self.implementation(&mut module);
                }
                Some(word) => {
                    let defines = [
                        "struct",
                        "enum",
                        "fn",
                        "trait",
                        "type",
                        "const",
                        "static",
                        "union",
                        "macro_rules",
                    ];
                    if defines.contains(&word) {
                        let name = if word == "macro_rules" { 2 } else { 1 };
                        if let Some(name) = self.word(name) {
                            module.items.insert(name.to_owned());
                        }
                    }
                    self.path(&mut module);
                }
                None => {
                    if self.is(0, '{') {
                        depth += 1;
                    } else if self.is(0, '}') {
                        if depth == 0 {
                            break;
                        }
                        depth -= 1;
                    }
                    self.at += 1;
                }
            }
            public = false;
        }
        self.modules.of.insert(path, module);
    }

    /// Reads `#[...]` or `#![...]`, and those that follow.
    fn attributes(&mut self) -> Attributes {
        let mut read = Attributes::default();
        while self.is(0, '#') && (self.is(1, '[') || self.is(1, '!')) {
            self.at += if self.is(1, '!') { 2 } else { 1 };
            let start = self.at + 1;
            self.skip_group();
            let inside = &self.tokens[start..self.at - 1];
            let words: Vec<&str> = inside.iter().filter_map(Token::word).collect();
            read.test |= words == ["cfg", "test"] || words == ["test"];
            if let [Token::Word(word), Token::Mark('='), Token::Text(text)] = inside
                && word == "path"
            {
                read.path = Some(text.clone());
            }
        }
        read
    }

    /// Skips a group in brackets, which opens here.
    fn skip_group(&mut self) {
        let mut depth = 0;
        loop {
            match self.tokens.get(self.at) {
                Some(Token::Mark('(' | '[' | '{')) => depth += 1,
                Some(Token::Mark(')' | ']' | '}')) => depth -= 1,
                None => return,
                _ => {}
            }
            self.at += 1;
            if depth == 0 {
                return;
            }
        }
    }

    /// Skips an item, a statement or a field.
    fn skip_item(&mut self) {
        while self.word(0) == Some("pub") {
            self.at += 1;
            if self.is(0, '(') {
                self.skip_group();
            }
        }
        let items = [
            "fn", "impl", "struct", "enum", "trait", "mod", "use", "const", "static",
        ];
        let is_item = self.word(0).is_some_and(|word| items.contains(&word));
        loop {
            match self.tokens.get(self.at) {
                Some(Token::Mark('{')) => return self.skip_group(),
                Some(Token::Mark('(' | '[')) => self.skip_group(),
                Some(Token::Mark(',')) if !is_item => return,
                Some(Token::Mark('}')) | None => return,
                Some(Token::Mark(';')) => {
                    self.at += 1;
                    return;
                }
                _ => self.at += 1,
            }
        }
    }

    /// Reads `mod name;` or `mod name { ... }`.
    fn child(&mut self, parent: &[String], folder: &Path, given: Option<&str>) {
        while self.word(0) != Some("mod") {
            self.at += 1;
        }
        let Some(name) = self.word(1).map(str::to_owned) else {
            return;
        };
        let mut path = parent.to_vec();
        path.push(name.clone());
        let inline = self.is(2, '{');
        self.at += 3;
        if inline {
            self.module(path, &folder.join(&name));
            self.at += 1;
            return;
        }
        let here = self.file.parent().expect("a file stands in a folder");
        let beside = folder.join(format!("{name}.rs"));
        let file = match given {
            Some(given) => here.join(given),
            None if self.base.join(&beside).exists() => beside,
            None => folder.join(&name).join("mod.rs"),
        };
        let folder = if file.ends_with("mod.rs") || given.is_some() {
            file.parent()
                .expect("a file stands in a folder")
                .to_path_buf()
        } else {
            folder.join(&name)
        };
        self.unread.push(Unread { path, file, folder });
    }

    /// Reads a tree of a `use` declaration, up to the comma, brace or semicolon after it.
    fn import(&mut self, prefix: &[String], public: bool, imports: &mut Vec<Import>) {
        let mut path = prefix.to_vec();
        let mut leaf = |path: &[String], name: &str| {
            imports.push(Import {
                path: path.to_vec(),
                name: name.to_owned(),
                public,
            });
        };
        while self.at < self.tokens.len() {
            if self.is(0, '{') {
                self.at += 1;
                while !self.is(0, '}') {
                    self.import(&path, public, imports);
                    if self.is(0, ',') {
                        self.at += 1;
                    }
                }
                self.at += 1;
                return;
            }
            if self.is(0, '*') {
                leaf(&path, "*");
                self.at += 1;
                return;
            }
            match self.word(0).map(str::to_owned) {
                Some(word) if word == "as" => {
                    let name = self.word(1).unwrap_or("_").to_owned();
                    leaf(&path, &name);
                    self.at += 2;
                    return;
                }
                Some(word) => {
                    // `a::{self, b}` binds `a`
                    if word != "self" || path.is_empty() {
                        path.push(word);
                    }
                    self.at += 1;
                }
                None if self.is(0, ':') => self.at += 1,
                None => {
                    let name = path.last().cloned().unwrap_or_default();
                    leaf(&path, &name);
                    return;
                }
            }
        }
    }

    /// Reads `impl<...> Type` or `impl<...> Trait for Type` as far as the names go.
    fn implementation(&mut self, module: &mut Module) {
        self.at += 1;
        let start = self.at;
        if self.is(0, '<') {
            let mut depth = 0;
            loop {
                if self.is(0, '<') {
                    depth += 1;
                } else if self.is(0, '>') && !self.tokens[self.at - 1].is('-') {
                    depth -= 1;
                }
                self.at += 1;
                if depth == 0 || self.at >= self.tokens.len() {
                    break;
                }
            }
        }
        let name = self.segments();
        // `impl Trait` of an argument or a result ends otherwise than an implementation
        let mut ahead = 0;
        let inherent = loop {
            match self.tokens.get(self.at + ahead) {
                Some(Token::Word(word)) if word == "for" => break false,
                Some(Token::Word(word)) if word == "where" => break true,
                Some(Token::Mark('{')) => break true,
                Some(Token::Mark('<' | '>' | '\'' | ',' | ':')) | Some(Token::Word(_)) => {
                    ahead += 1
                }
                _ => break false,
            }
        };
        if inherent && !name.is_empty() && self.starts_item(start - 1) {
            module.implements.push(name);
        }
        self.at = start;
    }

    /// Whether the token at `at` stands where an item can begin.
    fn starts_item(&self, at: usize) -> bool {
        at == 0 || matches!(self.tokens[at - 1], Token::Mark('}' | ';' | ']' | '{'))
    }

    /// Reads words joined by `::`.
    fn segments(&mut self) -> Vec<String> {
        let mut path = Vec::new();
        while let Some(word) = self.word(0).map(str::to_owned) {
            path.push(word);
            self.at += 1;
            if self.is(0, ':') && self.is(1, ':') && self.word(2).is_some() {
                self.at += 2;
            } else {
                break;
            }
        }
        path
    }

    fn path(&mut self, module: &mut Module) {
        let path = self.segments();
        module.words.insert(path[0].clone());
        if path.len() > 1 {
            module.paths.push(path);
        }
    }
}
