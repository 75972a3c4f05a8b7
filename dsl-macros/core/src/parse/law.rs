//! Impact laws: `impact surface, ...: part, part, ...`, the parts in any order; and dry friction in the same way:
//! `dry friction name: bound f, sliding v`.

use super::cursor::Cursor;
use super::expression::expression;
use super::pieces::{name, said_of};
use crate::ast::{Documentation, Expr, Law, Name, Statement};
use crate::diagnostics::{Checked, Diagnostics, Place, Reported, closest, list};
use crate::words;

/// Under which name the law of a surface is marked as faulty.
pub(crate) fn law_of(surface: &str) -> String {
    format!("impact {surface}")
}

/// Parses what stands behind the word `impact`.
pub(super) fn impact(cursor: &mut Cursor) -> Checked<Statement> {
    if let Some(part) = cursor.ident().map(ToString::to_string)
        && words::LAW_PARTS.contains(&part.as_str())
    {
        cursor.said().poison(&law_of(""));
        let message = format!(
            "the law names its surface in front of a colon; write `impact name: {part} ...` with the name of the surface"
        );
        return Err(cursor.said().syntax(cursor.place(), message));
    }
    let mut surfaces = vec![name(cursor, "the name of a surface")?];
    while cursor.eat_symbol(",") {
        surfaces.push(name(cursor, "the name of a surface")?);
    }
    match law(cursor) {
        Ok(law) => Ok(Statement::Impact {
            surfaces,
            law: Box::new(law),
        }),
        Err(Reported) => {
            for surface in &surfaces {
                cursor.said().poison(&law_of(&surface.text));
            }
            Err(Reported)
        }
    }
}

/// Parts of a law as they are found, each with the place of its word.
#[derive(Default)]
struct Parts {
    inelastic: Option<Place>,
    restitution: Option<(Place, Expr)>,
    friction: Option<(Place, Expr)>,
    at_rest: Option<(Place, Expr)>,
    sliding: Option<(Place, Expr)>,
    along: Option<(Place, Expr)>,
    holding: Option<(Place, Vec<Name>)>,
    sequence: Option<Place>,
}

fn law(cursor: &mut Cursor) -> Checked<Law> {
    if !cursor.eat_symbol(":") {
        return Err(cursor.unexpected("`:` and an impact law"));
    }
    let begin = cursor.place();
    let mut parts = Parts::default();
    each_part(cursor, &words::LAW_PARTS, |cursor| parts.read(cursor))?;
    parts.law(begin, &mut cursor.said())
}

/// Reads parts between commas, which begin with some words.
fn each_part(
    cursor: &mut Cursor,
    words: &[&str],
    mut read: impl FnMut(&mut Cursor) -> Checked<()>,
) -> Checked<()> {
    read(cursor)?;
    while cursor.eat_symbol(",") {
        read(cursor)?;
    }
    match cursor.ident().map(ToString::to_string) {
        Some(word) if words.contains(&word.as_str()) => {
            let message = format!("a comma is missing before {}", cursor.describe());
            Err(cursor.said().syntax(cursor.place(), message))
        }
        _ => Ok(()),
    }
}

impl Parts {
    fn read(&mut self, cursor: &mut Cursor) -> Checked<()> {
        let place = cursor.place();
        let Some(word) = cursor.eat_name() else {
            return Err(cursor.unexpected("a part of an impact law such as `inelastic`"));
        };
        let new = match word.text.as_str() {
            "inelastic" => self.inelastic.replace(place).is_none(),
            "restitution" => value(&mut self.restitution, "restitution", place, cursor)?,
            "friction" => self.friction(place, cursor)?,
            "sliding" => value(&mut self.sliding, "sliding", place, cursor)?,
            "along" => value(&mut self.along, "along", place, cursor)?,
            "holding" => {
                let names = held(cursor)?;
                self.holding.replace((place, names)).is_none()
            }
            "in" => {
                if !cursor.eat_word("sequence") {
                    let wanted =
                        "`sequence` behind `in`, for contacts that are struck one after the other";
                    return Err(cursor.unexpected(wanted));
                }
                self.sequence.replace(place).is_none()
            }
            other => return Err(unknown_part(other, place, &mut cursor.said())),
        };
        if new {
            return Ok(());
        }
        Err(cursor.said().report(
            "E20",
            place,
            format!("`{}` stands twice in one impact law; keep one", word.text),
        ))
    }

