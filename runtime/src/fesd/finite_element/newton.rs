//! Newton's method for one element.

use super::{
    ElementError, FiniteElement, MAX_ITERATIONS, State, assembly, end, largest, numerical_time,
};
use crate::linalg::banded::Unfactorized;
use crate::linalg::dense;
use crate::model::ControlPiece;
use crate::rk::ButcherTableau;
use crate::yardstick;

/// Relative change of the state that ends Newton's method.
const CONVERGED: f64 = 2e-16;
/// Residual beyond which that before a last step says nothing of what is left after it: of forces that act on nothing, as of the bound of a
/// condition that sets something, which no change of the state shows.
const BEFORE_THE_STEP: f64 = 1e-6;
/// Rounding error of the gaps, as a relative change, above which it hides the convergence.
const HIDDEN: f64 = 10.0 * yardstick::ROUNDING;
/// Contraction below which an iteration in numerical time goes on.
const CONTRACTS: f64 = 0.1;
/// Contraction above which the Jacobian is evaluated anew.
const SLOW: f64 = 0.05;
/// That contraction of stages that share one Jacobian, and the iterations after which these count as not converged.
const SLOW_APART: f64 = 0.2;
const ITERATIONS_APART: usize = 25;
/// Unknowns of an element from which on its matrix is looked at for a band, and share of the largest entry of a column up to which a pivot
/// counts as zero, as in [`dense`]. Chosen: below, factors take as long either way.
const LARGE: usize = 160;
const SINGULAR: f64 = 1e-14;
/// Most times longer than the previous element that an element may be to be predicted from it.
const MOST_GROWTH: f64 = 16.0;

/// Solves the element of length `h` from `start` under `controls`; the end state is in `end`.
pub(crate) fn solve(
    element: &mut FiniteElement<'_>,
    start: &State,
    h: f64,
    controls: &ControlPiece,
) -> Result<(), ElementError> {
    element.start.copy_from(start);
    if (h - element.length).abs() > 0.2 * h {
        element.factorized = false;
    }
    element.length = h;
    element.constraints.set_length(h);
    // What a much shorter element says of its rates is rounding error, multiplied.
    element.has_previous &= h <= MOST_GROWTH * element.previous_length;
    element.controls.clone_from(controls);
    let place = element.place_of_controls();
    for (stage, c) in element
        .inputs_of_stages
        .chunks_exact_mut(element.inputs)
        .zip(element.tableau.c())
    {
        controls.write(start.time + c * h, &mut stage[place.clone()]);
    }
    evaluate_start(element);
    predict(element, h);
    let predicted = element.has_previous;
    let apart = takes_apart(element);
    let mut outcome = iterate(element, apart);
    if outcome.is_err() {
        element.factorized = false;
        if predicted {
            // The prediction may have led astray.
            element.has_previous = false;
            evaluate_start(element);
            predict(element, h);
            outcome = iterate(element, apart);
        }
    }
    if apart && outcome.is_err() {
        // Derivatives that change so much need those of each stage.
        element.has_previous = false;
        evaluate_start(element);
        predict(element, h);
        outcome = iterate(element, false);
    }
    outcome?;
    if numerical_time::adapt(element) {
        element.factorized = false;
        iterate(element, false)?;
    }
    end::finish(element)?;
    element.previous.clone_from(&element.unknowns);
    element.previous_length = h;
    element.has_previous = true;
    Ok(())
}

/// Starts from the previous element's stage polynomials, extrapolated, or else from the free
/// acceleration at the start.
fn predict(element: &mut FiniteElement<'_>, h: f64) {
    let stages = element.tableau.stages();
    let block = element.block();
    if !element.has_previous {
        for stage in element.unknowns.chunks_exact_mut(block) {
            stage[..element.n].copy_from_slice(&element.acceleration);
            stage[element.n..].fill(0.0);
        }
        return;
    }
    let continues = element.start.time >= element.end.time - 0.5 * element.previous_length;
    let offset = if continues { 1.0 } else { 0.0 };
    let mut values = [0.0; ButcherTableau::MAX_STAGES];
    for m in 0..stages {
        // Extrapolating far beyond the previous element does more harm than good.
        let theta = (offset + element.tableau.c()[m] * h / element.previous_length).min(2.0);
        element
            .tableau
            .lagrange_values(theta, &mut values[..stages]);
        for k in 0..block {
            element.unknowns[m * block + k] = (0..stages)
                .map(|j| values[j] * element.previous[j * block + k])
                .sum();
        }
    }
}

