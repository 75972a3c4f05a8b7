//! Random mechanisms with contacts, as scene files: boxes and stacks of boxes, wheels, tiles, sliders in slots with
//! clearance. The gaps of their corners are combinations of each other; none is refused, and independent methods
//! agree.
//!
//! A small set runs with the other tests; the large one by
//! `HANGTIME_SCENES=1000 cargo test -p hangtime-bin --test command_line contact_scenes`.

use std::fmt::Write as _;

use serde_json::Value;

use crate::support::{Random, Scratch, json};

/// A law for one body: hard, bouncing or rough.
fn law(random: &mut Random, sliding: &str) -> String {
    match random.whole(0, 2) {
        0 => "inelastic".to_owned(),
        1 => format!("restitution {:.3}", random.within(0.1, 0.5)),
        _ => format!(
            "inelastic, friction {:.3}, sliding {sliding}",
            random.within(0.1, 0.8)
        ),
    }
}

/// A body with corners at distances and angles from its centre, over a floor at some height.
fn corners(random: &mut Random, corners: &[(f64, f64)], (x, z, phi): (f64, f64, f64)) -> String {
    // The origin of coordinates is anywhere.
    let floor = random.within(-2.0, 2.0);
    let mut text = String::from(
        "coordinates { x: m, z: m, phi: rad }\n\
         lagrangian 1 [kg]/2*|dot((x, z))|^2 + 0.02 [kg m^2]*dot(phi)^2 - 9.81 [N]*z\n",
    );
    let kind = random.0;
    for (k, (r, angle)) in corners.iter().enumerate() {
        let mut same = Random(kind);
        let law = law(&mut same, &format!("dot(c{k}).x"));
        let _ = writeln!(
            text,
            "let c{k} = (x + {r:.6} [m]*cos(phi + {angle:.6}), z + {r:.6} [m]*sin(phi + {angle:.6}))\n\
             surface f{k}: c{k}.z >= {floor:.6} [m]\nimpact f{k}: {law}"
        );
    }
    let _ = writeln!(
        text,
        "start {{ x: {x:.4} [m], z: {:.4} [m], phi: {phi:.4}, dot(x): {:.4} [m/s], dot(phi): {:.4} }}\nhorizon {:.3} [s]",
        z + floor,
        random.within(-1.0, 1.0),
        random.within(-3.0, 3.0),
        random.within(0.5, 1.2)
    );
    text
}

fn box_on_floor(random: &mut Random) -> String {
    let (w, h) = (random.within(0.1, 0.4), random.within(0.1, 0.4));
    let (r, angle) = (w.hypot(h), h.atan2(w));
    let pi = std::f64::consts::PI;
    let all = [(r, angle), (r, pi - angle), (r, pi + angle), (r, -angle)];
    let start = (0.0, r + random.within(0.05, 0.8), random.within(-0.7, 0.7));
    corners(random, &all, start)
}

fn wheel(random: &mut Random) -> String {
    let spokes = random.whole(3, 8);
    let r = random.within(0.2, 0.5);
    let step = std::f64::consts::TAU / spokes as f64;
    let all: Vec<(f64, f64)> = (0..spokes).map(|k| (r, step * k as f64)).collect();
    let start = (0.0, r + random.within(0.05, 0.5), random.within(-0.7, 0.7));
    corners(random, &all, start)
}

/// Boxes that do not turn, one above the other between a floor and each other.
fn stack(random: &mut Random) -> String {
    let count = random.whole(2, 4);
    let list = |of: &dyn Fn(usize) -> String, between: &str| {
        (1..=count).map(of).collect::<Vec<_>>().join(between)
    };
    let masses: Vec<f64> = (0..=count).map(|_| random.within(0.3, 3.0)).collect();
    let height = random.within(0.1, 0.5);
    let coordinates = list(&|k| format!("z{k}: m"), ", ");
    let energy = list(
        &|k| {
            format!(
                "{m:.4} [kg]*(dot(z{k})^2/2 - 9.81 [m/s^2]*z{k})",
                m = masses[k]
            )
        },
        " + ",
    );
    let mut text =
        format!("coordinates {{ {coordinates} }}\nlagrangian {energy}\nsurface s1: z1 >= 0 [m]\n");
    for k in 2..=count {
        let _ = writeln!(text, "surface s{k}: z{k} - z{} >= {height:.4} [m]", k - 1);
    }
    // The lowest part of the last box is that of the first and all gaps: a combination of them, which closes with them.
    let _ = writeln!(
        text,
        "surface top: z{count} >= {:.4} [m]",
        (count - 1) as f64 * (height * 1e4).round() / 1e4
    );
    let _ = writeln!(
        text,
        "impact {}, top: inelastic",
        list(&|k| format!("s{k}"), ", ")
    );
    let begins: Vec<f64> = (0..=count)
        .map(|k| k as f64 * (height + 0.1) + random.within(0.0, 0.1))
        .collect();
    let start = list(&|k| format!("z{k}: {:.4} [m]", begins[k]), ", ");
    let _ = writeln!(
        text,
        "start {{ {start} }}\nhorizon {:.3} [s]",
        random.within(0.6, 1.2)
    );
    text
}

