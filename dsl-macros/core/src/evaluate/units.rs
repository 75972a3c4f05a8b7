//! Units beside values, E03: both sides of every sum, comparison and declaration have the same unit.
//!
//! Seven exponents go with every number; units that are not declared are inferred. Bare numbers are dimensionless, except 0,
//! which fits anywhere, and except where a declaration gives the unit (`m: kg = 80`). A scene that declares no unit at all is
//! not checked.

use super::value::{Number, Value};
use crate::ast::{Expr, Kind, Link, Name, Prefix, WrittenUnit};
use crate::diagnostics::{Diagnostics, Place};
use crate::dimension::{Dimension, Unifier};
use crate::graph::Sym;
use crate::words;
use hangtime_units::{Ratio, Unit};
use std::collections::{HashMap, HashSet};
use std::f64::consts::TAU;

/// What is known of units.
#[derive(Default)]
pub(crate) struct Units {
    /// Whether the scene declares any.
    checked: bool,
    /// What has been found since it was told, of a statement that may fail for another reason.
    pub(crate) found: Diagnostics,
    /// Unit of the Lagrangian.
    pub(crate) energy: Dimension,
    /// Units of surfaces, joints and ways of dry friction, by name.
    pub(crate) gaps: HashMap<String, Dimension>,
    /// Surfaces, and coordinates with a start value, whose units differ.
    pub(crate) faulty: HashSet<String>,
    /// Names that are declared in rad.
    radians: HashSet<String>,
    /// Where the last function was called.
    pub(super) called: Option<Place>,
    unifier: Unifier,
}

impl Units {
    /// Of a scene that declares some, or none.
    pub(crate) fn begin(&mut self, checked: bool) {
        self.checked = checked;
        self.energy = self.unknown("lagrangian");
    }

    /// A known unit.
    pub(crate) fn of(&self, unit: Unit) -> Dimension {
        match self.checked {
            true => Dimension::of(unit),
            false => Dimension::default(),
        }
    }

    pub(crate) fn one(&self) -> Dimension {
        self.of(Unit::ONE)
    }

    pub(crate) fn second(&self) -> Dimension {
        self.of(Unit::mechanical(0, 0, 1))
    }

    /// That of `owner`, which is to be inferred.
    pub(crate) fn unknown(&mut self, owner: &str) -> Dimension {
        match self.checked {
            true => self.unifier.unknown(owner),
            false => Dimension::default(),
        }
    }

    /// The unit of a quantity, as far as it is declared.
    pub(crate) fn declared(&mut self, name: &str, unit: Option<&WrittenUnit>) -> Dimension {
        if unit.is_some_and(|unit| unit.text == "rad") {
            self.radians.insert(name.to_owned());
        }
        match unit {
            Some(written) => self.of(written.unit),
            None => self.unknown(name),
        }
    }

    /// The unit of a number as it is written.
    pub(super) fn written(&mut self, value: f64, unit: Option<&WrittenUnit>) -> Dimension {
        match unit {
            Some(written) => self.of(written.unit),
            None if value == 0.0 => self.unknown(""),
            None => self.one(),
        }
    }

    /// The unit, if all of it is known.
    pub(crate) fn known(&self, dimension: &Dimension) -> Option<Unit> {
        self.unifier.known(dimension)
    }

    /// Makes both equal, inferring what is not known; whether that is possible.
    pub(crate) fn unify(&mut self, own: &Dimension, its: &Dimension) -> bool {
        self.unifier.unify(own, its)
    }

    /// Notes the unit of the gap of what the statement declares, or that units differ in it.
    pub(crate) fn put_gap(&mut self, name: &Name, unit: Dimension) {
        match self.found.mistakes() == 0 {
            true => self.gaps.insert(name.text.clone(), unit).is_some(),
            false => self.faulty.insert(name.text.clone()),
        };
    }

