//! Contacts that touch: the lines on which their forces are sought.

use super::line::Line;
use super::problem::{Cone, Problem};
use super::view::View;

/// The lines of contacts that touch: their normals, then the tangents of those that may stick, each with a cone, then the second
/// tangents of those in space. What slides already is part of its normal.
#[derive(Debug, Clone)]
pub(crate) struct Touching {
    pub(crate) contacts: Vec<usize>,
    pub(crate) lines: Vec<Line>,
    cones: Vec<Cone>,
    /// Number of contacts that may open; the others, behind them, are dry friction.
    surfaces: usize,
}

impl Touching {
    /// Of the `contacts`, of which those with friction for which `in_cone` holds are at rest along their tangents.
    pub(crate) fn new(
        view: &View<'_>,
        contacts: &[usize],
        in_cone: impl Fn(usize) -> bool,
    ) -> Self {
        let (mut lines, mut tangents, mut cones) = (Vec::new(), Vec::new(), Vec::new());
        let mut acrosses = Vec::new();
        for (normal, &contact) in contacts.iter().enumerate() {
            let mut slope = 0.0;
            if view.has_friction(contact) && in_cone(contact) {
                tangents.push(Line::tangent(contact));
                if view.is_in_space(contact) {
                    acrosses.push((cones.len(), Line::Across { contact }));
                }
                cones.push(cone(view, contact, normal));
            } else if view.has_friction(contact) {
                slope = -view.kinetic(contact) * view.side(contact).signum();
            }
            lines.push(Line::Normal { contact, slope });
        }
        lines.extend(tangents);
        add_acrosses(&mut lines, &mut cones, acrosses);
        Self {
            surfaces: contacts.iter().filter(|&&i| !view.is_dry(i)).count(),
            contacts: contacts.to_vec(),
            lines,
            cones,
        }
    }

    /// The line of the tangent of the `k`-th contact, where its friction has a cone.
    pub(crate) fn tangent(&self, k: usize) -> Option<usize> {
        let cone = self.cones.iter().position(|cone| cone.normal == k);
        cone.map(|cone| self.contacts.len() + cone)
    }

    /// The components of `values` along both tangents of a cone; the second is 0 in the plane.
    pub(crate) fn both(&self, tangent: usize, values: &[f64]) -> (f64, f64) {
        let cone = &self.cones[tangent - self.contacts.len()];
        let across = cone.across.map_or(0.0, |across| values[across]);
        (values[tangent], across)
    }

    /// Whether one of the contacts that may stick slides with a lower coefficient of its own.
    pub(crate) fn breaks(&self) -> bool {
        self.cones.iter().any(|cone| cone.kinetic < cone.friction)
    }

    /// The problem of the law for lines that move by `offsets` without forces.
    pub(super) fn problem<'p>(&'p self, matrix: &'p [f64], offsets: &'p [f64]) -> Problem<'p> {
        Problem {
            matrix,
            offsets,
            cones: &self.cones,
            surfaces: self.surfaces,
        }
    }
}

/// The law of a contact with friction whose normal is the line `normal`.
pub(crate) fn cone(view: &View<'_>, contact: usize, normal: usize) -> Cone {
    let (friction, kinetic) = view.frictions(contact);
    Cone {
        normal,
        friction,
        kinetic,
        across: None,
    }
}

/// Adds the lines of the second tangents of some cones.
pub(crate) fn add_acrosses(
    lines: &mut Vec<Line>,
    cones: &mut [Cone],
    acrosses: Vec<(usize, Line)>,
) {
    for (cone, line) in acrosses {
        cones[cone].across = Some(lines.len());
        lines.push(line);
    }
}
