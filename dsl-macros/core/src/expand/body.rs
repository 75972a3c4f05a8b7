//! Bodies: `body crate: mass m, inertia j, at (x, z), angle phi, tip = (l, 0)` becomes its energies and its points, and `gravity` the
//! potential energy of all of them. A body is the place where it is, and its name stands in front of what it has, `crate.tip`.

use super::clause::{Clause, clauses, head, shown, sorted};
use super::constants::Constants;
use super::names::{Names, Scope, encoded, indices, member};
use super::part::Placed;
use super::space;
use super::tokens::{
    around, components, ended, group_in, grouped, inside, items, joined, keyword, number, place_of,
    punct, undocumented, word,
};
use crate::diagnostics::{Checked, Diagnostics, Place, Reported, closest};
use crate::words;
use proc_macro2::{Delimiter, Ident, Span, TokenStream, TokenTree};
use quote::quote_spanned;
use std::collections::{HashMap, HashSet};
use std::rc::Rc;

/// What is known of a body.
pub(super) struct Body {
    /// Whether it has an angle, by whose name it turns.
    turns: bool,
    /// Whether it has no mass and no motion of its own.
    is_fixed: bool,
    /// Whether it never moves.
    is_still: bool,
    pub(super) span: Span,
    /// Whether its place has two components, as far as that is written.
    is_plane: bool,
    /// Points that were named.
    points: Vec<Ident>,
    scope: Rc<Scope>,
}

/// Everything that is written out of bodies.
pub(super) struct Bodies<'a> {
    pub(super) names: &'a mut Names,
    pub(super) diagnostics: &'a mut Diagnostics,
    pub(super) known: HashMap<String, Body>,
    /// Names of bodies in the order of the scene.
    order: Vec<String>,
    pub(super) written: Vec<Placed>,
    /// Entries of the picture, each with the name that it draws.
    drawn: Vec<(String, Placed)>,
    gravity: Option<(Span, Placed)>,
    pub(super) constants: Constants,
    /// Whether the bodies of the scene are in space.
    pub(super) in_space: bool,
}

impl<'a> Bodies<'a> {
    pub(super) fn new(names: &'a mut Names, diagnostics: &'a mut Diagnostics) -> Self {
        Self {
            names,
            diagnostics,
            known: HashMap::new(),
            order: Vec::new(),
            written: Vec::new(),
            drawn: Vec::new(),
            gravity: None,
            constants: Constants::default(),
            in_space: false,
        }
    }

    /// Takes up a statement that is no other one's to write out.
    pub(super) fn other(&mut self, (statement, scope): Placed) -> Checked<()> {
        self.constants.note(&statement, &scope);
        self.written.push((statement, scope));
        Ok(())
    }

    pub(super) fn write(&mut self, tokens: TokenStream, scope: &Rc<Scope>) {
        let tokens = tokens.into_iter().collect();
        self.written.push((tokens, Rc::clone(scope)));
    }

    /// Notes an entry of the picture.
    pub(super) fn drawn(&mut self, name: &str, entry: TokenStream, scope: &Rc<Scope>) {
        let entry = (entry.into_iter().collect(), Rc::clone(scope));
        self.drawn.push((name.to_owned(), entry));
    }

    pub(super) fn told(&mut self, place: Place, message: impl Into<String>) -> Reported {
        self.diagnostics.report("E27", place, message)
    }

    /// The name of something that belongs to what has a whole name, as it is declared.
    pub(super) fn own(&mut self, whole: &str, name: &str, span: Span) -> Ident {
        let name = format!("{whole}.{name}");
        self.names.declare(&name, &[]);
        Ident::new(&encoded(&name), span)
    }

