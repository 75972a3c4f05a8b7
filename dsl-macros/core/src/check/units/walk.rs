//! Units of expressions.

use crate::ast::{Expr, Kind, Link, Name, Operator, Prefix, WrittenUnit};
use crate::check::values::is_bare;
use crate::diagnostics::{Checked, Diagnostics, Place, Reported};
use crate::dimension::{Dimension, Unifier};
use crate::evaluate::{BUDGET, Matrix, Value, stacked};
use crate::words;
use hangtime_units::Ratio;
use std::collections::{HashMap, HashSet};

/// Most calls inside each other; the evaluation before this one refuses more.
const MOST_CALLS: usize = 100;

/// Units of the components of a value: of matrices entry by entry, as those of moments of inertia and of rotations differ.
pub(super) type Units = Value<Dimension>;

/// What is recorded and drawn.
#[derive(Default)]
pub(super) struct Shown {
    /// Units of the outputs.
    pub(super) outputs: Vec<Dimension>,
    /// Names of the bodies in the picture.
    pub(super) bodies: Vec<String>,
}

// Many fields: what the statements leave behind for those below them.
pub(super) struct Walk<'a> {
    pub(super) diagnostics: &'a mut Diagnostics,
    pub(super) unifier: Unifier,
    pub(super) values: HashMap<String, Units>,
    pub(super) functions: HashMap<String, (Vec<Name>, Expr)>,
    pub(super) frames: Vec<Vec<(String, Units)>>,
    pub(super) visited: usize,
    /// Where the last function was called.
    pub(super) called: Place,
    pub(super) coordinates: Vec<Name>,
    /// Unit of the Lagrangian.
    pub(super) energy: Dimension,
    pub(super) gaps: Vec<(String, Dimension)>,
    /// Sliding velocities with the surfaces that they belong to.
    pub(super) sliding: Vec<(Vec<Name>, Expr, Dimension)>,
    pub(super) constraints: Vec<Dimension>,
    pub(super) goals: Vec<Dimension>,
    pub(super) shown: Shown,
    /// Surfaces, and coordinates with a start value, whose units differ.
    pub(super) faulty: HashSet<String>,
    /// Numbers of which the sine, the cosine or the tangent is taken.
    pub(super) angles: Vec<(String, Expr)>,
    /// Names that are declared in rad.
    pub(super) radians: HashSet<String>,
    /// Joints, and how many equations each is.
    pub(super) joints: Vec<(String, usize)>,
    /// Joints that are equations between velocities.
    pub(super) rolling: HashSet<String>,
}

