//! Jacobian and Hessian of the local rows.

use super::layout::{
    AHEAD, ALPHA, BEHIND, BETA, C_MINUS, C_PLUS, FALL, LAMBDA_MINUS, LAMBDA_PLUS, P, RISE,
    SLIP_MINUS, SLIP_PLUS, W,
};
use super::system::HeavisideSystem;

/// Rate of the control at a place of `xi`, if there is one; the controls begin at `first`.
fn slope_of(drive: &[f64], first: usize, place: usize) -> Option<f64> {
    drive.get(place.checked_sub(first)?).copied()
}

/// Entries (row, column, value) of the Jacobian of the local rows at `xi`, always in the same order.
pub(crate) fn jacobian(
    dcs: &mut HeavisideSystem<'_>,
    xi: &[f64],
    mut add: impl FnMut(usize, usize, f64),
) {
    if dcs.drive.1.is_empty() {
        undriven_jacobian(dcs, xi, add);
        return;
    }
    let (drive, time) = (dcs.drive.1.clone(), dcs.layout.time());
    let first = dcs.layout.states();
    undriven_jacobian(dcs, xi, |row, column, value| {
        add(row, column, value);
        if let Some(slope) = slope_of(&drive, first, column) {
            add(row, time, value * slope);
        }
    });
}

fn undriven_jacobian(
    dcs: &mut HeavisideSystem<'_>,
    xi: &[f64],
    mut add: impl FnMut(usize, usize, f64),
) {
    dcs.write_input(xi);
    dcs.system.evaluate(&dcs.input);
    dcs.system.evaluate_jacobians(&dcs.input);
    let n = dcs.layout.n;
    let theta = dcs.layout.theta().map_or(1.0, |place| xi[place]);
    for k in 0..n {
        add(k, n + k, theta);
        if let Some(place) = dcs.layout.theta() {
            add(k, place, xi[n + k]);
            add(n + k, place, dcs.system.acceleration[k]);
        }
    }
    if let Some(place) = dcs.layout.theta() {
        add(dcs.layout.time(), place, 1.0);
    }
    let entries = dcs.system.model.declaration().free_jacobian.entries;
    for (&(row, column), value) in entries.iter().zip(&dcs.system.acceleration_jacobian) {
        add(
            n + row as usize,
            dcs.layout.local_of_input(column as usize),
            theta * value,
        );
    }
    for contact in 0..dcs.layout.contacts {
        contact_entries(dcs, xi, contact, &mut add);
    }
    for r in 0..dcs.layout.rough.len() {
        friction_entries(dcs, xi, r, &mut add);
    }
    for (j, &contact) in dcs.layout.elastic.iter().enumerate() {
        let row = dcs.layout.rebound_row(j);
        add(row, dcs.layout.rebound_place(j, FALL), 1.0);
        add(row, dcs.layout.rebound_place(j, RISE), 1.0);
        add(row, dcs.layout.algebraic(contact, BETA), -1.0);
    }
    for count in 2..=dcs.layout.contacts {
        let row = dcs.layout.product_row(count);
        let (before, alpha) = (
            dcs.layout.product(count - 1),
            dcs.layout.algebraic(count - 1, ALPHA),
        );
        add(row, dcs.layout.product(count), 1.0);
        add(row, before, -xi[alpha]);
        add(row, alpha, -xi[before]);
    }
}

fn contact_entries(
    dcs: &HeavisideSystem<'_>,
    xi: &[f64],
    contact: usize,
    add: &mut impl FnMut(usize, usize, f64),
) {
    let n = dcs.layout.n;
    let beta = dcs.layout.algebraic(contact, BETA);
    let row = dcs.layout.contact_row(contact);
    let gap = dcs.layout.lifted_gap(contact);
    let bounces = dcs.layout.rebound(contact).is_some();
    for (place, factor) in dcs.pressing(contact).into_iter().flatten() {
        for k in 0..n {
            add(n + k, place, factor * dcs.system.auxiliary(contact, k));
        }
    }
    let velocity = dcs.system.normal_velocity(contact);
    if let Some(place) = dcs.layout.theta() {
        add(gap, place, velocity);
    }
    let dip = dcs.layout.dip(contact);
    if bounces {
        add(dip.unwrap_or(gap), beta, velocity);
    } else {
        add(row + 1, gap, 1.0);
    }
    for height in dcs.layout.heights(contact) {
        add(row + 2, height, 1.0);
    }
    let push = dcs.pressure(xi, contact) * dcs.system.auxiliary_acceleration;
    let rates = dcs.gap_rates(xi, contact);
    for (entry, column, value) in dcs.system.contact_jacobian(contact) {
        let column = dcs.layout.local_of_input(column);
        match entry {
            0 => {}
            1 => {
                for (height, rate) in dcs.layout.heights(contact).zip(rates) {
                    add(height, column, rate * value);
                }
                add(row + 1, column, -value);
            }
            _ => add(n + entry - 2, column, push * value),
        }
    }
    add(row, dcs.layout.algebraic(contact, ALPHA), 1.0);
    add(row, beta, 1.0);
    add(row + 1, dcs.layout.algebraic(contact, P), 1.0);
    add(row + 1, dcs.layout.algebraic(contact, W), -1.0);
    if !bounces {
        add(row + 2, dcs.layout.algebraic(contact, P), 1.0);
    }
    add(row + 2, dcs.layout.algebraic(contact, LAMBDA_PLUS), -1.0);
    add(row + 2, dcs.layout.algebraic(contact, LAMBDA_MINUS), 1.0);
    edge_entries(dcs, contact, add);
}

