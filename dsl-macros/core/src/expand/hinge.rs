//! Joints between bodies: `hinge elbow: upper.tip == lower.base`, and `weld`, `slider` and `rolling`, become `joint`s, and what moves in
//! them gets a name, `elbow.angle` and `rail.way`.

use super::clause::{Clause, clauses, head, shown, sorted};
use super::contact::gaps;
use super::names::ident;
use super::shape::shapes_of;
use super::tokens::{grouped, keyword, number, opened, parted, place_of};
use super::written::Written;
use crate::diagnostics::{Checked, Place};
use crate::words;
use proc_macro2::{Delimiter, Ident, Span, TokenStream, TokenTree};
use quote::quote_spanned;

/// What a joint is made of.
struct Between<'t> {
    whole: String,
    name: &'t Ident,
    span: Span,
    /// The two that are joined.
    sides: [TokenTree; 2],
    /// Their bodies; none of a place that belongs to none.
    bodies: [Option<String>; 2],
    /// What else is said, in the order of [`words::JOINT`].
    clauses: [Option<Clause<'t>>; 5],
}

impl<'t> Between<'t> {
    fn clause(&self, word: &str) -> Option<Clause<'t>> {
        let place = words::JOINT.iter().position(|known| *known == word)?;
        self.clauses[place]
    }
}

