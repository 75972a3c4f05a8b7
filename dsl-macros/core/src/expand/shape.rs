//! Shapes of bodies: `shape crate: rectangle (w, h)`. Each is all that lies within a radius of a convex core, which has corners,
//! strips along its sides, and the half planes in all of which it lies.

use super::clause::{Clause, clauses, shown, sorted};
use super::names::{ident, member};
use super::tokens::{components, ended, grouped, halves, is_punct, place_of, punct, undocumented};
use super::written::{Shape, Side, Written};
use crate::diagnostics::{Checked, Place, Reported, list};
use crate::words;
use proc_macro2::{Delimiter, Ident, Span, TokenStream, TokenTree};
use quote::quote_spanned;

/// How each kind of shape is written in the plane.
const KINDS: [&str; 8] = [
    "circle r",
    "rectangle (w, h)",
    "polygon ((0, 0), (l, 0), (0, l))",
    "half plane",
    "below h",
    "capsule (l, r)",
    "segment l",
    "point",
];

/// The same in space.
const IN_SPACE: [&str; 5] = [
    "sphere r",
    "box (a, b, c)",
    "half space",
    "capsule (l, r)",
    "point",
];

/// What a shape is made with.
struct Frame<'t> {
    shape: Shape,
    span: Span,
    kind: Clause<'t>,
    /// By which angle it is turned in the plane.
    turn: TokenStream,
    /// Whether it can be drawn: its size does not move.
    is_drawn: bool,
}

/// `shape crate: rectangle (w, h) at (a, b) angle c`, also under a name of its own, `shape crate.lid: ..`, and `shape die: box (a, b, c)`
/// in space.
pub(super) fn shape(written: &mut Written<'_>, statement: &[TokenTree]) -> Checked<()> {
    let mut frame = frame(written, statement)?;
    match frame.kind.word().as_str() {
        "circle" | "sphere" => round(written, &mut frame)?,
        "capsule" | "segment" => capsule(written, &mut frame)?,
        "rectangle" | "box" => cuboid(written, &mut frame)?,
        "polygon" => polygon(written, &mut frame)?,
        "point" => point_alone(written, &mut frame),
        "below" => below(written, &mut frame),
        _ => half(written, &mut frame)?,
    }
    written.shapes.push(frame.shape);
    Ok(())
}