/// Evaluates the directions of the position corrections, and the free acceleration at the start where no
/// previous element helps.
fn evaluate_start(element: &mut FiniteElement<'_>) {
    if element.constraints.count() == 0 && element.active().is_empty() && element.has_previous {
        return;
    }
    let n = element.n;
    let mut first = std::mem::take(&mut element.first);
    let controls = element.place_of_controls();
    first[controls.clone()].copy_from_slice(&element.stage_input(0)[controls]);
    first[..n].copy_from_slice(&element.start.q);
    first[n..2 * n].copy_from_slice(&element.start.v);
    element.write_time(element.start.time, &mut first);
    if !element.has_previous {
        element
            .model
            .free_acceleration(&first, &mut element.acceleration);
    }
    element.constraints.align(&first);
    element.constraints.evaluate(&first);
    element.constraints.find_redundancy();
    element.first = first;
    for (row, correction) in element.corrections.chunks_exact_mut(n).enumerate() {
        let direction = &element.constraints.directions[row * n..(row + 1) * n];
        correction.copy_from_slice(direction);
    }
}

/// Whether stages may share a Jacobian: with joints, and nothing else that has unknowns of its own.
fn takes_apart(element: &FiniteElement<'_>) -> bool {
    let free = element.constraints.count() == 0 && element.active().is_empty();
    free && element.decoupled.is_some() && !element.clock.is_slowed()
}

/// Evaluates and factorizes the matrix of the present stages, all at once or `apart`.
fn factorize(element: &mut FiniteElement<'_>, apart: bool) -> Result<(), ElementError> {
    if let Some(mut decoupled) = element.decoupled.take_if(|_| apart) {
        let nodes = element.tableau.c().iter().enumerate();
        let from_middle = |c: &f64| (c - 0.5).abs();
        let middle = nodes.min_by(|a, b| from_middle(a.1).total_cmp(&from_middle(b.1)));
        assembly::evaluate_stage_jacobian(element, middle.map_or(0, |(stage, _)| stage));
        let (h, n) = (element.length, element.n);
        let regular = decoupled.factorize(h, &element.by_q, &element.by_v, n);
        element.decoupled = Some(decoupled);
        if !regular {
            return Err(ElementError::Singular);
        }
    } else {
        assembly::assemble(element);
        if !factorize_band(element)? {
            dense::factorize(&mut element.matrix, &mut element.pivots)
                .map_err(|_| ElementError::Singular)?;
        }
    }
    element.counts.factorizations += 1;
    (element.factorized, element.apart) = (true, apart);
    Ok(())
}

/// Factorizes the matrix of a large element by its band, if it has a narrow one.
fn factorize_band(element: &mut FiniteElement<'_>) -> Result<bool, ElementError> {
    let size = element.residual.len();
    element.is_banded = false;
    if size < LARGE {
        return Ok(false);
    }
    element.entries.clear();
    for (row, values) in element.matrix.chunks_exact(size).enumerate() {
        let columns = values.iter().enumerate();
        let kept = columns.filter(|(_, value)| **value != 0.0);
        let kept = kept.map(|(column, value)| (row, column, *value));
        element.entries.extend(kept);
    }
    match element.band.factorize(size, &element.entries, SINGULAR) {
        Ok(()) => element.is_banded = true,
        Err(Unfactorized::Singular) => return Err(ElementError::Singular),
        Err(Unfactorized::Wide) => {}
    }
    Ok(element.is_banded)
}

