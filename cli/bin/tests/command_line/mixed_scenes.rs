//! Random scenes in which contacts of all kinds meet: bodies in a row with stops, springs and ropes between them, blocks on ground that
//! moves or is bumpy, arms with stops and friction in their joints, bodies with rough corners. They run to their ends, and in
//! which order their surfaces are declared changes nothing.
//!
//! A small set runs with the other tests; the large one by
//! `HANGTIME_MIXED_SCENES=3000 cargo test -p hangtime-bin --test command_line mixed_scenes`.

use std::fmt::Write as _;

use serde_json::Value;

use crate::support::{Random, Scratch, hangtime};

/// How many scenes run unless the variable says how many.
const SCENES: usize = 30;
const VARIABLE: &str = "HANGTIME_MIXED_SCENES";
/// One of so many may stop before its horizon, or be confirmed by no second run: motions that depend on their start too sensitively.
const STOPS: usize = 1000;

/// A scene: what stands before its contacts, each of them with its law, and what stands behind.
struct Scene {
    head: String,
    contacts: Vec<String>,
    tail: String,
}

impl Scene {
    /// Its text with the contacts in the order of `turned`, last ones first.
    fn text(&self, turned: bool) -> String {
        let mut contacts: Vec<&str> = self.contacts.iter().map(String::as_str).collect();
        if turned {
            contacts.reverse();
        }
        format!("{}{}{}", self.head, contacts.concat(), self.tail)
    }
}

/// A law without friction.
fn plain(random: &mut Random) -> String {
    if random.chance(0.5) {
        "inelastic".to_owned()
    } else {
        format!("restitution {:.3}", random.within(0.1, 0.95))
    }
}

fn rough(random: &mut Random, sliding: &str) -> String {
    let law = if random.chance(0.7) {
        "inelastic".to_owned()
    } else {
        format!("restitution {:.3}", random.within(0.05, 0.5))
    };
    format!(
        "{law}, friction {:.3}, sliding {sliding}",
        random.within(0.05, 0.7)
    )
}

/// Bodies on a line: stops and springs between them, walls at rest or moving, dry friction on some.
fn row(random: &mut Random) -> Scene {
    let count = random.whole(2, 5);
    let names: Vec<String> = (0..count).map(|k| format!("x{k}")).collect();
    let (mut energy, mut contacts, mut start) = (Vec::new(), Vec::new(), Vec::new());
    for (k, x) in names.iter().enumerate() {
        energy.push(format!("{:.3}*dot({x})^2", random.within(0.1, 1.0)));
        start.push(format!(
            "{x}: {:.3}, dot({x}): {:.3}",
            k as f64 + random.within(0.0, 0.3),
            random.within(-2.0, 2.0)
        ));
        if random.chance(0.4) {
            contacts.push(format!(
                "dry friction rub{k}: bound {:.3}, sliding dot({x})\n",
                random.within(0.2, 2.0)
            ));
        }
    }
    for k in 1..count {
        let (left, right) = (&names[k - 1], &names[k]);
        contacts.push(format!(
            "surface near{k}: {right} - {left} >= {:.3}\nimpact near{k}: {}\n",
            random.within(0.2, 0.6),
            plain(random)
        ));
        if random.chance(0.3) {
            contacts.push(format!(
                "surface far{k}: {right} - {left} <= {:.3}\nimpact far{k}: {}\n",
                random.within(1.4, 2.0),
                plain(random)
            ));
        }
        if random.chance(0.5) {
            energy.push(format!(
                "-{:.3}*({right} - {left} - 1)^2",
                random.within(1.0, 20.0)
            ));
        }
    }
    let wall = if random.chance(0.5) {
        format!(
            "{:.3}*sin({:.3}*t)",
            random.within(0.05, 0.3),
            random.within(1.0, 8.0)
        )
    } else {
        "0".to_owned()
    };
    contacts.push(format!(
        "surface wall: x0 >= {wall} - 0.5\nimpact wall: {}\n",
        plain(random)
    ));
    finish(
        names.join(", "),
        &energy.join(" + "),
        contacts,
        &start.join(", "),
        random.within(1.0, 3.0),
    )
}

fn finish(
    coordinates: String,
    energy: &str,
    contacts: Vec<String>,
    start: &str,
    horizon: f64,
) -> Scene {
    Scene {
        head: format!(
            "coordinates {{ {coordinates} }}\nlagrangian {}\n",
            energy.replace("+ -", "- ")
        ),
        contacts,
        tail: format!("start {{ {start} }}\nhorizon {horizon:.3}\n"),
    }
}

