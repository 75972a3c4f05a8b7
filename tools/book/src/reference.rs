//! Chapters that are written by the code: what stands beside variants, fields and options in the sources is what the book says of them.

use std::fmt::Write as _;
use std::fs;
use std::io::{Error, Result};
use std::path::Path;

use hangtime_cli::CommandLine;

use crate::language;

/// One entry: a name in the notation of results, and what is said of it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Entry {
    /// The name.
    pub name: String,
    /// What its documentation says, as one paragraph of Markdown.
    pub text: String,
}

/// A structure of a document.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Structure {
    /// What its documentation says.
    pub about: String,
    /// Its fields.
    pub fields: Vec<Entry>,
}

/// Where statuses and other words of results are declared: titles, files and enumerations.
const STATUSES: [[&str; 3]; 8] = [
    [
        "Simulations",
        "runtime/src/simulation/result.rs",
        "SimulationStatus",
    ],
    ["Optimal control", "runtime/src/ocp/solution.rs", "Status"],
    ["Estimation", "runtime/src/estimation/result.rs", "Status"],
    ["Programs from files", "solver/src/nl/solution.rs", "Status"],
    ["Runs that are stopped", "cli/src/ending.rs", "Stop"],
    [
        "Certificates of optima",
        "solver/src/mpcc/stationarity.rs",
        "Stationarity",
    ],
    [
        "Second derivatives at a solution",
        "solver/src/nl/second_order.rs",
        "SecondOrder",
    ],
    ["Events", "runtime/src/simulation/result.rs", "EventKind"],
];

/// Where the documents that `--json` prints are declared: titles, and files of structures that are written and of functions that name
/// fields.
const DOCUMENTS: [[&str; 2]; 15] = [
    ["Simulations", "cli/src/json/simulation.rs"],
    ["Method of a simulation", "cli/src/method.rs"],
    ["Optimal control", "cli/src/json/solution.rs"],
    ["What a search found", "runtime/src/ocp/solution.rs"],
    ["Estimation", "cli/src/json/estimate.rs"],
    [
        "Where searches of an estimation ended",
        "runtime/src/estimation/result.rs",
    ],
    ["Programs from files", "cli/src/json/program.rs"],
    ["Gradients", "cli/src/json/gradient.rs"],
    ["Ranges of gradients", "runtime/src/derivative/ranges.rs"],
    ["Joints", "cli/src/json/joints.rs"],
    ["What documents have in common", "cli/src/json/parts.rs"],
    ["Residuals", "solver/src/nlp/solution.rs"],
    ["Sizes", "solver/src/problem_size.rs"],
    ["Work of a simulation", "runtime/src/simulation/result.rs"],
    ["CPU times", "solver/src/seconds.rs"],
];

/// The text of a generated chapter, by its file; `None` if there is no such chapter.
///
/// # Errors
/// A source that cannot be read, a type that is not in it, and a variant or field without documentation.
pub(crate) fn chapter(file: &str, root: &Path) -> Result<Option<String>> {
    match file {
        language::FILE => {
            let source = fs::read_to_string(root.join(language::SOURCE))?;
            Ok(Some(language::chapter(&source)))
        }
        "statuses.md" => statuses(root).map(Some),
        "columns.md" => columns(root).map(Some),
        "settings.md" => Ok(Some(settings())),
        _ => Ok(None),
    }
}

/// All words of results with their meaning, as (title of the part, entries); variants with the same name are one entry.
///
/// # Errors
/// As of chapters that are generated: a name without documentation.
pub fn words_of_results(root: &Path) -> Result<Vec<(&'static str, Vec<Entry>)>> {
    let parts = STATUSES.iter().map(|[title, file, name]| {
        let source = fs::read_to_string(root.join(file))?;
        let mut entries: Vec<Entry> = Vec::new();
        let wanted = |kind: &str, item: &str| kind == "enum" && item == *name;
        let variants = items(file, &source, wanted)?.into_iter();
        for Entry {
            name: variant,
            text,
        } in variants.flat_map(|item| item.1.fields)
        {
            let shown = shown_name(&source, name, &variant)
                .ok_or_else(|| Error::other(format!("{file}: `{name}::{variant}` has no name")))?;
            match entries.iter_mut().find(|entry| entry.name == shown) {
                Some(entry) => entry.text += &format!(" {text}"),
                None => entries.push(Entry { name: shown, text }),
            }
        }
        Ok((*title, entries))
    });
    parts.collect()
}

