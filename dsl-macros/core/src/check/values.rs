//! Numbers of the declaration: defaults, bounds, start, horizon; and the formulas of the dynamics.

use super::Checker;
use crate::ast::{Assignment, Expr, Kind, Name, Quantity, WrittenUnit};
use crate::diagnostics::{Checked, Place, Reported, closest, list};
use crate::evaluate::unrepresentable;
use crate::graph::{self, Compose, Sym, Variable};
use crate::scene::{self, Coordinate};

impl Checker<'_> {
    /// The default of a parameter, in its declared unit: a constant expression. Without a unit of its
    /// own it is meant in the declared one.
    pub(super) fn default_value(
        &mut self,
        name: &Name,
        value: &Expr,
        unit: Option<&WrittenUnit>,
    ) -> Checked<f64> {
        let sym = self.in_declared_unit(value, unit)?;
        match sym.as_number() {
            Some(value) => Ok(value),
            None => Err(self.diagnostics.syntax(
                value.place,
                format!(
                    "the default of parameter `{}` must be a number; abbreviations of other \
                     parameters belong to `let`",
                    name.text
                ),
            )),
        }
    }

    /// An expression as a number in a declared unit: bare numbers are in that unit already, anything
    /// else is in SI units and converted.
    fn in_declared_unit(&mut self, expr: &Expr, unit: Option<&WrittenUnit>) -> Checked<Sym> {
        let value = self.scope.scalar(expr, self.diagnostics)?;
        if is_bare(expr) {
            return Ok(value);
        }
        let value = value.scaled(1.0 / scene::scale(unit));
        match graph::take_fault() {
            Some(fault) => Err(unrepresentable(fault, expr, self.diagnostics)),
            None => Ok(value),
        }
    }

    /// Bounds of coordinates or controls.
    pub(super) fn bounds(&mut self, quantities: &[Quantity], control: bool) -> Checked<()> {
        for quantity in quantities {
            let known = self.known(control);
            let index = known
                .iter()
                .position(|known| known.name.text == quantity.name.text);
            let (Some(index), Some(bounds)) = (index, &quantity.bounds) else {
                continue;
            };
            let (name, unit) = (&quantity.name.text, quantity.unit.as_ref());
            let Ok(range) = self.range(bounds, unit, name) else {
                continue;
            };
            self.known(control)[index].bounds = Some(range);
        }
        Ok(())
    }

    /// E17: bounds in the declared unit. A unit behind the upper bound is meant for both: `0.3..=0.5 [m]`.
    pub(super) fn range(
        &mut self,
        (lower, upper): &(Expr, Expr),
        unit: Option<&WrittenUnit>,
        name: &str,
    ) -> Checked<(Sym, Sym)> {
        let shared = match own_unit(upper) {
            Some(shared) if is_bare(lower) => shared.unit.scale / scene::scale(unit),
            _ => 1.0,
        };
        let what = format!("a bound of `{name}`");
        let mut bound = |expr: &Expr, factor: f64| {
            let sym = self.in_declared_unit(expr, unit)?.scaled(factor);
            if let Some(fault) = graph::take_fault() {
                return Err(unrepresentable(fault, expr, self.diagnostics));
            }
            self.constant(sym, expr, &what)
        };
        let (low, high) = (bound(lower, shared), bound(upper, 1.0));
        let (low, high) = (low?, high?);
        if let (Some(least), Some(most)) = (low.as_number(), high.as_number())
            && least > most
        {
            return Err(self.diagnostics.report(
                "E17",
                lower.place.to(upper.place),
                format!(
                    "lower bound {least} of `{name}` lies above its upper bound {most}; exchange them"
                ),
            ));
        }
        Ok((low, high))
    }

    fn known(&mut self, control: bool) -> &mut Vec<Coordinate> {
        if control {
            &mut self.controls
        } else {
            &mut self.coordinates
        }
    }

    /// A value that may depend on parameters only.
    pub(super) fn constant(&mut self, sym: Sym, expr: &Expr, what: &str) -> Checked<Sym> {
        let moving = graph::variables(&[sym])
            .into_iter()
            .find(|variable| !matches!(variable, Variable::Parameter(_)));
        match moving {
            None => Ok(sym),
            Some(variable) => Err(self.diagnostics.syntax(
                expr.place,
                format!(
                    "{what} depends on {}; it may depend on parameters only",
                    self.in_words(variable)
                ),
            )),
        }
    }

    pub(super) fn lagrangian(&mut self, keyword: Place, expr: &Expr) -> Checked<()> {
        let value = self.scope.scalar(expr, self.diagnostics)?;
        if self.lagrangian.is_some() {
            return Err(self.diagnostics.syntax(
                keyword,
                "a scene has one `lagrangian`; add the terms up in it",
            ));
        }
        if let Some(variable) = graph::variables(&[value])
            .into_iter()
            .find(|variable| matches!(variable, Variable::Control(_)))
        {
            return Err(self.diagnostics.syntax(
                expr.place,
                format!(
                    "the Lagrangian depends on {}; a control acts through `forces {{ ... }}`",
                    self.in_words(variable)
                ),
            ));
        }
        super::rules::smooth(value, expr, self)?;
        self.lagrangian = Some((value, keyword));
        Ok(())
    }

    pub(super) fn dissipation(&mut self, keyword: Place, expr: &Expr) -> Checked<()> {
        let value = self.scope.scalar(expr, self.diagnostics)?;
        if self.dissipation.is_some() {
            return Err(self.diagnostics.syntax(
                keyword,
                "a scene has one `dissipation`; add the terms up in it",
            ));
        }
        if !graph::depends_on(value, |variable| matches!(variable, Variable::Velocity(_))) {
            return Err(self.diagnostics.report(
                "E04",
                expr.place,
                "the dissipation contains no velocity; write e.g. `c/2*dot(y)^2` for a damper",
            ));
        }
        super::rules::smooth(value, expr, self)?;
        self.damping_is_not_negative(value, expr)?;
        self.dissipation = Some(value);
        Ok(())
    }

    /// E10: where damping is a constant for the defaults of the parameters, it takes energy out.
    fn damping_is_not_negative(&mut self, dissipation: Sym, expr: &Expr) -> Checked<()> {
        for (i, coordinate) in self.coordinates.iter().enumerate() {
            let velocity = Variable::Velocity(i as u16);
            let slope = graph::partial(&[dissipation], velocity);
            let damping = graph::partial(&slope, velocity)[0];
            if self.at_default(damping).is_some_and(|value| value < 0.0) {
                let message = format!(
                    "the dissipation is negative: with the defaults of the parameters it feeds energy into \
                     `dot({})`; a damper is written with a plus sign, as in `c/2*dot(y)^2`",
                    coordinate.name.text
                );
                return Err(self.diagnostics.report("E10", expr.place, message));
            }
        }
        Ok(())
    }

    pub(super) fn forces(&mut self, assignments: &[Assignment]) -> Checked<()> {
        for assignment in assignments {
            let value = self.scope.scalar(&assignment.value, self.diagnostics);
            let (Ok(index), Ok(value)) = (self.coordinate_index(&assignment.target), value) else {
                continue;
            };
            if assignment.velocity {
                self.diagnostics.syntax(
                    assignment.target.place(),
                    format!(
                        "a force acts on a coordinate; write `{}: ...`",
                        assignment.target.text
                    ),
                );
                continue;
            }
            self.forces.push((index, value));
        }
        Ok(())
    }

    pub(super) fn coordinate_index(&mut self, name: &Name) -> Checked<usize> {
        if let Some(index) = self
            .coordinates
            .iter()
            .position(|known| known.name.text == name.text)
        {
            return Ok(index);
        }
        let names: Vec<String> = self
            .coordinates
            .iter()
            .map(|known| known.name.text.clone())
            .collect();
        let names = || names.iter().map(String::as_str);
        let message = if self.scope.names.contains_key(&name.text) {
            format!(
                "`{}` is not a coordinate (coordinates: {})",
                name.text,
                list(names())
            )
        } else {
            match closest(&name.text, names()) {
                Some(near) => format!("`{}` is not declared; did you mean `{near}`?", name.text),
                None => format!(
                    "`{}` is not declared (coordinates: {})",
                    name.text,
                    list(names())
                ),
            }
        };
        Err(self.diagnostics.report("E01", name.place(), message))
    }

    pub(super) fn start_statement(&mut self, assignments: &[Assignment]) -> Checked<()> {
        self.start.extend_from_slice(assignments);
        Ok(())
    }

    /// Initial coordinates and velocities in declared units.
    pub(super) fn start_values(&mut self) -> Checked<(Vec<Sym>, Vec<Sym>)> {
        let n = self.coordinates.len();
        let mut values: Vec<Option<(Sym, Place)>> = vec![None; 2 * n];
        let mut failed = false;
        for assignment in std::mem::take(&mut self.start) {
            let index = self.coordinate_index(&assignment.target);
            let Ok(index) = index else {
                failed = true;
                continue;
            };
            let unit = self.coordinates[index].unit.clone();
            let name = &assignment.target.text;
            let shown = if assignment.velocity {
                format!("dot({name})")
            } else {
                name.clone()
            };
            let value = self
                .in_declared_unit(&assignment.value, unit.as_ref())
                .and_then(|sym| {
                    self.constant(
                        sym,
                        &assignment.value,
                        &format!("the start value of `{shown}`"),
                    )
                });
            let Ok(value) = value else {
                failed = true;
                continue;
            };
            let place = assignment.value.place;
            if !assignment.velocity
                && let Some(bounds) = self.coordinates[index].bounds
            {
                self.within(value, bounds, place, name);
            }
            let slot = index + if assignment.velocity { n } else { 0 };
            if values[slot].replace((value, place)).is_some() {
                self.diagnostics.syntax(
                    assignment.target.place(),
                    format!("`{shown}` has two start values; keep one"),
                );
                failed = true;
            }
        }
        if failed {
            return Err(Reported);
        }
        let known: Vec<(Sym, Option<Place>)> = values
            .into_iter()
            .map(|value| value.map_or((Sym::ZERO, None), |(value, place)| (value, Some(place))))
            .collect();
        self.free_start_within_bounds(&known);
        let mut values: Vec<Sym> = known.into_iter().map(|(value, _)| value).collect();
        let velocities = values.split_off(n);
        Ok((values, velocities))
    }

    /// The number that a value is for the defaults of the parameters.
    pub(super) fn at_default(&self, value: Sym) -> Option<f64> {
        let defaults: Vec<f64> = self.parameters.iter().map(|known| known.default).collect();
        graph::substitute(&[value], |variable| match variable {
            Variable::Parameter(i) => defaults.get(usize::from(i)).map(|&v| Sym::number(v)),
            _ => None,
        })[0]
            .as_number()
    }

    /// E17: a start value lies between bounds, for the defaults of the parameters.
    pub(super) fn within(&mut self, value: Sym, bounds: (Sym, Sym), place: Place, shown: &str) {
        let (Some(low), Some(high), Some(value)) = (
            self.at_default(bounds.0),
            self.at_default(bounds.1),
            self.at_default(value),
        ) else {
            return;
        };
        if !(low..=high).contains(&value) {
            self.diagnostics.report(
                "E17",
                place,
                format!("`{shown}` starts at {value}, outside its bounds {low}..={high}"),
            );
        }
    }

    pub(super) fn horizon(&mut self, keyword: Place, expr: &Expr) -> Checked<()> {
        let value = self.scope.scalar(expr, self.diagnostics)?;
        let value = self.constant(value, expr, "the horizon")?;
        if self.horizon.is_some() {
            return Err(self
                .diagnostics
                .syntax(keyword, "a scene has one `horizon`; keep one"));
        }
        if let Some(value) = value.as_number()
            && value <= 0.0
        {
            return Err(self.diagnostics.syntax(
                expr.place,
                format!("the horizon is {value} s; it must be above 0"),
            ));
        }
        self.horizon = Some(value);
        Ok(())
    }
}

/// The unit of a number that carries one, possibly with a sign.
fn own_unit(expr: &Expr) -> Option<&WrittenUnit> {
    match &expr.kind {
        Kind::Number { unit, .. } => unit.as_ref(),
        Kind::Negate(inner) => own_unit(inner),
        _ => None,
    }
}

/// Whether an expression is a number without unit, possibly with sign and arithmetic: such a number is
/// meant in the unit of the declaration it belongs to.
pub(crate) fn is_bare(expr: &Expr) -> bool {
    match &expr.kind {
        Kind::Number { unit, .. } => unit.is_none(),
        Kind::Name(name) => name.text == "pi",
        Kind::Negate(inner) => is_bare(inner),
        Kind::Chain(..) => expr.children().into_iter().all(is_bare),
        _ => false,
    }
}
