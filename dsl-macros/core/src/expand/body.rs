//! Bodies: `body crate: mass m, inertia j, at (x, z), angle phi, tip = (l, 0)` becomes its energies and its points, and `gravity` the
//! potential energy of all of them. A body is the place where it is, and its name stands in front of what it has, `crate.tip`.

use super::clause::{Clause, clauses, head, shown, sorted};
use super::names::{ident, indices, member};
use super::part::Placed;
use super::space;
use super::tokens::{
    around, components, ended, group_in, grouped, inside, items, keyword, number, punct,
    undocumented, word,
};
use super::written::{Body, Written};
use crate::diagnostics::{Checked, Place};
use crate::words;
use proc_macro2::{Delimiter, Ident, Span, TokenTree};
use quote::quote_spanned;
use std::collections::HashSet;
use std::rc::Rc;

/// `gravity (0, -g)`.
pub(super) fn gravity(written: &mut Written<'_>, statement: &[TokenTree]) -> Checked<()> {
    let statement = undocumented(statement);
    let place = Place::at(statement[0].span());
    let value = ended(&statement[1..]);
    if written.gravity.is_some() {
        let message = "`gravity` is declared twice; it is that of all bodies";
        return Err(written.diagnostics.report("E19", place, message));
    }
    if !written.scope.prefix.is_empty() {
        let message = "`gravity` is that of all bodies; declare it in the scene, outside of parts";
        return Err(written.told(place, message));
    }
    if matches!(value, [TokenTree::Literal(_), ..]) {
        let message = "`gravity` is a vector, as in `gravity (0, -g)`";
        return Err(written.diagnostics.syntax(place, message));
    }
    fits(written, value, place, "gravity")?;
    let value = (value.to_vec(), Rc::clone(&written.scope));
    written.gravity = Some((statement[0].span(), value));
    Ok(())
}

