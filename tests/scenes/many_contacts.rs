//! Contacts by the hundred: closed forms, balances, and the default simulation against the event-driven one.

#[path = "../../benches/contacts/families.rs"]
mod families;

use hangtime::model::Function;
use hangtime::prelude::*;
use hangtime::simulation::{EventDriven, Simulation};
use hangtime_scene_files::{TextScene, of_text};

fn scene(text: &str) -> TextScene {
    of_text("scene.hang", text).unwrap_or_else(|error| panic!("{error}"))
}

fn default_run(scene: &TextScene) -> Simulation {
    let run = simulate(scene).run().expect("a problem");
    assert!(run.status.is_solved(), "{:?}", run.status);
    run
}

fn event_driven(scene: &TextScene) -> Simulation {
    let run = simulate(scene)
        .method(EventDriven::default())
        .run()
        .expect("a problem");
    assert!(run.status.is_solved(), "{:?}", run.status);
    run
}

fn last(rows: &[Vec<f64>]) -> &[f64] {
    rows.last().expect("an end")
}

/// Largest difference of the coordinates at the end.
fn apart(one: &Simulation, other: &Simulation) -> f64 {
    let pairs = last(&one.trajectory.q)
        .iter()
        .zip(last(&other.trajectory.q));
    pairs.fold(0.0, |most, (a, b)| f64::max(most, (a - b).abs()))
}

/// Each is run to the default tolerances of 1e-9 and more; events amplify that.
#[test]
fn default_and_event_driven_agree_on_up_to_forty_contacts() {
    let scenes = [
        families::row(20, "inelastic", 1.0),
        families::tower(20),
        families::stack(6),
        families::rough_blocks(12),
        families::discs(6),
        families::chain(5),
        families::bar(6),
    ];
    for text in scenes {
        let scene = scene(&text);
        let difference = apart(&default_run(&scene), &event_driven(&scene));
        assert!(difference < 1e-6, "{difference:e}: {text}");
    }
}

/// The textbook's equations of a chain of `n` links of length `l` with equal masses at their ends, in absolute angles from the vertical:
/// `sum_j c_ij (l cos(q_i - q_j) q_j'' + l sin(q_i - q_j) q_j'^2) + c_i g sin q_i = 0`, where `c_i` masses hang below link `i` and
/// `c_ij` below both. The rates of `(q, q')`.
fn chain_rates(state: &[f64], l: f64) -> Vec<f64> {
    let n = state.len() / 2;
    let (q, v) = state.split_at(n);
    let below = |i: usize| (n - i) as f64;
    let mut matrix = nalgebra::DMatrix::zeros(n, n);
    let mut right = nalgebra::DVector::zeros(n);
    for i in 0..n {
        right[i] = -below(i) * 9.81 * q[i].sin();
        for j in 0..n {
            let (c, apart) = (below(i.max(j)) * l, q[i] - q[j]);
            matrix[(i, j)] = c * apart.cos();
            right[i] -= c * apart.sin() * v[j] * v[j];
        }
    }
    let rates = nalgebra::Cholesky::new(matrix).expect("positive definite");
    let rates = rates.solve(&right);
    v.iter().copied().chain(rates.iter().copied()).collect()
}

/// Its motion by the classical Runge-Kutta method.
fn chain_by_hand(mut state: Vec<f64>, l: f64, (horizon, steps): (f64, usize)) -> Vec<f64> {
    let h = horizon / steps as f64;
    let moved = |state: &[f64], rates: &[f64], h: f64| -> Vec<f64> {
        let pairs = state.iter().zip(rates);
        pairs.map(|(x, rate)| x + h * rate).collect()
    };
    for _ in 0..steps {
        let one = chain_rates(&state, l);
        let two = chain_rates(&moved(&state, &one, h / 2.0), l);
        let three = chain_rates(&moved(&state, &two, h / 2.0), l);
        let four = chain_rates(&moved(&state, &three, h), l);
        for (i, x) in state.iter_mut().enumerate() {
            *x += h / 6.0 * (one[i] + 2.0 * two[i] + 2.0 * three[i] + four[i]);
        }
    }
    state
}

/// So many links swing down freely from where they are nearly stretched.
#[test]
fn chain_of_24_links_moves_as_the_equations_of_the_textbook_say() {
    let (n, horizon) = (24, 0.3);
    let scene = scene(&families::hanging(n, |i| 0.8 + 0.02 * i as f64, horizon));
    let start = (1..=n).map(|i| 0.8 + 0.02 * i as f64);
    let start: Vec<f64> = start.chain(vec![0.0; n]).collect();
    let half = chain_by_hand(start.clone(), 0.1, (horizon, 100));
    let whole = chain_by_hand(start, 0.1, (horizon, 200));
    for run in [default_run(&scene), event_driven(&scene)] {
        for (i, angle) in last(&run.trajectory.q).iter().enumerate() {
            // Of order four: what half the steps differ by is 15 times the error. The default promises 1e-6 of the largest angle.
            let error = (whole[i] - half[i]).abs() / 15.0 + 1e-6;
            assert!(
                (angle - whole[i]).abs() < error,
                "{i}: {angle} {}",
                whole[i]
            );
            assert!(error < 1e-5, "{i}: {error:e}");
        }
    }
}

