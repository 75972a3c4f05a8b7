//! What goes into the packages: licences, figures, a README that says how to depend on it, and a changelog of readable length.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::{members, workspace};

/// Most lines of a release in the changelog, without the empty ones: what a reader takes in.
const RELEASE: usize = 60;
/// Most lines of all documents outside of the book, and of one page of `docs/experiments`.
const DOCUMENTS: (usize, usize) = (1500, 120);
/// What every package that can be published says of itself.
const FIELDS: [&str; 7] = [
    "description",
    "license",
    "repository",
    "rust-version",
    "readme",
    "keywords",
    "categories",
];

/// A package that can be published.
struct Package {
    folder: PathBuf,
    manifest: String,
}

impl Package {
    fn all() -> Vec<Self> {
        let read = |member: &PathBuf| Self {
            folder: workspace().join(member),
            manifest: text(&workspace().join(member).join("Cargo.toml")),
        };
        let packages = members()
            .iter()
            .map(read)
            .filter(|package| !package.manifest.contains("publish = false"))
            .collect::<Vec<_>>();
        assert!(packages.len() >= 10, "packages are not found");
        packages
    }

    /// The value of a key that stands alone in its line.
    fn value(&self, key: &str) -> Option<&str> {
        let lines = self.manifest.lines();
        let mut values = lines.filter_map(|line| line.strip_prefix(key)?.strip_prefix(" = "));
        values.next().map(|value| value.trim_matches('"'))
    }

    fn name(&self) -> &str {
        self.value("name").expect("a name")
    }

    /// The files that would be published.
    fn files(&self) -> Vec<String> {
        let output = Command::new(env!("CARGO"))
            .args(["package", "--list", "--allow-dirty", "--offline", "-p"])
            .arg(self.name())
            .current_dir(workspace())
            .output()
            .expect("cargo runs");
        let errors = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "{}: {errors}", self.name());
        let list = String::from_utf8_lossy(&output.stdout);
        // On Windows with the separators of that system.
        list.lines().map(|line| line.replace('\\', "/")).collect()
    }
}

fn text(path: &Path) -> String {
    fs::read_to_string(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// The paths behind `![...](`.
fn figures(readme: &str) -> Vec<&str> {
    let behind = readme.split("![").skip(1);
    let paths = behind.filter_map(|rest| rest.split_once("](")?.1.split_once(')'));
    paths.map(|(path, _)| path).collect()
}

#[test]
fn packages_hold_licences_their_readme_and_its_figures() {
    for package in Package::all() {
        let (name, files) = (package.name(), package.files());
        let readme = package
            .folder
            .join(package.value("readme").expect("a README"));
        let readme = text(&readme);
        let wanted = ["LICENSE-APACHE", "LICENSE-MIT", "README.md", "Cargo.toml"];
        for wanted in wanted.into_iter().chain(figures(&readme)) {
            assert!(
                files.iter().any(|file| file == wanted),
                "{name}: no {wanted}"
            );
        }
        assert!(
            files.iter().any(|file| file.ends_with(".rs")),
            "{name}: no sources"
        );
        for licence in ["LICENSE-APACHE", "LICENSE-MIT"] {
            let (own, common) = (package.folder.join(licence), workspace().join(licence));
            assert_eq!(text(&own), text(&common), "{name}: {licence}");
        }
    }
}

#[test]
fn packages_say_what_they_are_and_how_to_depend_on_them() {
    for package in Package::all() {
        let name = package.name();
        for field in FIELDS {
            let own = package.value(field);
            let inherited = package.value(&format!("{field}.workspace"));
            assert!(own.or(inherited).is_some(), "{name}: no `{field}`");
        }
        // The program has the README of the library, whose name it has as well.
        let library = if name == "hangtime-bin" {
            "hangtime"
        } else {
            name
        };
        let readme = package
            .folder
            .join(package.value("readme").expect("a README"));
        // A version, or where the sources are as long as no registry has it.
        let line = format!("[dependencies]\n{library} = ");
        assert!(text(&readme).contains(&line), "{name}: README lacks {line}");
    }
}

#[test]
fn python_package_has_the_version_and_the_oldest_rust_of_the_workspace() {
    let [root, native, package] = ["Cargo.toml", "python/Cargo.toml", "python/pyproject.toml"]
        .map(|path| text(&workspace().join(path)));
    let line = |text: &str, key: &str| {
        let found = text.lines().find(|line| line.starts_with(key));
        found.unwrap_or_else(|| panic!("no {key}")).to_owned()
    };
    for key in ["version = ", "rust-version = "] {
        assert_eq!(line(&native, key), line(&root, key));
    }
    assert_eq!(line(&package, "version = "), line(&root, "version = "));
    for licence in ["LICENSE-APACHE", "LICENSE-MIT"] {
        let [own, common] =
            [workspace().join("python"), workspace()].map(|folder| text(&folder.join(licence)));
        assert_eq!(own, common, "python: {licence}");
    }
}

#[test]
fn releases_in_the_changelog_are_of_readable_length() {
    let changelog = text(&workspace().join("CHANGELOG.md"));
    let releases: Vec<&str> = changelog.split("\n## ").skip(1).collect();
    assert!(releases.len() >= 2, "releases are not found");
    for release in releases {
        let title = release.lines().next().unwrap_or_default();
        let lines = release.lines().filter(|line| !line.is_empty()).count();
        assert!(
            lines <= RELEASE,
            "{title}: {lines} lines; at most {RELEASE}"
        );
    }
}

/// Files below a folder with this ending, without those of the book.
fn documents(folder: &Path, ending: &str) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in fs::read_dir(folder)
        .expect("a folder")
        .map(|entry| entry.expect("an entry").path())
    {
        if entry.is_dir() && !entry.ends_with("book") {
            found.extend(documents(&entry, ending));
        } else if entry.extension().is_some_and(|end| end == ending) {
            found.push(entry);
        }
    }
    found
}

#[test]
fn documents_are_of_readable_length_and_their_tables_are_there() {
    let (most, page) = DOCUMENTS;
    let docs = workspace().join("docs");
    let pages = documents(&docs, "md");
    let root =
        ["README.md", "CONTRIBUTING.md", "ARCHITECTURE.md"].map(|file| workspace().join(file));
    let lines = |file: &PathBuf| text(file).lines().count();
    let all: usize = pages.iter().chain(&root).map(lines).sum();
    assert!(
        all <= most,
        "{all} lines outside of the book; say in {most} what a reader needs"
    );
    let mut linked = Vec::new();
    for file in &pages {
        assert!(
            lines(file) <= page,
            "{}: more than {page} lines; one page a question",
            file.display()
        );
        let folder = file.parent().expect("a folder");
        for target in text(file)
            .split("](")
            .skip(1)
            .filter_map(|rest| rest.split(')').next())
        {
            let target = folder.join(target.split('#').next().unwrap_or_default());
            assert!(target.exists(), "{}: {}", file.display(), target.display());
            linked.push(target);
        }
    }
    for table in documents(&docs, "csv") {
        assert!(
            linked.contains(&table),
            "no page leads to {}",
            table.display()
        );
        let columns = |line: &str| {
            line.split('"')
                .step_by(2)
                .map(|part| part.matches(',').count())
                .sum::<usize>()
        };
        let rows = text(&table);
        let mut counts = rows.lines().map(columns);
        let heading = counts.next().expect("a heading");
        assert!(
            counts.all(|count| count == heading),
            "{}: rows of other lengths",
            table.display()
        );
    }
}
