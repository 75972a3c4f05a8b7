//! Files of cases: which scenes they hold, and what is said about each.

use std::fs;
use std::path::Path;

/// A statement about a scene, without comments, with the line that it begins in.
#[derive(Debug, Clone)]
pub(crate) struct Line {
    pub(crate) number: usize,
    pub(crate) text: String,
}

/// A scene and what one fence says about it.
#[derive(Debug)]
pub(crate) struct Section {
    /// The file without its folder.
    pub(crate) file: String,
    /// Heading above it.
    pub(crate) heading: String,
    /// Text of the scene.
    pub(crate) scene: String,
    /// Text of another scene that it is compared with.
    pub(crate) like: Option<String>,
    pub(crate) statements: Vec<Line>,
}

/// All sections of a file.
///
/// # Errors
/// A fence that is not closed, a scene of which nothing is expected, and expectations of no scene.
pub(crate) fn read(path: &Path) -> Result<Vec<Section>, String> {
    let file = path.file_name().unwrap_or_default().to_string_lossy();
    let text = fs::read_to_string(path).map_err(|error| format!("{file}: {error}"))?;
    let is_mark = |line: &str| line.starts_with("```");
    if text.lines().filter(|line| is_mark(line)).count() % 2 == 1 {
        return Err(format!("{file}: a fence is not closed"));
    }
    let (mut heading, mut scene, mut like) = (String::new(), String::new(), None);
    // Line of the last scene, while nothing is expected of it.
    let mut open = None;
    let mut sections = Vec::new();
    let mut lines = text.lines().zip(1..);
    while let Some((line, number)) = lines.next() {
        if line.starts_with('#') {
            heading = line.trim_start_matches('#').trim().to_owned();
        }
        let Some(kind) = line.strip_prefix("```").map(str::trim) else {
            continue;
        };
        let inner: Vec<(&str, usize)> = lines.by_ref().take_while(|l| !is_mark(l.0)).collect();
        let whole = || inner.iter().map(|(line, _)| format!("{line}\n")).collect();
        let wrong = |why: &str| format!("{file}:{number}: {why}");
        if kind == "expect" {
            if scene.is_empty() {
                return Err(wrong("no scene stands above"));
            }
            open = None;
            sections.push(Section {
                file: file.to_string(),
                heading: heading.clone(),
                scene: scene.clone(),
                like: like.clone(),
                statements: statements(&inner).map_err(wrong)?,
            });
        } else if kind == "hang like" {
            like = Some(whole());
        } else if let Some(path) = kind.strip_prefix("hang") {
            if open.replace(number).is_some() {
                return Err(wrong("nothing is expected of the scene above"));
            }
            like = None;
            scene = match path.trim() {
                "" => whole(),
                path => {
                    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
                    let read = fs::read_to_string(root.join(path));
                    read.map_err(|error| wrong(&format!("{path}: {error}")))?
                }
            };
        }
    }
    match open {
        Some(number) => Err(format!("{file}:{number}: nothing is expected of it")),
        None => Ok(sections),
    }
}

/// Lines joined with those that continue them.
fn statements(lines: &[(&str, usize)]) -> Result<Vec<Line>, &'static str> {
    let mut statements: Vec<Line> = Vec::new();
    for &(line, number) in lines {
        let text = uncommented(line).trim_end();
        if text.starts_with(' ') {
            let begun = statements.last_mut();
            let begun = begun.ok_or("an indented line continues none")?;
            begun.text = format!("{} {}", begun.text, text.trim());
        } else if !text.is_empty() {
            let text = text.to_owned();
            statements.push(Line { number, text });
        }
    }
    Ok(statements)
}

/// A line without the comment behind `//`, if that stands in no quotes.
fn uncommented(line: &str) -> &str {
    let is_outside = |at: &usize| line[..*at].matches('"').count().is_multiple_of(2);
    let mut marks = line.match_indices("//").map(|mark| mark.0);
    &line[..marks.find(is_outside).unwrap_or(line.len())]
}
