//! Forces and impulses of contacts in the functions of optimal control: values through the contact's own functions,
//! derivatives against differences.

#![allow(clippy::unwrap_used, reason = "a failed step is a failed test")]

use crate::support::cases;
use hangtime::model::{Model, SparsityPattern, contact_point};
use proptest::prelude::*;

hangtime::model! {
    /// A bent rod in mixed units over a hill, with a mass on a dry rail: forces in every statement of optimal control.
    pub Rod {
        parameters { m: kg = 2, l: cm = 40, g: m/s^2 = 9.81, mu = 0.3, w: 1/m = 2, f: N = 3, d: m = 0.2 }
        coordinates { y: m, z: cm, a: deg, s: mm }
        controls { u: N }
        let tip = (y + l*cos(a), z + l*sin(a))
        lagrangian m/2*|dot((y, z))|^2 + m/4*|dot(tip)|^2 + m/9*dot(s + y)^2 - m*g*z
        forces { y: u }
        surface hill: tip.z >= d*sin(w*tip.y) + d*sin(t/1 [s])
        surface wall: y <= 3 [m]
        impact hill: inelastic, friction mu, sliding dot(tip.y) + d*dot(tip.z)/1 [m]
        impact wall: restitution 0.5, holding z
        dry friction rail: bound f*(2 + sin(w*y)), sliding dot(s)
        outputs { push: N = force(hill) - 2*force(wall) }
        minimize integral(push^2*(1 + sin(a)) + friction_force(rail)*friction_force(hill)*cos(t/1 [s]))/1 [s]
            + sum(impulse(hill)^2*y*exp(t/9 [s]))*1 [1/m/s^2] + force(wall)*force(hill)*time/1 [s]
        constraint strong: push <= u
        constraint soft: impulse(wall) + friction_impulse(hill)*sin(y/d) <= 3 [N s]
        finally { friction_force(hill) + y*1 [N/m] <= 3 [N], sum(impulse(hill)^2*y*exp(t/9 [s])) <= 9 [N^2 s^2 m], sum(impulse(wall)) == 1 [N s] }
        start { z: 50 }
    }
}

/// A chain of nine masses, whose equations are solved at run time: the last one may touch a wall.
const LONG: &str = "
    parameters { k: 1/m = 0.7 }
    coordinates { a: m, b: m, c: m, d: m, e: m, f: m, g: m, h: m, i: m }
    lagrangian 1 [kg]/2*(dot(a)^2 + dot(b - a)^2*(2 + sin(k*a)) + dot(c)^2 + dot(d + c)^2 + dot(e)^2*(2 + cos(k*d))
        + dot(f - e)^2 + dot(g)^2 + dot(h + b)^2 + dot(i - g + a)^2)
    surface wall: i*(2 + sin(k*h)) + a >= 0
    impact wall: inelastic
    minimize integral(force(wall)^2)
    finally { a == 1 [m] }
    start { i: 1 }
    horizon 1 [s]";

/// The three groups of functions: values, Jacobian, Hessian.
const GROUPS: [&str; 3] = ["path", "terminal", "impact"];

fn patterns(model: &dyn Model, group: &str) -> (usize, [SparsityPattern; 2]) {
    let task = model.declaration().optimal_control.unwrap();
    let terms = task.contacts;
    match group {
        "path" => (
            task.path_functions(),
            [task.path_jacobian, task.path_hessian],
        ),
        "terminal" => (
            task.terminal_functions(),
            [task.terminal_jacobian, task.terminal_hessian],
        ),
        _ => (
            terms.impact_functions(),
            [terms.impact_jacobian, terms.impact_hessian],
        ),
    }
}

fn values(model: &dyn Model, group: &str, x: &[f64]) -> Vec<f64> {
    let mut values = vec![f64::NAN; patterns(model, group).0];
    match group {
        "path" => model.path_functions(x, &mut values),
        "terminal" => model.terminal_functions(x, &mut values),
        _ => model.impact_functions(x, &mut values),
    }
    values
}