/// Simplified Newton iterations: the factors, those of stages taken `apart` or of all, are kept as long as they contract well.
fn iterate(element: &mut FiniteElement<'_>, apart: bool) -> Result<(), ElementError> {
    let (mut last_change, mut last_forces) = (f64::INFINITY, f64::INFINITY);
    let (most, slow) = if apart {
        (ITERATIONS_APART, SLOW_APART)
    } else {
        (MAX_ITERATIONS, SLOW)
    };
    element.factorized &= element.apart == apart;
    for iteration in 0..most {
        evaluate_residual(element).map_err(|error| {
            // Far from its start the iteration diverged; that says nothing of the model.
            if iteration <= 1 {
                error
            } else {
                ElementError::NotConverged
            }
        })?;
        let free = element.constraints.count() == 0 && element.active().is_empty();
        if iteration == 0 && free && is_solved(element) {
            // The prediction already satisfies the stage equations (constant acceleration).
            return Ok(());
        }
        if !element.factorized {
            factorize(element, apart)?;
        }
        match &element.decoupled {
            Some(decoupled) if apart => decoupled.solve(&mut element.residual, element.n),
            _ if element.is_banded => element.band.solve(&mut element.residual),
            _ => dense::solve(&element.matrix, &element.pivots, &mut element.residual),
        }
        for (unknown, step) in element.unknowns.iter_mut().zip(&element.residual) {
            *unknown -= step;
        }
        element.counts.iterations += 1;
        let change = relative_change(element);
        if !change.is_finite() {
            return Err(ElementError::NotConverged);
        }
        let contraction = change / last_change;
        let states = change <= CONVERGED
            || (iteration > 0 && contraction < 1.0 && change * contraction <= 0.1 * CONVERGED)
            || (change <= yardstick::ROUNDING && contraction >= 0.3)
            || (change <= rounding_of_gaps(element) && !still_contracts(element, contraction));
        // Where contacts hold all coordinates, the states are known before the forces are.
        let forces = relative_change_of_forces(element);
        if states && (forces <= yardstick::NOTHING || forces >= 0.3 * last_forces) {
            if element.residual_norm > BEFORE_THE_STEP {
                // What is reported is what is left, and not what the last step has taken away.
                return evaluate_residual(element);
            }
            update_stages(element);
            return Ok(());
        }
        if contraction > slow {
            element.factorized = false;
        }
        (last_change, last_forces) = (change, forces);
    }
    Err(ElementError::NotConverged)
}

/// Whether the stage residual is at the rounding error of the accelerations.
fn is_solved(element: &FiniteElement<'_>) -> bool {
    element
        .residual
        .iter()
        .zip(&element.unknowns)
        .all(|(residual, unknown)| residual.abs() <= 4.0 * f64::EPSILON * unknown.abs())
}

/// Stage states from the unknowns.
fn update_stages(element: &mut FiniteElement<'_>) {
    if element.clock.is_slowed() {
        numerical_time::update_stages(element);
        return;
    }
    let (n, h, block) = (element.n, element.length, element.block());
    let multipliers = n + element.constraints.count();
    let stages = element.tableau.stages();
    for m in 0..stages {
        let x = &mut element.inputs_of_stages[m * element.inputs..(m + 1) * element.inputs];
        let c = element.tableau.c()[m];
        for k in 0..n {
            let (mut first, mut second, mut correction) = (0.0, 0.0, 0.0);
            for j in 0..stages {
                let unknown = &element.unknowns[j * block..(j + 1) * block];
                let a = element.tableau.a(m, j);
                first += a * unknown[k];
                second += element.tableau.a_squared(m, j) * unknown[k];
                for (i, eta) in unknown[multipliers..].iter().enumerate() {
                    correction += a * eta * element.corrections[i * n + k];
                }
            }
            x[n + k] = element.start.v[k] + h * first;
            x[k] = element.start.q[k] + h * (c * element.start.v[k] + h * (second + correction));
        }
        if element.model.declaration().explicit_time {
            x[element.inputs - 1] = element.start.time + c * h;
        }
    }
}