/// `body name: mass m, ..`.
pub(super) fn body(written: &mut Written<'_>, statement: &[TokenTree]) -> Checked<()> {
    let (name, indices, rest) = head(statement, written.diagnostics)?;
    let (span, text) = (name.span(), format!("{}{name}", written.scope.prefix));
    let Some(whole) = written.names.declare_body(&text, &indices) else {
        let message = format!("`{name}` is declared twice; rename this body");
        return Err(written.diagnostics.report("E19", Place::at(span), message));
    };
    let clauses = clauses(rest, &words::BODY);
    let [mass, inertia, centre, at, angle, turn, fixed] = of_body(written, name, &clauses)?;
    if let Some(at) = at {
        fits(written, at.tokens(), at.place(), &format!("body `{name}`"))?;
    }
    let given = |clause: Option<Clause<'_>>| clause.map(|clause| clause.value());
    let is_fixed = fixed.is_some();
    let [shape, many] = match written.in_space {
        true => ["(x, y, z)", "three"],
        false => ["(x, z)", "two"],
    };
    let place = match (given(at), is_fixed) {
        (Some(at), _) => at,
        (None, true) => written.axis(usize::MAX, span),
        (None, false) => {
            let message = format!(
                "body `{name}` is nowhere; say where, as in `at {shape}` with {many} coordinates"
            );
            return Err(written.told(Place::at(span), message));
        }
    };
    let is_plane = angle.is_some() || two(&place);
    let own = ident(&whole, span);
    written.write(quote_spanned!(span=> let #own: m = #place));
    let turns = match written.in_space {
        true => turned(written, (&whole, span), (turn, is_fixed)),
        false => {
            let turn = given(angle).or_else(|| is_fixed.then(|| number(0, span)));
            turn.map(|turn| {
                let value = quote_spanned!(span=> : rad = #turn);
                written.define((&whole, "angle", span), value);
            })
        }
    };
    written.order.push(whole.clone());
    let body = Body {
        turns: turns.is_some(),
        is_fixed,
        is_still: is_fixed && written.are_still([at, angle.or(turn)]),
        span,
        is_plane,
        points: Vec::new(),
        scope: Rc::clone(&written.scope),
    };
    written.known.insert(whole.clone(), body);
    let middle = match centre {
        None => quote_spanned!(span=> #own),
        Some(centre) => written.offset(&whole, centre.place(), &centre.value())?,
    };
    let middle = quote_spanned!(span=> = #middle);
    let centre = written.define((&whole, "centre", span), middle);
    if let Some(mass) = given(mass) {
        let m = written.define((&whole, "mass", span), quote_spanned!(span=> : kg = #mass));
        written.write(quote_spanned!(span=> lagrangian += #m/2*|dot(#centre)|^2));
    }
    if let Some(inertia) = inertia {
        turning(written, (&whole, span), (inertia, turn));
    }
    for clause in clauses.iter().filter(|clause| clause.is_named()) {
        point(written, &whole, clause)?;
    }
    Ok(())
}

/// Declares the matrix that turns a body in space, and its angular velocity along its own axes; none of a body that does not turn.
/// A quaternion gets the joint that keeps its length.
fn turned(
    written: &mut Written<'_>,
    (whole, span): (&str, Span),
    (turn, is_fixed): (Option<Clause<'_>>, bool),
) -> Option<()> {
    if let Some(parts) = space::quaternion(turn, span) {
        let unit = written.own(whole, "unit", span);
        let joint = quote_spanned!(span=> joint #unit: #(#parts^2)+* == 1);
        written.write(joint);
        let [matrix, spin] = space::of_quaternion(&parts, span);
        written.define((whole, "turn", span), matrix);
        written.define((whole, "spin", span), spin);
        return Some(());
    }
    let value = match turn {
        Some(turn) => turn.value().into(),
        None if is_fixed => quote_spanned!(span=> diagonal(1, 1, 1)),
        None => return None,
    };
    let matrix = written.define((whole, "turn", span), quote_spanned!(span=> = #value));
    if turn.is_some() {
        let rates = quote_spanned!(span=> = transpose(#matrix)*dot(#matrix));
        let rates = written.define((whole, "rates", span), rates);
        let spin = quote_spanned!(span=> = (#rates[2][1], #rates[0][2], #rates[1][0]));
        written.define((whole, "spin", span), spin);
    }
    Some(())
}

/// The kinetic energy of a body that turns.
fn turning(
    written: &mut Written<'_>,
    (whole, span): (&str, Span),
    (inertia, turn): (Clause<'_>, Option<Clause<'_>>),
) {
    let (j, value) = (written.named(whole, "inertia"), inertia.value());
    let [moments, energy] = match written.in_space {
        true => space::energy(inertia, turn, [&j, &written.named(whole, "spin")]),
        false => {
            let angle = written.named(whole, "angle");
            let energy = quote_spanned!(span=> #j/2*dot(#angle)^2);
            [quote_spanned!(span=> : kg*m^2 = #value), energy]
        }
    };
    written.define((whole, "inertia", span), moments);
    written.write(quote_spanned!(span=> lagrangian += #energy));
}

/// What is said of a body, fitting together.
fn of_body<'t>(
    written: &mut Written<'_>,
    name: &Ident,
    clauses: &[Clause<'t>],
) -> Checked<[Option<Clause<'t>>; 7]> {
    let what = format!("body `{name}`");
    let own = clauses.iter().filter(|clause| !clause.is_named()).copied();
    let found = sorted(own, &words::BODY, &what, written.diagnostics)?;
    let [mass, inertia, centre, _, angle, turn, fixed] = found.map(|clause| clause.is_some());
    let message = match fixed {
        _ if angle && written.in_space => {
            "is in space, where an angle does not say how it is turned; write `turn (q0, q1, q2, q3)`, or `turn rotation_z(phi)`"
        }
        _ if turn && !written.in_space => {
            "is in the plane, where it turns by an angle; write `angle phi`, or a `gravity` with three components"
        }
        true if mass || inertia => {
            "is fixed, so that its mass does nothing; leave `fixed` out, or the mass"
        }
        true if centre => {
            "is fixed and has no mass, so that it has no centre of mass; leave `centre` out"
        }
        false if !mass => "has no mass; write `mass m`, or `fixed` if it has no motion of its own",
        false if inertia && !turn && written.in_space => {
            "has an inertia, and nothing by which it turns; add `turn (q0, q1, q2, q3)`, or `turn rotation_z(phi)`"
        }
        false if inertia && !(angle || turn) => {
            "has an inertia, and no angle by which it turns; add `angle phi`"
        }
        _ => {
            let [_, inertia, _, _, _, turn, _] = found;
            let Some((clause, has)) = space::wrong([inertia, turn], written.in_space) else {
                return Ok(found);
            };
            return Err(written.told(clause.place(), format!("{what} has {has}")));
        }
    };
    Err(written.told(Place::at(name.span()), format!("{what} {message}")))
}

/// A point of a body, `tip = (l, 0)`.
fn point(written: &mut Written<'_>, whole: &str, clause: &Clause<'_>) -> Checked<()> {
    let text = clause.word();
    let (place, name) = (Place::at(clause.first().span()), format!("{whole}.{text}"));
    if written.names.has(&name) || words::BODY.contains(&text.as_str()) {
        let message = format!(
            "`{}` is something else of this body; choose another name for the point",
            shown(&name)
        );
        return Err(written.diagnostics.report("E19", place, message));
    }
    let offset = written.offset(whole, place, &clause.value())?;
    let span = clause.first().span();
    let own = written.define((whole, &text, span), quote_spanned!(span=> : m = #offset));
    if let Some(body) = written.known.get_mut(whole) {
        body.points.push(own);
    }
    Ok(())
}

/// E27: a vector that is written out has a component for each direction.
fn fits(written: &mut Written<'_>, value: &[TokenTree], place: Place, what: &str) -> Checked<()> {
    let [dimensions, many, example] = match written.in_space {
        true => ["in space", "three", "(0, 0, -g)"],
        false => ["in the plane", "two", "(0, -g)"],
    };
    match components(value).len() {
        0 | 1 => Ok(()),
        own if own == 2 + usize::from(written.in_space) => Ok(()),
        own => {
            let message = format!(
                "{what} has {own} components, and the bodies of this scene are {dimensions}; write {many}, as in `{example}`"
            );
            Err(written.told(place, message))
        }
    }
}

/// All statements, with weights and what is drawn.
pub(super) fn finished(mut written: Written<'_>) -> Vec<Placed> {
    let in_plane = written
        .gravity
        .as_ref()
        .is_some_and(|(_, (value, _))| value.len() == 1 && two(&value[0]));
    unused(&mut written);
    for whole in std::mem::take(&mut written.order) {
        weight(&mut written, &whole);
        let shape = format!("{whole}.");
        let is_own = |(name, _): &(String, Placed)| *name == whole || name.starts_with(&shape);
        if !written.drawn.iter().any(is_own) {
            draw_body(&mut written, &whole, in_plane);
        }
    }
    picture(&mut written);
    written.statements
}

/// E16: shapes that nothing can touch, and gravity that acts on nothing.
fn unused(written: &mut Written<'_>) {
    if written.diagnostics.mistakes() > 0 {
        return;
    }
    for shape in written.shapes.iter().filter(|shape| !shape.is_touched) {
        let message = format!(
            "shape `{0}` takes part in no contact and is only drawn; write one, as in `contact {0}, ground: inelastic`, or leave it out",
            shown(&shape.name)
        );
        written.diagnostics.warn("E16", shape.place, message);
    }
    let has_mass = written.order.iter().any(|body| !written.is_fixed(body));
    if let Some((span, _)) = written.gravity.as_ref().filter(|_| !has_mass) {
        let message = "`gravity` acts on bodies, and none has a mass here; write the weight into `lagrangian`, or declare `body name: mass m, ..`";
        written.diagnostics.warn("E16", Place::at(*span), message);
    }
}

fn weight(written: &mut Written<'_>, whole: &str) {
    let has_mass = !written.is_fixed(whole);
    let Some((span, (value, scope))) = written.gravity.clone().filter(|_| has_mass) else {
        return;
    };
    let value = grouped(Delimiter::None, value, span);
    let (m, centre) = ["mass", "centre"]
        .map(|name| written.named(whole, name))
        .into();
    written.scope = scope;
    let name = (whole, words::WEIGHT, span);
    let weight = written.define(name, quote_spanned!(span=> = #m*(#value . (#centre))));
    written.write(quote_spanned!(span=> lagrangian += #weight));
}

/// A body without a shape: its centre and lines to its points.
fn draw_body(written: &mut Written<'_>, whole: &str, in_plane: bool) {
    let Some(body) = written.known.get(whole) else {
        return;
    };
    let is_drawn = (body.is_plane || in_plane) && !written.in_space;
    if body.is_fixed && body.points.is_empty() || !is_drawn {
        return;
    }
    let (own, centre) = (written.body_place(whole), written.named(whole, "centre"));
    let links = body.points.iter();
    let links = links.map(|point| quote_spanned!(body.span=> link #centre to #point));
    let point = quote_spanned!(body.span=> point #own at #centre);
    let entries: Vec<_> = [point].into_iter().chain(links).collect();
    written.scope = Rc::clone(&body.scope);
    for entry in entries {
        written.draw(whole, entry);
    }
}

/// What is drawn of bodies, in front of what the scene draws itself; that goes before by name.
fn picture(written: &mut Written<'_>) {
    let is_picture = |(statement, _): &Placed| keyword(statement) == "picture";
    let own = written.statements.iter().rposition(is_picture);
    let (mut entries, mut taken) = (Vec::new(), HashSet::new());
    if let Some(own) = own {
        let (statement, scope) = &written.statements[own];
        let inner = undocumented(statement).get(1);
        let inner = group_in(inner, Delimiter::Brace).map_or_else(Vec::new, inside);
        for entry in items(&inner).map(undocumented) {
            if let [_, TokenTree::Ident(name), rest @ ..] = entry {
                let indices = rest.first().and_then(indices);
                let name = format!("{}{}", scope.prefix, super::decoded(name.to_string()));
                taken.insert(member(&name, &indices.unwrap_or_default()));
            }
        }
    }
    let mut drawn = std::mem::take(&mut written.drawn);
    drawn.retain(|(name, _)| !taken.contains(name));
    let Some((_, (first, _))) = drawn.first() else {
        return;
    };
    let span = first.first().map_or_else(Span::call_site, TokenTree::span);
    for (_, (entry, scope)) in drawn {
        let entry = written
            .names
            .resolved_in((&entry, true), &scope, written.diagnostics);
        entries.extend(entry);
        entries.push(punct(',', span));
    }
    match own {
        Some(own) => {
            for token in &mut written.statements[own].0 {
                if let Some(block) = group_in(Some(token), Delimiter::Brace) {
                    let inner = entries.drain(..).chain(inside(block)).collect();
                    *token = around(block, inner);
                }
            }
        }
        None => {
            let block = grouped(Delimiter::Brace, entries, span);
            let statement = vec![word("picture", span), block];
            written.statements.push((statement, Rc::default()));
        }
    }
}

/// Whether a vector of two components is written there.
fn two(value: &TokenTree) -> bool {
    components(std::slice::from_ref(value)).len() == 2
}
