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
    /// Whether some of the contacts slide along two directions.
    pub(super) in_space: bool,
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
            in_space: contacts.iter().any(|&i| view.is_in_space(i)),
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

    /// The line of the second tangent of a cone in space.
    pub(crate) fn across(&self, tangent: usize) -> Option<usize> {
        self.cones[tangent - self.contacts.len()].across
    }

    /// Whether one of the contacts that may stick slides with a lower coefficient of its own.
    pub(crate) fn breaks(&self) -> bool {
        self.cones.iter().any(|cone| cone.kinetic < cone.friction)
    }

    /// A contact that friction may push into the ground as much as its force lifts it, or more, with the [gain](View::gain) of
    /// its force: there may be no motion, or several (Painleve's paradox).
    pub(crate) fn jams(&self, view: &View<'_>) -> Option<(usize, f64)> {
        let mut contacts = self.contacts.iter().zip(&self.lines).enumerate();
        contacts.find_map(|(slot, (&i, &line))| {
            let mu = view.friction(i);
            let gain = match (self.tangent(slot), line) {
                (Some(_), _) => view.gain(i, mu).min(view.gain(i, -mu)),
                (None, Line::Normal { slope, .. }) if slope != 0.0 => view.gain(i, slope),
                (None, _) => return None,
            };
            (gain <= 0.0).then_some((i, gain))
        })
    }

    /// The switch that may slide and holds its zero the least, or pushes away from it: couplings of switches have no symmetry that would leave
    /// one motion.
    pub(crate) fn parting(&self, view: &View<'_>) -> Option<usize> {
        let switches = self
            .contacts
            .iter()
            .enumerate()
            .filter(|&(slot, &i)| view.switch_of(i).is_some() && self.tangent(slot).is_some());
        let holds = |i: usize| view.coupling(Line::tangent(i), Line::tangent(i));
        let switches = switches.map(|(_, &i)| i);
        switches.min_by(|&i, &j| holds(i).total_cmp(&holds(j)))
    }

    /// The problem of the law for lines that move by `offsets` without forces.
    pub(super) fn problem<'p>(&'p self, matrix: &'p [f64], offsets: &'p [f64]) -> Problem<'p> {
        Problem {
            matrix,
            offsets,
            cones: &self.cones,
            surfaces: self.surfaces,
            in_space: self.in_space,
        }
    }
}

/// Painleve's paradox in words: a contact whose [gain](View::gain) is zero or less.
pub(crate) fn jammed(view: &View<'_>, contact: usize, gain: f64) -> String {
    format!(
        "friction {} of `{}` pushes it into the ground as much as its force lifts it, 1 - mu |n'e| = {gain:.1e} \
         (Painleve); lower the friction or change the geometry",
        view.friction(contact),
        view.model.declaration().contacts[contact].name,
    )
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
