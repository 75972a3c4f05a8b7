//! Contacts between shapes: `contact crate, ground: inelastic, friction mu` becomes surfaces, one for each corner that can touch,
//! and their laws with the sliding velocities.

use super::clause::shown;
use super::names::{ident, member};
use super::shape::shapes_of;
use super::tokens::{ended, halves, items, place_of, undocumented};
use super::written::{Shape, Side, Written};
use crate::diagnostics::{Checked, Place};
use proc_macro2::{Ident, Span, TokenStream, TokenTree};
use quote::quote_spanned;

/// A smooth piece of a gap, `distance >= 0`, of a corner of one body on another one.
pub(super) struct Piece {
    pub(super) distance: TokenStream,
    /// The velocity at which they slide on each other.
    pub(super) sliding: TokenStream,
}

/// The corner of one body, with the radius around it, on another body with its own radius.
struct Touch<'b> {
    span: Span,
    corner: Ident,
    body: &'b str,
    on: &'b str,
    radius: Option<Ident>,
    others: Option<Ident>,
}

/// `contact a, b: law`, also of more than two, each with each.
pub(super) fn contact(written: &mut Written<'_>, statement: &[TokenTree]) -> Checked<()> {
    let statement = ended(undocumented(statement));
    let begin = Place::at(statement[0].span());
    let [head, law] = halves(statement, ':');
    let operands: Vec<&[TokenTree]> = items(&head[1..]).collect();
    if operands.len() < 2 || law.is_empty() {
        let message = "a contact is that of two shapes with a law, as in `contact block, ground: inelastic, friction mu`";
        return Err(written.diagnostics.syntax(begin, message));
    }
    let is_word = |word: &'static str| move |token: &&TokenTree| matches!(token, TokenTree::Ident(own) if own == word);
    let rubs = law.iter().any(|token| is_word("friction")(&token));
    if let Some(wrong) = law.iter().find(is_word("sliding")) {
        let message =
            "the sliding velocity of a contact is derived from its bodies; leave `sliding` out";
        return Err(written.told(Place::at(wrong.span()), message));
    }
    let before = written.diagnostics.mistakes();
    let found: Vec<_> = operands
        .iter()
        .map(|operand| shapes_of(written, operand))
        .collect();
    written.diagnostics.none_since(before)?;
    let found: Vec<Vec<usize>> = found.into_iter().flatten().collect();
    let is_list = found.len() > 2;
    for (k, first) in found.iter().enumerate() {
        for second in &found[k + 1..] {
            for (&a, &b) in first
                .iter()
                .flat_map(|a| second.iter().map(move |b| (a, b)))
            {
                if is_list && stand_still(written, a, b) {
                    continue;
                }
                let place = place_of(&head[1..], begin);
                pair(written, (a, b), place, (law, rubs))?;
            }
        }
    }
    Ok(())
}

/// Whether two shapes are on one body, or on bodies that are both fixed.
fn stand_still(written: &Written<'_>, a: usize, b: usize) -> bool {
    let [one, other] = [a, b].map(|shape| &written.shapes[shape].body);
    one == other || written.is_fixed(one) && written.is_fixed(other)
}

/// The surfaces and laws between two shapes.
fn pair(
    written: &mut Written<'_>,
    (a, b): (usize, usize),
    place: Place,
    (law, rubs): (&[TokenTree], bool),
) -> Checked<()> {
    let [one, other] = [a, b].map(|shape| written.shapes[shape].body.clone());
    if stand_still(written, a, b) {
        let names = [a, b].map(|shape| shown(&written.shapes[shape].name));
        let message = format!(
            "`{}` and `{}` never move against each other, on one body or on fixed ones; leave the contact out",
            names[0], names[1]
        );
        return Err(written.told(place, message));
    }
    if rubs {
        for body in [&one, &other] {
            written.needs_angle(body, place, "friction, which turns it,")?;
        }
    }
    let groups = gaps(written, a, b, place.start);
    is_contact(written, (a, b), &groups, (place, rubs))?;
    let (first, second) = (&written.shapes[a].name, &written.shapes[b].name);
    let own = second.strip_prefix(&written.scope.prefix).unwrap_or(second);
    let whole = format!("{first}.{own}");
    let many = groups.len() > 1;
    if !written.names.declare_path(&whole) {
        let message = format!(
            "`{}` is declared twice; keep one contact between two shapes",
            shown(&whole)
        );
        return Err(written.diagnostics.report("E19", place, message));
    }
    for (k, pieces) in (1..).zip(groups) {
        let index = if many { &[k][..] } else { &[] };
        written.names.declare(&whole, index);
        surface(
            written,
            &ident(&member(&whole, index), place.start),
            pieces,
            (law, rubs),
        );
    }
    Ok(())
}

