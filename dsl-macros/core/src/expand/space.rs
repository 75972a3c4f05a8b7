//! Bodies in space: how they are turned, by a matrix or a quaternion, and their energy by principal moments of inertia.

use super::clause::{Clause, clauses};
use super::part::Placed;
use super::tokens::{components, ended, grouped, halves, keyword, undocumented};
use crate::words;
use proc_macro2::{Delimiter, Ident, Span, TokenStream, TokenTree};
use quote::quote_spanned;

/// Whether the bodies of a scene are in space: by the components of its gravity, else by how bodies are turned, else by those of a place.
pub(super) fn is_there(statements: &[Placed]) -> bool {
    let of = |wanted: &'static str| {
        let statements = statements
            .iter()
            .map(|(statement, _)| undocumented(statement));
        statements.filter(move |statement| keyword(statement) == wanted)
    };
    let count = |value: &[TokenTree]| components(value).len();
    // How many components the values behind a word of bodies have.
    let behind = |word: &'static str| {
        let said = of("body").flat_map(|statement| {
            let [_, said] = halves(statement, ':');
            clauses(said, &words::BODY)
        });
        let said = said.filter(move |clause| clause.word() == word && !clause.is_named());
        said.map(|clause| count(clause.tokens()))
    };
    match of("gravity")
        .map(|statement| count(ended(&statement[1..])))
        .next()
    {
        Some(directions @ (2 | 3)) => directions == 3,
        _ if behind("turn").next().is_some() => true,
        _ if behind("angle").next().is_some() => false,
        _ => behind(words::AT).any(|directions| directions == 3),
    }
}

/// The components of what is said behind a word.
fn parts(clause: Option<Clause<'_>>) -> Vec<Vec<TokenTree>> {
    clause
        .map(|clause| components(clause.tokens()))
        .unwrap_or_default()
}

/// The four components of a quaternion, each as one operand; none of a matrix.
pub(super) fn quaternion(turn: Option<Clause<'_>>, span: Span) -> Option<[TokenTree; 4]> {
    let parts = parts(turn).into_iter();
    let parts = parts.map(|part| grouped(Delimiter::None, part, span));
    parts.collect::<Vec<_>>().try_into().ok()
}

/// The matrix of a quaternion, and its angular velocity along the axes that it turns.
pub(super) fn of_quaternion([a, b, c, d]: &[TokenTree; 4], span: Span) -> [TokenStream; 2] {
    [
        quote_spanned!(span=> = (
            (1 - 2*(#c^2 + #d^2), 2*(#b*#c - #a*#d), 2*(#b*#d + #a*#c)),
            (2*(#b*#c + #a*#d), 1 - 2*(#b^2 + #d^2), 2*(#c*#d - #a*#b)),
            (2*(#b*#d - #a*#c), 2*(#c*#d + #a*#b), 1 - 2*(#b^2 + #c^2)))),
        quote_spanned!(span=> = 2*(
            #a*dot(#b) - #b*dot(#a) + #d*dot(#c) - #c*dot(#d),
            #a*dot(#c) - #c*dot(#a) + #b*dot(#d) - #d*dot(#b),
            #a*dot(#d) - #d*dot(#a) + #c*dot(#b) - #b*dot(#c))),
    ]
}

/// The moments of inertia about three axes, and the kinetic energy by an angular velocity along them. That of the length of a quaternion,
/// which its joint keeps, may be any; with equal moments it makes the inertia the same for all four.
pub(super) fn energy(
    inertia: Clause<'_>,
    turn: Option<Clause<'_>>,
    [j, w]: [&Ident; 2],
) -> [TokenStream; 2] {
    let (span, value) = (j.span(), inertia.value());
    let moments = match parts(Some(inertia)).len() {
        3 => quote_spanned!(span=> : kg*m^2 = #value),
        _ => quote_spanned!(span=> : kg*m^2 = (#value, #value, #value)),
    };
    let energy = quote_spanned!(span=> (#j[0]*#w[0]^2 + #j[1]*#w[1]^2 + #j[2]*#w[2]^2)/2);
    let energy = match quaternion(turn, span) {
        Some(parts) => quote_spanned!(span=> #energy + 2*#j[0]*(#(#parts*dot(#parts))+*)^2),
        None => energy,
    };
    [moments, energy]
}

/// What is said that does not turn a body, and what it has instead: a quaternion of four components or a matrix of three rows, and
/// one moment of inertia or three.
pub(super) fn wrong<'t>(
    [inertia, turn]: [Option<Clause<'t>>; 2],
    in_space: bool,
) -> Option<(Clause<'t>, &'static str)> {
    let (moments, turned) = (parts(inertia).len(), parts(turn));
    let is_row = |row: &Vec<TokenTree>| components(row).len() == 3;
    match turned.len() {
        0 | 4 => {}
        3 if turned.iter().all(is_row) => {}
        _ => {
            let what = "a quaternion of four components or a matrix that turns it, as in `turn (q0, q1, q2, q3)` or `turn rotation_z(phi)`";
            return Some((turn?, what));
        }
    }
    match (moments, in_space) {
        (0 | 1, _) | (3, true) => None,
        (_, true) => Some((
            inertia?,
            "one moment of inertia for all axes or three, as in `inertia (jx, jy, jz)`",
        )),
        (_, false) => Some((inertia?, "one moment of inertia in the plane")),
    }
}
