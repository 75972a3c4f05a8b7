//! The state at the end of an element.

use super::{ElementError, FiniteElement, MAX_ITERATIONS};
use crate::joints::JointError;
use crate::linalg::dense;
use crate::linalg::least_norm::LeastNorm;
use crate::linalg::products::products;

/// The end state, moved onto the joints, and then along the surfaces that are held.
pub(super) fn finish(element: &mut FiniteElement<'_>) -> Result<(), ElementError> {
    finish_stages(element)?;
    let Some(mut joints) = element.joints.take() else {
        return Ok(());
    };
    let n = element.n;
    let mut x = element.stage_input(element.tableau.stages() - 1).to_vec();
    element.write_time(element.end.time, &mut x);
    x[..n].copy_from_slice(&element.end.q);
    x[n..2 * n].copy_from_slice(&element.end.v);
    let moved = joints.settle(&mut x, element.length);
    element.joints = Some(joints);
    moved.map_err(|error| match error {
        JointError::Singular => ElementError::Singular,
        JointError::NotClosed => ElementError::NotFinite,
    })?;
    element.end.q.copy_from_slice(&x[..n]);
    element.end.v.copy_from_slice(&x[n..2 * n]);
    if element.active().is_empty() {
        Ok(())
    } else {
        project_end(element)
    }
}

/// The end state of the scheme; without a stage at the end of the element it is projected on the constraints, which
/// is the boundary variable of the scheme and restores its order (Ascher, Petzold 1991).
fn finish_stages(element: &mut FiniteElement<'_>) -> Result<(), ElementError> {
    let n = element.n;
    let stages = element.tableau.stages();
    element.end.time = element.start.time + element.length;
    if element.tableau.stiffly_accurate() {
        let last = &element.inputs_of_stages[(stages - 1) * element.inputs..];
        element.end.q.copy_from_slice(&last[..n]);
        element.end.v.copy_from_slice(&last[n..2 * n]);
        return Ok(());
    }
    let block = element.block();
    let multipliers = n + element.constraints.count();
    if element.clock.is_slowed() {
        let mut x = element.stage_input(0).to_vec();
        element.interpolate(1.0, element.tableau.b(), &mut x);
        element.end.q.copy_from_slice(&x[..n]);
        element.end.v.copy_from_slice(&x[n..2 * n]);
        return project_end(element);
    }
    for k in 0..n {
        let (mut first, mut second) = (0.0, 0.0);
        for j in 0..stages {
            let unknown = &element.unknowns[j * block..(j + 1) * block];
            first += element.tableau.b()[j] * unknown[k];
            second += element.tableau.b_times_a()[j] * unknown[k];
            for (i, eta) in unknown[multipliers..].iter().enumerate() {
                second += element.tableau.b()[j] * eta * element.corrections[i * n + k];
            }
        }
        let h = element.length;
        element.end.v[k] = element.start.v[k] + h * first;
        element.end.q[k] = element.start.q[k] + h * (element.start.v[k] + h * second);
    }
    if !element.active().is_empty() || element.constraints.count() > 0 {
        project_end(element)?;
    }
    Ok(())
}

/// Number of forces from which on products with their directions are sums over what does not vanish. Chosen: below, finding it takes as long.
const MANY: usize = 16;

/// Moves the end state onto `g = 0`, `v_n = 0`, and `v_t = 0` where a contact sticks, along the directions
/// of the forces.
fn project_end(element: &mut FiniteElement<'_>) -> Result<(), ElementError> {
    let (n, forces) = (element.n, element.constraints.count());
    let mut x = element.stage_input(element.tableau.stages() - 1).to_vec();
    element.write_time(element.end.time, &mut x);
    let mut matrix = vec![0.0; forces * forces];
    let mut pivots = vec![0; forces];
    let mut shift = vec![0.0; forces];
    for iteration in 0..MAX_ITERATIONS {
        x[..n].copy_from_slice(&element.end.q);
        x[n..2 * n].copy_from_slice(&element.end.v);
        element.constraints.evaluate(&x);
        let constraints = &element.constraints;
        let gap = constraints.gaps.iter().fold(0.0_f64, |g, v| g.max(v.abs()));
        for i in 0..forces {
            if constraints.is_given(i) {
                // Nothing is held: no shift.
                matrix[i * forces..(i + 1) * forces].fill(0.0);
                matrix[i * forces + i] = 1.0;
                continue;
            }
            if forces >= MANY {
                continue;
            }
            for j in 0..forces {
                let gradient = &constraints.gradients[i * n..(i + 1) * n];
                let direction = &constraints.directions[j * n..(j + 1) * n];
                matrix[i * forces + j] = gradient.iter().zip(direction).map(|(a, b)| a * b).sum();
            }
        }
        if forces >= MANY {
            let held = |row: &usize| !constraints.is_given(*row);
            for row in (0..forces).filter(held) {
                matrix[row * forces..(row + 1) * forces].fill(0.0);
            }
            let products = products(&constraints.gradients, &constraints.directions, n);
            for (row, column, value) in products {
                if held(&row) {
                    matrix[row * forces + column] = value;
                }
            }
        }
        let couplings = matrix.clone();
        let independent = dense::factorize_independent(&mut matrix, &mut pivots);
        let solve = |right: &mut [f64]| {
            if independent {
                dense::solve(&matrix, &pivots, right);
                return Ok(());
            }
            let known = LeastNorm::of(&couplings, forces).ok_or(ElementError::Singular)?;
            right.copy_from_slice(&known.solve(right).0);
            Ok(())
        };
        if gap <= 4.0 * constraints.gap_rounding || iteration + 1 == MAX_ITERATIONS {
            shift.copy_from_slice(&constraints.velocities);
            shift[constraints.normals..constraints.active().len()].fill(0.0);
            solve(&mut shift)?;
            subtract(&constraints.directions, &shift, &mut element.end.v);
            return Ok(());
        }
        shift.fill(0.0);
        for (number, gap) in constraints.gaps.iter().enumerate() {
            shift[number] = *gap;
        }
        solve(&mut shift)?;
        subtract(&constraints.directions, &shift, &mut element.end.q);
    }
    Ok(())
}

/// Subtracts `shift` along `directions`, one row each, from `target`.
fn subtract(directions: &[f64], shift: &[f64], target: &mut [f64]) {
    for (direction, value) in directions.chunks_exact(target.len()).zip(shift) {
        for (component, d) in target.iter_mut().zip(direction) {
            *component -= d * value;
        }
    }
}