/// Residuals of all stages: `A - a - sum d r - sum e s`, `v_n / h` or `r - D f`, `v_t / h`, `g / h^2`.
fn evaluate_residual(element: &mut FiniteElement<'_>) -> Result<(), ElementError> {
    update_stages(element);
    let (n, h, block, forces) = (
        element.n,
        element.length,
        element.block(),
        element.constraints.count(),
    );
    element.residual_norm = 0.0;
    element.acceleration_scale = 0.0;
    element.gap_rounding = 0.0;
    for m in 0..element.tableau.stages() {
        let x = &element.inputs_of_stages[m * element.inputs..(m + 1) * element.inputs];
        element
            .model
            .free_acceleration(x, &mut element.acceleration);
        element.counts.evaluations += 1;
        let unknown = &element.unknowns[m * block..(m + 1) * block];
        let residual = &mut element.residual[m * block..(m + 1) * block];
        for k in 0..n {
            residual[k] = unknown[k] - element.acceleration[k];
            element.acceleration_scale = element
                .acceleration_scale
                .max(element.acceleration[k].abs());
        }
        element.constraints.evaluate(x);
        element.gap_rounding = element.gap_rounding.max(element.constraints.gap_rounding);
        for (i, direction) in element.constraints.directions.chunks_exact(n).enumerate() {
            for k in 0..n {
                let force = direction[k] * unknown[n + i];
                residual[k] -= force;
                element.acceleration_scale = element.acceleration_scale.max(force.abs());
            }
            residual[n + i] = if element.constraints.is_given(i) {
                unknown[n + i] - element.constraints.velocities[i]
            } else {
                element.constraints.velocities[i] / h
            };
        }
        for &(given, surface, factor) in &element.constraints.loads {
            residual[n + given] -= factor * unknown[n + surface];
        }
        for (target, gap) in residual[n + forces..]
            .iter_mut()
            .zip(&element.constraints.gaps)
        {
            *target = gap / (h * h);
        }
        element.constraints.turn_redundancy();
        let [of_velocities, of_positions] = &element.constraints.redundancy;
        let (own, positions) = unknown[n..].split_at(forces);
        of_velocities.add(own, &mut residual[n..n + forces]);
        of_positions.add(positions, &mut residual[n + forces..]);
        for value in residual {
            if !value.is_finite() {
                return Err(ElementError::NotFinite);
            }
            element.residual_norm = element.residual_norm.max(h * value.abs());
        }
    }
    Ok(())
}

/// Relative change of the stage states that the rounding errors of the gaps cause, where it hides the
/// convergence: far from the origin, and in short elements.
fn rounding_of_gaps(element: &FiniteElement<'_>) -> f64 {
    let rounding = 8.0 * element.gap_rounding / (element.length * element.speed());
    if rounding > HIDDEN { rounding } else { 0.0 }
}

/// Whether an iteration that gaps call converged still gains digits of the velocities: in numerical time it contracts more
/// slowly, and they decide whether a sliding contact is at rest.
fn still_contracts(element: &FiniteElement<'_>, contraction: f64) -> bool {
    element.clock.is_slowed() && contraction < CONTRACTS
}

/// What the change of the contact forces by the last Newton step (in `residual`) makes of the velocities, relative to them.
fn relative_change_of_forces(element: &FiniteElement<'_>) -> f64 {
    let (n, count) = (element.n, element.constraints.count());
    let steps = element.residual.chunks_exact(element.block());
    let step = steps.fold(0.0_f64, |step, change| {
        step.max(largest(&change[n..n + count]))
    });
    element.length * step * largest(&element.constraints.directions) / element.speed()
}

/// Relative change of the stage states by the last Newton step (in `residual`).
fn relative_change(element: &FiniteElement<'_>) -> f64 {
    let (n, h, block) = (element.n, element.length, element.block());
    let multipliers = n + element.constraints.count();
    let (mut step, mut correction) = (0.0_f64, 0.0_f64);
    for change in element.residual.chunks_exact(block) {
        // Comparisons that let NaN through to the caller's test.
        for value in &change[..n] {
            step = if value.abs() <= step {
                step
            } else {
                value.abs()
            };
        }
        for eta in &change[multipliers..] {
            correction = if eta.abs() <= correction {
                correction
            } else {
                eta.abs()
            };
        }
    }
    let reach = largest(&element.corrections);
    let speed = element.speed();
    let position = largest(&element.start.q).max(h * speed) + f64::MIN_POSITIVE;
    let by_velocity = h * step / speed;
    let by_position = h * h * (step + reach * correction) / position;
    if by_velocity >= by_position {
        by_velocity
    } else {
        by_position
    }
}
