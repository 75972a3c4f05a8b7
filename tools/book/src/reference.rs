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

/// A part of a page: what it is about, and the enumeration or the structures of one source file that it lists.
struct Part {
    title: &'static str,
    file: &'static str,
    /// The names of the types, and of the functions that make parts of documents.
    types: &'static [&'static str],
}

const fn part(title: &'static str, file: &'static str, types: &'static [&'static str]) -> Part {
    Part { title, file, types }
}

/// Where statuses and other words of results are declared.
const STATUSES: [Part; 8] = [
    part(
        "Simulations",
        "runtime/src/simulation/result.rs",
        &["SimulationStatus"],
    ),
    part(
        "Optimal control",
        "runtime/src/ocp/solution.rs",
        &["Status"],
    ),
    part(
        "Estimation",
        "runtime/src/estimation/result.rs",
        &["Status"],
    ),
    part(
        "Programs from files",
        "solver/src/nl/solution.rs",
        &["Status"],
    ),
    part("Runs that are stopped", "cli/src/ending.rs", &["Stop"]),
    part(
        "Certificates of optima",
        "solver/src/mpcc/stationarity.rs",
        &["Stationarity"],
    ),
    part(
        "Second derivatives at a solution",
        "solver/src/nl/second_order.rs",
        &["SecondOrder"],
    ),
    part("Events", "runtime/src/simulation/result.rs", &["EventKind"]),
];

