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

/// What a fence holds.
#[derive(Clone, Copy, PartialEq)]
enum Fence {
    Scene,
    Like,
    Statements,
    Other,
}

/// Where the reader of a file is.
struct Reader<'a> {
    file: &'a str,
    heading: String,
    scene: String,
    like: Option<String>,
    /// Line of the last scene, while nothing is expected of it.
    open: Option<usize>,
    fence: Option<Fence>,
    sections: Vec<Section>,
}

/// All sections of a file.
///
/// # Errors
/// A fence that is not closed, a scene of which nothing is expected, and expectations of no scene.
pub(crate) fn read(path: &Path) -> Result<Vec<Section>, String> {
    let shown = path.file_name().unwrap_or_default().to_string_lossy();
    let text = fs::read_to_string(path).map_err(|error| format!("{shown}: {error}"))?;
    sections(&shown, &text)
}

fn sections(file: &str, text: &str) -> Result<Vec<Section>, String> {
    let mut reader = Reader {
        file,
        heading: String::new(),
        scene: String::new(),
        like: None,
        open: None,
        fence: None,
        sections: Vec::new(),
    };
    for (line, number) in text.lines().zip(1..) {
        reader.line(line, number)?;
    }
    if reader.fence.is_some() {
        return Err(format!("{file}: its last fence is not closed"));
    }
    reader.nothing_open()?;
    Ok(reader.sections)
}

impl Reader<'_> {
    fn line(&mut self, line: &str, number: usize) -> Result<(), String> {
        match (self.fence, line.strip_prefix("```")) {
            (Some(_), Some(_)) => self.fence = None,
            (None, Some(kind)) => self.begin(kind.trim(), number)?,
            (Some(Fence::Scene), None) => {
                self.scene.push_str(line);
                self.scene.push('\n');
            }
            (Some(Fence::Like), None) => {
                let like = self.like.get_or_insert_default();
                like.push_str(line);
                like.push('\n');
            }
            (Some(Fence::Statements), None) => self.statement(line, number)?,
            (Some(Fence::Other), None) => {}
            (None, None) => {
                if let Some(heading) = line.strip_prefix('#') {
                    self.heading = heading.trim_start_matches('#').trim().to_owned();
                }
            }
        }
        Ok(())
    }

    fn begin(&mut self, kind: &str, number: usize) -> Result<(), String> {
        self.fence = Some(match kind {
            "hang" => {
                self.nothing_open()?;
                self.scene.clear();
                self.like = None;
                self.open = Some(number);
                Fence::Scene
            }
            "hang like" => {
                self.like = Some(String::new());
                Fence::Like
            }
            kind if kind.starts_with("hang ") => {
                self.nothing_open()?;
                let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
                let scene = fs::read_to_string(path.join(kind["hang ".len()..].trim()));
                let unread = |error| format!("{}:{number}: {kind}: {error}", self.file);
                self.scene = scene.map_err(unread)?;
                self.like = None;
                self.open = Some(number);
                Fence::Scene
            }
            "expect" => {
                if self.scene.is_empty() {
                    return Err(format!("{}:{number}: no scene stands above", self.file));
                }
                self.open = None;
                self.sections.push(Section {
                    file: self.file.to_owned(),
                    heading: self.heading.clone(),
                    scene: self.scene.clone(),
                    like: self.like.clone(),
                    statements: Vec::new(),
                });
                Fence::Statements
            }
            _ => Fence::Other,
        });
        Ok(())
    }

    fn statement(&mut self, line: &str, number: usize) -> Result<(), String> {
        let text = uncommented(line);
        let statements = match self.sections.last_mut() {
            Some(section) => &mut section.statements,
            None => return Ok(()),
        };
        if text.trim().is_empty() {
            return Ok(());
        }
        if !text.starts_with(' ') {
            let text = text.trim_end().to_owned();
            statements.push(Line { number, text });
            return Ok(());
        }
        let Some(begun) = statements.last_mut() else {
            let file = self.file;
            return Err(format!("{file}:{number}: an indented line continues none"));
        };
        begun.text.push(' ');
        begun.text.push_str(text.trim());
        Ok(())
    }

    fn nothing_open(&self) -> Result<(), String> {
        match self.open {
            None => Ok(()),
            Some(number) => Err(format!(
                "{}:{number}: nothing is expected of this scene; a fence `expect` is to follow",
                self.file
            )),
        }
    }
}

/// A line without the comment behind `//`, if that stands in no quotes.
fn uncommented(line: &str) -> &str {
    let mut quoted = false;
    let mut bytes = line.bytes().enumerate().peekable();
    while let Some((at, byte)) = bytes.next() {
        match byte {
            b'"' => quoted = !quoted,
            b'/' if !quoted && bytes.peek().is_some_and(|&(_, next)| next == b'/') => {
                return &line[..at];
            }
            _ => {}
        }
    }
    line
}
