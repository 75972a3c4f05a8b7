//! The constants of the search stand in one file: in the folders that search there are no others.

use std::path::Path;

use crate::arrows::Finding;

/// Numbers with a point that belong to a formula: ends, halves, doubles and a parabola through rest.
const OF_FORMULAS: [&str; 5] = ["0.0", "0.5", "1.0", "2.0", "4.0"];

/// The code of a source text, without comments and what is compiled for tests only.
fn code(source: &str) -> String {
    let end = source.find("#[cfg(test)]").unwrap_or(source.len());
    let lines = source[..end].lines();
    let code = lines.map(|line| line.split("//").next().unwrap_or_default());
    code.collect::<Vec<_>>().join("\n")
}

/// The numbers in a text, as they are written.
fn numbers(text: &str) -> Vec<String> {
    let characters: Vec<char> = text.chars().collect();
    let at = |k: usize| characters.get(k).copied().unwrap_or(' ');
    let mut found = Vec::new();
    let mut k = 0;
    while k < characters.len() {
        let before = if k == 0 { ' ' } else { at(k - 1) };
        if !at(k).is_ascii_digit() || before.is_alphanumeric() || "_.".contains(before) {
            k += 1;
            continue;
        }
        let begin = k;
        let goes_on = |k: usize| {
            let point = at(k) == '.' && at(k + 1).is_ascii_digit();
            let sign = at(k) == '-' && at(k - 1) == 'e';
            at(k).is_ascii_alphanumeric() || at(k) == '_' || point || sign
        };
        while goes_on(k) {
            k += 1;
        }
        found.push(characters[begin..k].iter().collect());
    }
    found
}

/// The values of the constants of a text: what stands behind their names and types.
fn values(code: &str) -> Vec<&str> {
    let items = code.match_indices("const ");
    let values = items.filter_map(|(at, word)| {
        let (name, rest) = code[at + word.len()..].split_once(": ")?;
        let is_name = |c: char| c.is_ascii_uppercase() || c.is_ascii_digit() || c == '_';
        let (_, value) = rest.split_once(" =")?;
        let end = value.find(";\n").unwrap_or(value.len());
        name.chars().all(is_name).then(|| &value[..end])
    });
    values.collect()
}

/// How many constants a source text defines.
pub(crate) fn count(source: &str) -> usize {
    values(&code(source)).len()
}

/// Constants with numbers of their own, and numbers that should be constants.
pub(crate) fn elsewhere(file: &Path, source: &str) -> Vec<Finding> {
    let code = code(source);
    let constants = values(&code).into_iter();
    let constants = constants.filter(|value| !numbers(value).is_empty());
    let constants = constants.map(|value| format!("a constant, {value}"));
    let fractions = numbers(&code).into_iter();
    let fractions = fractions.filter(|number| number.contains(['.']) || number.contains("e-"));
    let fractions = fractions.filter(|number| {
        let plain = number.trim_end_matches("_f64");
        !OF_FORMULAS.contains(&plain)
    });
    let fractions = fractions.map(|number| format!("a number, {number}"));
    let found = |text| Finding {
        file: file.to_path_buf(),
        text,
    };
    constants.chain(fractions).map(found).collect()
}
