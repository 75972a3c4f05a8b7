//! Elements in numerical time: the time-freezing system in a sliding mode.
//!
//! In sustained contact the time-freezing system moves at the speed `rho = theta_free` of its clock
//! ([`clock::speed`]), since its right-hand side is the convex combination
//!
//! ```text
//! q' = rho v
//! v' = rho a + a_bar sum_I (gamma_i d_i + beta_i e_i),   rho = prod_I (1 - gamma_i),   |beta_i| <= mu_i gamma_i
//! t' = rho
//! ```
//!
//! of free flow and auxiliary dynamics whose weights hold `g_i = 0`, `v_n,i = 0`, and `v_t,i = 0` where a contact
//! sticks. With the contact accelerations `r_i = a_bar gamma_i / rho` and `s_i = a_bar beta_i / rho` as unknowns each
//! right-hand side is `rho` times that in physical time, and `rho` a function of the `r_i` alone. The stages of an element
//! of numerical length `h_tau` are
//!
//! ```text
//! v_m = v_0 + h_tau sum_j a_mj rho_j A_j
//! q_m = q_0 + h_tau sum_j a_mj (rho_j v_j + ...)
//! t_m = t_0 + h_tau sum_j a_mj rho_j
//! ```
//!
//! The clock ends at `t_0 + h`, as the grid of the steps or the place of a switch wants it: this equation determines
//! `h_tau = h / sum_j b_j rho_j`, and is used to eliminate it. What is left of the clock are the *shares*
//! `omega_j = rho_j / sum_k b_k rho_k`, 1 where nothing is in contact; with them the element has the physical length `h` as
//! any other, and its stages lie at the physical times `t_m`.
//!
//! Where contacts press harder than `a_bar` the clock nearly stops, and the motion between two nodes would be lost. The
//! element takes a larger `a_bar` there ([`StageClock::adapt`](super::stage_clock::StageClock::adapt)), which scales its
//! numerical time and nothing else.
//!
//! Source of the system: Nurkanovic, Albrecht, Brogliato, Diehl, Automatica 158 (2023) 111295; several contacts in the
//! lean product form.

use super::FiniteElement;
use crate::time_freezing::clock;

/// Shares of the stages for the contact accelerations among the unknowns.
fn update_shares(element: &mut FiniteElement<'_>) {
    let mut clock = std::mem::take(&mut element.clock);
    let Some(auxiliary) = clock.auxiliary_acceleration else {
        element.clock = clock;
        return;
    };
    let rows = clock.slopes.chunks_exact_mut(clock.contacts);
    for ((m, share), slopes) in clock.shares.iter_mut().enumerate().zip(rows) {
        *share = clock::speed(element.stage_forces(m), auxiliary, slopes);
    }
    let weights = element.tableau.b().iter().zip(&clock.shares);
    let mean: f64 = weights.map(|(b, speed)| b * speed).sum();
    for value in clock.shares.iter_mut().chain(&mut clock.slopes) {
        *value /= mean;
    }
    element.clock = clock;
}

/// Raises the acceleration of the auxiliary dynamics to what the forces of the solved element ask for; true if they do.
pub(super) fn adapt(element: &mut FiniteElement<'_>) -> bool {
    if !element.clock.is_slowed() {
        return false;
    }
    let stages = 0..element.tableau.stages();
    let sums = stages.map(|m| element.stage_forces(m).iter().map(|r| r.max(0.0)).sum());
    let largest = sums.fold(0.0, f64::max);
    element.clock.adapt(largest)
}

/// Stage states from the unknowns.
pub(super) fn update_stages(element: &mut FiniteElement<'_>) {
    update_shares(element);
    let (n, inputs, block, h) = (element.n, element.inputs, element.block(), element.length);
    let multipliers = n + element.constraints.count();
    let (tableau, stages) = (element.tableau, element.tableau.stages());
    let mut x = std::mem::take(&mut element.inputs_of_stages);
    for (m, stage) in x.chunks_exact_mut(inputs).enumerate() {
        for k in 0..n {
            let rate = |j: usize| element.clock.shares[j] * element.unknowns[j * block + k];
            let change: f64 = (0..stages).map(|j| tableau.a(m, j) * rate(j)).sum();
            stage[n + k] = element.start.v[k] + h * change;
        }
        element.write_time(element.stage_time(m), stage);
    }
    for m in 0..stages {
        for k in 0..n {
            let (mut change, mut correction) = (0.0, 0.0);
            for j in 0..stages {
                let a = tableau.a(m, j);
                change += a * element.clock.shares[j] * x[j * inputs + n + k];
                let etas = &element.unknowns[j * block + multipliers..(j + 1) * block];
                for (i, eta) in etas.iter().enumerate() {
                    correction += a * eta * element.corrections[i * n + k];
                }
            }
            x[m * inputs + k] = element.start.q[k] + h * (change + h * correction);
        }
    }
    element.inputs_of_stages = x;
}