/// Of the comparisons of a contact with the other pieces of its edge.
fn edge_entries(
    dcs: &HeavisideSystem<'_>,
    contact: usize,
    add: &mut impl FnMut(usize, usize, f64),
) {
    let margin = dcs.layout.contact_row(contact) + 2;
    let gap = dcs.layout.lifted_gap(contact);
    let bounces = dcs.layout.bounces(contact);
    let own = (!bounces).then(|| dcs.layout.algebraic(contact, P));
    let mut parts: Vec<usize> = own.into_iter().collect();
    for (k, other) in dcs.layout.edges_of(contact) {
        let row = dcs.layout.edge_row(k);
        let ahead = dcs.layout.edge_place(k, AHEAD);
        add(row, ahead, 1.0);
        add(row, dcs.layout.edge_place(k, BEHIND), -1.0);
        for &part in &parts {
            add(row, part, 1.0);
        }
        // The gap is a part of the margin, and what the other one is ahead of.
        add(row, gap, 2.0);
        add(row, dcs.layout.lifted_gap(other), -1.0);
        add(margin, ahead, 1.0);
        parts.push(ahead);
    }
}

fn friction_entries(
    dcs: &HeavisideSystem<'_>,
    xi: &[f64],
    r: usize,
    add: &mut impl FnMut(usize, usize, f64),
) {
    let n = dcs.layout.n;
    let contact = dcs.layout.rough[r];
    let row = dcs.layout.friction_row(r);
    let place = |offset: usize| dcs.layout.friction_place(r, offset);
    for k in 0..n {
        let push = dcs.system.auxiliary_friction(contact, k);
        add(n + k, place(SLIP_PLUS), -push);
        add(n + k, place(SLIP_MINUS), push);
    }
    let share = dcs.friction_share(xi, r) * friction_unit(dcs, contact);
    for (entry, column, value) in dcs.system.tangent_jacobian(contact) {
        let column = dcs.layout.local_of_input(column);
        if entry == 0 {
            add(row + 1, column, value);
        } else {
            add(n + entry - 1, column, share * value);
        }
    }
    add(row, place(SLIP_PLUS), 1.0);
    add(row, place(SLIP_MINUS), 1.0);
    if dcs.layout.is_dry(contact) {
        let a_bar = dcs.system.auxiliary_acceleration;
        let theta = dcs.layout.theta();
        for (_, column, value) in dcs.system.contact_jacobian(contact) {
            let speed = theta.map_or(1.0, |place| xi[place]);
            add(
                row,
                dcs.layout.local_of_input(column),
                -speed * value / a_bar,
            );
        }
        if let Some(place) = theta {
            add(row, place, -dcs.system.pressed(contact) / a_bar);
        }
    } else {
        for (pressing, factor) in dcs.pressing(contact).into_iter().flatten() {
            add(row, pressing, -factor);
        }
    }
    add(row + 1, place(C_PLUS), -1.0);
    add(row + 1, place(C_MINUS), 1.0);
}

/// `a_bar mu` of a contact.
fn friction_unit(dcs: &HeavisideSystem<'_>, contact: usize) -> f64 {
    dcs.system.auxiliary_acceleration * dcs.system.friction(contact)
}