/// All fields of documents with their meaning, as (title of the part, structures with their fields), whole documents first.
///
/// # Errors
/// As of chapters that are generated: a field without documentation.
pub fn fields_of_documents(root: &Path) -> Result<Vec<(&'static str, Vec<Structure>)>> {
    let parts = DOCUMENTS.iter().map(|[title, file]| {
        let source = fs::read_to_string(root.join(file))?;
        let mut items = items(file, &source, |kind, _| ["struct", "fn"].contains(&kind))?;
        items.retain(|(_, item)| !item.fields.is_empty());
        items.sort_by_key(|(name, _)| !name.ends_with("_document"));
        Ok((*title, items.into_iter().map(|item| item.1).collect()))
    });
    parts.collect()
}

fn statuses(root: &Path) -> Result<String> {
    let mut text = String::from(
        "# Words of results\n\nNot converging is a status: the best result so far is printed all the same, and the exit status of the program is 3. Bad input is \
         refused before the first step with exit status 2. What to do where a status is not `solved` is in [Reading results](results.md#status). \
         This chapter is written by the code: what it says of a word is what stands beside it in the sources.\n",
    );
    for (title, entries) in words_of_results(root)? {
        let _ = write!(text, "\n## {title}\n\n");
        push_table(&mut text, "word", &entries);
    }
    Ok(text)
}

fn columns(root: &Path) -> Result<String> {
    let mut text = String::from(
        "# Fields and columns\n\nWhat `--json` prints, field by field; the files of `--out` have the same numbers, in columns with the same names, with units in \
         their headings. This chapter is written by the code, too.\n",
    );
    for (title, structures) in fields_of_documents(root)? {
        let _ = write!(text, "\n## {title}\n");
        for Structure { about, fields } in structures {
            let _ = write!(text, "\n{about}\n\n");
            push_table(&mut text, "field", &fields);
        }
    }
    Ok(text)
}

fn settings() -> String {
    let mut text = String::from(
        "# Commands and settings\n\nEvery command with its options, as `hangtime COMMAND --help` prints them. A setting that would do nothing is refused.\n",
    );
    for command in CommandLine::settings() {
        let _ = write!(
            text,
            "\n## `hangtime {}`\n\n{}\n\n",
            command.name,
            sentence(&command.about)
        );
        let entries = command.options.into_iter();
        let entries: Vec<Entry> = entries
            .map(|(name, text)| Entry {
                name,
                text: sentence(&text),
            })
            .collect();
        push_table(&mut text, "option", &entries);
    }
    text
}

/// Markdown in which `<` and `|` are what they say, and a full stop at the end.
fn sentence(text: &str) -> String {
    let end = if text.ends_with(['.', '!', '?', ')']) || text.is_empty() {
        ""
    } else {
        "."
    };
    format!("{text}{end}")
}

fn push_table(text: &mut String, heading: &str, entries: &[Entry]) {
    if entries.is_empty() {
        return;
    }
    let _ = write!(text, "| {heading} | meaning |\n|---|---|\n");
    for Entry { name, text: said } in entries {
        let _ = writeln!(text, "| `{name}` | {} |", said.replace('|', "\\|"));
    }
}

/// A link `[`X`](path)` or `[`X`]` as its words.
fn plain(text: &str) -> String {
    let mut plain = String::new();
    let mut rest = text.replace("\\[", "(").replace("\\]", ")");
    while let Some(start) = rest.find("[`") {
        plain.push_str(&rest[..start]);
        let inside = rest[start + 1..].to_owned();
        let Some(end) = inside.find(']') else {
            plain.push_str(&inside);
            return plain;
        };
        // The last part of a path is its name.
        let name = inside[..end].trim_matches('`');
        let name = name.rsplit("::").next().unwrap_or(name);
        let _ = write!(plain, "`{name}`");
        let after = &inside[end + 1..];
        rest = match after
            .strip_prefix('(')
            .and_then(|target| target.split_once(')'))
        {
            Some((_, after)) => after.to_owned(),
            None => after.to_owned(),
        };
    }
    plain + &rest
}