/// Dense Jacobian, row by row.
fn jacobian(model: &dyn Model, group: &str, x: &[f64]) -> Vec<Vec<f64>> {
    let (rows, [pattern, _]) = patterns(model, group);
    assert_eq!((pattern.rows, pattern.columns), (rows, x.len()));
    let mut values = vec![f64::NAN; pattern.entries.len()];
    match group {
        "path" => model.path_jacobian(x, &mut values),
        "terminal" => model.terminal_jacobian(x, &mut values),
        _ => model.impact_jacobian(x, &mut values),
    }
    let mut dense = vec![vec![0.0; x.len()]; rows];
    for (&(row, column), value) in pattern.entries.iter().zip(values) {
        dense[row as usize][column as usize] = value;
    }
    dense
}

/// Dense Hessian of the weighted functions.
fn hessian(model: &dyn Model, group: &str, x: &[f64], weights: &[f64]) -> Vec<Vec<f64>> {
    let (_, [_, pattern]) = patterns(model, group);
    let mut values = vec![f64::NAN; pattern.entries.len()];
    match group {
        "path" => model.path_hessian(x, weights, &mut values),
        "terminal" => model.terminal_hessian(x, weights, &mut values),
        _ => model.impact_hessian(x, weights, &mut values),
    }
    let mut dense = vec![vec![0.0; x.len()]; x.len()];
    for (&(i, j), value) in pattern.entries.iter().zip(values) {
        dense[i as usize][j as usize] = value;
        dense[j as usize][i as usize] = value;
    }
    dense
}

/// Differences of a vector-valued function, one list an input.
fn differences(x: &[f64], f: impl Fn(&[f64]) -> Vec<f64>) -> Vec<Vec<f64>> {
    (0..x.len())
        .map(|k| {
            let step = 1e-5 * (1.0 + x[k].abs());
            let at = |sign: f64| {
                let mut moved = x.to_vec();
                moved[k] += sign * step;
                f(&moved)
            };
            let pairs = at(1.0).into_iter().zip(at(-1.0));
            pairs
                .map(|(above, below)| (above - below) / (2.0 * step))
                .collect()
        })
        .collect()
}

/// A central difference is good to about the square of its step, and to rounding over it, of the largest value.
fn assert_near(what: &str, found: &[f64], wanted: &[f64], size: f64) {
    for (i, (found, wanted)) in found.iter().zip(wanted).enumerate() {
        assert!(
            (found - wanted).abs() < 1e-6 * size,
            "{what}[{i}]: {found} instead of {wanted}"
        );
    }
}

fn check_derivatives(model: &dyn Model, group: &str, x: &[f64]) {
    let first = jacobian(model, group, x);
    let size = |rows: &[Vec<f64>]| rows.iter().flatten().fold(1.0_f64, |s, v| s.max(v.abs()));
    for (k, wanted) in differences(x, |x| values(model, group, x))
        .iter()
        .enumerate()
    {
        let column: Vec<f64> = first.iter().map(|row| row[k]).collect();
        assert_near(
            &format!("{group} jacobian, column {k}"),
            &column,
            wanted,
            size(&first),
        );
    }
    let weights: Vec<f64> = (0..first.len()).map(|i| 0.7 + 0.4 * i as f64).collect();
    let weighted = |x: &[f64]| -> Vec<f64> {
        let rows = jacobian(model, group, x);
        let column = |k: usize| rows.iter().zip(&weights).map(|(row, w)| w * row[k]).sum();
        (0..x.len()).map(column).collect()
    };
    let second = hessian(model, group, x, &weights);
    for (k, wanted) in differences(x, weighted).iter().enumerate() {
        let what = format!("{group} hessian, column {k}");
        assert_near(&what, &second[k], wanted, size(&second));
    }
}

/// The factors that make forces of accelerations, of each contact.
fn inverse_inertias(model: &dyn Model, x: &[f64]) -> Vec<f64> {
    let declaration = model.declaration();
    let mut point = vec![0.0; contact_point::length(declaration.coordinates.len())];
    (0..declaration.contacts.len())
        .map(|contact| {
            model.contact(contact, x, &mut point);
            point[contact_point::INVERSE_INERTIA]
        })
        .collect()
}

