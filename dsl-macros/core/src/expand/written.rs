//! What is written out of bodies, their shapes, contacts and joints, and what is known of those that were written.

use super::clause::{Clause, shown};
use super::constants::Constants;
use super::names::{Names, Scope, ident, indices, member};
use super::part::Placed;
use super::tokens::{grouped, joined, number, place_of};
use crate::diagnostics::{Checked, Diagnostics, Place, Reported, closest};
use crate::words;
use proc_macro2::{Delimiter, Ident, Literal, Span, TokenStream, TokenTree};
use quote::quote_spanned;
use std::collections::HashMap;
use std::rc::Rc;

/// What is known of a body.
pub(super) struct Body {
    /// Whether it has an angle, by whose name it turns.
    pub(super) turns: bool,
    /// Whether it has no mass and no motion of its own.
    pub(super) is_fixed: bool,
    /// Whether it never moves.
    pub(super) is_still: bool,
    pub(super) span: Span,
    /// Whether its place has two components, as far as that is written.
    pub(super) is_plane: bool,
    /// Points that were named.
    pub(super) points: Vec<Ident>,
    pub(super) scope: Rc<Scope>,
}

/// All points with `normal . (p - middle) <= half`, or within a radius of a line along `normal`.
#[derive(Clone)]
pub(super) struct Side {
    pub(super) normal: TokenStream,
    pub(super) half: TokenStream,
    /// Whether a round shape is a radius farther away.
    pub(super) is_moved: bool,
    /// A point of the line.
    pub(super) line: Option<Ident>,
    /// Directions along it, where they are the same everywhere.
    pub(super) tangents: Option<[Ident; 2]>,
}

impl Side {
    pub(super) fn new(normal: TokenStream, half: TokenStream) -> Self {
        Self {
            normal,
            half,
            is_moved: false,
            line: None,
            tangents: None,
        }
    }

    pub(super) fn moved(self, is_moved: bool) -> Self {
        Self { is_moved, ..self }
    }
}

/// A shape, with names in the place of its parts.
pub(super) struct Shape {
    /// Its own whole name, and that of its body.
    pub(super) name: String,
    pub(super) body: String,
    /// Its kind in words.
    pub(super) kind: String,
    pub(super) middle: Ident,
    /// Whether a contact or a joint names it.
    pub(super) is_touched: bool,
    /// Place of its statement.
    pub(super) place: Place,
    /// None of a half plane.
    pub(super) corners: Vec<Ident>,
    pub(super) radius: Option<Ident>,
    /// In all of them the core lies.
    pub(super) sides: Vec<Side>,
    /// Whether a corner that is inside of all sides is inside of the core, which has a width.
    pub(super) is_solid: bool,
    /// What lies within a radius of the core beside its corners: all points that are within all sides of one of these.
    pub(super) strips: Vec<Vec<Side>>,
    /// Of what lies below a curve, its function and the directions along and across its argument.
    pub(super) curve: Option<(TokenStream, [Ident; 2])>,
}

/// Everything that is written out of bodies.
pub(super) struct Written<'a> {
    pub(super) names: &'a mut Names,
    pub(super) diagnostics: &'a mut Diagnostics,
    pub(super) known: HashMap<String, Body>,
    /// Names of bodies in the order of the scene.
    pub(super) order: Vec<String>,
    pub(super) shapes: Vec<Shape>,
    pub(super) statements: Vec<Placed>,
    /// Entries of the picture, each with the name that it draws.
    pub(super) drawn: Vec<(String, Placed)>,
    pub(super) gravity: Option<(Span, Placed)>,
    constants: Constants,
    /// Whether the bodies of the scene are in space.
    pub(super) in_space: bool,
    /// Where names of what is written now are looked for.
    pub(super) scope: Rc<Scope>,
}

impl<'a> Written<'a> {
    pub(super) fn new(
        names: &'a mut Names,
        diagnostics: &'a mut Diagnostics,
        in_space: bool,
    ) -> Self {
        Self {
            names,
            diagnostics,
            known: HashMap::new(),
            order: Vec::new(),
            shapes: Vec::new(),
            statements: Vec::new(),
            drawn: Vec::new(),
            gravity: None,
            constants: Constants::default(),
            in_space,
            scope: Rc::default(),
        }
    }

    /// Takes up a statement that is no other one's to write out.
    pub(super) fn other(&mut self, statement: Vec<TokenTree>) -> Checked<()> {
        self.constants.note(&statement, &self.scope);
        self.statements.push((statement, Rc::clone(&self.scope)));
        Ok(())
    }

    pub(super) fn write(&mut self, tokens: TokenStream) {
        let tokens = tokens.into_iter().collect();
        self.statements.push((tokens, Rc::clone(&self.scope)));
    }

    /// Notes an entry of the picture.
    pub(super) fn draw(&mut self, name: &str, entry: TokenStream) {
        let entry = (entry.into_iter().collect(), Rc::clone(&self.scope));
        self.drawn.push((name.to_owned(), entry));
    }

    pub(super) fn told(&mut self, place: Place, message: impl Into<String>) -> Reported {
        self.diagnostics.report("E27", place, message)
    }

    /// The name of something that belongs to what has a whole name, as it is declared.
    pub(super) fn own(&mut self, whole: &str, name: &str, span: Span) -> Ident {
        let name = format!("{whole}.{name}");
        self.names.declare(&name, &[]);
        ident(&name, span)
    }

