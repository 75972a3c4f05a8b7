//! Joints between bodies: `hinge elbow: upper.tip == lower.base`, and `weld`, `slider` and `rolling`, become `joint`s, and what moves in
//! them gets a name, `elbow.angle` and `rail.way`.

use super::clause::{Clause, clauses, head, shown, sorted};
use super::contact::Contacts;
use super::names::{Scope, encoded};
use super::shape::Shapes;
use super::tokens::{grouped, is_punct, place_of};
use crate::diagnostics::{Checked, Place};
use crate::words;
use proc_macro2::{Delimiter, Ident, Span, TokenStream, TokenTree};
use quote::quote_spanned;
use std::rc::Rc;

/// What a joint is made of.
struct Between<'t> {
    whole: String,
    name: &'t Ident,
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

/// Writes joints of bodies out.
pub(super) struct Hinges<'s, 'a>(pub(super) &'s mut Shapes<'a>);

impl Hinges<'_, '_> {
    /// `hinge elbow: upper.tip == lower.base`: a point on a point, about which both turn.
    pub(super) fn hinge(&mut self, statement: &[TokenTree], scope: &Rc<Scope>) -> Checked<()> {
        let between = self.between(statement, "==", scope)?;
        self.refuse(&between, &["motor", "stop", "restitution"])?;
        self.pinned(&between, scope);
        if let Some(turn) = self.turn(&between) {
            let span = between.name.span();
            let turn = quote_spanned!(span=> : rad = #turn);
            let angle = self
                .0
                .bodies
                .define((&between.whole, "angle", span), turn, scope);
            return self.driven(&between, &angle, scope);
        }
        match words::JOINT.iter().find_map(|word| between.clause(word)) {
            None => Ok(()),
            Some(clause) => self.turning(&between, clause.place(), &format!("`{}`", clause.word())),
        }
    }

    /// `ball socket: a.tip == b.base`: a point on a point in space, about which both turn freely.
    pub(super) fn ball(&mut self, statement: &[TokenTree], scope: &Rc<Scope>) -> Checked<()> {
        let between = self.between(statement, "==", scope)?;
        self.refuse(&between, &[])?;
        self.pinned(&between, scope);
        Ok(())
    }

    /// What moves a joint and what it strikes: a force on the quantity that moves in it, and a surface for each end of its range.
    fn driven(&mut self, between: &Between<'_>, moves: &Ident, scope: &Rc<Scope>) -> Checked<()> {
        let (span, whole) = (between.name.span(), &between.whole);
        if let Some(motor) = between.clause("motor") {
            let value = motor.value();
            self.0
                .bodies
                .write(quote_spanned!(span=> forces { #moves: #value }), scope);
        }
        let (Some(stop), restitution) = (between.clause("stop"), between.clause("restitution"))
        else {
            return match between.clause("restitution") {
                None => Ok(()),
                Some(clause) => {
                    let message = format!(
                        "joint `{0}` strikes nothing; add `stop -1..=1`, or leave `restitution` out",
                        between.name
                    );
                    Err(self.0.bodies.told(clause.place(), message))
                }
            };
        };
        let range = stop.tokens();
        let mut marks = range.windows(3);
        let at = marks.position(|marks| {
            marks
                .iter()
                .zip(['.', '.', '='])
                .all(|(token, mark)| is_punct(Some(token), mark))
        });
        let Some(at) = at.filter(|&at| at > 0 && at + 3 < range.len()) else {
            let message = "`stop` has both ends of a range, as in `stop -1..=1`";
            return Err(self.0.bodies.diagnostics.syntax(stop.place(), message));
        };
        let (low, high) = (&range[..at], &range[at + 3..]);
        let constants = &self.0.bodies.constants;
        if let (Some(from), Some(to)) = (constants.value(low, scope), constants.value(high, scope))
            && from >= to
        {
            let message = "the range of a stop begins below where it ends, as in `stop -1..=1`";
            let place = place_of(range, stop.place());
            return Err(self.0.bodies.diagnostics.report("E10", place, message));
        }
        let names = ["low", "high"].map(|name| self.0.bodies.own(whole, name, span));
        let law = match restitution {
            None => quote_spanned!(span=> inelastic),
            Some(clause) => TokenStream::from_iter(clause.whole().iter().cloned()),
        };
        let [lowest, highest] = &names;
        self.0.bodies.write(
            quote_spanned!(span=> surface #lowest: #moves >= #(#low)*),
            scope,
        );
        self.0.bodies.write(
            quote_spanned!(span=> surface #highest: #moves <= #(#high)*),
            scope,
        );
        for name in &names {
            self.0
                .bodies
                .write(quote_spanned!(span=> impact #name: #law), scope);
        }
        Ok(())
    }

    /// E27: what hangs on how both bodies are turned.
    fn turning(&mut self, between: &Between<'_>, place: Place, what: &str) -> Checked<()> {
        let mut bodies = between.bodies.iter().flatten();
        bodies.try_for_each(|body| self.0.bodies.needs_angle(body, place, what))
    }

    /// `weld seam: a.tip == b.base angle c`: a point on a point, and an angle between both bodies that stays.
    pub(super) fn weld(&mut self, statement: &[TokenTree], scope: &Rc<Scope>) -> Checked<()> {
        let between = self.between(statement, "==", scope)?;
        self.refuse(&between, &["angle"])?;
        self.pinned(&between, scope);
        self.locked(&between, scope)
    }

    /// `slider rail: block on frame along (1, 0)`: a point on a line of the other body, and an angle that stays.
    pub(super) fn slider(&mut self, statement: &[TokenTree], scope: &Rc<Scope>) -> Checked<()> {
        let between = self.between(statement, "on", scope)?;
        self.refuse(&between, &words::JOINT)?;
        let Some(direction) = between.clause("along") else {
            let message = format!(
                "slider `{0}` has no direction; add it as its second body has it, as in `slider {0}: block on frame along (1, 0)`",
                between.name
            );
            return Err(self.0.bodies.told(Place::at(between.name.span()), message));
        };
        let (span, value) = (between.name.span(), direction.value());
        let direction = match &between.bodies[1] {
            Some(body) if self.0.bodies.turns(body) => {
                let angle = self.0.bodies.named(body, "angle");
                quote_spanned!(span=> rotation(#angle)*#value)
            }
            _ => quote_spanned!(span=> #value),
        };
        let [a, b] = &between.sides;
        let direction = quote_spanned!(span=> = (#direction)/|#value|);
        let along = self
            .0
            .bodies
            .define((&between.whole, "along", span), direction, scope);
        let way = quote_spanned!(span=> : m = #along . (#a - #b));
        let way = self
            .0
            .bodies
            .define((&between.whole, "way", span), way, scope);
        let joint = Ident::new(&encoded(&between.whole), span);
        let off = quote_spanned!(span=> #along[0]*(#a - #b)[1] - #along[1]*(#a - #b)[0]);
        self.0
            .bodies
            .write(quote_spanned!(span=> joint #joint: #off == 0), scope);
        self.driven(&between, &way, scope)?;
        let [first, _] = &between.bodies;
        match first.as_ref().is_some_and(|body| self.0.bodies.turns(body)) {
            true => self.locked(&between, scope),
            false => Ok(()),
        }
    }

    /// `rolling grip: wheel on ground`: two shapes that touch in one point, and do not slide there.
    pub(super) fn rolling(&mut self, statement: &[TokenTree], scope: &Rc<Scope>) -> Checked<()> {
        let between = self.between(statement, "on", scope)?;
        self.refuse(&between, &[])?;
        let place = Place::at(between.name.span());
        let mut shapes = Vec::new();
        for side in &between.sides {
            shapes.push(self.0.shapes_of(&super::tokens::opened(side), scope)?);
        }
        let (&[a], &[b]) = (&shapes[0][..], &shapes[1][..]) else {
            let message = format!(
                "`{}` rolls with more than one shape of a body; name one of them, as in `block.lid`",
                between.name
            );
            return Err(self.0.bodies.told(place, message));
        };
        let bodies = [a, b].map(|shape| self.0.list[shape].body.clone());
        for body in &bodies {
            self.0.bodies.needs_angle(body, place, "rolling")?;
        }
        let groups = Contacts(&mut *self.0).gaps(a, b, place.start);
        let (1, Some([piece])) = (groups.len(), groups.first().map(Vec::as_slice)) else {
            let kinds = [a, b].map(|shape| self.0.list[shape].kind);
            let message = format!(
                "a {} does not roll on a {} in one point; a circle rolls on a half plane or on a circle",
                kinds[0], kinds[1]
            );
            return Err(self.0.bodies.told(place, message));
        };
        let (span, distance, sliding) = (place.start, &piece.distance, &piece.sliding);
        let joint = Ident::new(&encoded(&between.whole), span);
        let grip = self.0.bodies.own(&between.whole, "grip", span);
        self.0
            .bodies
            .write(quote_spanned!(span=> joint #joint: #distance == 0), scope);
        self.0
            .bodies
            .write(quote_spanned!(span=> joint #grip: #sliding == 0), scope);
        Ok(())
    }

    /// Name, sides and clauses of a joint; its name is taken.
    fn between<'t>(
        &mut self,
        statement: &'t [TokenTree],
        sign: &str,
        scope: &Rc<Scope>,
    ) -> Checked<Between<'t>> {
        let (name, indices, rest) = head(statement, self.0.bodies.diagnostics)?;
        let place = Place::at(name.span());
        let keyword = super::tokens::keyword(statement);
        let message = match (keyword == "ball", self.0.bodies.in_space) {
            (true, false) => Some("in the plane a point is held on a point by `hinge`"),
            (false, true) => Some(
                "this is a joint of the plane; in space `ball` holds a point on a point, and a `joint` what else is equal",
            ),
            _ => None,
        };
        if let Some(message) = message {
            return Err(self.0.bodies.told(Place::at(statement[0].span()), message));
        }
        let said = clauses(rest, &words::JOINT);
        let relation = said[0].whole();
        let is_sign = |at: usize| match sign {
            "==" => {
                relation[at..]
                    .iter()
                    .take(2)
                    .all(|token| is_punct(Some(token), '='))
                    && at + 2 < relation.len()
            }
            _ => {
                matches!(&relation[at], TokenTree::Ident(word) if word == sign)
                    && at + 1 < relation.len()
            }
        };
        let at = (1..relation.len()).find(|&at| is_sign(at));
        let Some(at) = at else {
            let example = words::example(&keyword).unwrap_or_default();
            let message = format!("`{keyword}` joins two sides by `{sign}`, as in `{example}`");
            return Err(self
                .0
                .bodies
                .diagnostics
                .syntax(place_of(relation, place), message));
        };
        let behind = at + if sign == "==" { 2 } else { 1 };
        let sides = [&relation[..at], &relation[behind..]];
        let what = format!("joint `{name}`");
        let clauses = sorted(
            said[1..].iter().copied(),
            &words::JOINT,
            &what,
            self.0.bodies.diagnostics,
        )?;
        let text = format!("{}{name}", scope.prefix);
        let Some(whole) = self.0.bodies.names.declare_part(&text, &indices) else {
            let message = format!("`{name}` is declared twice; rename this joint");
            return Err(self.0.bodies.diagnostics.report("E19", place, message));
        };
        let bodies = sides.map(|side| self.body_of(side, scope));
        if bodies.iter().all(Option::is_none) {
            let message = format!(
                "neither side of `{name}` is a body or a point of one; what holds between other places is a `joint {name}: left == right`"
            );
            return Err(self.0.bodies.told(place_of(relation, place), message));
        }
        let sides = sides.map(|side| grouped(Delimiter::None, side.to_vec(), side[0].span()));
        Ok(Between {
            whole,
            name,
            sides,
            bodies,
            clauses,
        })
    }

    /// The body to which a place belongs by its name.
    fn body_of(&mut self, tokens: &[TokenTree], scope: &Rc<Scope>) -> Option<String> {
        let [TokenTree::Ident(_), ..] = tokens else {
            return None;
        };
        let found = self
            .0
            .bodies
            .names
            .resolved(tokens, scope, self.0.bodies.diagnostics);
        let [TokenTree::Ident(name)] = &found[..] else {
            return None;
        };
        let whole = super::decoded(name.to_string());
        let is_its = |body: &&String| {
            let rest = whole.strip_prefix(body.as_str());
            rest.is_some_and(|rest| rest.is_empty() || rest.starts_with('.'))
        };
        let found = self.0.bodies.known.keys().filter(is_its);
        found.max_by_key(|body| body.len()).cloned()
    }

    /// Clauses that a kind of joint does not have.
    fn refuse(&mut self, between: &Between<'_>, known: &[&str]) -> Checked<()> {
        let clauses = between.clauses.iter().flatten();
        let mut wrong = clauses.filter(|clause| !known.contains(&clause.word().as_str()));
        let Some(clause) = wrong.next() else {
            return Ok(());
        };
        let message = format!(
            "`{}` says nothing of joint `{}`; leave it out",
            clause.word(),
            between.name
        );
        Err(self.0.bodies.told(clause.place(), message))
    }

    /// A point on a point.
    fn pinned(&mut self, between: &Between<'_>, scope: &Rc<Scope>) {
        let (span, [a, b]) = (between.name.span(), &between.sides);
        let joint = Ident::new(&encoded(&between.whole), span);
        self.0
            .bodies
            .write(quote_spanned!(span=> joint #joint: #a == #b), scope);
    }

    /// How far the second body is turned against the first one; none if one of them cannot turn.
    fn turn(&self, between: &Between<'_>) -> Option<TokenStream> {
        let span = between.name.span();
        let known = between.bodies.iter().flatten();
        if !known.clone().all(|body| self.0.bodies.turns(body)) {
            return None;
        }
        let angle =
            |body: &Option<String>| body.as_ref().map(|body| self.0.bodies.named(body, "angle"));
        match [&between.bodies[0], &between.bodies[1]].map(angle) {
            [Some(a), Some(b)] => Some(quote_spanned!(span=> #b - #a)),
            [Some(a), None] => Some(quote_spanned!(span=> -#a)),
            [None, Some(b)] => Some(quote_spanned!(span=> #b)),
            [None, None] => None,
        }
    }

    /// An angle between both bodies that stays, 0 where none is said.
    fn locked(&mut self, between: &Between<'_>, scope: &Rc<Scope>) -> Checked<()> {
        let what = format!("joint `{}`", shown(&between.whole));
        self.turning(between, Place::at(between.name.span()), &what)?;
        let Some(turn) = self.turn(between) else {
            return Ok(());
        };
        let span: Span = between.name.span();
        let angle = between
            .clause("angle")
            .map_or_else(|| super::tokens::number(0, span), |clause| clause.value());
        let joint = self.0.bodies.own(&between.whole, "turn", span);
        self.0
            .bodies
            .write(quote_spanned!(span=> joint #joint: #turn == #angle), scope);
        Ok(())
    }
}