/// Entries (one of (i, j) and (j, i) each) of the Hessian of `weights' rows` at `xi`, always in the
/// same order. An entry with `i = j` is a diagonal one.
pub(crate) fn hessian(
    dcs: &mut HeavisideSystem<'_>,
    xi: &[f64],
    weights: &[f64],
    mut add: impl FnMut(usize, usize, f64),
) {
    if dcs.drive.1.is_empty() {
        undriven_hessian(dcs, xi, weights, add);
        return;
    }
    let (drive, time) = (dcs.drive.1.clone(), dcs.layout.time());
    let first = dcs.layout.states();
    undriven_hessian(dcs, xi, weights, |i, j, value| {
        add(i, j, value);
        let (by_i, by_j) = (slope_of(&drive, first, i), slope_of(&drive, first, j));
        // An entry off the diagonal stands for two; where it moves onto the diagonal it is both.
        let mut moved = |a: usize, factor: f64| {
            let both = if a == time && i != j { 2.0 } else { 1.0 };
            add(a.max(time), a.min(time), both * factor * value);
        };
        if let Some(slope) = by_i {
            moved(j, slope);
        }
        if let Some(slope) = by_j.filter(|_| i != j) {
            moved(i, slope);
        }
        if let (Some(a), Some(b)) = (by_i, by_j) {
            moved(time, a * b);
        }
    });
}

fn undriven_hessian(
    dcs: &mut HeavisideSystem<'_>,
    xi: &[f64],
    weights: &[f64],
    mut add: impl FnMut(usize, usize, f64),
) {
    dcs.write_input(xi);
    dcs.system.evaluate_jacobians(&dcs.input);
    let n = dcs.layout.n;
    let theta = dcs.layout.theta().map_or(1.0, |place| xi[place]);
    let declaration = dcs.system.model.declaration();
    for k in 0..n {
        dcs.force_weights[k] = theta * weights[n + k];
    }
    dcs.system
        .evaluate_acceleration_hessian(&dcs.input, &dcs.force_weights);
    let entries = declaration.free_hessian.entries;
    for (&(i, j), &value) in entries.iter().zip(&dcs.system.acceleration_hessian) {
        add(
            dcs.layout.local_of_input(i as usize),
            dcs.layout.local_of_input(j as usize),
            value,
        );
    }
    if let Some(place) = dcs.layout.theta() {
        for (k, &weight) in weights[..n].iter().enumerate() {
            add(place, n + k, weight);
        }
        for (&(row, column), value) in declaration
            .free_jacobian
            .entries
            .iter()
            .zip(&dcs.system.acceleration_jacobian)
        {
            add(
                place,
                dcs.layout.local_of_input(column as usize),
                weights[n + row as usize] * value,
            );
        }
    }
    for contact in 0..dcs.layout.contacts {
        contact_curvature(dcs, xi, weights, contact, &mut add);
    }
    for r in 0..dcs.layout.rough.len() {
        friction_curvature(dcs, xi, weights, r, &mut add);
    }
    for count in 2..=dcs.layout.contacts {
        add(
            dcs.layout.product(count - 1),
            dcs.layout.algebraic(count - 1, ALPHA),
            -weights[dcs.layout.product_row(count)],
        );
    }
}

fn contact_curvature(
    dcs: &mut HeavisideSystem<'_>,
    xi: &[f64],
    weights: &[f64],
    contact: usize,
    add: &mut impl FnMut(usize, usize, f64),
) {
    let n = dcs.layout.n;
    let a_bar = dcs.system.auxiliary_acceleration;
    let row = dcs.layout.contact_row(contact);
    let by_gap = weights[dcs.layout.lifted_gap(contact)];
    let by_beta = dcs.layout.dip(contact).map_or(by_gap, |dip| weights[dip]);
    let push = dcs.pressure(xi, contact) * a_bar;
    let heights = dcs.layout.heights(contact).zip(dcs.gap_rates(xi, contact));
    let by_velocity = heights
        .map(|(height, rate)| rate * weights[height])
        .sum::<f64>()
        - weights[row + 1];
    dcs.system.evaluate_contact_hessian(
        contact,
        &dcs.input,
        [0.0, by_velocity],
        weights[n..2 * n].iter().map(|weight| push * weight),
    );
    let entries = dcs.system.model.declaration().contacts[contact]
        .hessian
        .entries;
    for (&(i, j), &value) in entries.iter().zip(&dcs.system.contact_hessians[contact]) {
        add(
            dcs.layout.local_of_input(i as usize),
            dcs.layout.local_of_input(j as usize),
            value,
        );
    }
    let beta = dcs
        .layout
        .rebound(contact)
        .map(|_| (dcs.layout.algebraic(contact, BETA), by_beta));
    for (entry, column, value) in dcs.system.contact_jacobian(contact) {
        let column = dcs.layout.local_of_input(column);
        if entry == 1 {
            let theta = dcs.layout.theta().map(|place| (place, by_gap));
            for (place, weight) in theta.into_iter().chain(beta) {
                add(place, column, weight * value);
            }
        }
        if entry >= 2 {
            for (place, factor) in dcs.pressing(contact).into_iter().flatten() {
                let weight = factor * a_bar * weights[n + entry - 2];
                add(place, column, weight * value);
            }
        }
    }
}