/// The text that the function `name` of an enumeration has for a variant.
fn shown_name(source: &str, name: &str, variant: &str) -> Option<String> {
    let from = source.find(&format!("impl {name} {{"))?;
    let from = from + source[from..].find("fn name(")?;
    let arms = &source[from..from + source[from..].find("\n    }")?];
    let arm = arms.lines().find(|line| {
        line.split(['|', '=']).any(|pattern| {
            let pattern = pattern.trim().strip_prefix("Self::").unwrap_or_default();
            pattern.split(['(', ' ', '{']).next() == Some(variant)
        })
    })?;
    let text = arm.split('"').nth(1)?;
    Some(text.to_owned())
}

/// The kind and the name of the item that begins in a line.
fn heading(line: &str) -> Option<(&str, &str)> {
    let words = match line.strip_prefix("pub") {
        Some(rest) => rest.split_once(' ')?.1,
        None => line,
    };
    let (kind, rest) = words.split_once(' ')?;
    let mut words = rest.split(|c: char| !c.is_alphanumeric() && c != '_');
    Some((kind, words.next()?))
}

/// The field of a document that a line of an item of this `kind` names, below these `attributes` and a comment, or the variant.
fn field<'s>(line: &'s str, kind: &str, attributes: &'s str, commented: bool) -> Option<&'s str> {
    match kind {
        "struct" if !attributes.contains("serde(skip)") => {
            let renamed = attributes.split_once("rename = \"").map(|(_, name)| name);
            let declared = line.split_once(": ")?.0.rsplit(' ').next();
            renamed.and_then(|name| name.split('"').next()).or(declared)
        }
        "enum" if line.starts_with(char::is_uppercase) => {
            line.split(|c: char| !c.is_alphanumeric()).next()
        }
        "fn" => {
            let calls = [".with(\"", ".some(\"", ".list(\""].into_iter();
            let mut called = calls.filter_map(|call| Some(line.split_once(call)?.1));
            let row = || line.strip_prefix("(\"").filter(|_| commented);
            called.next().or_else(row)?.split('"').next()
        }
        _ => None,
    }
}

/// The items of a source that are `wanted` by kind and name, with the fields that documents get from each, or its variants: structures that
/// are written, enumerations, and functions that name fields, in a comment above each what it is.
fn items<'s>(
    file: &str,
    source: &'s str,
    wanted: impl Fn(&str, &str) -> bool,
) -> Result<Vec<(&'s str, Structure)>> {
    let source = source.split("#[cfg(test)]").next().unwrap_or(source);
    let mut items: Vec<(&str, Structure)> = Vec::new();
    let (mut above, mut attributes, mut kind) = (Vec::new(), String::new(), "");
    for line in source.lines() {
        let code = line.trim_start();
        if code.starts_with("//") {
            above.push(code);
            continue;
        }
        if code.starts_with("#[") {
            attributes.push_str(code);
            continue;
        }
        let begun = heading(code).filter(|(kind, name)| wanted(kind, name));
        let marks = if begun.is_none() && kind == "fn" {
            "// "
        } else {
            "///"
        };
        let said = above.drain(..);
        let said = said.filter_map(|line: &str| Some(line.strip_prefix(marks)?.trim()));
        let said: Vec<&str> = said.filter(|line| !line.is_empty()).collect();
        let text = plain(&said.join(" "));
        let attributes = std::mem::take(&mut attributes);
        if let Some((of_kind, name)) = begun {
            let written = of_kind != "struct" || attributes.contains("Serialize");
            kind = if written { of_kind } else { "" };
            let fields = Vec::new();
            items.push((
                name,
                Structure {
                    about: text,
                    fields,
                },
            ));
        } else if line.starts_with('}') {
            kind = "";
        } else if let Some(name) = field(code, kind, &attributes, !text.is_empty())
            && let Some((item, known)) = items.last_mut()
            && known.fields.iter().all(|field| field.name != name)
        {
            if text.is_empty() || known.about.is_empty() {
                let said = format!("{file}: `{item}` or its `{name}` has no documentation");
                return Err(Error::other(said));
            }
            let name = name.to_owned();
            known.fields.push(Entry { name, text });
        }
    }
    Ok(items)
}
