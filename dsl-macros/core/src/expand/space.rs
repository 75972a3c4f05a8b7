//! Bodies in space: how they are turned, by a matrix or a quaternion, and their energy by principal moments of inertia.

use super::body::{Bodies, components};
use super::clause::{Clause, clauses};
use super::names::Scope;
use super::part::Placed;
use super::tokens::{ended, is_punct, keyword, undocumented};
use crate::diagnostics::Checked;
use crate::words;
use proc_macro2::{Ident, Span, TokenStream, TokenTree};
use quote::quote_spanned;
use std::rc::Rc;

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
            let colon = statement
                .iter()
                .position(|token| is_punct(Some(token), ':'));
            clauses(
                &statement[colon.map_or(statement.len(), |colon| colon + 1)..],
                &words::BODY,
            )
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

impl Bodies<'_> {
    /// Declares the matrix that turns a body, and its angular velocity along its own axes; none of a body that does not turn. A
    /// quaternion gets the joint that keeps its length.
    pub(super) fn turned(
        &mut self,
        (whole, span): (&str, Span),
        (turn, is_fixed): (Option<Clause<'_>>, bool),
        scope: &Rc<Scope>,
    ) -> Option<()> {
        let quaternion = turn
            .map(|turn| components(turn.tokens()))
            .unwrap_or_default();
        if let [a, b, c, d] = &quaternion[..] {
            let [a, b, c, d] = [a, b, c, d].map(|part| quote_spanned!(span=> (#(#part)*)));
            let unit = self.own(whole, "unit", span);
            let length = quote_spanned!(span=> #a^2 + #b^2 + #c^2 + #d^2);
            self.write(quote_spanned!(span=> joint #unit: #length == 1), scope);
            let matrix = quote_spanned!(span=> = (
                (1 - 2*(#c^2 + #d^2), 2*(#b*#c - #a*#d), 2*(#b*#d + #a*#c)),
                (2*(#b*#c + #a*#d), 1 - 2*(#b^2 + #d^2), 2*(#c*#d - #a*#b)),
                (2*(#b*#d - #a*#c), 2*(#c*#d + #a*#b), 1 - 2*(#b^2 + #c^2))));
            self.define((whole, "turn", span), matrix, scope);
            let spin = quote_spanned!(span=> = 2*(
                #a*dot(#b) - #b*dot(#a) + #d*dot(#c) - #c*dot(#d),
                #a*dot(#c) - #c*dot(#a) + #b*dot(#d) - #d*dot(#b),
                #a*dot(#d) - #d*dot(#a) + #c*dot(#b) - #b*dot(#c)));
            self.define((whole, "spin", span), spin, scope);
            return Some(());
        }
        let value = match turn {
            Some(turn) => TokenStream::from(turn.value()),
            None if is_fixed => quote_spanned!(span=> diagonal(1, 1, 1)),
            None => return None,
        };
        let matrix = self.define(
            (whole, "turn", span),
            quote_spanned!(span=> = #value),
            scope,
        );
        if turn.is_some() {
            let rates = quote_spanned!(span=> = transpose(#matrix)*dot(#matrix));
            let rates = self.define((whole, "rates", span), rates, scope);
            let spin = quote_spanned!(span=> = (#rates[2][1], #rates[0][2], #rates[1][0]));
            self.define((whole, "spin", span), spin, scope);
        }
        Some(())
    }

    /// E27: a quaternion has four components, a matrix three rows, and moments of inertia are one or three.
    pub(super) fn of_turn<'t>(
        &mut self,
        name: &Ident,
        said: [Option<Clause<'t>>; 7],
    ) -> Checked<[Option<Clause<'t>>; 7]> {
        let [_, inertia, _, _, _, turn, _] = said;
        let parts = |clause: Option<Clause<'_>>| {
            clause
                .map(|clause| components(clause.tokens()))
                .unwrap_or_default()
        };
        let (moments, turned) = (parts(inertia), parts(turn));
        let is_row = |row: &Vec<TokenTree>| components(row).len() == 3;
        let is_turn = turned.is_empty()
            || turned.len() == 4
            || turned.len() == 3 && turned.iter().all(is_row);
        let are_moments = moments.len() <= 1 || moments.len() == 3 && self.in_space;
        let (wrong, message) = match (is_turn, self.in_space) {
            (false, _) => (
                turn,
                "a quaternion of four components or a matrix that turns it, as in `turn (q0, q1, q2, q3)` or `turn rotation_z(phi)`",
            ),
            (true, false) => (inertia, "one moment of inertia in the plane"),
            (true, true) => (
                inertia,
                "one moment of inertia for all axes or three, as in `inertia (jx, jy, jz)`",
            ),
        };
        let wrong = wrong.filter(|_| !(is_turn && are_moments));
        match wrong {
            None => Ok(said),
            Some(clause) => Err(self.told(clause.place(), format!("body `{name}` has {message}"))),
        }
    }

    /// The kinetic energy of a body that turns. That of the length of a quaternion, which its joint keeps, may be any; with equal
    /// moments it makes the inertia the same for all four.
    pub(super) fn turning(
        &mut self,
        (whole, span): (&str, Span),
        (inertia, turn): (Clause<'_>, Option<Clause<'_>>),
        scope: &Rc<Scope>,
    ) {
        let value = inertia.value();
        if !self.in_space {
            let value = quote_spanned!(span=> : kg*m^2 = #value);
            let j = self.define((whole, "inertia", span), value, scope);
            let angle = self.named(whole, "angle");
            return self.write(
                quote_spanned!(span=> lagrangian += #j/2*dot(#angle)^2),
                scope,
            );
        }
        let value = match components(inertia.tokens()).len() {
            3 => quote_spanned!(span=> : kg*m^2 = #value),
            _ => quote_spanned!(span=> : kg*m^2 = (#value, #value, #value)),
        };
        let j = self.define((whole, "inertia", span), value, scope);
        let w = self.named(whole, "spin");
        let mut energy = quote_spanned!(span=> (#j[0]*#w[0]^2 + #j[1]*#w[1]^2 + #j[2]*#w[2]^2)/2);
        let quaternion = turn
            .map(|turn| components(turn.tokens()))
            .unwrap_or_default();
        if quaternion.len() == 4 {
            let rates = quaternion
                .iter()
                .map(|part| quote_spanned!(span=> (#(#part)*)*dot(#(#part)*)));
            energy = quote_spanned!(span=> #energy + 2*#j[0]*(#(#rates)+*)^2);
        }
        self.write(quote_spanned!(span=> lagrangian += #energy), scope);
    }
}
