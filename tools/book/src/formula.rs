//! Formulas: a part of the notation of TeX as MathML, which browsers set by themselves.
//!
//! | written | set |
//! |---|---|
//! | `a_i`, `x^{2}`, `v'` | index, exponent, prime |
//! | `\frac{a}{b}`, `\sqrt{a}` | fraction, root |
//! | `\dot{q}`, `\ddot{q}`, `\bar{a}` | derivatives in time, bar |
//! | `\lambda`, `\le`, `\perp`, `\int`, ... | letters and signs of [`SIGNS`] |
//! | `\sin`, `\max`, ... | functions of [`FUNCTIONS`] |
//! | `\text{if}`, `\quad`, `\,` | words, space |
//! | `\begin{cases} a & b \\ c & d \end{cases}`, `pmatrix` | cases, matrices |

use std::fmt::Write as _;

/// Letters and signs by their names.
const SIGNS: [(&str, &str); 45] = [
    ("alpha", "\u{3b1}"),
    ("beta", "\u{3b2}"),
    ("gamma", "\u{3b3}"),
    ("delta", "\u{3b4}"),
    ("epsilon", "\u{3b5}"),
    ("eta", "\u{3b7}"),
    ("theta", "\u{3b8}"),
    ("kappa", "\u{3ba}"),
    ("lambda", "\u{3bb}"),
    ("mu", "\u{3bc}"),
    ("nu", "\u{3bd}"),
    ("pi", "\u{3c0}"),
    ("rho", "\u{3c1}"),
    ("sigma", "\u{3c3}"),
    ("tau", "\u{3c4}"),
    ("phi", "\u{3c6}"),
    ("psi", "\u{3c8}"),
    ("omega", "\u{3c9}"),
    ("Delta", "\u{394}"),
    ("Lambda", "\u{39b}"),
    ("Phi", "\u{3a6}"),
    ("infty", "\u{221e}"),
    ("partial", "\u{2202}"),
    ("le", "\u{2264}"),
    ("ge", "\u{2265}"),
    ("ne", "\u{2260}"),
    ("approx", "\u{2248}"),
    ("in", "\u{2208}"),
    ("to", "\u{2192}"),
    ("perp", "\u{22a5}"),
    ("cdot", "\u{b7}"),
    ("times", "\u{d7}"),
    ("pm", "\u{b1}"),
    ("nabla", "\u{2207}"),
    ("int", "\u{222b}"),
    ("sum", "\u{2211}"),
    ("ldots", "\u{2026}"),
    ("top", "\u{22a4}"),
    ("mid", "|"),
    ("lbrace", "{"),
    ("rbrace", "}"),
    ("prime", "\u{2032}"),
    ("langle", "\u{27e8}"),
    ("rangle", "\u{27e9}"),
    ("Rightarrow", "\u{21d2}"),
];
/// How many of them are letters; the others are operators.
const LETTERS: usize = 22;
/// Functions and words that stand upright.
const FUNCTIONS: [&str; 14] = [
    "sin", "cos", "tan", "exp", "ln", "log", "sup", "max", "min", "sign", "arg", "det", "tanh",
    "cosh",
];
/// Spaces, and their widths.
const SPACES: [(&str, &str); 5] = [
    ("quad", "1em"),
    ("qquad", "2em"),
    (",", "0.17em"),
    (";", "0.28em"),
    (" ", "0.28em"),
];
/// Signs above a letter.
const ACCENTS: [(&str, &str); 5] = [
    ("dot", "\u{2d9}"),
    ("ddot", "\u{a8}"),
    ("bar", "\u{af}"),
    ("hat", "^"),
    ("tilde", "~"),
];

/// A formula as MathML: in a line of its own, or within a sentence.
///
/// # Errors
/// What is not understood, and where.
pub fn mathml(formula: &str, block: bool) -> Result<String, String> {
    let mut parser = Parser {
        rest: formula.trim(),
        whole: formula.trim(),
        operand: false,
    };
    let rows = parser.rows(None)?;
    let set = match &rows[..] {
        [row] if row.len() == 1 => row[0].clone(),
        _ => table(&rows, "columnalign=\"left\""),
    };
    let display = if block { " display=\"block\"" } else { "" };
    Ok(format!(
        "<math{display} alttext=\"{}\"><mrow>{set}</mrow></math>",
        escape(formula.trim())
    ))
}