/// A slider on a spring in a slot with clearance: four corners between two rails.
fn slider(random: &mut Random) -> String {
    let (w, h) = (random.within(0.1, 0.3), random.within(0.05, 0.15));
    let clearance = random.within(0.002, 0.02);
    let law = match random.whole(0, 1) {
        0 => "inelastic".to_owned(),
        _ => format!("restitution {:.3}", random.within(0.1, 0.5)),
    };
    let mut text = "coordinates { x: m, z: m, phi: rad }\nlagrangian 1 [kg]/2*|dot((x, z))|^2 + 0.01 [kg m^2]*dot(phi)^2 \
                    - 9.81 [N]*z - 50 [N/m]/2*x^2\n"
        .to_owned();
    for (k, (x, z)) in [(w, h), (-w, h), (w, -h), (-w, -h)].into_iter().enumerate() {
        let place = format!("z + {x:.5} [m]*sin(phi) + {z:.5} [m]*cos(phi)");
        let rail = h + clearance;
        let relation = if z > 0.0 {
            format!("<= {rail:.5}")
        } else {
            format!(">= -{rail:.5}")
        };
        let _ = writeln!(
            text,
            "surface r{k}: {place} {relation} [m]\nimpact r{k}: {law}"
        );
    }
    let _ = writeln!(
        text,
        "start {{ x: {:.4} [m], dot(z): {:.4} [m/s], dot(phi): {:.4} }}\nhorizon {:.3} [s]",
        random.within(0.1, 0.3),
        random.within(-0.3, 0.3),
        random.within(-1.0, 1.0),
        random.within(0.2, 0.5)
    );
    text
}

/// A block that slides over tiles of different roughness, flush with each other.
fn tiles(random: &mut Random) -> String {
    let seam = random.within(0.3, 1.0);
    let (first, second) = (random.within(0.02, 0.1), random.within(0.1, 0.6));
    format!(
        "coordinates {{ y: m, z: m }}\nlagrangian 1 [kg]/2*|dot((y, z))|^2 - 9.81 [N]*z\n\
         surface left: max(z, y - {seam:.4} [m]) >= 0 [m]\nsurface right: max(z, {seam:.4} [m] - y) >= 0 [m]\n\
         impact left: inelastic, friction {first:.4}\nimpact right: inelastic, friction {second:.4}\n\
         start {{ z: {:.4} [m], dot(y): {:.4} [m/s] }}\nhorizon 1 [s]\n",
        random.whole(0, 1) as f64 * random.within(0.0, 0.2),
        random.within(2.0, 4.0)
    )
}

fn scene(random: &mut Random, number: usize) -> String {
    let kinds = [box_on_floor, wheel, stack, slider, tiles];
    kinds[number % kinds.len()](random)
}

/// The last state, the size of it, and the estimate of the error of a method.
fn run(file: &str, method: &str) -> (Vec<f64>, f64) {
    let result = json(&["simulate", file, "--json", "--method", method]);
    assert_eq!(result["status"], "solved", "{file} {method}");
    let list = |value: &Value| -> Vec<f64> {
        value
            .as_array()
            .unwrap()
            .iter()
            .map(|value| value.as_f64().unwrap())
            .collect()
    };
    let last = &result["final"];
    let error = result["error_estimate"].as_f64().unwrap_or(0.0);
    (list(&last["q"]), error)
}

/// Largest difference of two states, relative to lengths of 1 m and angles of 1 rad or their own size.
fn apart(one: &[f64], other: &[f64]) -> f64 {
    one.iter().zip(other).fold(0.0, |most, (a, b)| {
        most.max((a - b).abs() / (1.0 + a.abs()))
    })
}

fn compare(numbers: impl Iterator<Item = usize>) {
    let folder = Scratch::new("contact-scenes");
    std::fs::create_dir_all(folder.text()).unwrap();
    let mut failures = Vec::new();
    for number in numbers {
        let text = scene(&mut Random(number as u64 + 1), number);
        let file = folder.0.join(format!("scene{number}.hang"));
        std::fs::write(&file, &text).unwrap();
        let file = file.to_str().unwrap();
        let runs = std::panic::catch_unwind(|| {
            ["fesd", "event", "moreau"].map(|method| run(file, method))
        });
        let Ok([fesd, event, moreau]) = runs else {
            failures.push(format!("{number}: no result\n{text}"));
            continue;
        };
        let located = apart(&fesd.0, &event.0);
        let stepped = apart(&event.0, &moreau.0);
        // Located methods differ by what both allow; an impact magnifies that by its change of slope, some tens of times
        // over a dozen impacts.
        if located > 1e-6 + 1e3 * (fesd.1 + event.1) {
            failures.push(format!(
                "{number}: located methods differ by {located:e}\n{text}"
            ));
        }
        // Time stepping is of first order; where an impact more or less decides, its estimate says so.
        if stepped > 0.05 + 30.0 * moreau.1 {
            failures.push(format!(
                "{number}: Moreau's steps differ by {stepped:e}\n{text}"
            ));
        }
    }
    assert!(
        failures.is_empty(),
        "{} of them:\n{}",
        failures.len(),
        failures.join("\n")
    );
}

/// How many scenes are compared, unless the variable says how many.
const SCENES: usize = 30;
const VARIABLE: &str = "HANGTIME_SCENES";

#[test]
fn bodies_with_corners_run_by_three_methods_that_agree() {
    let asked = std::env::var(VARIABLE).ok();
    let count = asked.map_or(SCENES, |count| count.parse().expect("a number of scenes"));
    compare(0..count);
}