impl Walk<'_> {
    pub(super) fn named(&mut self, name: &Name) -> Dimension {
        match self.values.get(&name.text) {
            Some(Units::Scalar(dimension)) => dimension.clone(),
            _ => self.unifier.unknown(&name.text),
        }
    }

    pub(super) fn expect(
        &mut self,
        expr: &Expr,
        own: &Dimension,
        wanted: &Dimension,
        reason: &str,
    ) -> Checked<()> {
        self.expect_called(expr, (own, wanted), reason, ["", ""])
    }

    /// An expression has the wanted dimension, where a unit is usually called otherwise than it is shown: the one by the other.
    pub(super) fn expect_called(
        &mut self,
        expr: &Expr,
        (own, wanted): (&Dimension, &Dimension),
        reason: &str,
        [shown, called]: [&str; 2],
    ) -> Checked<()> {
        if self.unifier.unify(own, wanted) {
            return Ok(());
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
        let message = format!(
            "units differ: `{expr}` {is_in}, where {} is needed ({reason}){}",
            match call(self.unifier.show(wanted)).as_str() {
                "1" => "a pure number",
                unit => unit,
            },
            self.hint(&[(expr, wanted)])
        );
        Err(self.diagnostics.report("E03", expr.place, message))
    }

    /// An expression has the unit of what it belongs to.
    pub(super) fn fits(&mut self, expr: &Expr, wanted: &Dimension, reason: &str) -> Checked<()> {
        let own = self.scalar(expr)?;
        self.expect(expr, &own, wanted, reason)
    }

    /// An expression has the unit of what it belongs to, or is a bare number, which is meant in that unit.
    pub(super) fn given(&mut self, expr: &Expr, wanted: &Dimension, reason: &str) -> Checked<()> {
        match is_bare(expr) {
            true => Ok(()),
            false => self.fits(expr, wanted, reason),
        }
    }

    /// Two expressions with these units have the same one.
    pub(super) fn same(
        &mut self,
        place: Place,
        (left, own): (&Expr, &Dimension),
        (right, its): (&Expr, &Dimension),
        what: &str,
    ) -> Checked<()> {
        if self.unifier.unify(own, its) {
            return Ok(());
        }
        let message = format!(
            "units differ: `{left}` {}, `{right}` {}; {what} must agree{}",
            self.unifier.is_in(own),
            self.unifier.is_in(its),
            self.hint(&[(left, its), (right, own)])
        );
        Err(self.diagnostics.report("E03", place, message))
    }

    /// The unit that all of these have; `message` is what is said where two of them differ.
    fn common(
        &mut self,
        units: &[Dimension],
        place: Place,
        message: impl Fn(String, String) -> String,
    ) -> Checked<Dimension> {
        let first = units.first().ok_or(Reported)?;
        for own in units {
            if !self.unifier.unify(own, first) {
                let message = message(self.unifier.show(first), self.unifier.show(own));
                return Err(self.diagnostics.report("E03", place, message));
            }
        }
        Ok(first.clone())
    }

    /// The unit of a gap, so far.
    pub(super) fn gap(&self, surface: &str) -> Option<Dimension> {
        let gap = self.gaps.iter().find(|(name, _)| name == surface);
        gap.map(|(_, gap)| gap.clone())
    }

    /// What to write if a bare number is to blame: each expression with the unit that would fit.
    fn hint(&self, candidates: &[(&Expr, &Dimension)]) -> String {
        match candidates.iter().find(|(expr, _)| is_bare(expr)) {
            Some((expr, wanted)) => format!(
                "; a bare number has no unit, write it in brackets, as in `{expr} [{}]`",
                self.unifier.show(wanted)
            ),
            None => String::new(),
        }
    }

    pub(super) fn scalar(&mut self, expr: &Expr) -> Checked<Dimension> {
        match self.units(expr)? {
            Units::Scalar(dimension) => Ok(dimension),
            Units::Vector(_) | Units::Matrix(_) => Err(Reported),
        }
    }

    pub(super) fn pure(&mut self, expr: &Expr, function: &str) -> Checked<Dimension> {
        if matches!(function, "sin" | "cos" | "tan") && is_bare(expr) {
            self.angles.push((function.to_owned(), expr.clone()));
        }
        let own = self.scalar(expr)?;
        if self.unifier.unify(&own, &Dimension::one()) {
            return Ok(own);
        }
        let message = format!(
            "units differ: `{function}` needs a pure number, `{expr}` is in {}",
            self.unifier.show(&own)
        );
        Err(self.diagnostics.report("E03", expr.place, message))
    }

    pub(super) fn units(&mut self, expr: &Expr) -> Checked<Units> {
        // What grows beyond all bounds is reported where it is evaluated.
        self.visited += 1;
        if self.visited > BUDGET {
            return Err(Reported);
        }
        match &expr.kind {
            Kind::Number { value, unit, .. } => Ok(Units::Scalar(match unit {
                Some(written) => Dimension::of(written.unit),
                None if *value == 0.0 => self.unifier.unknown(""),
                None => Dimension::one(),
            })),
            Kind::Name(name) => Ok(self.name(name)),
            Kind::Negate(inner) => self.units(inner),
            Kind::Chain(first, rest) => self.chain(first, rest),
            Kind::Power { base, exponent, .. } => {
                let own = self.units(base);
                self.pure(exponent, "an exponent")?;
                let Units::Scalar(own) = own? else {
                    return Err(Reported);
                };
                match constant(exponent).and_then(Ratio::from_f64) {
                    Some(exponent) => Ok(Units::Scalar(own.power(exponent))),
                    None => {
                        let own = self.pure(base, "a power with a variable exponent")?;
                        Ok(Units::Scalar(own))
                    }
                }
            }
            Kind::Call {
                function,
                arguments,
            } => self.call(function, arguments),
            Kind::Derivative {
                function,
                order,
                argument,
            } => {
                let at = self.scalar(argument)?;
                let value = self.apply(function, vec![Units::Scalar(at.clone())])?;
                let divisor = at.power(Ratio::integer(i32::try_from(*order).unwrap_or(1)));
                Ok(value.map(|own| own.over(&divisor)))
            }
            Kind::Norm(inner) => self.norm(inner),
            Kind::Vector(items) => {
                let rows = items.iter().map(|item| self.units(item));
                let rows = rows.collect::<Checked<_>>()?;
                stacked(items, rows, self.diagnostics)
            }
            Kind::Component { vector, name } => {
                let units = self.units(vector)?;
                let components = units.components();
                let has = |name: &str| self.coordinates.iter().any(|known| known.text == name);
                let flat = has("x") && has("y") && !has("z");
                let index = match (components.len(), name.text.as_str()) {
                    (2 | 3, "x") => 0,
                    (2, "y") if flat => 1,
                    (2, "y") => 0,
                    (2, "z") | (3, "y") => 1,
                    (3, "z") => 2,
                    _ => {
                        let other = self.name(name);
                        return self.inner(expr, &units, &other);
                    }
                };
                Ok(Units::Scalar(components[index].clone()))
            }
            Kind::Profile { .. } => self.profile(expr),
            Kind::Index { vector, index } => self.units(vector)?.at(*index).ok_or(Reported),
        }
    }

    fn norm(&mut self, inner: &Expr) -> Checked<Units> {
        let units = self.units(inner)?;
        let message = |first, other| {
            format!(
                "units differ: the components of `{inner}` are in {first} and {other}, so they have \
                 no common length"
            )
        };
        let length = self.common(units.components(), inner.place, message);
        length.map(Units::Scalar)
    }

    fn name(&mut self, name: &Name) -> Units {
        let local = self
            .frames
            .last()
            .and_then(|frame| frame.iter().find(|(known, _)| *known == name.text));
        if let Some((_, units)) = local {
            return units.clone();
        }
        match self.values.get(&name.text) {
            Some(units) => units.clone(),
            None if name.text == "pi" => Units::Scalar(Dimension::one()),
            None if name.text == "t" || name.text == words::FINAL_TIME => {
                Units::Scalar(Dimension::second())
            }
            // Its own declaration has been reported.
            None => Units::Scalar(self.unifier.unknown(&name.text)),
        }
    }

    fn chain(&mut self, first: &Expr, rest: &[Link]) -> Checked<Units> {
        let mut total = self.units(first);
        // Terms that do not fit: those after them may fit these instead, and are no mistakes of their own.
        let mut strange: Vec<Units> = Vec::new();
        for (i, link) in rest.iter().enumerate() {
            let its = self.units(&link.operand);
            let left = Prefix {
                first,
                rest: &rest[..i],
            };
            total = match (total, its) {
                (Ok(own), Ok(its)) if link.operator.is_additive() => {
                    let fits = strange.iter().any(|known| self.agree(known, &its));
                    if !fits && self.step(&left, own.clone(), link, &its).is_err() {
                        strange.push(its);
                    }
                    Ok(own)
                }
                (Ok(own), Ok(its)) => self.step(&left, own, link, &its),
                _ => Err(Reported),
            };
        }
        if strange.is_empty() {
            total
        } else {
            Err(Reported)
        }
    }

    /// Whether components have the same units.
    fn agree(&mut self, own: &Units, its: &Units) -> bool {
        let pairs = own.components().iter().zip(its.components());
        own.components().len() == its.components().len()
            && pairs.into_iter().all(|(a, b)| self.unifier.unify(a, b))
    }

    /// One step of a chain: what is on the left of an operator, and what stands on its right.
    fn step(&mut self, left: &Prefix<'_>, own: Units, link: &Link, its: &Units) -> Checked<Units> {
        match link.operator {
            Operator::Add | Operator::Subtract => {
                for (a, b) in own.components().iter().zip(its.components()) {
                    if self.unifier.unify(a, b) {
                        continue;
                    }
                    // A bare number on the left is a whole side only where it stands alone.
                    let bare = left.rest.is_empty().then_some((left.first, b));
                    let candidates: Vec<_> = bare.into_iter().chain([(&link.operand, a)]).collect();
                    let message = format!(
                        "units differ: `{left}` {}, `{}` {}; both sides of `{}` must agree{}",
                        self.unifier.is_in(a),
                        link.operand,
                        self.unifier.is_in(b),
                        link.operator.symbol(),
                        self.hint(&candidates)
                    );
                    return Err(self.diagnostics.report("E03", link.place, message));
                }
                Ok(own)
            }
            Operator::Multiply => match (&own, its) {
                (Units::Scalar(a), _) => Ok(its.map(|b| a.times(b))),
                (_, Units::Scalar(b)) => Ok(own.map(|a| a.times(b))),
                (Units::Matrix(matrix), _) => self.matrix_product(left, matrix, link, its),
                (Units::Vector(_), _) => Err(Reported),
            },
            Operator::Divide => match its {
                Units::Scalar(b) => Ok(own.map(|a| a.over(b))),
                Units::Vector(_) | Units::Matrix(_) => Err(Reported),
            },
        }
    }

    fn call(&mut self, function: &Name, arguments: &[Expr]) -> Checked<Units> {
        let text = function.text.as_str();
        if self.functions.contains_key(text) {
            let mut units = Vec::with_capacity(arguments.len());
            for argument in arguments {
                units.push(self.units(argument)?);
            }
            return self.apply(function, units);
        }
        match (text, arguments) {
            ("dot", [argument]) => {
                let units = self.units(argument)?;
                Ok(units.map(|own| own.over(&Dimension::second())))
            }
            (words::INTEGRAL, [argument]) => {
                let own = self.scalar(argument)?;
                Ok(Units::Scalar(own.times(&Dimension::second())))
            }
            (words::SUM, [argument]) => self.scalar(argument).map(Units::Scalar),
            (words::START | words::PEAK | "abs", [argument]) => self.units(argument),
            ("dot", [left, right]) => {
                let (own, its) = (self.units(left)?, self.units(right)?);
                self.inner(left, &own, &its)
            }
            ("cross", [left, right]) => {
                let (own, its) = (self.units(left)?, self.units(right)?);
                let product = |a: usize, b: usize| -> Dimension {
                    own.components()[a].times(&its.components()[b])
                };
                match (own.components().len(), its.components().len()) {
                    (2, 2) => Ok(Units::Scalar(product(0, 1))),
                    (3, 3) => {
                        let pairs = [(1, 2), (2, 0), (0, 1)];
                        Ok(Units::Vector(pairs.map(|(a, b)| product(a, b)).into()))
                    }
                    _ => Err(Reported),
                }
            }
            ("atan2", [y, x]) => {
                let (own, its) = (self.scalar(y)?, self.scalar(x)?);
                let what = "both arguments of `atan2`";
                self.same(function.place(), (y, &own), (x, &its), what)?;
                Ok(Units::Scalar(Dimension::one()))
            }
            ("sqrt" | "cbrt", [argument]) => {
                let own = self.scalar(argument)?;
                let exponent = Ratio::new(1, if text == "sqrt" { 2 } else { 3 });
                Ok(Units::Scalar(own.power(exponent.unwrap_or(Ratio::ONE))))
            }
            (_, [argument]) if words::JUMPS.contains(&text) => {
                let argument = self.scalar(argument);
                argument.map(|_| Units::Scalar(Dimension::one()))
            }
            (words::IF, [left, right, yes, no]) => {
                self.extreme(function, left, std::slice::from_ref(right))?;
                self.extreme(function, yes, std::slice::from_ref(no))
            }
            ("max" | "min" | "clamp", [first, others @ ..]) => {
                self.extreme(function, first, others)
            }
            (_, [argument]) if words::FUNCTIONS.contains(&text) => {
                Ok(Units::Scalar(self.pure(argument, text)?))
            }
            (
                _,
                [
                    Expr {
                        kind: Kind::Name(surface),
                        ..
                    },
                ],
            ) if words::CONTACT_FUNCTIONS.contains(&text) => self.of_contact(text, &surface.text),
            _ if words::MATRIX_FUNCTIONS.contains(&text) => {
                self.matrix_function(function, arguments)
            }
            _ => Err(Reported),
        }
    }

    /// Units of a force or an impulse of a contact: a force does work on a change of the gap, an impulse is a force for a
    /// time.
    fn of_contact(&self, text: &str, surface: &str) -> Checked<Units> {
        let force = self.energy.over(&self.gap(surface).ok_or(Reported)?);
        if let Some((_, count)) = self.joints.iter().find(|(name, _)| name == surface)
            && *count > 1
        {
            return Ok(Units::Vector(vec![force; *count].into()));
        }
        Ok(Units::Scalar(match text {
            "force" | "friction_force" => force,
            _ => force.times(&Dimension::second()),
        }))
    }

    /// Units of the largest or smallest of some numbers.
    fn extreme(&mut self, function: &Name, first: &Expr, others: &[Expr]) -> Checked<Units> {
        let own = self.scalar(first)?;
        for other in others {
            let its = self.scalar(other)?;
            let what = format!("the arguments of `{}`", function.text);
            self.same(function.place(), (first, &own), (other, &its), &what)?;
        }
        Ok(Units::Scalar(own))
    }

    /// Units of a function given by points, whose argument has those of its points.
    fn profile(&mut self, expr: &Expr) -> Checked<Units> {
        let Kind::Profile {
            argument,
            argument_unit,
            value_unit,
            ..
        } = &expr.kind
        else {
            return Err(Reported);
        };
        let of = |unit: &Option<WrittenUnit>| {
            unit.as_ref()
                .map_or_else(Dimension::one, |unit| Dimension::of(unit.unit))
        };
        let Units::Scalar(own) = self.name(argument) else {
            return Err(Reported);
        };
        let wanted = of(argument_unit);
        if self.unifier.unify(&own, &wanted) {
            return Ok(Units::Scalar(of(value_unit)));
        }
        let message = format!(
            "units differ: the points of `{expr}` are in {}, its argument is in {}",
            self.unifier.show(&wanted),
            self.unifier.show(&own)
        );
        Err(self.diagnostics.report("E03", self.called, message))
    }

    fn inner(&mut self, whole: &Expr, left: &Units, right: &Units) -> Checked<Units> {
        let pairs = left.components().iter().zip(right.components());
        let products: Vec<Dimension> = pairs.map(|(a, b)| a.times(b)).collect();
        let message = |first, other| {
            format!("units differ: the terms of the inner product are in {first} and {other}")
        };
        let product = self.common(&products, whole.place, message);
        product.map(Units::Scalar)
    }

    fn apply(&mut self, function: &Name, units: Vec<Units>) -> Checked<Units> {
        // A function that uses itself has been reported.
        if self.frames.len() > MOST_CALLS {
            return Err(Reported);
        }
        let Some((arguments, body)) = self.functions.get(&function.text).cloned() else {
            return Err(Reported);
        };
        let frame = arguments
            .into_iter()
            .map(|argument| argument.text)
            .zip(units)
            .collect();
        self.frames.push(frame);
        self.called = function.place();
        let result = self.units(&body);
        self.frames.pop();
        result
    }

    /// Units of a product in which a matrix stands on the left of a vector or of another matrix.
    fn matrix_product(
        &mut self,
        left: &Prefix<'_>,
        own: &Matrix<Dimension>,
        link: &Link,
        its: &Units,
    ) -> Checked<Units> {
        let (place, factor) = (link.place, &link.operand);
        let message = |first, other| {
            format!(
                "units differ: the terms of the product `{left}*{factor}` are in {first} and {other}"
            )
        };
        let columns = match its {
            Units::Matrix(other) => other.columns,
            Units::Scalar(_) | Units::Vector(_) => 1,
        };
        let entries = own.products(its.components(), columns).map(|pairs| {
            let products: Vec<Dimension> = pairs.iter().map(|(a, b)| a.times(b)).collect();
            self.common(&products, place, message)
        });
        let entries: Vec<Dimension> = entries.collect::<Checked<_>>()?;
        Ok(match its {
            Units::Matrix(_) => Units::Matrix(Matrix::new(entries, columns)),
            Units::Scalar(_) | Units::Vector(_) => Units::Vector(entries.into()),
        })
    }

    /// Units of what the functions of matrices make.
    fn matrix_function(&mut self, function: &Name, arguments: &[Expr]) -> Checked<Units> {
        match (function.text.as_str(), arguments) {
            ("transpose", [argument]) => match self.units(argument)? {
                Units::Matrix(matrix) => Ok(Units::Matrix(matrix.transposed())),
                _ => Err(Reported),
            },
            ("diagonal", items) => {
                let n = items.len();
                // Zeros fit anywhere.
                let mut entries: Vec<Dimension> =
                    (0..n * n).map(|_| self.unifier.unknown("")).collect();
                for (i, item) in items.iter().enumerate() {
                    entries[i * n + i] = self.scalar(item)?;
                }
                Ok(Units::Matrix(Matrix::new(entries, n)))
            }
            (name, [angle]) => {
                self.pure(angle, name)?;
                let columns = if name == "rotation" { 2 } else { 3 };
                let entries = vec![Dimension::one(); columns * columns];
                Ok(Units::Matrix(Matrix::new(entries, columns)))
            }
            _ => Err(Reported),
        }
    }
}

/// The value of an expression made of numbers only.
pub(super) fn constant(expr: &Expr) -> Option<f64> {
    match &expr.kind {
        Kind::Number { value, unit, .. } => unit.is_none().then_some(*value),
        Kind::Negate(inner) => Some(-constant(inner)?),
        Kind::Chain(first, rest) => rest.iter().try_fold(constant(first)?, |a, link| {
            let b = constant(&link.operand)?;
            Some(match link.operator {
                Operator::Add => a + b,
                Operator::Subtract => a - b,
                Operator::Multiply => a * b,
                Operator::Divide => a / b,
            })
        }),
        Kind::Power { base, exponent, .. } => Some(constant(base)?.powf(constant(exponent)?)),
        _ => None,
    }
}
