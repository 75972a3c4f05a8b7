//! Scenes and programs in colours: words of the language, numbers, units, comments.

/// Words of Rust in the book's programs that are none of the language.
const RUST: [&str; 4] = ["pub", "use", "impl", "struct"];

/// Text as HTML shows it.
pub(crate) fn escape(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
        .replace('"', "&quot;")
}

/// A scene as HTML.
pub(crate) fn scene(text: &str) -> String {
    let mut html = String::new();
    for line in text.lines() {
        let (code, comment) = line.split_at(line.find("//").unwrap_or(line.len()));
        let mut rest = code;
        while let Some(first) = rest.chars().next() {
            let (length, class) = token(rest, first);
            let (token, after) = rest.split_at(length);
            html.push_str(&marked(class, token));
            rest = after;
        }
        html.push_str(&marked("comment", comment));
        html.push('\n');
    }
    html
}

/// Length and class of the token at the beginning.
fn token(text: &str, first: char) -> (usize, &'static str) {
    let until = |end: fn(char) -> bool| text.find(end).unwrap_or(text.len());
    if first.is_ascii_digit() {
        // `0..=1` is two numbers.
        let length = until(|c| !c.is_ascii_digit() && c != '.');
        (text[..length].find("..").unwrap_or(length), "number")
    } else if first.is_alphabetic() {
        let length = until(|c| !c.is_alphanumeric() && c != '_');
        let token = &text[..length];
        let word = hangtime_dsl::is_word(token) || RUST.contains(&token);
        (length, if word { "word" } else { "" })
    } else if first == '[' {
        let length = text.find(']').map_or(text.len(), |end| end + 1);
        (length, "unit")
    } else {
        (first.len_utf8(), "")
    }
}

fn marked(class: &str, text: &str) -> String {
    if class.is_empty() || text.is_empty() {
        return escape(text);
    }
    format!("<span class=\"{class}\">{}</span>", escape(text))
}

/// A block of commands: what is typed stands out.
pub(crate) fn console(text: &str) -> String {
    let lines = text.lines().map(|line| {
        let class = if line.starts_with("$ ") { "typed" } else { "" };
        marked(class, line) + "\n"
    });
    lines.collect()
}
