//! Units of whole statements.

use super::{Units, Walk};
use crate::ast::{
    Assignment, Condition, Expr, FreeStart, Kind, Law, Name, Quantity, Scene, Statement,
};
use crate::check::values::is_bare;
use crate::diagnostics::{Checked, Reported};
use crate::dimension::Dimension;

impl Walk<'_> {
    pub(super) fn declare(&mut self, scene: &Scene) {
        for statement in &scene.statements {
            let (Statement::Parameters(list)
            | Statement::Coordinates(list)
            | Statement::Controls(list)) = statement
            else {
                continue;
            };
            if matches!(statement, Statement::Coordinates(_)) {
                self.coordinates
                    .extend(list.iter().map(|quantity| quantity.name.clone()));
            }
            for quantity in list {
                let dimension = match &quantity.unit {
                    Some(written) => Dimension::of(written.unit),
                    None => self.unifier.unknown(&quantity.name.text),
                };
                self.values
                    .insert(quantity.name.text.clone(), Units::Scalar(dimension));
            }
        }
    }

    pub(super) fn statement(&mut self, statement: &Statement) -> Checked<()> {
        match statement {
            Statement::Parameters(list)
            | Statement::Coordinates(list)
            | Statement::Controls(list) => {
                for quantity in list {
                    let _: Checked<()> = self.quantity(quantity);
                }
                Ok(())
            }
            Statement::Let { name, value } => {
                let units = self.units(value)?;
                self.values.insert(name.text.clone(), units);
                Ok(())
            }
            Statement::Function {
                name,
                arguments,
                body,
            } => {
                self.functions
                    .insert(name.text.clone(), (arguments.clone(), body.clone()));
                Ok(())
            }
            Statement::Lagrangian { value, .. } => {
                let own = self.scalar(value)?;
                let energy = self.energy.clone();
                self.unifier.unify(&own, &energy);
                Ok(())
            }
            Statement::Dissipation { value, .. } => {
                let own = self.scalar(value)?;
                let wanted = self.energy.over(&Dimension::second());
                self.expect(value, &own, &wanted, "the dissipation is a power")
            }
            Statement::Forces(assignments) => {
                for assignment in assignments {
                    let _: Checked<()> = self.force(assignment);
                }
                Ok(())
            }
            Statement::Surface {
                name, left, right, ..
            } => self.surface(name, left, right),
            Statement::Impact { surfaces, law } => self.law(surfaces, law),
            Statement::Minimize { value, .. } => self.scalar(value).map(|_| ()),
            Statement::Constraint { name, condition } => {
                let what = format!("both sides of constraint `{}`", name.text);
                let own = self.condition(condition, &what)?;
                self.constraints.push(own);
                Ok(())
            }
            Statement::Finally(goals) => {
                for goal in goals {
                    if let Ok(own) = self.condition(goal, "both sides of a terminal condition") {
                        self.goals.push(own);
                    }
                }
                Ok(())
            }
            Statement::Free(values) => {
                for value in values {
                    let _: Checked<()> = self.free(value);
                }
                Ok(())
            }
            Statement::Start(assignments) => {
                for assignment in assignments {
                    let _: Checked<()> = self.start(assignment);
                }
                Ok(())
            }
            Statement::Horizon { value, .. } if is_bare(value) => Ok(()),
            Statement::Horizon { value, .. } => {
                let own = self.scalar(value)?;
                self.expect(value, &own, &Dimension::second(), "the horizon is a time")
            }
        }
    }

    fn surface(&mut self, name: &Name, left: &Expr, right: &Expr) -> Checked<()> {
        let (own, its) = (self.scalar(left), self.scalar(right));
        let (own, its) = (own?, its?);
        if !self.unifier.unify(&own, &its) {
            return Err(self.differ(
                left.place.to(right.place),
                (left, &own),
                (right, &its),
                &format!("both sides of surface `{}`", name.text),
            ));
        }
        self.gaps.push((name.text.clone(), own));
        Ok(())
    }

    fn quantity(&mut self, quantity: &Quantity) -> Checked<()> {
        let wanted = self.named(&quantity.name);
        let mut exprs: Vec<&Expr> = quantity.value.iter().collect();
        if let Some((lower, upper)) = &quantity.bounds {
            exprs.extend([lower, upper]);
        }
        for expr in exprs {
            if is_bare(expr) {
                continue;
            }
            let own = self.scalar(expr)?;
            self.expect(
                expr,
                &own,
                &wanted,
                &format!("`{}` is declared so", quantity.name.text),
            )?;
        }
        Ok(())
    }

    fn force(&mut self, assignment: &Assignment) -> Checked<()> {
        if !self
            .coordinates
            .iter()
            .any(|known| known.text == assignment.target.text)
        {
            return Err(Reported);
        }
        let own = self.scalar(&assignment.value)?;
        let coordinate = self.named(&assignment.target);
        let wanted = self.energy.over(&coordinate);
        self.expect(
            &assignment.value,
            &own,
            &wanted,
            &format!(
                "a force on `{}` is the Lagrangian's unit over that of the coordinate",
                assignment.target.text
            ),
        )
    }

    fn start(&mut self, assignment: &Assignment) -> Checked<()> {
        if is_bare(&assignment.value) {
            return Ok(());
        }
        let own = self.scalar(&assignment.value)?;
        let (wanted, shown) = self.of_target(&assignment.target, assignment.velocity);
        self.expect(
            &assignment.value,
            &own,
            &wanted,
            &format!("it is the start value of `{shown}`"),
        )
    }

    /// Components of an impulse direction are displacements of the coordinates, up to one factor.
    fn direction(&mut self, direction: &Expr) -> Checked<()> {
        let Kind::Vector(items) = &direction.kind else {
            self.units(direction)?;
            return Ok(());
        };
        let coordinates: Vec<Name> = self.coordinates.clone();
        let mut first: Option<(Dimension, &Expr)> = None;
        for (item, coordinate) in items.iter().zip(&coordinates) {
            let own = self.scalar(item)?;
            let relative = own.over(&self.named(coordinate));
            match &first {
                None => first = Some((relative, item)),
                Some((known, _)) => {
                    let wanted = known.times(&self.named(coordinate));
                    self.expect(
                        item,
                        &own,
                        &wanted,
                        &format!(
                            "components of an impulse direction are proportional to displacements, \
                             here of `{}`",
                            coordinate.text
                        ),
                    )?;
                }
            }
        }
        Ok(())
    }

    /// Unit of the difference of both sides.
    fn condition(&mut self, condition: &Condition, what: &str) -> Checked<Dimension> {
        let (left, right) = (&condition.left, &condition.right);
        let (own, its) = (self.scalar(left), self.scalar(right));
        let (own, its) = (own?, its?);
        if self.unifier.unify(&own, &its) {
            return Ok(own);
        }
        let place = left.place.to(right.place);
        Err(self.differ(place, (left, &own), (right, &its), what))
    }

    fn free(&mut self, value: &FreeStart) -> Checked<()> {
        let Some((lower, upper)) = &value.bounds else {
            return Ok(());
        };
        let (wanted, shown) = self.of_target(&value.target, value.velocity);
        for expr in [lower, upper] {
            if !is_bare(expr) {
                let own = self.scalar(expr)?;
                self.expect(expr, &own, &wanted, &format!("it bounds `{shown}`"))?;
            }
        }
        Ok(())
    }

    /// Unit and name of a coordinate or a velocity.
    fn of_target(&mut self, target: &Name, velocity: bool) -> (Dimension, String) {
        let own = self.named(target);
        if velocity {
            (
                own.over(&Dimension::second()),
                format!("dot({})", target.text),
            )
        } else {
            (own, target.text.clone())
        }
    }

    fn law(&mut self, surfaces: &[Name], law: &Law) -> Checked<()> {
        for (coefficient, of) in [
            (&law.restitution, "restitution"),
            (&law.friction, "friction"),
        ] {
            let Some(expr) = coefficient else { continue };
            let Ok(own) = self.scalar(expr) else { continue };
            let reason = format!("a coefficient of {of} is a ratio");
            let _: Checked<()> = self.expect(expr, &own, &Dimension::one(), &reason);
        }
        if let Some(expr) = &law.sliding
            && let Ok(own) = self.scalar(expr)
        {
            self.sliding.push((surfaces.to_vec(), expr.clone(), own));
        }
        match &law.along {
            Some(direction) => self.direction(direction),
            None => Ok(()),
        }
    }

    /// Sliding velocities are measured like the gaps, over seconds.
    pub(super) fn sliding_velocities(&mut self) {
        for (surfaces, expr, own) in std::mem::take(&mut self.sliding) {
            for surface in surfaces {
                let gap = self
                    .gaps
                    .iter()
                    .find(|(name, _)| *name == surface.text)
                    .map(|(_, gap)| gap.clone());
                let Some(gap) = gap else { continue };
                let wanted = gap.over(&Dimension::second());
                let reason = format!(
                    "the sliding velocity of `{}` has the unit of its gap over s",
                    surface.text
                );
                let _: Checked<()> = self.expect(&expr, &own, &wanted, &reason);
            }
        }
    }
}