/// E27: shapes that do not touch in points, and friction on the edges of what is in space.
fn is_contact(
    written: &mut Written<'_>,
    (a, b): (usize, usize),
    groups: &[Vec<Piece>],
    (place, rubs): (Place, bool),
) -> Checked<()> {
    let [one, other] = [a, b].map(|shape| &written.shapes[shape]);
    let in_space = written.in_space;
    let edges = rubs && in_space && groups.iter().any(|group| group.len() > 1);
    let of_curve = one.curve.is_some() || other.curve.is_some();
    let why = match groups.is_empty() {
        false if !edges => return Ok(()),
        false => {
            "with friction in space; leave `friction` out, or let a half space or a sphere touch"
        }
        true if of_curve => {
            "in points that a formula tells; what has corners alone touches a curve, as a polygon and a `point` do"
        }
        true if in_space => {
            "in space; a half space touches all shapes, a sphere and a point all but a point"
        }
        true => "; give one of them a radius, as a circle or a capsule has",
    };
    let blank = if why.starts_with(';') { "" } else { " " };
    let message = format!(
        "there is no contact between a {} and a {}{blank}{why}",
        one.kind, other.kind
    );
    Err(written.told(place, message))
}

/// One surface of a contact, with its law.
fn surface(
    written: &mut Written<'_>,
    name: &Ident,
    pieces: Vec<Piece>,
    (law, rubs): (&[TokenTree], bool),
) {
    let span = name.span();
    let (gaps, slides): (Vec<TokenStream>, Vec<TokenStream>) = pieces
        .into_iter()
        .map(|piece| (piece.distance, piece.sliding))
        .unzip();
    let surface = match &gaps[..] {
        [gap] => quote_spanned!(span=> surface #name: #gap >= 0),
        gaps => quote_spanned!(span=> surface #name: max(#(#gaps),*) >= 0),
    };
    written.write(surface);
    let law = law.iter();
    let law = quote_spanned!(span=> impact #name: #(#law)*);
    written.write(match rubs {
        false => law,
        true => quote_spanned!(span=> #law, sliding (#(#slides),*)),
    });
}

/// All gaps that have to be kept between two shapes, each the largest of its pieces.
pub(super) fn gaps(written: &Written<'_>, a: usize, b: usize, span: Span) -> Vec<Vec<Piece>> {
    let (a, b) = (&written.shapes[a], &written.shapes[b]);
    let is_round = a.radius.is_some() || b.radius.is_some();
    let halves = a.corners.is_empty() || b.corners.is_empty();
    let mut groups = Vec::new();
    // A sharp corner that meets a segment has no side on which it is; in space edges meet edges.
    let is_small = |shape: &Shape| shape.corners.len() == 1;
    let are_sharp = !written.in_space && a.is_solid && b.is_solid;
    let touch_in_points = match written.in_space {
        true => halves || is_small(a) || is_small(b),
        false => is_round || halves || are_sharp,
    };
    if !touch_in_points {
        return groups;
    }
    if is_round && !halves {
        for corner in &a.corners {
            let touch = touch(a, corner, b, span);
            groups.extend(
                b.corners
                    .iter()
                    .map(|other| vec![on_corner(written, &touch, other)]),
            );
        }
    }
    for (one, other) in [(a, b), (b, a)] {
        for corner in &one.corners {
            let touch = touch(one, corner, other, span);
            if let (Some(curve), None) = (&other.curve, &touch.radius) {
                groups.push(vec![on_curve(written, &touch, &other.middle, curve)]);
            } else if is_round && !halves {
                let strips = other.strips.iter();
                groups.extend(strips.map(|strip| on_sides(written, &touch, other, strip)));
            } else if !other.sides.is_empty() {
                groups.push(on_sides(written, &touch, other, &other.sides));
            }
        }
    }
    groups
}

/// A round corner on a round corner.
fn on_corner(written: &Written<'_>, touch: &Touch<'_>, other: &Ident) -> Piece {
    let (span, corner) = (touch.span, &touch.corner);
    let distance = quote_spanned!(span=> |#corner - #other|);
    let normal = quote_spanned!(span=> ((#corner - #other)/#distance));
    piece(
        written,
        touch,
        (&normal, None),
        &less_radii(touch, distance),
    )
}

/// A sharp corner on a curve: its height above that, less by what the curve is inclined.
fn on_curve(
    written: &Written<'_>,
    touch: &Touch<'_>,
    middle: &Ident,
    (function, [along, across]): &(TokenStream, [Ident; 2]),
) -> Piece {
    let (span, corner) = (touch.span, &touch.corner);
    let place = quote_spanned!(span=> (#along . (#corner - #middle)));
    let height = quote_spanned!(span=> (#across . (#corner - #middle) - #function(#place)));
    let slope = quote_spanned!(span=> diff(#function)(#place));
    let length = quote_spanned!(span=> sqrt(1 + #slope^2));
    let normal = quote_spanned!(span=> ((#across - #slope*#along)/#length));
    piece(
        written,
        touch,
        (&normal, None),
        &quote_spanned!(span=> #height/#length),
    )
}

/// A corner on all of these sides of a shape, some of them a radius farther away.
fn on_sides(written: &Written<'_>, touch: &Touch<'_>, shape: &Shape, sides: &[Side]) -> Vec<Piece> {
    let (span, corner) = (touch.span, &touch.corner);
    let pieces = sides.iter().map(|side| {
        let (along, half) = (&side.normal, &side.half);
        let through = side.line.as_ref().unwrap_or(&shape.middle);
        let apart = quote_spanned!(span=> (#corner - #through));
        if side.line.is_some() && side.is_moved {
            let across = quote_spanned!(span=> (#apart - (#along . #apart)*#along));
            let distance = quote_spanned!(span=> |#across|);
            let normal = quote_spanned!(span=> (#across/#distance));
            return piece(
                written,
                touch,
                (&normal, None),
                &less_radii(touch, distance),
            );
        }
        let distance = quote_spanned!(span=> #along . #apart - #half);
        let distance = match side.is_moved {
            true => less_radii(touch, distance),
            false => distance,
        };
        piece(written, touch, (along, side.tangents.as_ref()), &distance)
    });
    pieces.collect()
}

/// A piece of a gap along a normal of length 1. The point of the corner that touches is a radius below it; its velocity and that of
/// the other body there differ along the surface by `(p' - b') x n + w_a r_a + w_b (n . (p - b) - r_a)`.
fn piece(
    written: &Written<'_>,
    touch: &Touch<'_>,
    (normal, tangents): (&TokenStream, Option<&[Ident; 2]>),
    distance: &TokenStream,
) -> Piece {
    let distance = distance.clone();
    if written.in_space {
        let sliding = slides_in_space(written, touch, normal, tangents);
        return Piece { distance, sliding };
    }
    let (span, corner) = (touch.span, &touch.corner);
    let on = written.body_place(touch.on);
    let apart = quote_spanned!(span=> (dot(#corner) - dot(#on)));
    let mut sliding = quote_spanned!(span=> #normal[1]*#apart[0] - #normal[0]*#apart[1]);
    let mut below = quote_spanned!(span=> #normal . (#corner - #on));
    if let Some(radius) = &touch.radius {
        below = quote_spanned!(span=> #below - #radius);
        if written.turns(touch.body) {
            let angle = written.named(touch.body, "angle");
            sliding = quote_spanned!(span=> #sliding + dot(#angle)*#radius);
        }
    }
    if written.turns(touch.on) {
        let angle = written.named(touch.on, "angle");
        sliding = quote_spanned!(span=> #sliding + dot(#angle)*(#below));
    }
    Piece { distance, sliding }
}

/// Both components of the velocity of the touching point of a corner against the other body, `p' + w_a x (-r n) - b' - w_b x (p - r n - b)`,
/// along directions that are given, or along two that go smoothly with the normal everywhere but at -(2, 3, 6)/7.
fn slides_in_space(
    written: &Written<'_>,
    touch: &Touch<'_>,
    normal: &TokenStream,
    tangents: Option<&[Ident; 2]>,
) -> TokenStream {
    let (span, corner) = (touch.span, &touch.corner);
    let spin = |body: &str| {
        let (turn, spin) = (written.turn(body), written.named(body, "spin"));
        let moves = written.turns(body) && !written.is_still(body);
        moves.then(|| quote_spanned!(span=> (#turn*#spin)))
    };
    let on = written.body_place(touch.on);
    let mut apart = quote_spanned!(span=> dot(#corner) - dot(#on));
    let mut arm = quote_spanned!(span=> #corner - #on);
    if let Some(radius) = &touch.radius {
        arm = quote_spanned!(span=> #arm - #radius*#normal);
        if let Some(spin) = spin(touch.body) {
            apart = quote_spanned!(span=> #apart - #radius*cross(#spin, #normal));
        }
    }
    if let Some(spin) = spin(touch.on) {
        apart = quote_spanned!(span=> #apart - cross(#spin, #arm));
    }
    if let Some([first, second]) = tangents {
        return quote_spanned!(span=> #first . (#apart), #second . (#apart));
    }
    let away = quote_spanned!(span=> (2/7, 3/7, 6/7));
    let [first, second] = [
        quote_spanned!(span=> (3/7, -6/7, 2/7)),
        quote_spanned!(span=> (6/7, 2/7, -3/7)),
    ]
    .map(|basis| {
        let share = quote_spanned!(span=> (#basis . #normal)/(1 + #away . #normal));
        quote_spanned!(span=> (#basis - #share*(#normal + #away)))
    });
    quote_spanned!(span=> #first . (#apart), #second . (#apart))
}

fn touch<'b>(shape: &'b Shape, corner: &Ident, on: &'b Shape, span: Span) -> Touch<'b> {
    Touch {
        span,
        corner: corner.clone(),
        body: &shape.body,
        on: &on.body,
        radius: shape.radius.clone(),
        others: on.radius.clone(),
    }
}

/// A distance of cores as one of shapes.
fn less_radii(touch: &Touch<'_>, distance: TokenStream) -> TokenStream {
    let radii = touch.radius.iter().chain(&touch.others);
    radii.fold(
        distance,
        |distance, radius| quote_spanned!(touch.span=> #distance - #radius),
    )
}