/// Entries of the gradient of the gap of `contact` at the point of the last evaluation.
pub(crate) fn gap_gradient(
    dcs: &mut HeavisideSystem<'_>,
    contact: usize,
    mut add: impl FnMut(usize, f64),
) {
    dcs.system.evaluate_jacobians(&dcs.input);
    for (entry, input, value) in dcs.system.contact_jacobian(contact) {
        if entry == 0 {
            add(dcs.layout.local_of_input(input), value);
        }
    }
}

/// Entries (one of (i, j) and (j, i) each) of the Hessian of `weight g` of a contact where the system was evaluated last.
pub(crate) fn gap_hessian(
    dcs: &mut HeavisideSystem<'_>,
    contact: usize,
    weight: f64,
    mut add: impl FnMut(usize, usize, f64),
) {
    let none = std::iter::repeat_n(0.0, dcs.layout.n);
    dcs.system
        .evaluate_contact_hessian(contact, &dcs.input, [weight, 0.0], none);
    let declared = &dcs.system.model.declaration().contacts[contact];
    let entries = declared.hessian.entries;
    for (&(i, j), &value) in entries.iter().zip(&dcs.system.contact_hessians[contact]) {
        let place = |input: u32| dcs.layout.local_of_input(input as usize);
        add(place(i), place(j), value);
    }
}

fn friction_curvature(
    dcs: &mut HeavisideSystem<'_>,
    xi: &[f64],
    weights: &[f64],
    r: usize,
    add: &mut impl FnMut(usize, usize, f64),
) {
    let n = dcs.layout.n;
    let contact = dcs.layout.rough[r];
    let unit = friction_unit(dcs, contact);
    let share = dcs.friction_share(xi, r) * unit;
    let by_velocity = weights[dcs.layout.friction_row(r) + 1];
    dcs.system.evaluate_tangent_hessian(
        contact,
        &dcs.input,
        by_velocity,
        weights[n..2 * n].iter().map(|weight| share * weight),
    );
    let friction = dcs.system.model.declaration().contacts[contact].friction;
    let entries = friction.map_or(&[][..], |friction| friction.hessian.entries);
    for (&(i, j), &value) in entries.iter().zip(&dcs.system.tangent_hessians[contact]) {
        add(
            dcs.layout.local_of_input(i as usize),
            dcs.layout.local_of_input(j as usize),
            value,
        );
    }
    for (entry, column, value) in dcs.system.tangent_jacobian(contact) {
        if entry > 0 {
            let column = dcs.layout.local_of_input(column);
            let weight = unit * weights[n + entry - 1] * value;
            add(dcs.layout.friction_place(r, SLIP_PLUS), column, -weight);
            add(dcs.layout.friction_place(r, SLIP_MINUS), column, weight);
        }
    }
    if dcs.layout.is_dry(contact) {
        pressed_curvature(dcs, xi, (contact, weights[dcs.layout.friction_row(r)]), add);
    }
}

/// What the given normal acceleration of a dry friction adds, whose row has a weight.
fn pressed_curvature(
    dcs: &mut HeavisideSystem<'_>,
    xi: &[f64],
    (contact, weight): (usize, f64),
    add: &mut impl FnMut(usize, usize, f64),
) {
    let weight = -weight / dcs.system.auxiliary_acceleration;
    let theta = dcs.layout.theta();
    let speed = theta.map_or(1.0, |place| xi[place]);
    let none = std::iter::repeat_n(0.0, dcs.layout.n);
    let weights = [0.0, weight * speed];
    dcs.system
        .evaluate_contact_hessian(contact, &dcs.input, weights, none);
    let declared = &dcs.system.model.declaration().contacts[contact];
    let entries = declared.hessian.entries.iter();
    for (&(i, j), &value) in entries.zip(&dcs.system.contact_hessians[contact]) {
        let place = |input: u32| dcs.layout.local_of_input(input as usize);
        add(place(i), place(j), value);
    }
    let Some(theta) = theta else {
        return;
    };
    for (_, column, value) in dcs.system.contact_jacobian(contact) {
        add(theta, dcs.layout.local_of_input(column), weight * value);
    }
}