/// Markdown in which formulas, `$...$` and blocks of the language `math`, are set.
///
/// # Errors
/// As [`mathml`].
pub fn in_markdown(text: &str) -> Result<String, String> {
    let mut set = String::with_capacity(text.len());
    let mut lines = text.split_inclusive('\n');
    while let Some(line) = lines.next() {
        let Some(info) = line.strip_prefix("```") else {
            set += &in_line(line)?;
            continue;
        };
        let inside: String = lines
            .by_ref()
            .take_while(|line| !line.starts_with("```"))
            .collect();
        if info.trim() == "math" {
            set += &mathml(&inside, true)?;
            set.push('\n');
        } else {
            set += line;
            set += &inside;
            set += "```\n";
        }
    }
    Ok(set)
}

/// A line of Markdown, of which code stays as it is.
fn in_line(line: &str) -> Result<String, String> {
    let mut set = String::new();
    for (index, part) in line.split('`').enumerate() {
        if index > 0 {
            set.push('`');
        }
        if index % 2 == 1 {
            set.push_str(part);
            continue;
        }
        for (index, part) in part.split('$').enumerate() {
            match index % 2 {
                0 => set.push_str(part),
                _ => set += &mathml(part, false)?,
            }
        }
    }
    Ok(set)
}

struct Parser<'f> {
    rest: &'f str,
    whole: &'f str,
    /// Whether what stands before is an operand, of which a minus is taken away; elsewhere it is a sign.
    operand: bool,
}

/// Rows of cells, each set.
type Rows = Vec<Vec<String>>;

impl<'f> Parser<'f> {
    fn fail<T>(&self, what: &str) -> Result<T, String> {
        let at = self.whole.len() - self.rest.len();
        Err(format!("formula `{}`: {what} at letter {at}", self.whole))
    }

    fn next(&mut self) -> Option<char> {
        let first = self.rest.chars().next()?;
        self.rest = &self.rest[first.len_utf8()..];
        Some(first)
    }