    /// Reads `friction mu`, or `friction static mu_s, kinetic mu_k`; whether it is new.
    fn friction(&mut self, place: Place, cursor: &mut Cursor) -> Checked<bool> {
        let mut ahead = cursor.clone();
        let names_two = ahead.eat_word("static") && !ahead.is_empty() && !ahead.at_any_symbol();
        let at_rest = cursor.place();
        if names_two {
            *cursor = ahead;
            value(&mut self.at_rest, "static", at_rest, cursor)?;
            let mut ahead = cursor.clone();
            if !(ahead.eat_symbol(",") && ahead.eat_word("kinetic")) {
                let message = "`friction static mu_s` says what holds at rest only; add the coefficient of sliding, as in \
                               `friction static 0.5, kinetic 0.4`";
                return Err(cursor.said().report("E20", at_rest, message));
            }
            *cursor = ahead;
        } else if cursor.at_word("kinetic") && !names_two {
            let mut ahead = cursor.clone();
            if ahead.eat_word("kinetic") && !ahead.is_empty() && !ahead.at_any_symbol() {
                let message = "`friction kinetic mu_k` says nothing of rest; write `friction static mu_s, kinetic mu_k`, or \
                               `friction mu` where one coefficient holds for both";
                return Err(cursor.said().report("E20", at_rest, message));
            }
        }
        value(&mut self.friction, "friction", place, cursor)
    }

    /// The law, if its parts fit together.
    fn law(self, begin: Place, diagnostics: &mut Diagnostics) -> Checked<Law> {
        let mut exclude = |place: Place, why: &str| Err(diagnostics.report("E20", place, why));
        match (self.inelastic, &self.restitution) {
            (None, None) => exclude(
                begin,
                "the impact law says nothing about the normal velocity; add `inelastic` or \
                 `restitution e`",
            )?,
            (Some(place), Some(_)) => exclude(
                place,
                "`inelastic` and `restitution` exclude each other: `inelastic` is no rebound at all; keep \
                 one",
            )?,
            _ => {}
        }
        if let (Some(_), Some((place, _))) = (&self.along, &self.holding) {
            exclude(
                *place,
                "`along` and `holding` both give the direction of the impulse; keep one",
            )?;
        }
        if let (Some((place, _)), Some(_)) = (&self.along, &self.friction) {
            exclude(
                *place,
                "`along` and `friction` exclude each other: Coulomb's law bounds the tangential part of a \
                 force whose normal part acts along M^-1 grad gap, and `along` puts another direction in \
                 its place; leave one out",
            )?;
        }
        if let (None, Some((place, _))) = (&self.friction, &self.sliding) {
            exclude(
                *place,
                "`sliding` gives the velocity that friction brakes, and there is no `friction`; add \
                 `friction mu` or leave it out",
            )?;
        }
        let expr = |part: Option<(Place, Expr)>| part.map(|(_, expr)| expr);
        Ok(Law {
            restitution: expr(self.restitution),
            friction: expr(self.friction),
            at_rest: expr(self.at_rest),
            sliding: expr(self.sliding),
            along: expr(self.along),
            holding: self.holding.map(|(_, names)| names).unwrap_or_default(),
            sequence: self.sequence.is_some(),
        })
    }
}

/// Says what to write instead of a part that there is not.
fn unknown_part(word: &str, place: Place, diagnostics: &mut Diagnostics) -> Reported {
    let message = match word {
        "sequence" => {
            "contacts are struck one after the other `in sequence`; write both words".to_owned()
        }
        "elastic" => {
            "there is no law `elastic`; a rebound is `restitution 1`, no rebound is `inelastic`"
                .to_owned()
        }
        other => {
            let shown = |part| if part == "in" { "in sequence" } else { part };
            let parts = words::LAW_PARTS.map(shown);
            let help = match closest(other, parts) {
                Some(near) => format!("did you mean `{near}`?"),
                None => format!("the parts are {}", list(parts)),
            };
            format!("unknown part `{other}` of an impact law; {help}")
        }
    };
    diagnostics.syntax(place, message)
}