    /// The unit of a gap, if all of it is known.
    pub(crate) fn gap(&self, surface: &str) -> Option<Unit> {
        self.known(self.gaps.get(surface)?)
    }

    /// A gap with its unit, for people.
    pub(crate) fn shown_gap(&self, surface: &str, value: f64) -> String {
        let unit = self.gap(surface).map(|unit| unit.to_string());
        match unit.filter(|unit| unit != "1") {
            Some(unit) => format!("{} {unit}", rounded(value)),
            None => rounded(value).to_string(),
        }
    }

    /// Whether a number is in the wanted unit.
    pub(crate) fn expect(
        &mut self,
        expr: &Expr,
        own: &Dimension,
        wanted: &Dimension,
        reason: &str,
    ) -> bool {
        self.expect_called(expr, (own, wanted), reason, ["", ""])
    }

    /// Whether a number is in the wanted unit, where one is usually called otherwise than it is shown: the one by the other.
    pub(crate) fn expect_called(
        &mut self,
        expr: &Expr,
        (own, wanted): (&Dimension, &Dimension),
        reason: &str,
        [shown, called]: [&str; 2],
    ) -> bool {
        if self.unifier.unify(own, wanted) {
            return true;
        }
        let call = |unit: String| match unit == shown {
            true => called.to_owned(),
            false => unit,
        };
        let is_in = match &expr.kind {
            // Shown without its angle the written unit would be another one.
            Kind::Number {
                unit: Some(unit), ..
            } if ["rad", "deg", "rev"]
                .iter()
                .any(|angle| unit.text.contains(angle)) =>
            {
                format!("is in {}", unit.text)
            }
            _ if self.unifier.show(own) == shown => format!("is in {called}"),
            _ => self.unifier.is_in(own),
        };
        let needed = match call(self.unifier.show(wanted)) {
            unit if unit == "1" => "a pure number".to_owned(),
            unit => unit,
        };
        let hint = self.hint(&[(expr, wanted)]);
        self.differ(
            expr.place,
            format!("`{expr}` {is_in}, where {needed} is needed ({reason}){hint}"),
        )
    }

    /// Whether two expressions have the same unit.
    pub(crate) fn same(
        &mut self,
        place: Place,
        (left, own): (&Expr, &Dimension),
        (right, its): (&Expr, &Dimension),
        what: &str,
    ) -> bool {
        if self.unifier.unify(own, its) {
            return true;
        }
        let message = format!(
            "`{left}` {}, `{right}` {}; {what} must agree{}",
            self.unifier.is_in(own),
            self.unifier.is_in(its),
            self.hint(&[(left, its), (right, own)])
        );
        self.differ(place, message)
    }

    /// The unit that all of these have; `message` is what is said where two of them differ.
    pub(super) fn common(
        &mut self,
        numbers: &[Number],
        place: Place,
        message: impl Fn(String, String) -> String,
    ) -> Dimension {
        let Some(first) = numbers.first().map(|number| &number.unit) else {
            return Dimension::default();
        };
        let mut others = numbers[1..].iter().map(|number| &number.unit);
        if let Some(other) = others.find(|own| !self.unifier.unify(own, first)) {
            let message = message(self.unifier.show(first), self.unifier.show(other));
            self.differ(place, message);
            return Dimension::default();
        }
        first.clone()
    }

