//! Bounds of coordinates and path constraints of a scene, as functions that must not be below zero.

use super::discretization::Setting;
use crate::model::held::complete_largest;
use crate::model::{Function, Model};

/// A bound and its function.
pub(in crate::ocp) struct Bound {
    pub(in crate::ocp) name: &'static str,
    pub(in crate::ocp) unit: &'static str,
    pub(in crate::ocp) kind: BoundKind,
}

/// What a bound is of.
#[derive(Clone, Copy, PartialEq)]
pub(in crate::ocp) enum BoundKind {
    /// A coordinate, with its bounds.
    Coordinate(usize, (f64, f64)),
    /// A path constraint, which may be an equality.
    Path(usize, bool),
}

/// All bounds of a scene.
pub(in crate::ocp) struct Bounds<'a> {
    model: &'a dyn Model,
    pub(in crate::ocp) all: Vec<Bound>,
    /// Place of the first path constraint among path functions.
    first: usize,
}

impl<'a> Bounds<'a> {
    pub(in crate::ocp) fn new(setting: Setting<'a>) -> Self {
        let declaration = setting.model.declaration();
        let declared = declaration.optimal_control;
        let coordinates = declaration.coordinates.iter().enumerate();
        let coordinates = coordinates.map(|(k, known)| {
            let bounds = (setting.bounds.0[k], setting.bounds.1[k]);
            (known.name, known.unit, BoundKind::Coordinate(k, bounds))
        });
        let none = (f64::NEG_INFINITY, f64::INFINITY);
        let coordinates = coordinates.filter(
            |(_, _, kind)| !matches!(kind, BoundKind::Coordinate(_, bounds) if *bounds == none),
        );
        let constraints = declared.map_or(&[][..], |declared| declared.constraints);
        let constraints = constraints.iter().enumerate();
        let constraints = constraints
            .map(|(i, known)| (known.name, known.unit, BoundKind::Path(i, known.equality)));
        let all = coordinates.chain(constraints);
        Self {
            model: setting.model,
            all: all
                .map(|(name, unit, kind)| Bound { name, unit, kind })
                .collect(),
            first: declared.map_or(0, |declared| usize::from(declared.running_cost)),
        }
    }

    /// The values of their functions where path functions read this, apart from largest values of an instant; minus the amount of an equality.
    pub(in crate::ocp) fn values(&self, mut x: Vec<f64>) -> Vec<f64> {
        let declared = self.model.declaration().optimal_control;
        let mut functions = vec![0.0; declared.map_or(0, |declared| declared.path_functions())];
        if functions.len() > self.first {
            complete_largest(self.model, &mut x);
            self.model.values(Function::Path, &x, &mut functions);
        }
        let value = |bound: &Bound| match bound.kind {
            BoundKind::Coordinate(k, (lower, upper)) => (x[k] - lower).min(upper - x[k]),
            BoundKind::Path(i, true) => -functions[self.first + i].abs(),
            BoundKind::Path(i, false) => functions[self.first + i],
        };
        self.all.iter().map(value).collect()
    }

    /// Whether the function of a bound reads forces of contacts.
    pub(in crate::ocp) fn reads_forces(&self, bound: &Bound) -> bool {
        let declaration = self.model.declaration();
        let declared = declaration.optimal_control;
        let reads = |i| {
            declared.is_some_and(|d| d.path_jacobian.reads(self.first + i, declaration.inputs()))
        };
        matches!(bound.kind, BoundKind::Path(i, _) if reads(i))
    }
}
