//! What stands behind `with`.

use crate::method::Method;
use crate::statement::{Expressions, Id};
use crate::words::{behind, parts, quoted, split};

/// One setting of a run.
#[derive(Debug, Clone)]
pub(crate) enum Setting {
    /// A word of [`NUMBERS`] with its number, or one of [`FLAGS`].
    Number(&'static str, f64),
    /// A word of [`VALUES`], the name behind it, and a value in the language.
    Value(&'static str, String, Id),
    Control(Control),
    /// A text of the scene, and what stands in its place.
    Replaced(String, String),
    /// Methods in the place of the usual ones.
    By(Vec<Method>),
    /// A setting of the run whose motion this one starts from, which is as this one otherwise.
    Previous(Box<Setting>),
}

const NUMBERS: &str = "tolerance rest width auxiliary steps stages events intervals starts \
                       elements programs";

const FLAGS: &str = "linear constant freezing aligned long";

/// The last one stands for parameters also where it is left out.
const VALUES: [&str; 3] = ["their start", "start", "set"];

/// The number behind a word, or of a flag that there is one: the last one counts.
pub(crate) fn number(settings: &[Setting], word: &str) -> Option<f64> {
    settings.iter().rev().find_map(|setting| match setting {
        Setting::Number(known, number) if *known == word => Some(*number),
        _ => None,
    })
}

/// The same of what is counted.
pub(crate) fn count(settings: &[Setting], word: &str) -> Option<usize> {
    number(settings, word).map(|number| number as usize)
}

/// A control over time.
#[derive(Debug, Clone)]
pub(crate) struct Control {
    pub(crate) name: String,
    pub(crate) linear: bool,
    /// Times and values; the first time is the start for controls that are constant on intervals.
    pub(crate) nodes: Vec<(Option<Id>, Id)>,
}

/// Reads a line behind `with`: for each item the settings it stands for, one of which a run has.
///
/// # Errors
/// What cannot be read of it.
pub(crate) fn settings(
    line: usize,
    text: &str,
    expressions: &mut Expressions,
) -> Result<Vec<Vec<Setting>>, String> {
    let (text, by) = match behind(text, "by") {
        Some(names) => ("", Some(names)),
        None => match split(text, ", by ") {
            Some((text, names)) => (text, Some(names)),
            None => (text, None),
        },
    };
    let mut add = |text: &str| expressions.add(line, text);
    let items = parts(text, ",").into_iter().filter(|item| !item.is_empty());
    let mut all: Vec<_> = items
        .map(|item| one(item, &mut add))
        .collect::<Result<_, _>>()?;
    if let Some(names) = by {
        let methods: Result<_, _> = parts(names, ",").into_iter().map(Method::read).collect();
        all.push(vec![Setting::By(methods?)]);
    }
    Ok(all)
}

fn one(item: &str, add: &mut dyn FnMut(&str) -> Id) -> Result<Vec<Setting>, String> {
    if let Some(text) = behind(item, "previous") {
        let each = one(text, add)?.into_iter().map(Box::new);
        return Ok(each.map(Setting::Previous).collect());
    }
    if let Some(flag) = FLAGS.split(' ').find(|flag| *flag == item) {
        return Ok(vec![Setting::Number(flag, 1.0)]);
    }
    if let Some(text) = behind(item, "control") {
        return Ok(vec![Setting::Control(control(text, add)?)]);
    }
    let each = |values| parts(values, " or ").into_iter();
    if item.starts_with('"') {
        let (from, others) = quoted(item)?;
        let others = behind(others, "=>").ok_or("`=>` stands behind the text that is replaced")?;
        let each = each(others).map(|other| {
            let to = quoted(other)?.0.to_owned();
            Ok(Setting::Replaced(from.to_owned(), to))
        });
        return each.collect();
    }
    for word in NUMBERS.split(' ') {
        if let Some(values) = behind(item, word) {
            let numbers = each(values).map(|text| {
                let number = text.parse().map_err(|_| format!("`{text}` is no number"));
                number.map(|number| Setting::Number(word, number))
            });
            return numbers.collect();
        }
    }
    let (word, name, values) = match behind(item, "horizon") {
        Some(values) => ("horizon", "", values),
        None => {
            let mut words = VALUES.into_iter().map(|word| (word, behind(item, word)));
            let known = words.find_map(|(word, text)| Some((word, text?)));
            let (word, text) = known.unwrap_or(("set", item));
            let form = || format!("`{item}` is no setting");
            let (name, values) = split(text, "=").ok_or_else(form)?;
            (word, name, values)
        }
    };
    let values = each(values).map(|value| Setting::Value(word, name.to_owned(), add(value)));
    Ok(values.collect())
}

/// `u = 0 [N] until 1 [s] then 30 [N]`, or `u = 0 [N] at 0 [s] to 4 [N] at 2 [s]`.
fn control(text: &str, add: &mut dyn FnMut(&str) -> Id) -> Result<Control, String> {
    let (name, values) = split(text, "=").ok_or("a control is `NAME = VALUE`")?;
    let linear = split(values, " at ").is_some();
    let mut nodes = Vec::new();
    let mut begin = None;
    for node in parts(values, if linear { " to " } else { " then " }) {
        if linear {
            let (value, time) = split(node, " at ").ok_or("a node is `VALUE at TIME`")?;
            nodes.push((Some(add(time)), add(value)));
        } else {
            let (value, end) = split(node, " until ").map_or((node, None), |(v, e)| (v, Some(e)));
            nodes.push((begin, add(value)));
            begin = end.map(&mut *add);
        }
    }
    Ok(Control {
        name: name.to_owned(),
        linear,
        nodes,
    })
}