    /// Whether all terms of a sum have the unit of the first.
    pub(crate) fn of_sum(&mut self, first: &Expr, rest: &[Link], values: &[Value]) -> bool {
        let own = &values[0];
        // Terms that do not fit: those after them may fit these instead, and are no mistakes of their own.
        let mut strange: Vec<&Value> = Vec::new();
        for (i, link) in rest.iter().enumerate() {
            let its = &values[i + 1];
            let mut differing = |own: &Value| {
                let mut pairs = own.components().iter().zip(its.components());
                pairs.position(|(own, its)| !self.unifier.unify(&own.unit, &its.unit))
            };
            if strange.iter().any(|known| differing(known).is_none()) {
                continue;
            }
            let Some(k) = differing(own) else { continue };
            let [a, b] = [own, its].map(|value| &value.components()[k].unit);
            strange.push(its);
            let left = Prefix {
                first,
                rest: &rest[..i],
            };
            // A bare number on the left is a whole side only where it stands alone.
            let bare = left.rest.is_empty().then_some((first, b));
            let candidates: Vec<_> = bare.into_iter().chain([(&link.operand, a)]).collect();
            let message = format!(
                "`{left}` {}, `{}` {}; both sides of `{}` must agree{}",
                self.unifier.is_in(a),
                link.operand,
                self.unifier.is_in(b),
                link.operator.symbol(),
                self.hint(&candidates)
            );
            self.differ(link.place, message);
        }
        strange.is_empty()
    }

    /// The unit of a power.
    pub(super) fn of_power(
        &mut self,
        (base, own): (&Expr, &Number),
        (exponent, its): (&Expr, &Number),
    ) -> Dimension {
        if self.pure("an exponent", exponent, its).is_silent() {
            return Dimension::default();
        }
        match its.sym.as_number().and_then(Ratio::from_f64) {
            Some(exponent) => own.unit.power(exponent),
            None => self.pure("a power with a variable exponent", base, own),
        }
    }

    /// The unit of a function of numbers.
    pub(super) fn of_call(
        &mut self,
        function: &Name,
        arguments: &[Expr],
        numbers: &[Number],
    ) -> Dimension {
        let text = function.text.as_str();
        let root = |order| Ratio::new(1, order).unwrap_or(Ratio::ONE);
        match (text, numbers) {
            ("abs", [own]) => own.unit.clone(),
            ("sqrt", [own]) => own.unit.power(root(2)),
            ("cbrt", [own]) => own.unit.power(root(3)),
            (_, [_]) if words::JUMPS.contains(&text) => self.one(),
            (words::IF, [_, _, yes, _]) => {
                let [condition, branches] = [0..2, 2..4]
                    .map(|part| self.alike(function, &arguments[part.clone()], &numbers[part]));
                match condition && branches {
                    true => yes.unit.clone(),
                    false => Dimension::default(),
                }
            }
            (_, [own]) => self.pure(text, &arguments[0], own),
            (_, [own, ..]) => match (self.alike(function, arguments, numbers), text) {
                (true, "atan2") => self.one(),
                (true, _) => own.unit.clone(),
                (false, _) => Dimension::default(),
            },
            _ => Dimension::default(),
        }
    }

    /// Whether all arguments of a function have the same unit.
    fn alike(&mut self, function: &Name, arguments: &[Expr], numbers: &[Number]) -> bool {
        let what = match function.text.as_str() {
            "atan2" => "both arguments of `atan2`".to_owned(),
            text => format!("the arguments of `{text}`"),
        };
        let own = (&arguments[0], &numbers[0].unit);
        let mut others = arguments.iter().zip(numbers).skip(1);
        others.all(|(expr, its)| self.same(function.place(), own, (expr, &its.unit), &what))
    }

    /// The unit of what must be a pure number.
    pub(crate) fn pure(&mut self, function: &str, expr: &Expr, own: &Number) -> Dimension {
        if matches!(function, "sin" | "cos" | "tan") {
            let angle = format!("the argument of `{function}`");
            self.likely_degrees(&angle, expr, own.sym);
        }
        if self.unifier.unify(&own.unit, &Dimension::one()) {
            return own.unit.clone();
        }
        let shown = self.unifier.show(&own.unit);
        self.differ(
            expr.place,
            format!("`{function}` needs a pure number, `{expr}` is in {shown}"),
        );
        Dimension::default()
    }