    /// The name behind a backslash: letters, or one sign.
    fn command(&mut self) -> &'f str {
        let letters = self.rest.find(|c: char| !c.is_ascii_alphabetic());
        let length = match letters.unwrap_or(self.rest.len()) {
            0 => self.rest.chars().next().map_or(0, char::len_utf8),
            length => length,
        };
        let (name, rest) = self.rest.split_at(length);
        self.rest = rest;
        name
    }

    /// Everything to `\end{environment}`, or to the end.
    fn rows(&mut self, environment: Option<&str>) -> Result<Rows, String> {
        let mut rows: Rows = vec![vec![String::new()]];
        let end = environment.map(|name| format!("\\end{{{name}}}"));
        loop {
            self.rest = self.rest.trim_start();
            if let Some(end) = &end
                && let Some(rest) = self.rest.strip_prefix(end.as_str())
            {
                self.rest = rest;
                return Ok(rows);
            }
            if self.rest.is_empty() {
                return match environment {
                    None => Ok(rows),
                    Some(name) => self.fail(&format!("`{name}` has no end")),
                };
            }
            if let Some(rest) = self.rest.strip_prefix("\\\\") {
                self.rest = rest;
                rows.push(vec![String::new()]);
            } else if let Some(rest) = self.rest.strip_prefix('&') {
                self.rest = rest;
                if let Some(row) = rows.last_mut() {
                    row.push(String::new());
                }
            } else {
                let part = self.scripted()?;
                if let Some(cell) = rows.last_mut().and_then(|row| row.last_mut()) {
                    cell.push_str(&part);
                }
            }
        }
    }

    /// A part with what is below and above it.
    fn scripted(&mut self) -> Result<String, String> {
        let base = self.part()?;
        let operand = self.operand;
        let (mut below, mut above) = (None, String::new());
        loop {
            self.rest = self.rest.trim_start();
            match self.rest.chars().next() {
                Some('_') if below.is_none() => {
                    self.next();
                    below = Some(self.argument()?);
                }
                Some('^') => {
                    self.next();
                    above += &self.argument()?;
                }
                Some('\'') => {
                    self.next();
                    above += "<mo>\u{2032}</mo>";
                }
                _ => break,
            }
        }
        self.operand = operand;
        let above = (!above.is_empty()).then(|| format!("<mrow>{above}</mrow>"));
        Ok(match (below, above) {
            (None, None) => base,
            (Some(below), None) => format!("<msub>{base}{below}</msub>"),
            (None, Some(above)) => format!("<msup>{base}{above}</msup>"),
            (Some(below), Some(above)) => format!("<msubsup>{base}{below}{above}</msubsup>"),
        })
    }

    /// One part, or what stands in braces.
    fn argument(&mut self) -> Result<String, String> {
        self.rest = self.rest.trim_start();
        self.operand = false;
        self.part()
    }

    fn braced(&mut self) -> Result<String, String> {
        let mut inner = String::new();
        self.operand = false;
        loop {
            self.rest = self.rest.trim_start();
            if self.rest.is_empty() {
                return self.fail("a brace is not closed");
            }
            if self.rest.starts_with('}') {
                self.next();
                return Ok(format!("<mrow>{inner}</mrow>"));
            }
            inner += &self.scripted()?;
        }
    }

    fn part(&mut self) -> Result<String, String> {
        let part = self.atom()?;
        let space = part.is_empty() || part.starts_with("<mspace");
        let closes = ["<mo>)</mo>", "<mo>]</mo>", "<mo>|</mo>", "<mo>}</mo>"];
        if !space {
            self.operand = !part.starts_with("<mo")
                || part.starts_with("<mover")
                || closes.contains(&part.as_str());
        }
        Ok(part)
    }

    fn atom(&mut self) -> Result<String, String> {
        let Some(first) = self.rest.chars().next() else {
            return self.fail("something is missing");
        };
        if first.is_ascii_digit() {
            let length = self.rest.find(|c: char| !c.is_ascii_digit() && c != '.');
            let (number, rest) = self.rest.split_at(length.unwrap_or(self.rest.len()));
            self.rest = rest;
            return Ok(format!("<mn>{number}</mn>"));
        }
        self.next();
        Ok(match first {
            '\\' => return self.named(),
            '{' => return self.braced(),
            '}' => return self.fail("a brace is closed that is not open"),
            '-' if self.operand => "<mo>\u{2212}</mo>".to_owned(),
            '-' => "<mo form=\"prefix\">\u{2212}</mo>".to_owned(),
            letter if letter.is_alphabetic() => format!("<mi>{letter}</mi>"),
            sign => format!("<mo>{}</mo>", escape(&sign.to_string())),
        })
    }

    /// What a backslash begins.
    fn named(&mut self) -> Result<String, String> {
        let name = self.command();
        let sign = SIGNS.iter().position(|(known, _)| *known == name);
        if let Some(index) = sign {
            let tag = if index < LETTERS { "mi" } else { "mo" };
            return Ok(format!("<{tag}>{}</{tag}>", SIGNS[index].1));
        }
        if let Some((_, width)) = SPACES.iter().find(|(known, _)| *known == name) {
            return Ok(format!("<mspace width=\"{width}\"/>"));
        }
        if let Some((_, accent)) = ACCENTS.iter().find(|(known, _)| *known == name) {
            let base = self.argument()?;
            return Ok(format!(
                "<mover accent=\"true\">{base}<mo>{accent}</mo></mover>"
            ));
        }
        match name {
            "frac" => {
                let (above, below) = (self.argument()?, self.argument()?);
                Ok(format!("<mfrac>{above}{below}</mfrac>"))
            }
            "sqrt" => Ok(format!("<msqrt>{}</msqrt>", self.argument()?)),
            "text" | "mathrm" => {
                // Spaces at the ends would be left out.
                let words = self.verbatim()?.replace(' ', "\u{a0}");
                Ok(format!("<mtext>{}</mtext>", escape(&words)))
            }
            // Brackets grow by themselves.
            "left" | "right" => Ok(String::new()),
            "{" | "}" => Ok(format!("<mo>{name}</mo>")),
            "begin" => self.environment(),
            _ if FUNCTIONS.contains(&name) => Ok(format!("<mi>{name}</mi>")),
            _ => self.fail(&format!("`\\{name}` is not known")),
        }
    }

    /// What stands in braces, letter by letter.
    fn verbatim(&mut self) -> Result<&'f str, String> {
        let inner = self.rest.strip_prefix('{');
        match inner.and_then(|inner| inner.split_once('}')) {
            Some((words, rest)) => {
                self.rest = rest;
                Ok(words)
            }
            None => self.fail("braces are missing"),
        }
    }

    fn environment(&mut self) -> Result<String, String> {
        let name = self.verbatim()?;
        let rows = self.rows(Some(name))?;
        match name {
            "cases" => Ok(format!(
                "<mrow><mo>{{</mo>{}</mrow>",
                table(&rows, "columnalign=\"left\"")
            )),
            "pmatrix" => Ok(format!(
                "<mrow><mo>(</mo>{}<mo>)</mo></mrow>",
                table(&rows, "")
            )),
            _ => self.fail(&format!("`{name}` is not known")),
        }
    }
}

fn table(rows: &Rows, style: &str) -> String {
    let mut table = format!("<mtable {style}>");
    for row in rows {
        table.push_str("<mtr>");
        for cell in row {
            // Writing to a string cannot fail.
            let _ = write!(table, "<mtd><mrow>{cell}</mrow></mtd>");
        }
        table.push_str("</mtr>");
    }
    table + "</mtable>"
}

fn escape(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
        .replace('"', "&quot;")
}