/// A block in a plane on ground that is bumpy or moves, between walls.
fn block(random: &mut Random) -> Scene {
    let ground = match random.whole(0, 2) {
        0 => format!(
            "{:.3}*sin({:.3}*t)",
            random.within(0.02, 0.2),
            random.within(2.0, 12.0)
        ),
        1 => format!(
            "{:.3}*cos({:.3}*y)",
            random.within(0.02, 0.2),
            random.within(1.0, 5.0)
        ),
        _ => format!("{:.3}*y", random.within(-0.4, 0.4)),
    };
    let belt = random.within(-1.0, 1.0);
    let law = if random.chance(0.6) {
        rough(random, &format!("dot(y) - {belt:.3}").replace("- -", "+ "))
    } else {
        plain(random)
    };
    let mut contacts = vec![format!(
        "surface ground: z >= {ground}\nimpact ground: {law}\n"
    )];
    for (name, relation) in [("left", ">= -"), ("right", "<= ")] {
        contacts.push(format!(
            "surface {name}: y {relation}{:.3}\nimpact {name}: {}\n",
            random.within(0.3, 1.0),
            plain(random)
        ));
    }
    if random.chance(0.4) {
        contacts.push(format!(
            "surface roof: z <= {:.3}\nimpact roof: {}\n",
            random.within(0.8, 1.5),
            plain(random)
        ));
    }
    if random.chance(0.3) {
        contacts.push(format!(
            "dry friction guide: bound {:.3}, sliding dot(y)\n",
            random.within(0.1, 1.0)
        ));
    }
    let start = format!(
        "z: {:.3}, y: {:.3}, dot(y): {:.3}, dot(z): {:.3}",
        random.within(0.25, 0.7),
        random.within(-0.2, 0.2),
        random.within(-2.0, 2.0),
        random.within(-1.0, 1.0)
    );
    finish(
        "y, z".to_owned(),
        "(dot(y)^2 + dot(z)^2)/2 - 9.81*z",
        contacts,
        &start,
        random.within(0.8, 2.0),
    )
}

/// A double pendulum with stops and friction in its joints.
fn arm(random: &mut Random) -> Scene {
    let mut contacts = Vec::new();
    for joint in ["a", "b"] {
        for (side, relation) in [("low", ">= -"), ("high", "<= ")] {
            if random.chance(0.8) {
                // Beyond where it starts.
                let stop = random.within(0.3, 0.9) + if joint == "a" { 0.85 } else { 0.0 };
                contacts.push(format!(
                    "surface {joint}{side}: {joint} {relation}{stop:.3}\nimpact {joint}{side}: {}\n",
                    plain(random)
                ));
            }
        }
        if random.chance(0.5) {
            contacts.push(format!(
                "dry friction {joint}rub: bound {:.3}, sliding dot({joint})\n",
                random.within(0.05, 1.5)
            ));
        }
    }
    let floor = random.within(1.45, 1.9);
    contacts.push(format!(
        "surface floor: {floor:.3} >= cos(a) + cos(a + b)\nimpact floor: {}\n",
        plain(random)
    ));
    let energy = "dot(a)^2/2 + (dot(a)^2 + (dot(a) + dot(b))^2 + 2*dot(a)*(dot(a) + dot(b))*cos(b))/2 \
                  + 9.81*(2*cos(a) + cos(a + b))";
    let a = random.within(0.8, 1.1);
    let start = format!(
        "a: {a:.3}, b: {:.3}, dot(a): {:.3}, dot(b): {:.3}",
        random.within(0.0, 0.25),
        random.within(-1.0, 1.0),
        random.within(-2.0, 2.0)
    );
    finish(
        "a, b".to_owned(),
        energy,
        contacts,
        &start,
        random.within(0.5, 1.5),
    )
}