    /// The unit of a function given by points, whose argument has that of its points.
    pub(super) fn of_points(
        &mut self,
        expr: &Expr,
        own: &Value,
        units: [&Option<WrittenUnit>; 2],
    ) -> Dimension {
        let own = own.components().first();
        let own = own.map(|own| own.unit.clone()).unwrap_or_default();
        let [wanted, value] = units.map(|unit| self.written(1.0, unit.as_ref()));
        if self.unifier.unify(&own, &wanted) {
            return value;
        }
        let message = format!(
            "the points of `{expr}` are in {}, its argument is in {}",
            self.unifier.show(&wanted),
            self.unifier.show(&own)
        );
        self.differ(self.called.unwrap_or(expr.place), message);
        Dimension::default()
    }

    /// The unit of a force or an impulse of a contact: a force does work on a change of the gap, an impulse is a force for a
    /// time.
    pub(super) fn of_contact(&self, text: &str, contact: &str) -> Dimension {
        let gap = self.gaps.get(contact).cloned().unwrap_or_default();
        let force = self.energy.over(&gap);
        match text {
            "force" | "friction_force" => force,
            _ => force.times(&self.second()),
        }
    }

    fn differ(&mut self, place: Place, message: String) -> bool {
        let message = format!("units differ: {message}");
        self.found.report("E03", place, message);
        false
    }

    /// What to write if a bare number is to blame: each expression with the unit that would fit.
    fn hint(&self, candidates: &[(&Expr, &Dimension)]) -> String {
        match candidates.iter().find(|(expr, _)| expr.is_bare()) {
            Some((expr, wanted)) => format!(
                "; a bare number has no unit, write it in brackets, as in `{expr} [{}]`",
                self.unifier.show(wanted)
            ),
            None => String::new(),
        }
    }

    /// E23: a number beside an angle by which it is meant, where both are compared.
    pub(crate) fn angles(&mut self, left: (&Expr, &Number), right: (&Expr, &Number)) {
        for ((angle, _), (expr, number)) in [(left, right), (right, left)] {
            if self.shows_angle(angle) {
                self.likely_degrees(&format!("`{angle}`"), expr, number.sym);
            }
        }
    }

    /// E23: a number that belongs to the declaration of a name.
    pub(crate) fn angle_of(&mut self, name: &str, expr: &Expr, number: Sym) {
        if self.is_angle(name) {
            self.likely_degrees(&format!("`{name}`"), expr, number);
        }
    }

    /// Whether a name is declared in rad.
    pub(crate) fn is_angle(&self, name: &str) -> bool {
        self.radians.contains(name)
    }

    /// Whether an expression is a name declared in rad, or a sum with one and nothing else but numbers.
    fn shows_angle(&self, expr: &Expr) -> bool {
        match &expr.kind {
            Kind::Name(name) => self.is_angle(&name.text),
            Kind::Negate(inner) | Kind::Norm(inner) => self.shows_angle(inner),
            Kind::Chain(_, rest) if rest[0].operator.is_additive() => {
                let terms = expr.children();
                terms.iter().any(|term| self.shows_angle(term))
                    && terms
                        .iter()
                        .all(|term| term.is_bare() || self.shows_angle(term))
            }
            _ => false,
        }
    }

    /// E23: a number that is an angle in radians by the letter, and in degrees by its size.
    fn likely_degrees(&mut self, angle: &str, expr: &Expr, number: Sym) {
        let bare = self.checked && expr.is_bare() && !expr.mentions("pi");
        let Some(value) = number.as_number().filter(|value| bare && value.abs() > TAU) else {
            return;
        };
        let turns = (value.abs() / TAU * 10.0).round() / 10.0;
        let message = format!(
            "{angle} is in rad, and {value} rad are {turns} turns; write `{value} [deg]` if degrees are meant, \
             `{value} [rad]` if not"
        );
        self.found.warn("E23", expr.place, message);
    }
}

/// To four digits behind the point, or to the leading one.
pub(crate) fn rounded(value: f64) -> f64 {
    let scale = if value.abs() < 1e-3 { 1e9 } else { 1e4 };
    (value * scale).round() / scale
}