proptest! {
    #![proptest_config(cases(64))]

    #[test]
    fn functions_of_forces_are_those_of_accelerations_over_inverse_inertias(
        x in prop::collection::vec(-1.0..1.0_f64, 16),
    ) {
        let rod = Rod::default();
        let declaration = rod.declaration();
        // (y, z, a, s, their velocities, u, t), then r and s of hill, wall and rail.
        prop_assert_eq!((declaration.inputs(), declaration.path_inputs()), (10, 16));
        let plain = &x[..10];
        let (r, s) = (&x[10..13], &x[13..16]);
        let inertia = inverse_inertias(&rod, plain);
        let force = |i: usize| r[i] / inertia[i];
        let rub = |i: usize| s[i] / inertia[i];
        let (y, a, u, t) = (x[0], x[2].to_radians(), x[8], x[9]);
        let push = force(0) - 2.0 * force(1);
        let cost = push * push * (1.0 + a.sin()) + rub(2) * rub(0) * t.cos();
        let size = 1.0 + cost.abs() + push.abs();
        assert_near("path", &values(&rod, "path", &x), &[cost, u - push], size);

        let summed = force(0).powi(2) * y * (t / 9.0).exp();
        let limit = 3.0 - force(1) - rub(0) * (y / 0.2).sin();
        let wanted = [summed, force(1), limit];
        let size = wanted.iter().fold(1.0_f64, |size, v| size.max(v.abs()));
        assert_near("impact", &values(&rod, "impact", &x), &wanted, size);

        // (q, v, T), two sums, r and s; the ground is where it is at the final time.
        let mut z = [&x[..8], &[t, 0.3, 0.4]].concat();
        z.extend(&x[10..]);
        prop_assert_eq!(z.len(), declaration.terminal_inputs());
        let cost = 0.3 + force(1) * force(0) * t;
        let wanted = [cost, 3.0 - rub(0) - y, 9.0 - 0.3, 0.4 - 1.0];
        let size = wanted.iter().fold(1.0_f64, |size, v| size.max(v.abs()));
        assert_near("terminal", &values(&rod, "terminal", &z), &wanted, size);
    }

    #[test]
    fn derivatives_of_functions_of_forces_agree_with_differences(
        x in prop::collection::vec(0.1..1.0_f64, 17),
    ) {
        let rod = Rod::default();
        for group in GROUPS {
            let length = if group == "terminal" { 17 } else { 16 };
            check_derivatives(&rod, group, &x[..length]);
        }
    }
}

#[test]
fn forces_of_scenes_that_are_solved_at_run_time_are_formulas_as_well() {
    let long = hangtime_scene_files::of_text("long.hang", LONG).unwrap();
    let x: Vec<f64> = (0..20).map(|k| 0.3 + 0.1 * f64::from(k % 7)).collect();
    assert_eq!(long.declaration().path_inputs(), 20);
    let force = x[18] / inverse_inertias(&long, &x[..18])[0];
    let found = values(&long, "path", &x);
    assert!((found[0] - force * force).abs() < 1e-12 * (1.0 + force * force));
    check_derivatives(&long, "path", &x);
}

#[test]
fn functions_without_forces_read_the_inputs_of_all_other_functions() {
    let text = LONG.replace("force(wall)^2", "dot(a)^2");
    let plain = hangtime_scene_files::of_text("plain.hang", &text).unwrap();
    let declaration = plain.declaration();
    let task = declaration.optimal_control.unwrap();
    assert!(!task.contacts.any());
    assert_eq!(task.path_jacobian.columns, declaration.inputs());
    assert_eq!(task.terminal_jacobian.columns, 19);
    let names = declaration.kernels.iter().map(|kernel| kernel.name);
    assert!(names.into_iter().all(|name| !name.starts_with("impact_")));
}