/// A joint by its word: `hinge` is a point on a point, about which both turn; so is `ball` in space; `weld` keeps their angle as well, as
/// does `slider` with a point on a line.
pub(super) fn joint(written: &mut Written<'_>, statement: &[TokenTree]) -> Checked<()> {
    let word = keyword(statement);
    let (sign, known): (&[&str], &[&str]) = match word.as_str() {
        "hinge" => (&["=", "="], &["motor", "stop", "restitution"]),
        "weld" => (&["=", "="], &["angle"]),
        "ball" => (&["=", "="], &[]),
        "slider" => (&["on"], &words::JOINT),
        _ => (&["on"], &[]),
    };
    let between = between(written, statement, (&word, sign))?;
    let mut said = between.clauses.iter().flatten();
    if let Some(clause) = said.find(|clause| !known.contains(&clause.word().as_str())) {
        let (word, name) = (clause.word(), between.name);
        let message = format!("`{word}` says nothing of joint `{name}`; leave it out");
        return Err(written.told(clause.place(), message));
    }
    match word.as_str() {
        "slider" => return slider(written, &between),
        "rolling" => return rolling(written, &between),
        _ => {}
    }
    let (span, [a, b]) = (between.span, &between.sides);
    hold(written, &between, quote_spanned!(span=> #a == #b));
    match word.as_str() {
        "hinge" => hinge(written, &between),
        "weld" => locked(written, &between),
        _ => Ok(()),
    }
}

fn hold(written: &mut Written<'_>, between: &Between<'_>, equation: TokenStream) {
    let joint = ident(&between.whole, between.span);
    written.write(quote_spanned!(between.span=> joint #joint: #equation));
}

fn hinge(written: &mut Written<'_>, between: &Between<'_>) -> Checked<()> {
    if let Some(turn) = between_angles(written, between) {
        let turn = quote_spanned!(between.span=> : rad = #turn);
        let angle = written.define((&between.whole, "angle", between.span), turn);
        return driven(written, between, &angle);
    }
    match words::JOINT.iter().find_map(|word| between.clause(word)) {
        None => Ok(()),
        Some(clause) => both_turn(
            written,
            between,
            clause.place(),
            &format!("`{}`", clause.word()),
        ),
    }
}

/// What moves a joint and what it strikes: a force on the quantity that moves in it, and a surface for each end of its range.
fn driven(written: &mut Written<'_>, between: &Between<'_>, moves: &Ident) -> Checked<()> {
    let (span, whole) = (between.span, &between.whole);
    if let Some(motor) = between.clause("motor") {
        let value = motor.value();
        written.write(quote_spanned!(span=> forces { #moves: #value }));
    }
    let (Some(stop), restitution) = (between.clause("stop"), between.clause("restitution")) else {
        return match between.clause("restitution") {
            None => Ok(()),
            Some(clause) => {
                let message = format!(
                    "joint `{0}` strikes nothing; add `stop -1..=1`, or leave `restitution` out",
                    between.name
                );
                Err(written.told(clause.place(), message))
            }
        };
    };
    let range = stop.tokens();
    let Some([low, high]) = parted(range, &[".", ".", "="]) else {
        let message = "`stop` has both ends of a range, as in `stop -1..=1`";
        return Err(written.diagnostics.syntax(stop.place(), message));
    };
    let message = "the range of a stop begins below where it ends, as in `stop -1..=1`";
    let room = quote_spanned!(range[0].span()=> -(#(#low)*) + #(#high)*);
    let of = format!("the range of the stop of joint `{}`", between.name);
    written.positive(("E10", message), (&of, ""), (span, &room));
    let names = ["low", "high"].map(|name| written.own(whole, name, span));
    let law = match restitution {
        None => quote_spanned!(span=> inelastic),
        Some(clause) => TokenStream::from_iter(clause.whole().iter().cloned()),
    };
    let ends = [
        quote_spanned!(span=> >= #(#low)*),
        quote_spanned!(span=> <= #(#high)*),
    ];
    for (name, end) in names.iter().zip(ends) {
        written.write(quote_spanned!(span=> surface #name: #moves #end));
    }
    for name in &names {
        written.write(quote_spanned!(span=> impact #name: #law));
    }
    Ok(())
}

/// E27: what hangs on how both bodies are turned.
fn both_turn(
    written: &mut Written<'_>,
    between: &Between<'_>,
    place: Place,
    what: &str,
) -> Checked<()> {
    let mut bodies = between.bodies.iter().flatten();
    bodies.try_for_each(|body| written.needs_angle(body, place, what))
}

/// `slider rail: block on frame along (1, 0)`: a point on a line of the other body, and an angle that stays.
fn slider(written: &mut Written<'_>, between: &Between<'_>) -> Checked<()> {
    let Some(direction) = between.clause("along") else {
        let message = format!(
            "slider `{0}` has no direction; add it as its second body has it, as in `slider {0}: block on frame along (1, 0)`",
            between.name
        );
        return Err(written.told(Place::at(between.span), message));
    };
    let (span, value) = (between.span, direction.value());
    let direction = match &between.bodies[1] {
        Some(body) if written.turns(body) => {
            let angle = written.named(body, "angle");
            quote_spanned!(span=> rotation(#angle)*#value)
        }
        _ => quote_spanned!(span=> #value),
    };
    let [a, b] = &between.sides;
    let direction = quote_spanned!(span=> = (#direction)/|#value|);
    let along = written.define((&between.whole, "along", span), direction);
    let way = quote_spanned!(span=> : m = #along . (#a - #b));
    let way = written.define((&between.whole, "way", span), way);
    let off = quote_spanned!(span=> #along[0]*(#a - #b)[1] - #along[1]*(#a - #b)[0]);
    hold(written, between, quote_spanned!(span=> #off == 0));
    driven(written, between, &way)?;
    let [first, _] = &between.bodies;
    match first.as_ref().is_some_and(|body| written.turns(body)) {
        true => locked(written, between),
        false => Ok(()),
    }
}

/// `rolling grip: wheel on ground`: two shapes that touch in one point, and do not slide there.
fn rolling(written: &mut Written<'_>, between: &Between<'_>) -> Checked<()> {
    let place = Place::at(between.span);
    let mut shapes = Vec::new();
    for side in &between.sides {
        shapes.push(shapes_of(written, &opened(side))?);
    }
    let (&[a], &[b]) = (&shapes[0][..], &shapes[1][..]) else {
        let message = format!(
            "`{}` rolls with more than one shape of a body; name one of them, as in `block.lid`",
            between.name
        );
        return Err(written.told(place, message));
    };
    let bodies = [a, b].map(|shape| written.shapes[shape].body.clone());
    for body in &bodies {
        written.needs_angle(body, place, "rolling")?;
    }
    let groups = gaps(written, a, b, place.start);
    let (1, Some([piece])) = (groups.len(), groups.first().map(Vec::as_slice)) else {
        let kinds = [a, b].map(|shape| &written.shapes[shape].kind);
        let message = format!(
            "a {} does not roll on a {} in one point; a circle rolls on a half plane or on a circle",
            kinds[0], kinds[1]
        );
        return Err(written.told(place, message));
    };
    let (span, distance, sliding) = (place.start, &piece.distance, &piece.sliding);
    let grip = written.own(&between.whole, "grip", span);
    hold(written, between, quote_spanned!(span=> #distance == 0));
    written.write(quote_spanned!(span=> joint #grip: #sliding == 0));
    Ok(())
}

/// Name, sides and clauses of a joint; its name is taken.
fn between<'t>(
    written: &mut Written<'_>,
    statement: &'t [TokenTree],
    (keyword, sign): (&str, &[&str]),
) -> Checked<Between<'t>> {
    let (name, indices, rest) = head(statement, written.diagnostics)?;
    let place = Place::at(name.span());
    let message = match (keyword == "ball", written.in_space) {
        (true, false) => Some("in the plane a point is held on a point by `hinge`"),
        (false, true) => Some(
            "this is a joint of the plane; in space `ball` holds a point on a point, and a `joint` what else is equal",
        ),
        _ => None,
    };
    if let Some(message) = message {
        return Err(written.told(Place::at(statement[0].span()), message));
    }
    let said = clauses(rest, &words::JOINT);
    let relation = said[0].whole();
    let Some(sides) = parted(relation, sign) else {
        let (sign, example) = (sign.concat(), words::example(keyword).unwrap_or_default());
        let message = format!("`{keyword}` joins two sides by `{sign}`, as in `{example}`");
        return Err(written
            .diagnostics
            .syntax(place_of(relation, place), message));
    };
    let what = format!("joint `{name}`");
    let clauses = sorted(
        said[1..].iter().copied(),
        &words::JOINT,
        &what,
        written.diagnostics,
    )?;
    let text = format!("{}{name}", written.scope.prefix);
    let Some(whole) = written.names.declare_part(&text, &indices) else {
        let message = format!("`{name}` is declared twice; rename this joint");
        return Err(written.diagnostics.report("E19", place, message));
    };
    let bodies = sides.map(|side| body_of(written, side));
    if bodies.iter().all(Option::is_none) {
        let message = format!(
            "neither side of `{name}` is a body or a point of one; what holds between other places is a `joint {name}: left == right`"
        );
        return Err(written.told(place_of(relation, place), message));
    }
    let sides = sides.map(|side| grouped(Delimiter::None, side.to_vec(), side[0].span()));
    Ok(Between {
        whole,
        name,
        span: name.span(),
        sides,
        bodies,
        clauses,
    })
}

/// The body to which a place belongs by its name.
fn body_of(written: &mut Written<'_>, tokens: &[TokenTree]) -> Option<String> {
    let [TokenTree::Ident(_), ..] = tokens else {
        return None;
    };
    let found = written
        .names
        .resolved(tokens, &written.scope, written.diagnostics);
    let [TokenTree::Ident(name)] = &found[..] else {
        return None;
    };
    let whole = super::decoded(name.to_string());
    let is_its = |body: &&String| {
        let rest = whole.strip_prefix(body.as_str());
        rest.is_some_and(|rest| rest.is_empty() || rest.starts_with('.'))
    };
    let found = written.known.keys().filter(is_its);
    found.max_by_key(|body| body.len()).cloned()
}

/// How far the second body is turned against the first one; none if one of them cannot turn.
fn between_angles(written: &Written<'_>, between: &Between<'_>) -> Option<TokenStream> {
    let span = between.span;
    let known = between.bodies.iter().flatten();
    if !known.clone().all(|body| written.turns(body)) {
        return None;
    }
    let angle = |body: &Option<String>| body.as_ref().map(|body| written.named(body, "angle"));
    match [&between.bodies[0], &between.bodies[1]].map(angle) {
        [Some(a), Some(b)] => Some(quote_spanned!(span=> #b - #a)),
        [Some(a), None] => Some(quote_spanned!(span=> -#a)),
        [None, Some(b)] => Some(quote_spanned!(span=> #b)),
        [None, None] => None,
    }
}

/// An angle between both bodies that stays, 0 where none is said.
fn locked(written: &mut Written<'_>, between: &Between<'_>) -> Checked<()> {
    let (what, span) = (format!("joint `{}`", shown(&between.whole)), between.span);
    both_turn(written, between, Place::at(span), &what)?;
    if let Some(turn) = between_angles(written, between) {
        let angle = between.clause("angle");
        let angle = angle.map_or_else(|| number(0, span), |clause| clause.value());
        let joint = written.own(&between.whole, "turn", span);
        written.write(quote_spanned!(span=> joint #joint: #turn == #angle));
    }
    Ok(())
}