/// Where the documents that `--json` prints are declared, a document or a part of documents each.
const DOCUMENTS: [Part; 14] = [
    part(
        "Simulations",
        "cli/src/json/simulation.rs",
        &["simulation_document"],
    ),
    part(
        "Method of a simulation",
        "cli/src/method.rs",
        &["MethodSettings"],
    ),
    part(
        "Optimal control",
        "cli/src/json/solution.rs",
        &[
            "solution_document",
            "SolverSettings",
            "counts",
            "gradient",
            "time_freezing",
        ],
    ),
    part(
        "What a search found",
        "runtime/src/ocp/solution.rs",
        &[
            "Optimum",
            "Improvement",
            "Excess",
            "Margin",
            "RelaxedReport",
            "WordCounts",
        ],
    ),
    part(
        "Estimation",
        "cli/src/json/estimate.rs",
        &[
            "estimate_document",
            "parameter",
            "knowledge",
            "direction",
            "experiment",
        ],
    ),
    part(
        "Where searches of an estimation ended",
        "runtime/src/estimation/result.rs",
        &["LocalFit"],
    ),
    part(
        "Programs from files",
        "cli/src/json/program.rs",
        &["program_document"],
    ),
    part(
        "Gradients",
        "cli/src/json/gradient.rs",
        &["gradient", "side", "range", "end"],
    ),
    part("Joints", "cli/src/json/joints.rs", &["joints"]),
    part(
        "What documents have in common",
        "cli/src/json/parts.rs",
        &[
            "begun",
            "told",
            "event",
            "parts",
            "instants",
            "columns",
            "initially",
            "found",
        ],
    ),
    part("Residuals", "solver/src/nlp/solution.rs", &["Residuals"]),
    part("Sizes", "solver/src/problem_size.rs", &["ProblemSize"]),
    part(
        "Work of a simulation",
        "runtime/src/simulation/result.rs",
        &["Counts"],
    ),
    part("CPU times", "solver/src/seconds.rs", &["Seconds"]),
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

/// All words of results with their meaning, as (title of the part, entries).
///
/// # Errors
/// As of chapters that are generated: a name without documentation.
pub fn words_of_results(root: &Path) -> Result<Vec<(&'static str, Vec<Entry>)>> {
    let parts = STATUSES.iter().map(|part| {
        let source = fs::read_to_string(root.join(part.file))?;
        let mut entries = Vec::new();
        for name in part.types {
            entries.extend(
                variants(&source, name)
                    .map_err(|said| Error::other(format!("{}: {said}", part.file)))?,
            );
        }
        Ok((part.title, entries))
    });
    parts.collect()
}

/// All fields of documents with their meaning, as (title of the part, structures with their fields).
///
/// # Errors
/// As of chapters that are generated: a field without documentation.
pub fn fields_of_documents(root: &Path) -> Result<Vec<(&'static str, Vec<Structure>)>> {
    let parts = DOCUMENTS.iter().map(|part| {
        let source = fs::read_to_string(root.join(part.file))?;
        let mut structures = Vec::new();
        for name in part.types {
            let found = fields(&source, name)
                .map_err(|said| Error::other(format!("{}: {said}", part.file)))?;
            structures.push(found);
        }
        Ok((part.title, structures))
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

/// The body of an item that begins with `heading`, and the documentation before it.
fn body<'s>(source: &'s str, heading: &str) -> std::result::Result<(String, &'s str), String> {
    let starts = source.match_indices(heading).map(|(at, _)| at);
    // The whole name: what follows is no letter.
    let mut starts = starts.filter(|at| {
        !source[at + heading.len()..].starts_with(|c: char| c.is_alphanumeric() || c == '_')
    });
    let start = starts
        .next()
        .ok_or_else(|| format!("there is no `{heading}`"))?;
    let (before, from) = source.split_at(start);
    let open = from.find('{').ok_or("no body")?;
    let end = from.find("\n}").ok_or("no end")?;
    let mut lines: Vec<&str> = before.lines().collect();
    // The line in which the item begins, `pub(crate) `, belongs to it.
    if !before.ends_with('\n') {
        lines.pop();
    }
    let above = lines.iter().rev().take_while(|line| {
        let line = line.trim_start();
        line.starts_with("///") || line.starts_with("#[") || line.starts_with("// ")
    });
    let mut above: Vec<&&str> = above.collect();
    above.reverse();
    Ok((
        documentation(above.into_iter().copied()),
        &from[open + 1..end],
    ))
}

/// What doc comments among lines say, without links into the code.
fn documentation<'s>(lines: impl Iterator<Item = &'s str>) -> String {
    let said = lines.filter_map(|line| line.trim_start().strip_prefix("///"));
    let words: Vec<&str> = said
        .map(str::trim)
        .filter(|line| !line.is_empty())
        .collect();
    plain(&words.join(" "))
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

/// The variants of an enumeration by the names that its function `name` gives them; variants with the same name are one entry.
fn variants(source: &str, name: &str) -> std::result::Result<Vec<Entry>, String> {
    let (_, body) = body(source, &format!("enum {name}"))?;
    let mut entries: Vec<Entry> = Vec::new();
    let mut above: Vec<&str> = Vec::new();
    for line in body.lines() {
        let code = line.trim_start();
        let variant: &str = code
            .split(|c: char| !c.is_alphanumeric())
            .next()
            .unwrap_or("");
        if code.starts_with("///")
            || code.starts_with("#[")
            || !variant.starts_with(char::is_uppercase)
        {
            above.push(line);
            continue;
        }
        let text = documentation(above.drain(..));
        if text.is_empty() {
            return Err(format!("`{name}::{variant}` has no documentation"));
        }
        let shown = shown_name(source, name, variant)
            .ok_or_else(|| format!("`{name}::{variant}` has no name"))?;
        match entries.iter_mut().find(|entry| entry.name == shown) {
            Some(entry) => {
                let _ = write!(entry.text, " {text}");
            }
            None => entries.push(Entry { name: shown, text }),
        }
    }
    Ok(entries)
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

/// What a function makes of a document, and the fields that it names, each with what the comment above it says.
fn built(source: &str, name: &str) -> std::result::Result<Structure, String> {
    let (about, body) = body(source, &format!("fn {name}"))?;
    let mut fields: Vec<Entry> = Vec::new();
    let mut above: Vec<&str> = Vec::new();
    for line in body.lines().map(str::trim_start) {
        if let Some(said) = line.strip_prefix("// ") {
            above.push(said);
            continue;
        }
        let calls = [".with(\"", ".some(\"", ".list(\""].into_iter();
        let mut called = calls.filter_map(|call| Some(line.split_once(call)?.1));
        let named = called.next().or_else(|| line.strip_prefix("(\""));
        let field = named.and_then(|named| named.split('"').next());
        let text = plain(&std::mem::take(&mut above).join(" "));
        match field {
            Some(field) if text.is_empty() => {
                return Err(format!("`{field}` of `{name}` has no documentation"));
            }
            Some(field) if fields.iter().all(|known| known.name != field) => fields.push(Entry {
                name: field.to_owned(),
                text,
            }),
            _ => {}
        }
    }
    match about.is_empty() {
        true => Err(format!("`{name}` has no documentation")),
        false => Ok(Structure { about, fields }),
    }
}

/// What a structure is, and its fields as documents name them.
fn fields(source: &str, name: &str) -> std::result::Result<Structure, String> {
    if name.starts_with(char::is_lowercase) {
        return built(source, name);
    }
    let (about, body) = body(source, &format!("struct {name}"))?;
    let mut fields = Vec::new();
    let mut above: Vec<&str> = Vec::new();
    for line in body.lines() {
        let code = line.trim_start();
        let declared = code
            .split_once(": ")
            .filter(|_| !code.starts_with("//") && !code.starts_with("#["));
        let Some((field, _)) = declared else {
            above.push(line);
            continue;
        };
        let skipped = above.iter().any(|line| line.contains("serde(skip)"));
        let renamed = above
            .iter()
            .find_map(|line| line.split_once("rename = \"")?.1.split('"').next());
        let field = renamed
            .unwrap_or_else(|| field.rsplit(' ').next().unwrap_or(field))
            .to_owned();
        let text = documentation(above.drain(..));
        if skipped {
            continue;
        }
        if text.is_empty() {
            return Err(format!("`{name}.{field}` has no documentation"));
        }
        fields.push(Entry { name: field, text });
    }
    if about.is_empty() {
        return Err(format!("`{name}` has no documentation"));
    }
    Ok(Structure { about, fields })
}
