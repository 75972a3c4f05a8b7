//! States changed until they are consistent.

use super::problem::{Problem, Tangent};
use super::state::ContactState;
use crate::linalg::dense;

/// Share of its own coupling that each line gets more of in the linear systems, so that those of redundant contacts
/// have a solution; what it does is taken out again by the proximal point method.
const PROXIMAL: f64 = 1e-8;
/// Steps of that method; with independent contacts the second meets rounding error.
const REFINEMENTS: usize = 8;
/// Changes of all inconsistent states at once that do not make them fewer, before they are changed one at a time.
const PATIENCE: usize = 4;
/// Most changes: so many, and so many for each contact. One at a time may take more, and Lemke's method follows.
const CHANGES: (usize, usize) = (20, 6);
/// Share of the step before above which a step of the proximal point method gains nothing.
const STALLED: f64 = 0.5;

/// The linear system of some states.
pub(super) struct Equations {
    /// The lines whose force is unknown and whose motion vanishes, increasing.
    pub(super) unknown: Vec<usize>,
    /// Row-major, order `unknown.len()`.
    pub(super) matrix: Vec<f64>,
    /// `-q`.
    pub(super) right: Vec<f64>,
}

impl Equations {
    /// Of the `states`; the force of a contact that slips acts along its normal and its tangent.
    pub(super) fn of(
        problem: &Problem<'_>,
        tangents: &[Option<Tangent>],
        states: &[ContactState],
    ) -> Self {
        let (mut unknown, mut sticking) = (Vec::new(), Vec::new());
        for (i, state) in states.iter().enumerate() {
            if *state != ContactState::Open {
                unknown.push(i);
            }
            if let (ContactState::Stick, Some(Tangent { line: tangent, .. })) = (state, tangents[i])
            {
                sticking.push(tangent);
            }
        }
        sticking.sort_unstable();
        unknown.extend(sticking);
        let mut matrix = Vec::with_capacity(unknown.len() * unknown.len());
        for &row in &unknown {
            for &column in &unknown {
                let own = problem.coupling(row, column);
                let slope = states
                    .get(column)
                    .map_or(0.0, |state| slope(*state, tangents[column]));
                matrix.push(match tangents.get(column) {
                    Some(&Some(tangent)) if slope != 0.0 => {
                        own + slope * problem.coupling(row, tangent.line)
                    }
                    _ => own,
                });
            }
        }
        let right = unknown.iter().map(|&line| -problem.offsets[line]).collect();
        Self {
            unknown,
            matrix,
            right,
        }
    }

    /// The smallest solution, nearly: by the proximal point method from 0. `None` where a number is not finite.
    fn solve(&self, problem: &Problem<'_>) -> Option<Vec<f64>> {
        let order = self.unknown.len();
        let mut factors = self.matrix.clone();
        for (k, &line) in self.unknown.iter().enumerate() {
            factors[k * order + k] += PROXIMAL * problem.coupling(line, line).abs().max(PROXIMAL);
        }
        let mut pivots = vec![0; order];
        dense::factorize(&mut factors, &mut pivots).ok()?;
        let mut x = vec![0.0; order];
        let mut last = f64::INFINITY;
        for _ in 0..REFINEMENTS {
            let mut step = self.residual(&x);
            dense::solve(&factors, &pivots, &mut step);
            let size = step.iter().fold(0.0_f64, |most, step| most.max(step.abs()));
            if !size.is_finite() {
                return None;
            }
            // Of contradictory equations the multipliers grow by the same amount each time: the signs are known.
            if size == 0.0 || size > STALLED * last {
                break;
            }
            last = size;
            for (x, step) in x.iter_mut().zip(&step) {
                *x += step;
            }
        }
        Some(x)
    }

    /// `-q - K x`.
    pub(super) fn residual(&self, x: &[f64]) -> Vec<f64> {
        let rows = self.matrix.chunks_exact(x.len().max(1));
        let products = rows.map(|row| row.iter().zip(x).map(|(a, x)| a * x).sum::<f64>());
        let pairs = self.right.iter().zip(products);
        pairs.map(|(right, product)| right - product).collect()
    }
}