/// Derivatives `(d v_m / d A_j, d q_m / d A_j)` of the stage states, times the identity.
pub(super) fn weights(element: &FiniteElement<'_>, m: usize, j: usize) -> (f64, f64) {
    let (h, tableau, clock) = (element.length, element.tableau, &element.clock);
    if clock.is_slowed() {
        let (share, square) = (clock.shares[j], clock.squares[m * tableau.stages() + j]);
        (h * tableau.a(m, j) * share, h * h * square * share)
    } else {
        (h * tableau.a(m, j), h * h * tableau.a_squared(m, j))
    }
}

/// Prepares the derivatives of the stage states at the present stages.
pub(super) fn differentiate(element: &mut FiniteElement<'_>) {
    if !element.clock.is_slowed() {
        return;
    }
    let mut clock = std::mem::take(&mut element.clock);
    let (n, inputs, block, h) = (element.n, element.inputs, element.block(), element.length);
    let (tableau, stages) = (element.tableau, element.tableau.stages());
    let shares = &clock.shares;
    clock.squares.clear();
    for m in 0..stages {
        for j in 0..stages {
            let terms = (0..stages).map(|k| tableau.a(m, k) * shares[k] * tableau.a(k, j));
            clock.squares.push(terms.sum());
        }
    }
    let row = 2 * n + 1;
    clock.through_shares.clear();
    clock
        .through_shares
        .resize(stages * clock.contacts * stages * row, 0.0);
    for (place, rows) in clock
        .through_shares
        .chunks_exact_mut(stages * row)
        .enumerate()
    {
        let (j, slope) = (place / clock.contacts, clock.slopes[place]);
        // All shares fall where one speed grows, so that the clock ends where it did.
        let change = |l: usize| {
            let own = if l == j { 1.0 } else { 0.0 };
            (own - shares[l] * tableau.b()[j]) * slope
        };
        for m in 0..stages {
            for l in 0..stages {
                let weight = h * tableau.a(m, l) * change(l);
                for k in 0..n {
                    rows[m * row + k] += weight * element.inputs_of_stages[l * inputs + n + k];
                    rows[m * row + n + k] += weight * element.unknowns[l * block + k];
                }
                rows[m * row + 2 * n] += weight;
            }
        }
        for m in 0..stages {
            for l in 0..stages {
                let weight = h * tableau.a(m, l) * shares[l];
                for k in 0..n {
                    rows[m * row + k] += weight * rows[l * row + n + k];
                }
            }
        }
    }
    element.clock = clock;
}

/// Adds to the rows of stage `m` of the Newton matrix what the contact accelerations change through the shares.
pub(super) fn add_to_rows(element: &mut FiniteElement<'_>, m: usize) {
    if !element.clock.is_slowed() {
        return;
    }
    differentiate_by_time(element);
    let (n, block, h) = (element.n, element.block(), element.length);
    let (contacts, forces) = (element.clock.contacts, element.constraints.count());
    let stages = element.tableau.stages();
    let (size, row) = (stages * block, 2 * n + 1);
    let product =
        |a: &[f64], b: &[f64]| -> f64 { a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>() };
    for place in 0..stages * contacts {
        let column = place / contacts * block + n + place % contacts;
        let change = &element.clock.through_shares[(place * stages + m) * row..][..row];
        let (q, v, time) = (&change[..n], &change[n..2 * n], change[2 * n]);
        let mut add = |line: usize, value: f64| {
            element.matrix[(m * block + line) * size + column] += value;
        };
        for k in 0..n {
            let own = k * n..(k + 1) * n;
            let moved = product(&element.by_q[own.clone()], q) + product(&element.by_v[own], v);
            add(k, -moved - element.clock.by_time[k] * time);
        }
        for i in 0..forces {
            let own = i * n..(i + 1) * n;
            let turned = product(&element.constraints.turning[own.clone()], q);
            if element.constraints.is_given(i) {
                add(n + i, -turned);
                continue;
            }
            let velocity = turned + product(&element.constraints.gradients[own.clone()], v);
            add(n + i, velocity / h);
        }
        for i in 0..element.constraints.positions() {
            let gap = product(&element.constraints.gradients[i * n..(i + 1) * n], q);
            add(n + forces + i, gap / (h * h));
        }
    }
}

/// Derivative of the free acceleration with respect to time, from the Jacobian of the present stage.
fn differentiate_by_time(element: &mut FiniteElement<'_>) {
    let n = element.n;
    let declaration = element.model.declaration();
    let by_time = &mut element.clock.by_time;
    by_time.clear();
    by_time.resize(n, 0.0);
    let entries = declaration.free_jacobian.entries.iter();
    for (&(row, column), value) in entries.zip(&element.free_jacobian) {
        let Some(place) = (column as usize).checked_sub(2 * n) else {
            continue;
        };
        let rate = if place < declaration.controls.len() {
            let slope = element.controls.slopes().get(place);
            slope.copied().unwrap_or(0.0)
        } else {
            1.0
        };
        by_time[row as usize] += value * rate;
    }
}
