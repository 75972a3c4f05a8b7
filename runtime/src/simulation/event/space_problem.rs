//! The complementarity problem of closed contacts some of which are in space, by the method for cones.

use super::coulomb::{CoulombSolution, TangentialLaw};
use super::dynamics::{Dynamics, dot};
use crate::contact::{self, Cone, solve_in_space};
use crate::contact::{ContactState, Direction};
use crate::model::pair_size;

/// Share of its bound within which a friction is at it, and motions are none beside the largest offset.
const AT_BOUND: f64 = 1e-10;

/// One line of the problem: a covector, and a direction of the force.
struct Line<'d> {
    covector: &'d [f64],
    direction: Vec<f64>,
    offset: f64,
}

/// Closed contacts, as last evaluated, with what their velocities (or accelerations) are without contact forces, one a contact.
pub(super) struct SpaceProblem<'a> {
    pub(super) contacts: &'a [usize],
    pub(super) normal: &'a [f64],
    pub(super) tangential: &'a [f64],
    pub(super) across: &'a [f64],
    pub(super) laws: &'a [TangentialLaw],
}

/// Solves the problem; `None` where no solution is found.
pub(super) fn solve(
    problem: &SpaceProblem<'_>,
    dynamics: &Dynamics<'_>,
) -> Option<CoulombSolution> {
    let m = problem.contacts.len();
    let (lines, cones) = lines(problem, dynamics);
    let mut matrix = Vec::with_capacity(lines.len() * lines.len());
    for (row, own) in lines.iter().enumerate() {
        let dry = row < m && dynamics.is_dry(problem.contacts[row]);
        for (column, other) in lines.iter().enumerate() {
            matrix.push(if dry && column < m {
                {
                    let line = |slot: usize| contact::Line::normal(problem.contacts[slot]);
                    dynamics.coupling(line(row), line(column))
                }
            } else {
                dot(own.covector, &other.direction)
            });
        }
    }
    let offsets: Vec<f64> = lines.iter().map(|line| line.offset).collect();
    let mut forces = vec![0.0; lines.len()];
    if !solve_in_space(&matrix, &offsets, &cones, &mut forces) {
        return None;
    }
    let rows = matrix.chunks_exact(lines.len()).zip(&offsets);
    let motions: Vec<f64> = rows
        .map(|(row, offset)| offset + dot(row, &forces))
        .collect();
    Some(told(problem, dynamics, &cones, (&forces, &motions)))
}

/// Normals, then first tangents, then second ones, and the cones.
fn lines<'d>(problem: &SpaceProblem<'_>, dynamics: &'d Dynamics<'_>) -> (Vec<Line<'d>>, Vec<Cone>) {
    let (mut normals, mut firsts, mut seconds, mut cones) = (vec![], vec![], vec![], vec![]);
    for (slot, (&i, &law)) in problem.contacts.iter().zip(problem.laws).enumerate() {
        let mut direction = dynamics.direction(i).to_vec();
        if let TangentialLaw::Sliding(mu, sense) = law {
            for (d, e) in direction.iter_mut().zip(dynamics.slip_direction(i)) {
                *d -= sense.sign() * mu * e;
            }
        }
        normals.push(Line {
            covector: dynamics.normal(i),
            direction,
            offset: problem.normal[slot],
        });
        if !law.may_stick() {
            continue;
        }
        let (friction, kinetic) = law.coefficients();
        firsts.push(Line {
            covector: dynamics.tangent(i),
            direction: dynamics.friction_direction(i).to_vec(),
            offset: problem.tangential[slot],
        });
        let across = dynamics.is_in_space(i).then(|| {
            let line = contact::Line::Across { contact: i };
            let (covector, direction) = (dynamics.row(line).0, dynamics.line_direction(line));
            seconds.push(Line {
                covector,
                direction: direction.to_vec(),
                offset: problem.across[slot],
            });
            seconds.len() - 1
        });
        cones.push(Cone {
            normal: slot,
            friction,
            kinetic,
            across,
        });
    }
    for cone in &mut cones {
        cone.across = cone.across.map(|k| normals.len() + firsts.len() + k);
    }
    normals.append(&mut firsts);
    normals.append(&mut seconds);
    (normals, cones)
}

/// The solution in the words of the enumeration.
fn told(
    problem: &SpaceProblem<'_>,
    dynamics: &Dynamics<'_>,
    cones: &[Cone],
    (forces, motions): (&[f64], &[f64]),
) -> CoulombSolution {
    let m = problem.contacts.len();
    let mut solution = CoulombSolution {
        states: vec![ContactState::Open; m],
        p: forces[..m].iter().map(|p| p.max(0.0)).collect(),
        s: vec![0.0; m],
        normal: vec![0.0; m],
        tangential: vec![0.0; m],
        across: vec![(0.0, 0.0); m],
    };
    for (slot, &motion) in motions[..m].iter().enumerate() {
        let p = solution.p[slot];
        let opens = p == 0.0 && !dynamics.is_dry(problem.contacts[slot]);
        if opens {
            solution.normal[slot] = motion;
        }
        solution.states[slot] = match problem.laws[slot] {
            _ if opens => ContactState::Open,
            TangentialLaw::None => ContactState::Frictionless,
            TangentialLaw::Sliding(mu, sense) => {
                solution.s[slot] = -sense.sign() * mu * p;
                ContactState::Slip(sense)
            }
            TangentialLaw::Coulomb(_) | TangentialLaw::Breaking { .. } => ContactState::Stick,
        };
    }
    for (k, cone) in cones.iter().enumerate() {
        let (slot, line) = (cone.normal, m + k);
        let second = |values: &[f64]| cone.across.map_or(0.0, |line| values[line]);
        let friction = (forces[line], second(forces));
        let motion = (motions[line], second(motions));
        let bound = cone.friction * solution.p[slot];
        (solution.s[slot], solution.across[slot].0) = friction;
        if pair_size(friction) < (1.0 - AT_BOUND) * bound {
            continue;
        }
        (solution.tangential[slot], solution.across[slot].1) = motion;
        if solution.states[slot] == ContactState::Stick {
            let forward = cone.across.is_some() || motion.0 >= 0.0;
            let direction = if forward {
                Direction::Forward
            } else {
                Direction::Backward
            };
            solution.states[slot] = ContactState::Slip(direction);
        }
    }
    solution
}