/// Small oscillations of a hanging chain of `n` equal masses: `omega^2 = x g/l` at a zero `x` of the Laguerre polynomial `L_n`, and the
/// mass with `j` others below it swings by `L_j(x)`. After a period it is where it was.
#[test]
fn hanging_chain_of_16_links_oscillates_with_its_closed_frequencies() {
    let n = 16;
    let laguerre = |x: f64| {
        let mut all = vec![1.0, 1.0 - x];
        for j in 1..n {
            let j1 = j as f64;
            all.push(((2.0 * j1 + 1.0 - x) * all[j] - j1 * all[j - 1]) / (j1 + 1.0));
        }
        all
    };
    // The two lowest zeros, between neighbours of other sign.
    let grid = (0..10_000).map(|k| 1e-4 * f64::from(k));
    let crosses = |&x: &f64| laguerre(x)[n] * laguerre(x + 1e-4)[n] < 0.0;
    for x in grid.filter(crosses).take(2) {
        let (mut low, mut high) = (x, x + 1e-4);
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            match laguerre(low)[n] * laguerre(middle)[n] < 0.0 {
                true => high = middle,
                false => low = middle,
            }
        }
        let shape = laguerre(low);
        let period = std::f64::consts::TAU / (low * 9.81 / 0.1).sqrt();
        // Link i from the top is between the masses with n - i and n + 1 - i others below.
        let bent = |i: usize| shape[n - i] - shape[n + 1 - i];
        let largest = (1..=n).map(|i| bent(i).abs()).fold(0.0, f64::max);
        let angle = |i: usize| 1e-4 * bent(i) / largest;
        let run = default_run(&scene(&families::hanging(n, angle, period)));
        for (i, q) in last(&run.trajectory.q).iter().enumerate() {
            // Promised are 1e-6 of the largest angle; what is not linear is 1e-4 squared of it.
            let error = (q - angle(i + 1)).abs();
            assert!(error < 1.1e-6 * 1e-4, "{i}: {error:e} {period}");
        }
    }
}

/// More of them: `HANGTIME_SCENES=3000 cargo test --test scenes random_rows`.
#[test]
fn random_rows_of_balls_keep_momentum_and_agree() {
    let scenes = std::env::var("HANGTIME_SCENES")
        .ok()
        .and_then(|text| text.parse().ok())
        .unwrap_or(30);
    for seed in 0..scenes {
        let n = 3 + seed * 7 % 28;
        let law = ["inelastic", "restitution 0.5", "restitution 1"][seed % 3];
        let scene = scene(&families::row(n, law, 0.7 + 0.01 * seed as f64));
        let (one, other) = (default_run(&scene), event_driven(&scene));
        assert!(apart(&one, &other) < 1e-8, "{seed}");
        let before: f64 = one.trajectory.v[0].iter().sum();
        let after: f64 = last(&one.trajectory.v).iter().sum();
        // Sums of 30 velocities of the order of 1.
        assert!((before - after).abs() < 1e-12, "{seed}: {before} {after}");
    }
}

#[test]
fn row_of_fifty_balls_that_is_struck_has_the_velocities_of_moreaus_law() {
    for (law, restitution) in [("inelastic", 0.0), ("restitution 1", 1.0)] {
        let scene = scene(&families::row(50, law, 1.0));
        for run in [default_run(&scene), event_driven(&scene)] {
            // The others stay together with the velocity u, and the first leaves them by as much as it came:
            // v_1 + 49 u = 1, u - v_1 = e.
            let u = (1.0 + restitution) / 50.0;
            for (k, v) in last(&run.trajectory.v).iter().enumerate() {
                let wanted = if k == 0 { u - restitution } else { u };
                assert!((v - wanted).abs() < 1e-12, "{law} {k}: {v}");
            }
        }
    }
}

/// Inelastic impacts and contacts without friction take energy or leave it.
#[test]
fn discs_in_a_box_lose_energy_at_impacts_only() {
    let scene = scene(&families::discs(8));
    let run = default_run(&scene);
    let energy = |k: usize| {
        let (q, v) = (&run.trajectory.q[k], &run.trajectory.v[k]);
        let heights: f64 = q[8..].iter().sum();
        0.5 * v.iter().map(|v| v * v).sum::<f64>() + 9.81 * heights
    };
    let largest = energy(0);
    for k in 1..run.trajectory.time.len() {
        // What steps of tolerance 1e-9 leave of 40 J.
        assert!(energy(k) <= energy(k - 1) + 1e-8 * largest, "{k}");
    }
    assert!(run.events.len() > 10);
}

