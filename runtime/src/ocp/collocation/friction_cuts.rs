//! Friction between the stages: forces stay in their cones, slipping contacts do not slip back.

use super::dense_motion::{DenseMotion, lows};
use super::layout::{Cut, CutKind, Phase};
use super::limits::Limits;
use crate::model::tangent_point;
use crate::simulation::{ContactMode, Direction};

/// Places between the stages where a sticking contact's force leaves the friction cone, or a slipping contact slips
/// back. What the solver leaves of an active row is let pass; where sliding sets in without an acceleration, what
/// is let pass of a gap.
pub(in crate::ocp) fn friction(motion: &DenseMotion, limits: Limits) -> Vec<Cut> {
    let mut found = Vec::new();
    for (index, phase) in motion.program.phases.iter().enumerate() {
        let cut = |theta: f64, kind: CutKind| Cut {
            interval: phase.interval,
            phase: phase.index,
            theta,
            kind,
        };
        for (contact, mode) in phase.modes.iter().enumerate() {
            match *mode {
                ContactMode::Stick if phase.settles(contact) => {}
                ContactMode::Stick => {
                    for direction in Direction::BOTH {
                        let tolerance = limits.bound * largest_force(motion, phase, contact);
                        let mut reserve = |_: usize, theta: f64| {
                            reserve(motion, phase, contact, direction, theta)
                        };
                        let lows = lows(&[index], &mut reserve, -tolerance, tolerance);
                        let kind = CutKind::Cone(contact, direction);
                        found.extend(lows.iter().map(|low| cut(low.1, kind)));
                    }
                }
                ContactMode::Slip(direction) => {
                    let yielded = phase.yielded.contains(&contact);
                    let tolerance = if yielded { limits.gap } else { limits.bound };
                    let tolerance = tolerance * limits.setting.units.gap_rows[contact];
                    let mut velocity = sliding(motion, contact, direction);
                    let lows = lows(&[index], &mut velocity, -tolerance, tolerance);
                    found.extend(lows.iter().map(|low| cut(low.1, CutKind::Slip(contact))));
                    let last = index + 1 == motion.program.phases.len();
                    if last && velocity(index, 1.0) < -tolerance {
                        found.push(cut(1.0, CutKind::Slip(contact)));
                    }
                }
                ContactMode::Open | ContactMode::Frictionless => {}
            }
        }
    }
    found
}

/// Sliding velocity of a contact in the direction in which it slips.
fn sliding<'m>(
    motion: &'m DenseMotion,
    contact: usize,
    direction: Direction,
) -> impl FnMut(usize, f64) -> f64 + 'm {
    let model = motion.program.model;
    let declaration = model.declaration();
    let n = declaration.coordinates.len();
    let mut input = vec![0.0; declaration.inputs()];
    let mut point = vec![0.0; tangent_point::length(n)];
    move |phase, theta| {
        motion.write(phase, theta, &mut input);
        model.tangent(contact, &input, &mut point);
        direction.sign() * point[tangent_point::SLIDING_VELOCITY]
    }
}

/// The coefficient of friction of a contact, which may be an unknown.
fn coefficient(motion: &DenseMotion, contact: usize) -> f64 {
    let found = motion.program.program.laws().friction(contact);
    found.map_or_else(|| motion.program.model.friction(contact), |mu| motion.x[mu])
}

/// `mu r + sigma s` of a sticking contact inside a phase.
fn reserve(
    motion: &DenseMotion,
    phase: &Phase,
    contact: usize,
    direction: Direction,
    theta: f64,
) -> f64 {
    let mut weights = vec![0.0; phase.stages.len()];
    motion.program.tableau.lagrange_values(theta, &mut weights);
    let mu = coefficient(motion, contact);
    let stages = phase.stages.iter().zip(weights);
    stages
        .flat_map(|(stage, weight)| stage.tangential.iter().map(move |t| (t, weight)))
        .filter(|(tangential, _)| tangential.contact == contact)
        .filter_map(|(tangential, weight)| Some((tangential.normal, tangential.force?, weight)))
        .map(|(r, s, weight)| weight * (mu * motion.x[r] + direction.sign() * motion.x[s]))
        .sum()
}

/// The largest `mu r` of a contact at the stages of a phase, at least the smallest positive number.
fn largest_force(motion: &DenseMotion, phase: &Phase, contact: usize) -> f64 {
    let mu = coefficient(motion, contact);
    let tangential = phase.stages.iter().flat_map(|stage| &stage.tangential);
    let own = tangential.filter(|tangential| tangential.contact == contact);
    own.map(|tangential| mu * motion.x[tangential.normal])
        .fold(f64::MIN_POSITIVE, f64::max)
}
