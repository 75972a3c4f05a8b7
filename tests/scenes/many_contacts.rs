//! Contacts by the hundred: closed forms, balances, and the default simulation against the event-driven one.

#[path = "../../benches/contacts/families.rs"]
mod families;

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
        families::stack(6, None),
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

/// Discs of weight `w` in rows of `k`, `k - 1`, .. 1 between walls. In the lines at 60 degrees each contact carries half of
/// `w / cos 30` more than the one above it; what bottom discs and walls share is not determined.
#[test]
fn pyramid_of_discs_has_the_forces_of_its_closed_form() {
    let k: usize = 5;
    let rise = 0.2 * 0.75_f64.sqrt();
    let name = |row: usize, j: usize| format!("{row}_{j}");
    let discs: Vec<(usize, usize)> = (0..k)
        .flat_map(|row| (0..k - row).map(move |j| (row, j)))
        .collect();
    let (mut coordinates, mut energy, mut surfaces, mut start) = (vec![], vec![], vec![], vec![]);
    let mut wanted = Vec::new();
    for &(row, j) in &discs {
        let own = name(row, j);
        coordinates.push(format!("x{own}: m, z{own}: m"));
        energy.push(format!("m/2*(dot(x{own})^2 + dot(z{own})^2) - m*g*z{own}"));
        let (x, z) = (0.1 * row as f64 + 0.2 * j as f64, 0.1 + rise * row as f64);
        start.push(format!("x{own}: {x:.17} [m], z{own}: {z:.17} [m]"));
        if row == 0 {
            surfaces.push((format!("f{own}"), format!("z{own} - 0.1 [m]")));
            continue;
        }
        for (side, below) in [("l", name(row - 1, j)), ("r", name(row - 1, j + 1))] {
            let gap = format!("|(x{own} - x{below}, z{own} - z{below})| - 0.2 [m]");
            // The number of discs above along that line, the disc itself included.
            let along = if side == "l" { k - row - j } else { j + 1 };
            wanted.push((
                surfaces.len(),
                along as f64 * 9.81 / (2.0 * 0.75_f64.sqrt()),
            ));
            surfaces.push((format!("{side}{own}"), gap));
        }
    }
    surfaces.push(("left".into(), format!("x{}", name(0, 0))));
    surfaces.push((
        "right".into(),
        format!("{:.17} [m] - x{}", 0.2 * (k - 1) as f64, name(0, k - 1)),
    ));
    for j in 1..k {
        let (one, other) = (name(0, j - 1), name(0, j));
        surfaces.push((format!("b{j}"), format!("x{other} - x{one} - 0.2 [m]")));
    }
    let declared: Vec<String> = surfaces
        .iter()
        .map(|(name, gap)| format!("surface {name}: {gap} >= 0"))
        .collect();
    let names: Vec<&str> = surfaces.iter().map(|(name, _)| name.as_str()).collect();
    let text = format!(
        "parameters {{ m: kg = 1, g: m/s^2 = 9.81 }} coordinates {{ {} }} lagrangian {} {} impact {}: inelastic start {{ {} }} \
         horizon 0.1 [s]",
        coordinates.join(", "),
        energy.join(" + "),
        declared.join(" "),
        names.join(", "),
        start.join(", "),
    );
    let scene = scene(&text);
    for run in [default_run(&scene), event_driven(&scene)] {
        let forces = last(&run.trajectory.contact_force);
        for &(contact, force) in &wanted {
            // Positions are right to 1e-15 of their contacts' distances.
            let off = (forces[contact] - force).abs();
            assert!(
                off < 1e-9,
                "{}: {} {force}",
                names[contact],
                forces[contact]
            );
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
        let heights: f64 = q.iter().skip(1).step_by(2).sum();
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
    let backwards = {
        let (before, rest) = text.split_once(" surface ").expect("surfaces");
        let (surfaces, after) = rest.split_once(" impact ").expect("impacts");
        let mut surfaces: Vec<&str> = surfaces.split(" surface ").collect();
        surfaces.reverse();
        format!(
            "{before} surface {} impact {after}",
            surfaces.join(" surface ")
        )
    };
    assert_ne!(text, backwards);
    let (one, other) = (scene(&text), scene(&backwards));
    assert!(apart(&default_run(&one), &default_run(&other)) < 1e-10);
    assert!(apart(&event_driven(&one), &event_driven(&other)) < 1e-10);
}