/// Tangential force of a contact for one unit of its normal force, unless that is an unknown of its own.
pub(super) fn slope(state: ContactState, tangent: Option<Tangent>) -> f64 {
    tangent.map_or(0.0, |tangent| {
        state.force_ratio((tangent.friction, tangent.kinetic))
    })
}

/// Forces of all lines from those of the unknown ones.
pub(super) fn forces_of(
    problem: &Problem<'_>,
    tangents: &[Option<Tangent>],
    states: &[ContactState],
    (unknown, x): (&[usize], &[f64]),
) -> Vec<f64> {
    let mut forces = vec![0.0; problem.lines()];
    for (&line, &x) in unknown.iter().zip(x) {
        forces[line] = x;
        if let Some(&state) = states.get(line)
            && let Some(tangent) = tangents[line]
            && state != ContactState::Stick
        {
            forces[tangent.line] = slope(state, tangents[line]) * x;
        }
    }
    forces
}

/// The state that the law wants of a contact with these forces in its present one; `None` where it is consistent.
fn wanted(
    problem: &Problem<'_>,
    contact: usize,
    tangent: Option<Tangent>,
    state: ContactState,
    (forces, motions): (&[f64], &[(f64, f64)]),
) -> Option<ContactState> {
    let (normal, zero) = motions[contact];
    let own = |line: usize| {
        let own = problem.coupling(line, line);
        if own > 0.0 { own } else { 1.0 }
    };
    if state == ContactState::Open {
        if normal >= -zero {
            return None;
        }
        let Some(Tangent { line, friction, .. }) = tangent else {
            return Some(ContactState::Frictionless);
        };
        let (slip, _) = motions[line];
        let inside = (slip / own(line)).abs() <= friction * -normal / own(contact);
        return Some(if inside {
            ContactState::Stick
        } else {
            ContactState::slip(slip)
        });
    }
    let p = forces[contact];
    if p < -problem.zero_force(contact, zero) {
        return Some(ContactState::Open);
    }
    let Tangent { line, friction, .. } = tangent?;
    let (slip, zero) = motions[line];
    match state {
        ContactState::Stick => {
            let s = forces[line];
            let over = s.abs() > friction * p.max(0.0) + problem.zero_force(line, zero);
            over.then(|| ContactState::slip(-s))
        }
        ContactState::Slip(direction) if direction.sign() * slip < -zero => {
            let reverses = slip.abs() > 2.0 * friction * p * own(line);
            Some(if reverses {
                ContactState::Slip(direction.reversed())
            } else {
                ContactState::Stick
            })
        }
        _ => None,
    }
}

/// States that the forces of their equations do not contradict, from `states` on, with these forces; `None` where that
/// does not end.
pub(super) fn consistent(
    problem: &Problem<'_>,
    tangents: &[Option<Tangent>],
    mut states: Vec<ContactState>,
) -> Option<(Vec<ContactState>, Vec<f64>)> {
    let mut fewest = usize::MAX;
    let mut patience = PATIENCE;
    for _ in 0..CHANGES.0 + CHANGES.1 * states.len() {
        let equations = Equations::of(problem, tangents, &states);
        let x = equations.solve(problem)?;
        let forces = forces_of(problem, tangents, &states, (&equations.unknown, &x));
        let motions = problem.motions(&forces);
        let changes: Vec<(usize, ContactState)> = (0..states.len())
            .filter_map(|i| {
                let known = (&forces[..], &motions[..]);
                let wanted = wanted(problem, i, tangents[i], states[i], known);
                wanted.map(|state| (i, state))
            })
            .collect();
        if changes.is_empty() {
            return Some((states, forces));
        }
        if changes.len() < fewest {
            fewest = changes.len();
            patience = PATIENCE;
        } else {
            patience = patience.saturating_sub(1);
        }
        // One at a time, always that with the largest index: no state comes back (Murty).
        let taken = if patience > 0 { 0 } else { changes.len() - 1 };
        for &(i, state) in &changes[taken..] {
            states[i] = state;
        }
    }
    None
}