/// A body with corners over bumpy, rough ground.
fn corners(random: &mut Random) -> Scene {
    let count = random.whole(2, 4);
    let r = random.within(0.2, 0.4);
    let (bump, waves) = (random.within(0.0, 0.1), random.within(1.0, 4.0));
    let law_of = |random: &mut Random, k: usize, friction: bool| {
        if friction {
            rough(random, &format!("dot(c{k}).x"))
        } else {
            plain(random)
        }
    };
    let friction = random.chance(0.6);
    let mut head = String::new();
    let mut contacts = Vec::new();
    let phase = random.within(0.0, 1.0);
    for k in 0..count {
        let angle = phase + std::f64::consts::TAU * k as f64 / count as f64;
        let _ = writeln!(
            head,
            "let c{k} = (x + {r:.4}*cos(phi + {angle:.4}), z + {r:.4}*sin(phi + {angle:.4}))"
        );
        let law = law_of(random, k, friction);
        contacts.push(format!(
            "surface f{k}: c{k}.z - {bump:.3}*cos({waves:.3}*c{k}.x) >= 0\nimpact f{k}: {law}\n"
        ));
    }
    let start = format!(
        "z: {:.3}, phi: {:.3}, dot(x): {:.3}, dot(z): {:.3}, dot(phi): {:.3}",
        random.within(0.6, 1.0),
        random.within(-1.0, 1.0),
        random.within(-1.0, 1.0),
        random.within(-1.0, 0.5),
        random.within(-4.0, 4.0)
    );
    let energy = "(dot(x)^2 + dot(z)^2)/2 + 0.02*dot(phi)^2 - 9.81*z";
    let mut scene = finish(
        "x, z, phi".to_owned(),
        energy,
        contacts,
        &start,
        random.within(0.6, 1.4),
    );
    scene.head += &head;
    scene
}

fn scene(number: usize) -> Scene {
    let kinds = [row, block, arm, corners];
    kinds[number % kinds.len()](&mut Random(1_000_003 * (number as u64 + 1)))
}

/// What a run of the program says.
struct Run {
    status: String,
    /// Why it ended, on the standard error stream.
    message: String,
    q: Vec<f64>,
    error: f64,
}

fn run(file: &str) -> Run {
    let output = hangtime(&["simulate", file, "--json", "--time-limit", "60s"]);
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    let result: Value = serde_json::from_slice(&output.stdout).unwrap_or_default();
    let numbers = result["final"]["q"].as_array();
    let numbers = numbers.into_iter().flatten().filter_map(Value::as_f64);
    Run {
        status: result["status"].as_str().unwrap_or("refused").to_owned(),
        message,
        q: numbers.collect(),
        error: result["error_estimate"].as_f64().unwrap_or(0.0),
    }
}

/// What is wrong with a scene, and whether it stops.
fn judge(folder: &Scratch, number: usize) -> (Option<String>, bool) {
    let scene = scene(number);
    let [straight, turned] = [false, true].map(|turned| {
        let file = folder.0.join(format!("scene{number}{turned}.hang"));
        std::fs::write(&file, scene.text(turned)).unwrap();
        run(file.to_str().unwrap())
    });
    let text = scene.text(false);
    if straight.status != turned.status {
        let [one, other] =
            [&straight, &turned].map(|run| format!("{} {}", run.status, run.message));
        let wrong = format!("{number}: {one}\nwith the contacts in another order: {other}\n{text}");
        return (Some(wrong), straight.status != "solved");
    }
    if straight.status != "solved" {
        return (
            Some(format!("{number}: {}\n{text}", straight.message)),
            true,
        );
    }
    let apart = straight.q.iter().zip(&turned.q);
    let apart = apart.fold(0.0_f64, |most, (a, b)| {
        most.max((a - b).abs() / (1.0 + a.abs()))
    });
    let allowed = 2e-6 + 10.0 * (straight.error + turned.error);
    let wrong = (apart > allowed)
        .then(|| format!("{number}: {apart:e} apart with the contacts in another order\n{text}"));
    (wrong, false)
}

#[test]
fn scenes_of_mixed_contacts_run_to_their_ends_in_any_order_of_their_surfaces() {
    let asked = std::env::var(VARIABLE).ok();
    let count = asked.map_or(SCENES, |count| count.parse().expect("a number of scenes"));
    let folder = Scratch::new("mixed-scenes");
    std::fs::create_dir_all(folder.text()).unwrap();
    let (mut failures, mut stops) = (Vec::new(), Vec::new());
    for number in 0..count {
        match judge(&folder, number) {
            (Some(reason), true) => stops.push(reason),
            (Some(wrong), false) => failures.push(wrong),
            (None, _) => {}
        }
    }
    let text = format!(
        "{} stop:\n{}\n{} differ:\n{}",
        stops.len(),
        stops.join("\n"),
        failures.len(),
        failures.join("\n")
    );
    println!("{text}");
    assert!(
        stops.len() <= count / STOPS && failures.is_empty(),
        "{text}"
    );
}
