//! Functions given by points: the same functions of a scene as those of a formula, with all derivatives, and the same
//! motions and optima.

use hangtime::model::{Model, SparsityPattern, contact_point};
use hangtime::prelude::*;

hangtime::model! {
    /// A cart on a measured track, which is a parabola.
    pub Measured {
        parameters { m: kg = 2, g: m/s^2 = 9.81 }
        coordinates { y: m, s: m }
        controls { u: N in -30..=30 }
        profile track(w: cm): mm {
            (-200, 1000), (-150, 525), (-110, 253), (-30, -3), (0, 0), (20, 32), (100, 400), (160, 928), (200, 1400),
        }
        let cart = (y, track(y) + s)
        lagrangian m/2*|dot(cart)|^2 - m*g*cart.z
        forces { y: u }
        surface ground: s >= 0
        surface wall: y + diff(track)(y)*1 [m] <= 5 [m]
        impact ground, wall: inelastic
        minimize time
        finally { y == 1.5 [m] }
        start { y: -1 [m] }
        horizon 1.2 [s]
    }
}

hangtime::model! {
    /// The same by its formula.
    pub Formula {
        parameters { m: kg = 2, g: m/s^2 = 9.81 }
        coordinates { y: m, s: m }
        controls { u: N in -30..=30 }
        fn track(w) = 0.1*w + 0.3 [1/m]*w^2
        let cart = (y, track(y) + s)
        lagrangian m/2*|dot(cart)|^2 - m*g*cart.z
        forces { y: u }
        surface ground: s >= 0
        surface wall: y + diff(track)(y)*1 [m] <= 5 [m]
        impact ground, wall: inelastic
        minimize time
        finally { y == 1.5 [m] }
        start { y: -1 [m] }
        horizon 1.2 [s]
    }
}

hangtime::model! {
    /// A ball among blocks with edges, on a track whose profile is measured.
    pub Edges {
        parameters { m: kg = 1, g: m/s^2 = 9.81, mu = 0.1 }
        coordinates { y: m, z: m }
        profile track(w: m): m { (-1, 0.2), (0, 0), (1, -0.1), (2, 0.3) }
        fn block(y, z) = max(z - 0.5 [m], |y| - 0.4 [m])
        lagrangian m/2*|dot((y, z))|^2 - m*g*z
        surface ground: min(z - track(y), block(y, z)) >= 0
        impact ground: restitution 0.5, friction mu
        outputs { load: N = force(ground) }
        start { z: 1.5 [m] }
        horizon 1 [s]
    }
}

fn dense(pattern: &SparsityPattern, values: &[f64]) -> Vec<f64> {
    let mut dense = vec![0.0; pattern.rows * pattern.columns];
    for (&(row, column), value) in pattern.entries.iter().zip(values) {
        dense[row as usize * pattern.columns + column as usize] = *value;
    }
    dense
}

/// Everything that solvers read of a scene at a point.
fn functions(model: &dyn Model, x: &[f64]) -> Vec<f64> {
    let declaration = model.declaration();
    let n = declaration.coordinates.len();
    let weights = [0.7, -0.4, 1.3, 0.6];
    let mut all = Vec::new();
    let mut add = |pattern: Option<&SparsityPattern>, length: usize, write: &dyn Fn(&mut [f64])| {
        let mut values = vec![0.0; pattern.map_or(length, |known| known.entries.len())];
        write(&mut values);
        all.extend(pattern.map_or(values.clone(), |known| dense(known, &values)));
    };
    add(None, n, &|a| model.free_acceleration(x, a));
    add(Some(&declaration.free_jacobian), 0, &|v| {
        model.free_jacobian(x, v)
    });
    add(Some(&declaration.free_hessian), 0, &|v| {
        model.free_hessian(x, &weights[..n], v);
    });
    for (i, contact) in declaration.contacts.iter().enumerate() {
        add(None, contact_point::length(n), &|v| model.contact(i, x, v));
        add(Some(&contact.jacobian), 0, &|v| {
            model.contact_jacobian(i, x, v)
        });
        add(Some(&contact.hessian), 0, &|v| {
            model.contact_hessian(i, x, &weights, v);
        });
    }
    all
}

#[test]
fn parabola_by_points_is_the_parabola_with_all_derivatives_also_beyond_its_ends() {
    let (measured, formula) = (Measured::default(), Formula::default());
    // In front, at points, between them, behind.
    for y in [-2.7, -2.0, -1.3, -0.3, 0.0, 0.11, 0.9, 1.99, 2.6] {
        let x = [y, 0.2, 1.4, -0.7, 3.0];
        let (ours, theirs) = (functions(&measured, &x), functions(&formula, &x));
        for (k, (a, b)) in ours.iter().zip(&theirs).enumerate() {
            // Third derivatives cancel from values of a thousand millimetres over ten centimetres.
            let scale = 1.0 + b.abs();
            assert!((a - b).abs() < 1e-9 * scale, "{k} at {y}: {a} and {b}");
        }
    }
}

#[test]
fn motion_and_optimum_on_a_measured_parabola_are_those_on_the_parabola() {
    let (measured, formula) = (Measured::default(), Formula::default());
    let ends = [&measured as &dyn Model, &formula].map(|model| {
        let run = simulate(model).run().unwrap();
        assert!(run.status.is_solved(), "{run}");
        run.at(1.2).unwrap()["y"]
    });
    assert!((ends[0] - ends[1]).abs() < 1e-9, "{ends:?}");
    let optima = [&measured as &dyn Model, &formula].map(|model| {
        let best = solve(model).intervals(4).run().unwrap();
        assert!(best.status.is_solved(), "{:?}", best.status);
        best.objective
    });
    assert!((optima[0] - optima[1]).abs() < 1e-7, "{optima:?}");
}

#[test]
fn pieces_of_a_surface_are_contacts_that_know_each_other() {
    let contacts = Edges::default().declaration().contacts;
    let known: Vec<_> = contacts.iter().map(|c| (c.name, c.alternatives)).collect();
    let none: &[usize] = &[];
    assert_eq!(
        known,
        [
            ("ground.1", none),
            ("ground.2", &[2, 3]),
            ("ground.3", &[1, 3]),
            ("ground.4", &[1, 2]),
        ]
    );
}
