//! Formulas in the notation of TeX as MathML, which browsers set by themselves.

use pulldown_latex::config::{DisplayMode, RenderConfig};
use pulldown_latex::{Event, Parser, ParserError, Storage, push_mathml};

/// A formula as MathML: in a line of its own, or within a sentence.
///
/// # Errors
/// What is not understood, and where.
pub fn mathml(formula: &str, block: bool) -> Result<String, String> {
    let formula = formula.trim();
    let storage = Storage::new();
    let events: Result<Vec<Event<'_>>, _> = Parser::new(formula, &storage).collect();
    let refused = |error: ParserError| format!("formula `{formula}`: {error}");
    let events = events.map_err(refused)?;
    let config = RenderConfig {
        display_mode: match block {
            true => DisplayMode::Block,
            false => DisplayMode::Inline,
        },
        ..RenderConfig::default()
    };
    let mut set = String::new();
    let events = events.into_iter().map(Ok::<_, std::fmt::Error>);
    push_mathml(&mut set, events, config).map_err(|error| error.to_string())?;
    let words = format!("<math alttext=\"{}\"", escape(formula));
    Ok(set.replacen("<math", &words, 1))
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

fn escape(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
        .replace('"', "&quot;")
}