/// What a shape is made with.
fn frame<'t>(written: &mut Written<'_>, statement: &'t [TokenTree]) -> Checked<Frame<'t>> {
    let statement = ended(undocumented(statement));
    let begin = Place::at(statement[0].span());
    let [head, said] = halves(statement, ':');
    if said.is_empty() {
        let message =
            "a shape is written as in `shape block: rectangle (w, h)`, behind the name of its body";
        return Err(written.diagnostics.syntax(begin, message));
    }
    let (body, name, span) = owner(written, &head[1..])?;
    // Where this comes to nothing, a contact of the body without a shape is no second mistake.
    written.diagnostics.poison(&format!("shape {body}"));
    let clauses = clauses(said, &words::SHAPE);
    let what = format!("the shape of `{}`", shown(&name));
    let [kinds @ .., at, angle] = sorted(
        clauses.into_iter(),
        &words::SHAPE,
        &what,
        written.diagnostics,
    )?;
    let known: &[&str] = match written.in_space {
        true => &IN_SPACE,
        false => &KINDS,
    };
    let mut kinds = kinds.into_iter().flatten();
    let (Some(kind), None) = (kinds.next(), kinds.next()) else {
        return Err(no_kind(written, &what, known, begin));
    };
    let word = kind.word();
    let Some(example) = known
        .iter()
        .find(|kind| kind.split(' ').next() == Some(&word))
    else {
        return Err(no_kind(written, &what, known, kind.place()));
    };
    if !["circle", "sphere", "point"].contains(&word.as_str()) {
        written.needs_angle(&body, kind.place(), &format!("a shape `{word}`"))?;
    }
    let middle = match at {
        None => written.body_place(&body),
        Some(at) => {
            let place = written.offset(&body, at.place(), &at.value())?;
            written.define((&name, "middle", span), quote_spanned!(span=> : m = #place))
        }
    };
    let own = written.named(&body, "angle");
    let turn = match angle.map(|angle| angle.value()) {
        None => quote_spanned!(span=> #own),
        Some(angle) => quote_spanned!(span=> #own + #angle),
    };
    let is_drawn = match word.as_str() {
        "half" | "below" => written.is_still(&body) && written.are_still([at, angle]),
        _ => written.is_constant(kind.tokens()),
    };
    let shape = Shape {
        name,
        body,
        kind: match word.as_str() {
            "half" => (*example).to_owned(),
            "below" => "curve".to_owned(),
            _ => word,
        },
        middle,
        is_touched: false,
        place: begin,
        corners: Vec::new(),
        radius: None,
        sides: Vec::new(),
        is_solid: false,
        strips: Vec::new(),
        curve: None,
    };
    Ok(Frame {
        shape,
        span,
        kind,
        turn,
        is_drawn,
    })
}

/// E27: no shape of a scene in the plane or in space.
fn no_kind(written: &mut Written<'_>, what: &str, known: &[&str], place: Place) -> Reported {
    let is = if written.in_space {
        "is in space"
    } else {
        "is"
    };
    let known = list(known.iter().copied());
    written.told(place, format!("{what} {is} one of {known}"))
}

/// The body of a shape, the whole name of the shape, and where that stands.
fn owner(written: &mut Written<'_>, tokens: &[TokenTree]) -> Checked<(String, String, Span)> {
    let place = place_of(tokens, Place::at(Span::call_site()));
    let (names, own) = match tokens {
        [names @ .., point, TokenTree::Ident(own)] if is_punct(Some(point), '.') => {
            (names, Some(own))
        }
        names => (names, None),
    };
    let outer = written.whole(if own.is_some() { names } else { tokens })?;
    let (body, whole) = match own {
        Some(own) if written.known.contains_key(&outer) => {
            let whole = format!("{outer}.{own}");
            (outer, whole)
        }
        Some(_) => {
            let whole = written.whole(tokens)?;
            (whole.clone(), whole)
        }
        None => (outer.clone(), outer),
    };
    let Some(known) = written.known.get(&body) else {
        return Err(written.no_body(&body, place));
    };
    let span = match own {
        Some(own) => own.span(),
        None => known.span,
    };
    if written.shapes.iter().any(|shape| shape.name == whole)
        || body != whole && written.names.has(&whole)
    {
        let message = format!(
            "`{}` is declared twice; give this shape a name of its own, as in `shape {}.lid: ..`",
            shown(&whole),
            shown(&body)
        );
        return Err(written.diagnostics.report("E19", place, message));
    }
    if body != whole {
        written.names.declare_body(&whole, &[]);
    }
    Ok((body, whole, span))
}

/// Directions of a shape: along and across it, and in space its third axis.
fn axes(written: &mut Written<'_>, frame: &Frame<'_>) -> Vec<Ident> {
    let (turn, span) = (&frame.turn, frame.span);
    let matrix = match written.in_space {
        true => written.turn(&frame.shape.body),
        false => quote_spanned!(span=> rotation(#turn)),
    };
    let names = ["along", "across", "up"].into_iter();
    let names = names.take(2 + usize::from(written.in_space)).enumerate();
    names
        .map(|(k, name)| {
            let axis = written.axis(k, span);
            let value = quote_spanned!(span=> = #matrix*#axis);
            written.define((&frame.shape.name, name, span), value)
        })
        .collect()
}

/// A length of a shape, by name.
fn size(
    written: &mut Written<'_>,
    frame: &Frame<'_>,
    name: &str,
    value: &[TokenTree],
) -> Checked<Ident> {
    let span = value.first().map_or(frame.span, TokenTree::span);
    let value = grouped(Delimiter::None, value.to_vec(), span);
    let own = quote_spanned!(span=> : m = #value);
    let own = written.define((&frame.shape.name, name, span), own);
    let of = format!("{name} of shape `{}`", shown(&frame.shape.name));
    let mistake = ("E10", "the size of a shape is positive");
    written.positive(mistake, (&of, ""), (span, &quote_spanned!(span=> #value)));
    Ok(own)
}

/// Lengths in parentheses.
fn lengths(
    written: &mut Written<'_>,
    example: &str,
    frame: &Frame<'_>,
    names: &[&str],
) -> Checked<Vec<Ident>> {
    let parts = components(frame.kind.tokens());
    if parts.len() != names.len() {
        let many = if names.len() == 2 { "two" } else { "three" };
        let word = frame.kind.word();
        let message = format!("`{word}` has {many} lengths, as in `{example}`");
        return Err(written.told(frame.kind.place(), message));
    }
    let named = names.iter().zip(&parts);
    named
        .map(|(name, part)| size(written, frame, name, part))
        .collect()
}

/// Declares the next corner of the core.
fn corner(written: &mut Written<'_>, frame: &mut Frame<'_>, place: TokenStream) {
    let k = 1 + frame.shape.corners.len();
    let corner = listed(
        written,
        frame,
        ("corner", k),
        quote_spanned!(frame.span=> = #place),
    );
    frame.shape.corners.push(corner);
}

/// Declares one of several things of a shape.
fn listed(
    written: &mut Written<'_>,
    frame: &Frame<'_>,
    (name, k): (&str, usize),
    value: TokenStream,
) -> Ident {
    let name = format!("{}.{name}", frame.shape.name);
    written.names.declare(&name, &[k as i64]);
    let own = ident(&member(&name, &[k as i64]), frame.span);
    written.write(quote_spanned!(frame.span=> let #own #value));
    own
}

/// A circle or a sphere.
fn round(written: &mut Written<'_>, frame: &mut Frame<'_>) -> Checked<()> {
    let radius = size(written, frame, "radius", frame.kind.tokens())?;
    let size = quote_spanned!(frame.span=> radius #radius);
    frame.shape.corners = vec![frame.shape.middle.clone()];
    frame.shape.radius = Some(radius);
    match written.in_space {
        true => draw_round(written, frame),
        false => draw_shape(written, frame, &size),
    }
    Ok(())
}

/// A rectangle or a box: what is round comes near to its faces, its corners, and in space to its edges.
fn cuboid(written: &mut Written<'_>, frame: &mut Frame<'_>) -> Checked<()> {
    let (example, names, corners): (_, &[&str], &[&str]) = match written.in_space {
        true => (
            "box (a, b, c)",
            &["length", "width", "height"],
            &["+++", "++-", "+-+", "+--", "-++", "-+-", "--+", "---"],
        ),
        false => (
            "rectangle (w, h)",
            &["width", "height"],
            &["++", "-+", "--", "+-"],
        ),
    };
    let sizes = lengths(written, example, frame, names)?;
    let (axes, span, n) = (axes(written, frame), frame.span, names.len());
    let middle = frame.shape.middle.clone();
    let halves: Vec<_> = sizes
        .iter()
        .map(|size| quote_spanned!(span=> #size/2))
        .collect();
    // The place that lies so along some of the axes.
    let spot = |signs: &str, along: &[usize]| {
        let parts = signs.chars().zip(along).map(|(sign, &k)| {
            let (sign, half, axis) = (punct(sign, span), &halves[k], &axes[k]);
            quote_spanned!(span=> #sign #half*#axis)
        });
        quote_spanned!(span=> #middle #(#parts)*)
    };
    for signs in corners {
        corner(written, frame, spot(signs, &[0, 1, 2]));
    }
    frame.shape.sides = sides(&axes, &halves, span);
    let faces = (0..n).map(|k| pair(&frame.shape.sides, n, k));
    let mut strips: Vec<Vec<Side>> = faces.collect();
    if written.in_space {
        for k in 0..n {
            for signs in ["++", "+-", "-+", "--"] {
                let line = spot(signs, &[(k + 1) % n, (k + 2) % n]);
                let number = ("edge", strips.len() + 1 - n);
                let line = listed(written, frame, number, quote_spanned!(span=> = #line));
                strips.push(around(&axes[k], &halves[k], line));
            }
        }
        draw_edges(written, frame);
    } else {
        draw_shape(written, frame, &quote_spanned!(span=> size (#(#sizes),*)));
    }
    (frame.shape.is_solid, frame.shape.strips) = (true, strips);
    Ok(())
}

/// What lies within a radius of a segment, or the segment alone.
fn capsule(written: &mut Written<'_>, frame: &mut Frame<'_>) -> Checked<()> {
    let (span, middle) = (frame.span, frame.shape.middle.clone());
    let length = if frame.shape.kind == "capsule" {
        let mut sizes = lengths(written, "capsule (l, r)", frame, &["length", "radius"])?;
        frame.shape.radius = sizes.pop();
        sizes.remove(0)
    } else {
        size(written, frame, "length", frame.kind.tokens())?
    };
    let half = quote_spanned!(span=> #length/2);
    let axes = axes(written, frame);
    let along = &axes[0];
    for sign in ['+', '-'].map(|sign| punct(sign, span)) {
        corner(
            written,
            frame,
            quote_spanned!(span=> #middle #sign #half*#along),
        );
    }
    draw_round(written, frame);
    if written.in_space {
        frame.shape.strips = vec![around(along, &half, middle)];
        return Ok(());
    }
    frame.shape.sides = sides(&axes, &[half, quote_spanned!(span=> 0)], span);
    frame.shape.strips = vec![pair(&frame.shape.sides, 2, 1)];
    let ([a, b], across) = ([0, 1].map(|k| &frame.shape.corners[k]), &axes[1]);
    match &frame.shape.radius {
        None => draw_of(written, frame, quote_spanned!(span=> link #a to #b)),
        Some(radius) => {
            for sign in ['+', '-'].map(|sign| punct(sign, span)) {
                let away = quote_spanned!(span=> #sign #radius*#across);
                draw_of(
                    written,
                    frame,
                    quote_spanned!(span=> link #a #away to #b #away),
                );
            }
        }
    }
    Ok(())
}

/// A point alone, which is a corner.
fn point_alone(written: &mut Written<'_>, frame: &mut Frame<'_>) {
    frame.shape.corners = vec![frame.shape.middle.clone()];
    frame.shape.is_solid = true;
    if !written.in_space {
        draw_shape(written, frame, &TokenStream::new());
    }
}

/// All that lies below a function of the first axis.
fn below(written: &mut Written<'_>, frame: &mut Frame<'_>) {
    let axes = axes(written, frame);
    let [along, across] = [0, 1].map(|k| axes[k].clone());
    let (span, middle) = (frame.span, &frame.shape.middle);
    let function = TokenStream::from_iter(frame.kind.tokens().iter().cloned());
    let name = ident(&frame.shape.name, span);
    let entry =
        quote_spanned!(span=> curve #name: #middle + w*#along + #function(w)*#across over w);
    draw_of(written, frame, entry);
    frame.shape.curve = Some((function, [along, across]));
}

/// A convex polygon, whose corners go round either way: normals have the sign of its area.
fn polygon(written: &mut Written<'_>, frame: &mut Frame<'_>) -> Checked<()> {
    let spots = spots(written, frame)?;
    let axes = axes(written, frame);
    let [along, across] = [&axes[0], &axes[1]];
    let (span, middle) = (frame.span, frame.shape.middle.clone());
    let next = |k: usize| &spots[(k + 1) % spots.len()];
    let area = spots.iter().enumerate().map(|(k, spot)| {
        let next = next(k);
        quote_spanned!(span=> (#spot[0]*#next[1] - #spot[1]*#next[0]))
    });
    let area = quote_spanned!(span=> = #(#area)+*);
    let area = written.define((&frame.shape.name, "area", span), area);
    convex(written, frame, &spots, &area);
    let mut strips = Vec::new();
    for (k, spot) in spots.iter().enumerate() {
        corner(
            written,
            frame,
            quote_spanned!(span=> #middle + #spot[0]*#along + #spot[1]*#across),
        );
        let next = next(k);
        let edge = quote_spanned!(span=> = (#next - #spot)/|#next - #spot|);
        let edge = listed(written, frame, ("edge", k + 1), edge);
        let normal = quote_spanned!(span=> = #area/sqrt(#area^2)*(#edge[1], -#edge[0]));
        let normal = listed(written, frame, ("normal", k + 1), normal);
        let turned = |own: &Ident| quote_spanned!(span=> (#own[0]*#along + #own[1]*#across));
        let [side, way] = [&normal, &edge].map(turned);
        let half = quote_spanned!(span=> #normal . (#spot));
        let [begin, end] = [spot, next].map(|end| quote_spanned!(span=> #edge . (#end)));
        strips.push(vec![
            Side::new(side.clone(), half.clone()).moved(true),
            Side::new(
                quote_spanned!(span=> (-#side)),
                quote_spanned!(span=> (-(#half))),
            ),
            Side::new(way.clone(), quote_spanned!(span=> (#end))),
            Side::new(
                quote_spanned!(span=> (-#way)),
                quote_spanned!(span=> (-(#begin))),
            ),
        ]);
        frame.shape.sides.push(Side::new(side, half));
    }
    strips.push(frame.shape.sides.clone());
    draw_shape(
        written,
        frame,
        &quote_spanned!(span=> corners (#(#spots),*)),
    );
    (frame.shape.is_solid, frame.shape.strips) = (true, strips);
    Ok(())
}

/// The corners of a polygon as it is given.
fn spots(written: &mut Written<'_>, frame: &Frame<'_>) -> Checked<Vec<Ident>> {
    let kind = frame.kind;
    let points = components(kind.tokens());
    let parts: Vec<_> = points.iter().map(|point| components(point)).collect();
    if points.len() < 3 || parts.iter().any(|parts| parts.len() != 2) {
        let message = "a polygon has three corners at least, each with two lengths, as in `polygon ((0, 0), (l, 0), (0, l))`";
        return Err(written.told(kind.place(), message));
    }
    let spots = points.iter().enumerate().map(|(k, point)| {
        let span = frame.span;
        listed(
            written,
            frame,
            ("spot", k + 1),
            quote_spanned!(span=> : m = #(#point)*),
        )
    });
    Ok(spots.collect())
}

/// Writes that a polygon is convex: seen from each of its edges all other corners lie on the side of its area, with a share of it left.
fn convex(written: &mut Written<'_>, frame: &Frame<'_>, spots: &[Ident], area: &Ident) {
    let (n, points) = (spots.len(), components(frame.kind.tokens()));
    let of = format!("the outline of polygon `{}`", shown(&frame.shape.name));
    for (k, from) in spots.iter().enumerate() {
        let corner = (k + 1) % n;
        let (to, span) = (&spots[corner], points[corner][0].span());
        let others = (2..n).map(|j| &spots[(k + j) % n]);
        let turns = others.map(
            |other| quote_spanned!(span=> (cross(#to - #from, #other - #from) - 1e-12*#area)*#area),
        );
        let turns = quote_spanned!(span=> (#(#turns),*));
        let part = format!(" at corner {}, its turn times its area", corner + 1);
        let message = format!(
            "the outline does not turn the same way round, and once, at corner {} of the polygon, which has to be convex; make it of several, \
             as in `shape {}.lid: polygon ..`",
            corner + 1,
            shown(&frame.shape.body)
        );
        written.positive(("E27", &message), (&of, &part), (span, &turns));
    }
}

/// A half plane or a half space: all that lies below its axes but the last.
fn half(written: &mut Written<'_>, frame: &mut Frame<'_>) -> Checked<()> {
    let [word, message] = match written.in_space {
        true => [
            "space",
            "a half space is written as in `shape table: half space`; `at` stands behind that",
        ],
        false => [
            "plane",
            "a half plane is written as in `shape ground: half plane`; `at` and `angle` stand behind that",
        ],
    };
    if !matches!(frame.kind.tokens(), [TokenTree::Ident(own)] if own == word) {
        return Err(written.diagnostics.syntax(frame.kind.place(), message));
    }
    let (axes, span) = (axes(written, frame), frame.span);
    let up = axes.last();
    let side = Side::new(quote_spanned!(span=> #up), quote_spanned!(span=> 0));
    frame.shape.sides.push(Side {
        tangents: written.in_space.then(|| [0, 1].map(|k| axes[k].clone())),
        ..side.moved(true)
    });
    let (name, middle, along) = (
        ident(&frame.shape.name, span),
        &frame.shape.middle,
        &axes[0],
    );
    if !written.in_space {
        draw_of(
            written,
            frame,
            quote_spanned!(span=> curve #name: #middle + w*#along over w),
        );
    }
    Ok(())
}

/// Draws something of a shape.
fn draw_of(written: &mut Written<'_>, frame: &Frame<'_>, entry: TokenStream) {
    if frame.is_drawn {
        written.draw(&frame.shape.name, entry);
    }
}

/// Draws a shape under the word of its kind.
fn draw_shape(written: &mut Written<'_>, frame: &Frame<'_>, size: &TokenStream) {
    let Frame {
        shape, span, turn, ..
    } = frame;
    let word = Ident::new(&shape.kind, *span);
    let (name, middle) = (ident(&shape.name, *span), &shape.middle);
    let angle = match written.turns(&shape.body) {
        false => TokenStream::new(),
        true => quote_spanned!(*span=> angle #turn),
    };
    draw_of(
        written,
        frame,
        quote_spanned!(*span=> #word #name at #middle #size #angle),
    );
}

/// Draws circles around the corners, in space as seen along the second axis.
fn draw_round(written: &mut Written<'_>, frame: &Frame<'_>) {
    let Some(radius) = &frame.shape.radius else {
        return;
    };
    let span = frame.span;
    for (k, corner) in (1..).zip(&frame.shape.corners) {
        let name = match frame.shape.corners.len() {
            1 => frame.shape.name.clone(),
            _ => member(&format!("{}.end", frame.shape.name), &[k]),
        };
        let name = ident(&name, span);
        let place = match written.in_space {
            true => quote_spanned!(span=> (#corner[0], #corner[2])),
            false => quote_spanned!(span=> #corner),
        };
        draw_of(
            written,
            frame,
            quote_spanned!(span=> circle #name at #place radius #radius),
        );
    }
}

/// Draws lines between corners that differ in one sign, as seen along the second axis.
fn draw_edges(written: &mut Written<'_>, frame: &Frame<'_>) {
    let pairs = (0..8_usize).flat_map(|a| [1, 2, 4].map(|bit| (a, a | bit)));
    for (a, b) in pairs.filter(|(a, b)| a < b) {
        let [a, b] = [a, b].map(|k| &frame.shape.corners[k]);
        let entry = quote_spanned!(frame.span=> link (#a[0], #a[2]) to (#b[0], #b[2]));
        draw_of(written, frame, entry);
    }
}

/// The shapes that a name means: that of a body with all that have names of their own, or one of these.
pub(super) fn shapes_of(written: &mut Written<'_>, tokens: &[TokenTree]) -> Checked<Vec<usize>> {
    let place = place_of(tokens, Place::at(Span::call_site()));
    let whole = written.whole(tokens)?;
    let is_meant = |shape: &Shape| shape.name == whole || shape.body == whole;
    let found: Vec<usize> = (0..written.shapes.len())
        .filter(|&k| is_meant(&written.shapes[k]))
        .collect();
    for &k in &found {
        written.shapes[k].is_touched = true;
    }
    match (found.is_empty(), written.known.contains_key(&whole)) {
        (false, _) => Ok(found),
        (true, true) if written.diagnostics.is_poisoned(&format!("shape {whole}")) => Err(Reported),
        (true, true) => {
            let name = shown(&whole);
            let message = format!(
                "body `{name}` has no shape above that could touch anything; declare one before, as in `shape {name}: circle r`"
            );
            Err(written.told(place, message))
        }
        (true, false) => Err(written.no_body(&whole, place)),
    }
}

/// Sides on both ends of each axis, at a distance from the middle.
fn sides(axes: &[Ident], halves: &[TokenStream], span: Span) -> Vec<Side> {
    let both = ['+', '-'].map(|sign| punct(sign, span));
    let side = |sign: &TokenTree, (axis, half): (&Ident, &TokenStream)| {
        Side::new(quote_spanned!(span=> (#sign #axis)), half.clone())
    };
    let ends = both
        .iter()
        .flat_map(|sign| axes.iter().zip(halves).map(move |end| side(sign, end)));
    ends.collect()
}

/// What lies within a radius of a line of some length.
fn around(axis: &Ident, half: &TokenStream, line: Ident) -> Vec<Side> {
    let (span, end) = (axis.span(), |side: TokenStream| Side {
        line: Some(line.clone()),
        ..Side::new(side, half.clone())
    });
    let along = end(quote_spanned!(span=> #axis));
    vec![
        along.clone().moved(true),
        along,
        end(quote_spanned!(span=> (-#axis))),
    ]
}

/// Sides of which those with a remainder are moved by a radius.
fn pair(sides: &[Side], by: usize, remainder: usize) -> Vec<Side> {
    let sides = sides.iter().cloned().enumerate();
    sides
        .map(|(k, side)| side.moved(k % by == remainder))
        .collect()
}