/// Reads the expression of a part; whether the part is new.
fn value(
    slot: &mut Option<(Place, Expr)>,
    word: &str,
    place: Place,
    cursor: &mut Cursor,
) -> Checked<bool> {
    let ends = match cursor.ident() {
        Some(word) => words::is_keyword(&word.to_string()),
        None => cursor.is_empty() || cursor.at_symbol(",") || cursor.at_symbol(";"),
    };
    if ends {
        let message = format!("`{word}` needs {}", needed(word));
        return Err(cursor.said().syntax(place, message));
    }
    let sign = ["=", ":"].into_iter().find(|sign| cursor.at_symbol(sign));
    let at = cursor.place();
    if let Some(sign) = sign {
        cursor.eat_symbol(sign);
    }
    let expr = expression(cursor)?;
    if let Some(sign) = sign {
        let message = format!("no `{sign}` stands behind `{word}`; write `{word} {expr}`");
        cursor.said().syntax(at, message);
    }
    Ok(slot.replace((place, expr)).is_none())
}

/// What stands behind the word of a part.
fn needed(word: &str) -> &'static str {
    match word {
        "restitution" => "its coefficient, as in `restitution 0.5`",
        "friction" => "its coefficient, as in `friction 0.3`",
        "static" => "the coefficient at rest, as in `friction static 0.5, kinetic 0.4`",
        "sliding" => "the sliding velocity, as in `sliding dot(y)`",
        "bound" => "the largest force, as in `bound 2 [N]`",
        _ => "the direction of the impulse, as in `along (0, 1)`",
    }
}

/// Names of coordinates; a comma may also begin the next part of the law.
fn held(cursor: &mut Cursor) -> Checked<Vec<Name>> {
    let mut names = vec![name(cursor, "a coordinate")?];
    loop {
        let mut ahead = cursor.clone();
        let more = ahead.eat_symbol(",")
            && ahead
                .ident()
                .is_some_and(|ident| !words::is_keyword(&ident.to_string()));
        if !more {
            return Ok(names);
        }
        *cursor = ahead;
        names.push(name(cursor, "a coordinate")?);
    }
}

/// Parses what stands behind the word `dry`.
pub(super) fn dry_friction(
    cursor: &mut Cursor,
    documentation: Documentation,
) -> Checked<Statement> {
    if !cursor.eat_word("friction") {
        let wanted = "`friction` behind `dry`, as in `dry friction hinge: bound f, sliding dot(q)`";
        return Err(cursor.unexpected(wanted));
    }
    let name = name(cursor, "the name of the friction")?;
    let [bound, sliding] = said_of(&name, cursor, |cursor| dry_parts(cursor, &name))?;
    Ok(Statement::Dry {
        documentation,
        name,
        bound,
        sliding,
    })
}

/// Bound and sliding velocity.
fn dry_parts(cursor: &mut Cursor, name: &Name) -> Checked<[Expr; 2]> {
    if !cursor.eat_symbol(":") {
        let wanted = "`:` behind the name, as in `dry friction hinge: bound f, sliding dot(q)`";
        return Err(cursor.unexpected(wanted));
    }
    let (mut bound, mut sliding) = (None, None);
    each_part(cursor, &words::DRY_PARTS, |cursor| {
        let place = cursor.place();
        let Some(word) = cursor.eat_name() else {
            return Err(cursor.unexpected("`bound` or `sliding`"));
        };
        let slot = match word.text.as_str() {
            "bound" => &mut bound,
            "sliding" => &mut sliding,
            other => {
                let message = format!(
                    "unknown part `{other}` of dry friction; write `dry friction {}: bound f, sliding dot(q)`, with the \
                     largest force and the velocity that it brakes",
                    name.text
                );
                return Err(cursor.said().syntax(place, message));
            }
        };
        if !value(slot, &word.text, place, cursor)? {
            let message = format!("`{}` stands twice in one dry friction; keep one", word.text);
            return Err(cursor.said().report("E20", place, message));
        }
        Ok(())
    })?;
    match (bound, sliding) {
        (Some((_, bound)), Some((_, sliding))) => Ok([bound, sliding]),
        (None, _) => {
            let message = format!(
                "dry friction `{}` does not say how large its force may be; add `bound f`",
                name.text
            );
            Err(cursor.said().report("E20", name.place(), message))
        }
        (_, None) => {
            let message = format!(
                "dry friction `{}` does not say which velocity it brakes; add `sliding dot(q)`",
                name.text
            );
            Err(cursor.said().report("E20", name.place(), message))
        }
    }
}