    /// Declares something that belongs to what has a whole name, by what stands behind its name.
    pub(super) fn define(
        &mut self,
        (whole, name, span): (&str, &str, Span),
        value: TokenStream,
        scope: &Rc<Scope>,
    ) -> Ident {
        let own = self.own(whole, name, span);
        self.write(quote_spanned!(span=> let #own #value), scope);
        own
    }

    /// `gravity (0, -g)`.
    pub(super) fn gravity(&mut self, statement: &[TokenTree], scope: &Rc<Scope>) -> Checked<()> {
        let statement = undocumented(statement);
        let place = Place::at(statement[0].span());
        let value = ended(&statement[1..]);
        if self.gravity.is_some() {
            let message = "`gravity` is declared twice; it is that of all bodies";
            return Err(self.diagnostics.report("E19", place, message));
        }
        if !scope.prefix.is_empty() {
            let message =
                "`gravity` is that of all bodies; declare it in the scene, outside of parts";
            return Err(self.told(place, message));
        }
        if matches!(value, [TokenTree::Literal(_), ..]) {
            let message = "`gravity` is a vector, as in `gravity (0, -g)`";
            return Err(self.diagnostics.syntax(place, message));
        }
        self.fits(value, place, "gravity")?;
        let value = (value.to_vec(), Rc::clone(scope));
        self.gravity = Some((statement[0].span(), value));
        Ok(())
    }

    /// `body name: mass m, ..`.
    pub(super) fn body(&mut self, statement: &[TokenTree], scope: &Rc<Scope>) -> Checked<()> {
        let (name, indices, rest) = head(statement, self.diagnostics)?;
        let (span, text) = (name.span(), format!("{}{name}", scope.prefix));
        let Some(whole) = self.names.declare_body(&text, &indices) else {
            let message = format!("`{name}` is declared twice; rename this body");
            return Err(self.diagnostics.report("E19", Place::at(span), message));
        };
        let clauses = clauses(rest, &words::BODY);
        let [mass, inertia, centre, at, angle, turn, fixed] = self.of_body(name, &clauses)?;
        if let Some(at) = at {
            self.fits(at.tokens(), at.place(), &format!("body `{name}`"))?;
        }
        let given = |clause: Option<Clause<'_>>| clause.map(|clause| clause.value());
        let is_fixed = fixed.is_some();
        let nought = grouped(Delimiter::Parenthesis, nought(span, self.in_space), span);
        let place = match (given(at), is_fixed) {
            (Some(at), _) => at,
            (None, true) => nought,
            (None, false) => {
                let message = format!(
                    "body `{name}` is nowhere; say where, as in `at {}` with {} coordinates",
                    if self.in_space { "(x, y, z)" } else { "(x, z)" },
                    if self.in_space { "three" } else { "two" },
                );
                return Err(self.told(Place::at(span), message));
            }
        };
        let is_plane = angle.is_some() || two(&place);
        let own = Ident::new(&encoded(&whole), span);
        self.write(quote_spanned!(span=> let #own: m = #place), scope);
        let turns = match self.in_space {
            true => self.turned((&whole, span), (turn, is_fixed), scope),
            false => {
                let turn = given(angle).or_else(|| is_fixed.then(|| number(0, span)));
                turn.map(|turn| {
                    let value = quote_spanned!(span=> : rad = #turn);
                    self.define((&whole, "angle", span), value, scope);
                })
            }
        };
        self.order.push(whole.clone());
        let body = Body {
            turns: turns.is_some(),
            is_fixed,
            is_still: is_fixed && self.are_still([at, angle.or(turn)], scope),
            span,
            is_plane,
            points: Vec::new(),
            scope: Rc::clone(scope),
        };
        self.known.insert(whole.clone(), body);
        let middle = match centre {
            None => quote_spanned!(span=> #own),
            Some(centre) => self.offset(&whole, centre.place(), &centre.value())?,
        };
        let middle = quote_spanned!(span=> = #middle);
        let centre = self.define((&whole, "centre", span), middle, scope);
        if let Some(mass) = given(mass) {
            let m = self.define(
                (&whole, "mass", span),
                quote_spanned!(span=> : kg = #mass),
                scope,
            );
            self.write(
                quote_spanned!(span=> lagrangian += #m/2*|dot(#centre)|^2),
                scope,
            );
        }
        if let Some(inertia) = inertia {
            self.turning((&whole, span), (inertia, turn), scope);
        }
        for clause in clauses.iter().filter(|clause| clause.is_named()) {
            self.point(&whole, clause, scope)?;
        }
        Ok(())
    }

    /// Declares the matrix that turns a body in space, and its angular velocity along its own axes; none of a body that does not turn.
    /// A quaternion gets the joint that keeps its length.
    fn turned(
        &mut self,
        (whole, span): (&str, Span),
        (turn, is_fixed): (Option<Clause<'_>>, bool),
        scope: &Rc<Scope>,
    ) -> Option<()> {
        if let Some(parts) = space::quaternion(turn, span) {
            let unit = self.own(whole, "unit", span);
            let joint = quote_spanned!(span=> joint #unit: #(#parts^2)+* == 1);
            self.write(joint, scope);
            let [matrix, spin] = space::of_quaternion(&parts, span);
            self.define((whole, "turn", span), matrix, scope);
            self.define((whole, "spin", span), spin, scope);
            return Some(());
        }
        let value = match turn {
            Some(turn) => turn.value().into(),
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

    /// The kinetic energy of a body that turns.
    fn turning(
        &mut self,
        (whole, span): (&str, Span),
        (inertia, turn): (Clause<'_>, Option<Clause<'_>>),
        scope: &Rc<Scope>,
    ) {
        let (j, value) = (self.named(whole, "inertia"), inertia.value());
        let [moments, energy] = match self.in_space {
            true => space::energy(inertia, turn, [&j, &self.named(whole, "spin")]),
            false => {
                let angle = self.named(whole, "angle");
                let energy = quote_spanned!(span=> #j/2*dot(#angle)^2);
                [quote_spanned!(span=> : kg*m^2 = #value), energy]
            }
        };
        self.define((whole, "inertia", span), moments, scope);
        self.write(quote_spanned!(span=> lagrangian += #energy), scope);
    }

    /// What is said of a body, fitting together.
    fn of_body<'t>(
        &mut self,
        name: &Ident,
        clauses: &[Clause<'t>],
    ) -> Checked<[Option<Clause<'t>>; 7]> {
        let what = format!("body `{name}`");
        let own = clauses.iter().filter(|clause| !clause.is_named()).copied();
        let found = sorted(own, &words::BODY, &what, self.diagnostics)?;
        let [mass, inertia, centre, _, angle, turn, fixed] = found.map(|clause| clause.is_some());
        let message = match fixed {
            _ if angle && self.in_space => {
                "is in space, where an angle does not say how it is turned; write `turn (q0, q1, q2, q3)`, or `turn rotation_z(phi)`"
            }
            _ if turn && !self.in_space => {
                "is in the plane, where it turns by an angle; write `angle phi`, or a `gravity` with three components"
            }
            true if mass || inertia => {
                "is fixed, so that its mass does nothing; leave `fixed` out, or the mass"
            }
            true if centre => {
                "is fixed and has no mass, so that it has no centre of mass; leave `centre` out"
            }
            false if !mass => {
                "has no mass; write `mass m`, or `fixed` if it has no motion of its own"
            }
            false if inertia && !turn && self.in_space => {
                "has an inertia, and nothing by which it turns; add `turn (q0, q1, q2, q3)`, or `turn rotation_z(phi)`"
            }
            false if inertia && !(angle || turn) => {
                "has an inertia, and no angle by which it turns; add `angle phi`"
            }
            _ => {
                let [_, inertia, _, _, _, turn, _] = found;
                let Some((clause, has)) = space::wrong([inertia, turn], self.in_space) else {
                    return Ok(found);
                };
                return Err(self.told(clause.place(), format!("{what} has {has}")));
            }
        };
        Err(self.told(Place::at(name.span()), format!("{what} {message}")))
    }

    /// A point of a body, `tip = (l, 0)`.
    fn point(&mut self, whole: &str, clause: &Clause<'_>, scope: &Rc<Scope>) -> Checked<()> {
        let text = clause.word();
        let (place, name) = (Place::at(clause.first().span()), format!("{whole}.{text}"));
        if self.names.has(&name) || words::BODY.contains(&text.as_str()) {
            let message = format!(
                "`{}` is something else of this body; choose another name for the point",
                shown(&name)
            );
            return Err(self.diagnostics.report("E19", place, message));
        }
        let offset = self.offset(whole, place, &clause.value())?;
        let span = clause.first().span();
        let own = self.define(
            (whole, &text, span),
            quote_spanned!(span=> : m = #offset),
            scope,
        );
        if let Some(body) = self.known.get_mut(whole) {
            body.points.push(own);
        }
        Ok(())
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

    /// E27: a vector that is written out has a component for each direction.
    fn fits(&mut self, value: &[TokenTree], place: Place, what: &str) -> Checked<()> {
        let [dimensions, many, example] = match self.in_space {
            true => ["in space", "three", "(0, 0, -g)"],
            false => ["in the plane", "two", "(0, -g)"],
        };
        match components(value).len() {
            0 | 1 => Ok(()),
            own if own == 2 + usize::from(self.in_space) => Ok(()),
            own => {
                let message = format!(
                    "{what} has {own} components, and the bodies of this scene are {dimensions}; write {many}, as in `{example}`"
                );
                Err(self.told(place, message))
            }
        }
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
        Ident::new(&encoded(whole), self.span(whole))
    }

    /// What a body has, by name.
    pub(super) fn named(&self, whole: &str, name: &str) -> Ident {
        Ident::new(&encoded(&format!("{whole}.{name}")), self.span(whole))
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
    pub(super) fn whole(&mut self, tokens: &[TokenTree], scope: &Rc<Scope>) -> Checked<String> {
        let before = self.diagnostics.mistakes();
        let found = self.names.resolved(tokens, scope, self.diagnostics);
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
    pub(super) fn are_still(&self, clauses: [Option<Clause<'_>>; 2], scope: &Scope) -> bool {
        let mut clauses = clauses.into_iter().flatten();
        clauses.all(|clause| self.constants.all(clause.tokens(), scope))
    }

    /// All statements, with weights and what is drawn.
    pub(super) fn finished(mut self) -> Vec<Placed> {
        let in_plane = self
            .gravity
            .as_ref()
            .is_some_and(|(_, (value, _))| value.len() == 1 && two(&value[0]));
        for whole in std::mem::take(&mut self.order) {
            self.weight(&whole);
            let shape = format!("{whole}.");
            let is_own = |(name, _): &(String, Placed)| *name == whole || name.starts_with(&shape);
            if !self.drawn.iter().any(is_own) {
                self.draw(&whole, in_plane);
            }
        }
        self.picture();
        self.written
    }

    fn weight(&mut self, whole: &str) {
        let has_mass = !self.is_fixed(whole);
        let Some((span, (value, scope))) = self.gravity.clone().filter(|_| has_mass) else {
            return;
        };
        let value = grouped(Delimiter::None, value, span);
        let (m, centre) = ["mass", "centre"]
            .map(|name| self.named(whole, name))
            .into();
        self.write(
            quote_spanned!(span=> lagrangian += #m*(#value . (#centre))),
            &scope,
        );
    }

    /// A body without a shape: its centre and lines to its points.
    fn draw(&mut self, whole: &str, in_plane: bool) {
        let Some(body) = self.known.get(whole) else {
            return;
        };
        let is_drawn = (body.is_plane || in_plane) && !self.in_space;
        if body.is_fixed && body.points.is_empty() || !is_drawn {
            return;
        }
        let (own, centre) = (self.body_place(whole), self.named(whole, "centre"));
        let scope = Rc::clone(&body.scope);
        let links = body.points.iter();
        let links = links.map(|point| quote_spanned!(body.span=> link #centre to #point));
        let entries = [quote_spanned!(body.span=> point #own at #centre)].into_iter();
        for entry in entries.chain(links).collect::<Vec<_>>() {
            self.drawn(whole, entry, &scope);
        }
    }

    /// What is drawn of bodies, in front of what the scene draws itself; that goes before by name.
    fn picture(&mut self) {
        let is_picture = |(statement, _): &Placed| keyword(statement) == "picture";
        let own = self.written.iter().rposition(is_picture);
        let (mut entries, mut taken) = (Vec::new(), HashSet::new());
        if let Some(own) = own {
            let (statement, scope) = &self.written[own];
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
        let mut drawn = std::mem::take(&mut self.drawn);
        drawn.retain(|(name, _)| !taken.contains(name));
        let Some((_, (first, _))) = drawn.first() else {
            return;
        };
        let span = first.first().map_or_else(Span::call_site, TokenTree::span);
        for (_, (entry, scope)) in drawn {
            let entry = self
                .names
                .resolved_in((&entry, true), &scope, self.diagnostics);
            entries.extend(entry);
            entries.push(punct(',', span));
        }
        match own {
            Some(own) => {
                for token in &mut self.written[own].0 {
                    if let Some(block) = group_in(Some(token), Delimiter::Brace) {
                        let inner = entries.drain(..).chain(inside(block)).collect();
                        *token = around(block, inner);
                    }
                }
            }
            None => {
                let block = grouped(Delimiter::Brace, entries, span);
                let statement = vec![word("picture", span), block];
                self.written.push((statement, Rc::default()));
            }
        }
    }
}

/// Whether a vector of two components is written there.
fn two(value: &TokenTree) -> bool {
    components(std::slice::from_ref(value)).len() == 2
}

/// `0, 0`, in space `0, 0, 0`.
fn nought(span: Span, in_space: bool) -> Vec<TokenTree> {
    let noughts = (0..2 + usize::from(in_space)).map(|_| vec![number(0, span)]);
    joined(noughts, ',', span)
}
