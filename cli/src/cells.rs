//! Lines of tables in any style: semicolons, commas, tabs or blanks between cells, decimals behind a point or a comma.

/// What stands between semicolons, else between commas or tabs, else between blanks; units stay with their names.
pub(crate) fn cells(line: &str) -> Vec<String> {
    let separator = [';', ',', '\t'].into_iter().find(|&c| line.contains(c));
    let Some(separator) = separator else {
        let mut cells: Vec<String> = Vec::new();
        for word in line.split_whitespace() {
            match cells.last_mut() {
                Some(name) if word.starts_with(['[', '(']) => *name = format!("{name} {word}"),
                _ => cells.push(word.to_owned()),
            }
        }
        return cells;
    };
    let clean = |cell: &str| cell.trim().trim_matches('"').trim().to_owned();
    line.split(separator).map(clean).collect()
}

/// A finite number, whose decimals may stand behind a comma.
pub(crate) fn number_of(cell: &str) -> Option<f64> {
    let value: f64 = cell.replace(',', ".").parse().ok()?;
    value.is_finite().then_some(value)
}

/// The begin of a text, for a message.
pub(crate) fn short(text: &str) -> String {
    text.chars().take(60).collect()
}
