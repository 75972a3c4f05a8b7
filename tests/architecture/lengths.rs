//! Lengths of functions and structs, read line by line: the sources are formatted, so that what opens at an indentation is
//! closed at the same one.

use std::path::Path;

use crate::arrows::Finding;

/// Most lines of a function, its signature included.
const FUNCTION: usize = 80;
/// Most fields of a struct without a reason beside it.
const FIELDS: usize = 15;
/// How the reason for more fields begins, in a comment right above the struct.
const REASON: &str = "// Many fields: ";

/// What is too long in a source file.
pub(crate) fn too_long(file: &Path, source: &str) -> Vec<Finding> {
    let lines: Vec<&str> = source.lines().collect();
    let mut findings = Vec::new();
    for (at, line) in lines.iter().enumerate() {
        let indent = line.len() - line.trim_start().len();
        if let Some(name) = named(line, "fn") {
            let length = function(&lines[at..], indent);
            if length > FUNCTION {
                findings.push(format!("`{name}` has {length} lines"));
            }
        } else if let Some(name) = named(line, "struct")
            && line.ends_with('{')
        {
            let fields = fields(&lines[at + 1..], indent);
            if fields > FIELDS && !has_reason(&lines[..at]) {
                findings.push(format!("`{name}` has {fields} fields and no reason for it"));
            }
        }
    }
    let found = |text| Finding {
        file: file.to_path_buf(),
        text,
    };
    findings.into_iter().map(found).collect()
}

/// The name that a line defines after `keyword`, which only visibility and qualifiers precede.
fn named<'a>(line: &'a str, keyword: &str) -> Option<&'a str> {
    let mut rest = line.trim_start();
    if let Some(after) = rest.strip_prefix("pub") {
        let scope = after.starts_with('(').then(|| after.find(") ")).flatten();
        rest = after[scope.map_or(0, |end| end + 1)..].trim_start();
    }
    for qualifier in ["const ", "async "] {
        rest = rest.strip_prefix(qualifier).unwrap_or(rest);
    }
    let name = rest.strip_prefix(keyword)?.strip_prefix(' ')?;
    name.split(|c: char| !c.is_alphanumeric() && c != '_')
        .next()
}

/// Lines of the function that begins at the first line; 0 where it has no body of more than one line, or is one of a
/// declaration of a scene, which has no braces.
fn function(lines: &[&str], indent: usize) -> usize {
    let Some(open) = lines
        .iter()
        .take(FUNCTION)
        .position(|line| line.ends_with(['{', ';', '}']))
    else {
        return 0;
    };
    if !lines[open].ends_with('{') || lines[0].contains(") = ") {
        return 0;
    }
    length_to_brace(&lines[open..], indent).map_or(0, |length| open + length)
}

/// Lines up to the one that holds nothing but a closing brace at `indent`.
fn length_to_brace(lines: &[&str], indent: usize) -> Option<usize> {
    let closes = |line: &&str| line.trim_start() == "}" && line.len() == indent + 1;
    lines.iter().position(closes).map(|last| last + 1)
}

/// Fields of the struct whose first field is in the first line.
fn fields(lines: &[&str], indent: usize) -> usize {
    let body = &lines[..length_to_brace(lines, indent).unwrap_or(lines.len())];
    let is_field = |line: &&&str| {
        let text = line.trim_start();
        line.len() - text.len() == indent + 4
            && !text.starts_with(['/', '#'])
            && text.contains(": ")
    };
    body.iter().filter(is_field).count()
}

/// Whether a reason stands among the comments and attributes that end here.
fn has_reason(above: &[&str]) -> bool {
    above
        .iter()
        .rev()
        .map(|line| line.trim_start())
        .take_while(|line| line.starts_with("//") || line.starts_with('#'))
        .any(|line| line.starts_with(REASON))
}