    /// Declares something that belongs to what has a whole name, by what stands behind its name.
    pub(super) fn define(
        &mut self,
        (whole, name, span): (&str, &str, Span),
        value: TokenStream,
    ) -> Ident {
        let own = self.own(whole, name, span);
        self.write(quote_spanned!(span=> let #own #value));
        own
    }

    /// Writes that numbers are above zero: `part` of something, with code and message where a default is not.
    pub(super) fn positive(
        &mut self,
        (code, message): (&str, &str),
        (of, part): (&str, &str),
        (span, value): (Span, &TokenStream),
    ) {
        let word = ident(words::POSITIVE, span);
        let text = Literal::string(&[code, of, part, message].join("\n"));
        self.write(quote_spanned!(span=> let #word #text = #value));
    }

    /// A place that is given as seen from a body.
    pub(super) fn offset(
        &mut self,
        whole: &str,
        place: Place,
        value: &TokenTree,
    ) -> Checked<TokenStream> {
        self.needs_angle(whole, place, "a place on it")?;
        let (own, turn, span) = (self.body_place(whole), self.turn(whole), value.span());
        Ok(quote_spanned!(span=> #own + #turn*#value))
    }

    /// E27: what hangs on how a body is turned.
    pub(super) fn needs_angle(&mut self, whole: &str, place: Place, what: &str) -> Checked<()> {
        if self.turns(whole) {
            return Ok(());
        }
        let [has, write, never] = match self.in_space {
            true => ["turn", "turn (q0, q1, q2, q3)", "turn diagonal(1, 1, 1)"],
            false => ["angle", "angle phi", "angle 0"],
        };
        let message = format!(
            "body `{}` has no {has}, and {what} needs it; write `{write}` where the body is declared, or `{never}` if it never turns",
            shown(whole)
        );
        Err(self.told(place, message))
    }

    /// A vector of length 1 along an axis, 0 for none of them.
    pub(super) fn axis(&self, axis: usize, span: Span) -> TokenTree {
        let parts =
            (0..2 + usize::from(self.in_space)).map(|k| vec![number(i64::from(k == axis), span)]);
        grouped(Delimiter::Parenthesis, joined(parts, ',', span), span)
    }

    /// The matrix by which a body is turned.
    pub(super) fn turn(&self, whole: &str) -> TokenStream {
        let [turn, angle] = ["turn", "angle"].map(|name| self.named(whole, name));
        match self.in_space {
            true => quote_spanned!(turn.span()=> #turn),
            false => quote_spanned!(angle.span()=> rotation(#angle)),
        }
    }

    /// Whether a body has an angle.
    pub(super) fn turns(&self, body: &str) -> bool {
        self.known.get(body).is_some_and(|body| body.turns)
    }

    pub(super) fn is_fixed(&self, body: &str) -> bool {
        self.known.get(body).is_some_and(|body| body.is_fixed)
    }

    pub(super) fn is_still(&self, body: &str) -> bool {
        self.known.get(body).is_some_and(|body| body.is_still)
    }

    /// Where a body is, by name.
    pub(super) fn body_place(&self, whole: &str) -> Ident {
        ident(whole, self.span(whole))
    }

    /// What a body has, by name.
    pub(super) fn named(&self, whole: &str, name: &str) -> Ident {
        ident(&format!("{whole}.{name}"), self.span(whole))
    }

    fn span(&self, whole: &str) -> Span {
        let body = self.known.get(whole);
        body.map_or_else(Span::call_site, |body| body.span)
    }

    /// E27: a name that is no body above.
    pub(super) fn no_body(&mut self, name: &str, place: Place) -> Reported {
        let bodies: Vec<String> = self.known.keys().map(|name| shown(name)).collect();
        let name = shown(name);
        // In a part a body has a name of its own, behind that of the part.
        let own = |body: &str| body.rsplit('.').next().map(str::to_owned);
        let names: Vec<String> = bodies.iter().filter_map(|body| own(body)).collect();
        let near = closest(&name, bodies.iter().chain(&names).map(String::as_str));
        let near = near.and_then(|near| {
            let is_near = |body: &&String| *body == near || own(body).as_deref() == Some(near);
            bodies.iter().find(is_near)
        });
        let message = match near {
            Some(near) => format!("there is no body `{name}` above; did you mean `{near}`?"),
            None => format!(
                "there is no body `{name}` above; declare it before, as in `body {name}: mass m, at (x, z)` or `body {name}: fixed`"
            ),
        };
        self.told(place, message)
    }

    /// The whole name that tokens are.
    pub(super) fn whole(&mut self, tokens: &[TokenTree]) -> Checked<String> {
        let before = self.diagnostics.mistakes();
        let found = self.names.resolved(tokens, &self.scope, self.diagnostics);
        self.diagnostics.none_since(before)?;
        match &found[..] {
            [TokenTree::Ident(name)] => Ok(super::decoded(name.to_string())),
            [TokenTree::Ident(name), bracket] if indices(bracket).is_some() => {
                let name = super::decoded(name.to_string());
                Ok(member(&name, &indices(bracket).unwrap_or_default()))
            }
            _ => {
                let place = place_of(tokens, Place::at(Span::call_site()));
                Err(self.told(
                    place,
                    "a body or a shape has a name here, as in `block` or `block.lid`",
                ))
            }
        }
    }

    /// Whether nothing moves in these clauses.
    pub(super) fn are_still(&self, clauses: [Option<Clause<'_>>; 2]) -> bool {
        let mut clauses = clauses.into_iter().flatten();
        clauses.all(|clause| self.is_constant(clause.tokens()))
    }

    /// Whether tokens are made of numbers that do not move.
    pub(super) fn is_constant(&self, tokens: &[TokenTree]) -> bool {
        self.constants.all(tokens, &self.scope)
    }
}