#[test]
fn order_of_declarations_changes_nothing() {
    let text = families::tower(16);
    let backwards = text
        .replace("z[k - 1]", "z[n - k]")
        .replace("k > 1", "k < n");
    let backwards = backwards.replace("[k in 1..=n]: z[k]", "[k in 1..=n]: z[n + 1 - k]");
    assert_ne!(text, backwards);
    let (one, other) = (scene(&text), scene(&backwards));
    assert!(apart(&default_run(&one), &default_run(&other)) < 1e-10);
    assert!(apart(&event_driven(&one), &event_driven(&other)) < 1e-10);
}

/// Discs of masses `mass` that roll and slide on each other and on a rough floor that is no plane.
fn rolling_discs(count: usize, mass: &str) -> TextScene {
    scene(&format!(
        "count n = {count}
        parameters {{ m: kg = 2, own[n]: kg = 2, r: m = 0.1, g: m/s^2 = 9.81, mu = 0.3, far: m = 0.7 }}
        coordinates {{ x[n]: m, z[n]: m, phi[n]: rad }}
        let p[k in 1..=n] = (x[k], z[k])
        lagrangian sum(k in 1..=n: {mass}/2*|dot(p[k])|^2 + {mass}*r^2/4*dot(phi[k])^2 - {mass}*g*z[k])
        surface pair[i in 2..=n, j in 1..i]: |p[i] - p[j]| >= 2*r
        impact pair[i in 2..=n, j in 1..i]: restitution 0.4, friction mu, sliding r*(dot(phi[i]) + dot(phi[j])) + (x[i]*dot(z[j]) - z[i]*dot(x[j]))/far
        surface floor[i in 1..=n]: z[i] >= r + 0.1 [m]*sin(x[i]/far)^2
        impact floor[i in 1..=n]: inelastic, friction mu, sliding dot(x[i]) + r*dot(phi[i])
        start {{ x[k in 1..=n]: 0.3 [m]*k, z[k in 1..=n]: 0.5 [m] + 0.2 [m]*k }}
        horizon 1 [s]"
    ))
}

/// All that solvers ask of a contact at a place, with its derivatives.
fn asked(model: &dyn Model, contact: usize, x: &[f64]) -> Vec<f64> {
    let declaration = model.declaration();
    let (n, known) = (
        declaration.coordinates.len(),
        &declaration.contacts[contact],
    );
    let side = known.friction.expect("friction");
    let mut all = vec![0.0; 4 + 2 * n];
    model.contact(contact, x, &mut all);
    let mut add = |length: usize, fill: &dyn Fn(&mut [f64])| {
        let from = all.len();
        all.resize(from + length, 0.0);
        fill(&mut all[from..]);
    };
    let weights: Vec<f64> = (0..2 + n).map(|k| 0.3 + 0.1 * k as f64).collect();
    add(known.jacobian.entries.len(), &|out| {
        model.jacobian(Function::Contact(contact), x, out)
    });
    add(known.hessian.entries.len(), &|out| {
        model.hessian(Function::Contact(contact), x, &weights, out)
    });
    add(2 + 2 * n, &|out| model.tangent(contact, x, out));
    add(side.jacobian.entries.len(), &|out| {
        model.jacobian(Function::Tangent(contact), x, out)
    });
    add(side.hessian.entries.len(), &|out| {
        model.hessian(Function::Tangent(contact), x, &weights[1..], out);
    });
    all
}

/// Entries of patterns in their order, which decides where values stand.
fn patterns(model: &dyn Model, contact: usize) -> [Vec<(u32, u32)>; 4] {
    let known = &model.declaration().contacts[contact];
    let side = known.friction.expect("friction");
    [known.jacobian, known.hessian, side.jacobian, side.hessian].map(|known| known.entries.to_vec())
}

/// With a mass of its own each contact is derived by itself; with one mass they are one contact under other names.
#[test]
fn contacts_under_other_names_are_those_that_are_derived_by_themselves() {
    let (shared, own) = (rolling_discs(5, "m"), rolling_discs(5, "own[k]"));
    let x: Vec<f64> = (0..30)
        .map(|k| 0.4 * f64::from(k) + (1.7 * f64::from(k)).sin())
        .collect();
    for contact in 0..shared.declaration().contacts.len() {
        assert_eq!(
            patterns(&shared, contact),
            patterns(&own, contact),
            "contact {contact}"
        );
        let (one, other) = (asked(&shared, contact, &x), asked(&own, contact, &x));
        let size = one
            .iter()
            .fold(1.0_f64, |most, value| most.max(value.abs()));
        for (k, (a, b)) in one.iter().zip(&other).enumerate() {
            assert!(
                (a - b).abs() < 1e-12 * size,
                "value {k} of contact {contact}: {a} {b}"
            );
        }
    }
}
