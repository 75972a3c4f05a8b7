//! From imports to arrows between files, and what must hold of them.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use crate::modules::Modules;

/// Which files use which.
pub(crate) type Arrows = BTreeMap<PathBuf, BTreeSet<PathBuf>>;

/// A breach of a rule.
#[derive(Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Finding {
    pub(crate) file: PathBuf,
    pub(crate) text: String,
}

/// What a path leads to.
enum Found {
    Module(Vec<String>),
    /// An item, by the file that defines it.
    Item(PathBuf),
}

impl Modules {
    /// Follows `path` from the module `from`; nothing where it leads out of the crate.
    fn resolve(&self, from: &[String], path: &[String], depth: usize) -> Option<Found> {
        // a re-export of itself would have no end
        if depth > 16 {
            return None;
        }
        let mut at = from.to_vec();
        let mut rest = path;
        let mut anchored = false;
        while let Some(first) = rest.first() {
            match first.as_str() {
                "crate" => at.clear(),
                "self" => {}
                "super" => {
                    at.pop()?;
                }
                _ => break,
            }
            anchored = true;
            rest = &rest[1..];
        }
        while let Some(name) = rest.first() {
            let module = self.of.get(&at)?;
            let mut child = at.clone();
            child.push(name.clone());
            rest = &rest[1..];
            if self.of.contains_key(&child) {
                at = child;
                anchored = true;
                continue;
            }
            let bound = module.imports.iter().find(|import| import.name == *name);
            if let Some(import) = bound {
                match self.resolve(&at, &import.path, depth + 1)? {
                    Found::Module(next) => {
                        at = next;
                        anchored = true;
                        continue;
                    }
                    item => return Some(item),
                }
            }
            if module.items.contains(name) {
                return Some(Found::Item(module.file.clone()));
            }
            for import in module.imports.iter().filter(|import| import.name == "*") {
                if let Some(Found::Module(of)) = self.resolve(&at, &import.path, depth + 1) {
                    if of == at || !self.exports(&of, name) {
                        continue;
                    }
                    return self.resolve(&of, std::slice::from_ref(name), depth + 1);
                }
            }
            return anchored.then(|| Found::Item(module.file.clone()));
        }
        anchored.then_some(Found::Module(at))
    }

    fn exports(&self, module: &[String], name: &str) -> bool {
        self.of.get(module).is_some_and(|module| {
            module.items.contains(name) || module.imports.iter().any(|import| import.name == name)
        })
    }

    /// The arrows between the files of the crate.
    pub(crate) fn arrows(&self) -> Arrows {
        let mut arrows = Arrows::new();
        for (path, module) in &self.of {
            let mut targets = BTreeSet::new();
            for import in &module.imports {
                if import.public && module.is_door() && !module.words.contains(&import.name) {
                    continue;
                }
                match self.resolve(path, &import.path, 0) {
                    Some(Found::Item(file)) => {
                        targets.insert(file);
                    }
                    Some(Found::Module(of)) if import.name == "*" => {
                        targets.insert(self.of[&of].file.clone());
                    }
                    _ => {}
                }
            }
            for used in &module.paths {
                if let Some(Found::Item(file)) = self.resolve(path, used, 0) {
                    targets.insert(file);
                }
            }
            targets.remove(&module.file);
            arrows
                .entry(module.file.clone())
                .or_default()
                .extend(targets);
        }
        arrows
    }

    /// Inherent implementations that stand in another file than their type.
    pub(crate) fn scattered(&self) -> Vec<Finding> {
        let mut found = Vec::new();
        for (path, module) in &self.of {
            for of in &module.implements {
                if let Some(Found::Item(file)) = self.resolve(path, of, 0)
                    && file != module.file
                {
                    found.push(Finding {
                        file: module.file.clone(),
                        text: format!(
                            "implements {}, which {} defines",
                            of.join("::"),
                            file.display()
                        ),
                    });
                }
            }
        }
        found
    }
}

fn reachable<'a>(arrows: &'a Arrows, from: &'a Path) -> BTreeSet<&'a Path> {
    let mut seen = BTreeSet::new();
    let mut next = vec![from];
    while let Some(file) = next.pop() {
        for target in arrows.get(file).into_iter().flatten() {
            if seen.insert(target.as_path()) {
                next.push(target);
            }
        }
    }
    seen
}

/// A circle with the arrows inside it.
fn describe(circle: &[&Path], arrows: &Arrows) -> String {
    let mut text = format!("{} files in a circle:", circle.len());
    for file in circle {
        let inside: Vec<String> = arrows[*file]
            .iter()
            .filter(|target| circle.contains(&target.as_path()))
            .map(|target| target.display().to_string())
            .collect();
        text += &format!("\n  {} uses {}", file.display(), inside.join(", "));
    }
    text
}

/// The circles: largest sets of files each of which reaches each.
pub(crate) fn circles(arrows: &Arrows) -> Vec<Finding> {
    let reach: BTreeMap<&Path, BTreeSet<&Path>> = arrows
        .keys()
        .map(|file| (file.as_path(), reachable(arrows, file)))
        .collect();
    let mut circles = Vec::new();
    let mut placed = BTreeSet::new();
    for (&file, reached) in &reach {
        if !reached.contains(file) || placed.contains(file) {
            continue;
        }
        let circle: Vec<&Path> = reached
            .iter()
            .copied()
            .filter(|other| reach.get(other).is_some_and(|back| back.contains(file)))
            .collect();
        placed.extend(circle.iter().copied());
        circles.push(Finding {
            file: file.to_path_buf(),
            text: describe(&circle, arrows),
        });
    }
    circles
}

/// The order within one folder: groups from the top to the ground; what stands in one group does not use each other.
pub(crate) struct Order {
    pub(crate) folder: PathBuf,
    pub(crate) groups: Vec<Vec<String>>,
}

impl Order {
    fn place(&self, file: &Path) -> Option<(String, Option<usize>)> {
        let inside = file.strip_prefix(&self.folder).ok()?;
        let first = inside.iter().next()?.to_string_lossy();
        let name = first.trim_end_matches(".rs").to_owned();
        let place = self.groups.iter().position(|group| group.contains(&name));
        Some((name, place))
    }

    /// Arrows that run upwards or sideways, and files without a place.
    pub(crate) fn breaches(&self, arrows: &Arrows) -> Vec<Finding> {
        let mut breaches = BTreeSet::new();
        for (file, targets) in arrows {
            let Some((name, place)) = self.place(file) else {
                continue;
            };
            // the root of a folder holds its doors: it stands on top unless the order names it
            let root = name == "lib" || name == "mod" || name == "main";
            if place.is_none() && !root {
                breaches.insert(Finding {
                    file: file.clone(),
                    text: format!(
                        "`{name}` has no place in the order of {}",
                        self.folder.display()
                    ),
                });
            }
            for target in targets {
                let Some((to, below)) = self.place(target) else {
                    continue;
                };
                let (from, below) = (place.unwrap_or(0), below.unwrap_or(0));
                let down = from < below || (place.is_none() && root);
                if name != to && !down {
                    breaches.insert(Finding {
                        file: file.clone(),
                        text: format!("uses {}", target.display()),
                    });
                }
            }
        }
        breaches.into_iter().collect()
    }
}
