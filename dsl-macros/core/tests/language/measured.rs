//! Measured motions: what they declare, and what is refused with what to write instead.

use crate::formatted;
use hangtime_dsl::declaration::Measured;
use hangtime_dsl::{describe_differentiated, describe_text};

/// A ball with a coefficient that is looked for, and further statements.
fn scene(further: &str) -> String {
    format!(
        "parameters {{ m: kg = 1, g: m/s^2 = 9.81 }} free e in 0..=1 = 0.5 coordinates {{ y: m, phi: rad }} states {{ a: A }} \
         rates {{ a: -a/1[s] }} lagrangian m/2*dot(y)^2 + m*1[m^2]/2*dot(phi)^2 - m*g*y surface floor: y >= 0 \
         impact floor: restitution e start {{ y: 1 [m], a: 2 [A] }} outputs {{ height: cm = y, fast = dot(y) }} {further}"
    )
}

#[test]
fn experiments_are_described_with_names_units_and_deviations_in_the_declared_units() {
    let text = scene(
        "measured one: \"a b.csv\" { y within 1 [cm], dot(phi) within 90 [deg/s], a within 5, height within 1 [mm] }
         measured two: \"two.csv\" { fast within 0.1 [m/s], start { dot(y): -2*e*1[m/s] } }
         minimize misfit(one) + misfit(two, huber(2))",
    );
    let (derived, warnings) = describe_text(&text, "s").expect("no mistakes");
    assert!(
        warnings.is_empty() && derived.structure.optimal_control.is_none(),
        "{warnings:?}"
    );
    let [one, two] = derived.structure.experiments else {
        panic!()
    };
    assert_eq!(
        (one.file, one.huber, one.own_start),
        ("a b.csv", None, false)
    );
    let known: Vec<(&str, &str, Measured, f64)> = one
        .quantities
        .iter()
        .map(|q| (q.name, q.unit, q.measured, q.within))
        .collect();
    let quarter = std::f64::consts::FRAC_PI_2;
    assert_eq!(
        known,
        [
            ("y", "m", Measured::Coordinate(0), 0.01),
            ("dot(phi)", "rad/s", Measured::Velocity(1), quarter),
            ("a", "A", Measured::Velocity(2), 5.0),
            ("height", "cm", Measured::Output(0), 0.1),
        ]
    );
    assert_eq!((two.huber, two.quantities[0].unit), (Some(2.0), "m/s"));
    assert!(two.own_start);
    // The start of the second by the free parameter: one entry, of the velocity of y.
    let (derived, _) = describe_differentiated(&text, "s", &["e"]).expect("no mistakes");
    let starts = derived.structure.sensitivity.expect("asked for").starts;
    assert!(starts[0].is_none());
    assert_eq!(
        starts[1].as_ref().expect("declared").pattern.entries,
        [(3, 0)]
    );
}

#[test]
fn scene_without_measurements_carries_nothing_of_them() {
    let text = scene("minimize height").replace("free e in 0..=1 = 0.5", "parameters { e = 0.5 }");
    let (derived, _) = describe_text(&text, "s").expect("no mistakes");
    assert!(derived.structure.experiments.is_empty());
    let starts = derived
        .kernels
        .iter()
        .filter(|kernel| kernel.name.starts_with("start_"));
    assert_eq!(starts.count(), 2);
}

/// The scene with a measured motion of these entries.
fn entries(entries: &str) -> String {
    scene(&format!(
        "measured one: \"a.csv\" {{ {entries} }} minimize misfit(one)"
    ))
}

/// The scene with a measured motion and an objective.
fn misfits(objective: &str) -> String {
    scene(&format!(
        "measured one: \"a.csv\" {{ y within 1 [cm] }} {objective}"
    ))
}

answers! {
    mistakes_in_measurements_say_what_to_write: scene => r#"
        measured { }
            { => expected the name of the experiment
        measured one "a.csv" { }
            "a.csv" => expected `:` and the file of the measurements
        measured one: a { }
            a => expected the name of a file in quotation marks
        measured one: "" { y within 1 [cm] }
            "" => `one` has no file
        measured one: "a.csv" { y: 1 }
            one => `one` measures nothing
            : => expected `within` and the standard deviation
        measured one: "a.csv" { y within 1 [cm] }
            E15 one => nothing compares with the measured `one`; write `minimize misfit(one)`
        measured one: "a.csv" { } minimize misfit(one)
            one => `one` measures nothing; write what, as in `z within 1 [cm]`
        minimize misfit(two)
            E01 two => `two` is not measured; declare it
        // A parameter that only a start of an experiment reads is read.
        free v: m/s in 0..=1 = 0.5 measured one: "a.csv" { y within 1, start { dot(y): v } } minimize misfit(one)
        free v: m/s in 0..=1 = 0.5 measured one: "a.csv" { y within 1 } minimize misfit(one)
            E15 v => nothing in the motion
    "#;
    mistakes_in_entries_say_what_to_write: entries => r"
        y within 1 [kg]
            E03 1 [kg] => units differ: `1 [kg]` is in kg, where m is
        fast within 1 [m]
            E03 1 [m] => units differ: `1 [m]` is in m, where m/s is
        y within 0
            E17 0 => the standard deviation of the measured `y` is `0`
        z within 1
            E01 z => `z` is not declared
        e within 1
            E15 e => `e` is no coordinate, state or output
        y within 1, y within 2
            E19 y => `y` is measured twice in `one`
        y within 1, start { y: dot(y)*1[s] }
            dot(y)*1[s] => the start value of `y` depends on the velocity
    ";
    mistakes_in_misfits_say_what_to_write: misfits => r#"
        minimize misfit(on)
            E01 on => `on` is not measured; did you mean `one`?
        minimize misfit(one) + 1
            E15 1 => `1` beside a misfit
        minimize 2*misfit(one)
            E15 2*misfit(one) => `2*misfit(one)` beside a misfit
        minimize misfit(one) + misfit(one)
            E15 misfit(one) => the misfit of `one` is added twice
        minimize misfit(one, absolute)
            E15 absolute => `absolute` is no loss; write `huber`
        minimize misfit(one, huber(-1))
            E15 huber(-1) => `huber(-1)` is no loss
        minimize misfit()
            E02 misfit() => `misfit()`: a misfit is of one measured motion
        measured one: "a.csv" { y within 1 [cm] } minimize misfit(one)
            E19 one => `one` is measured twice; rename one
        minimize misfit(one) minimize time
            minimize => a scene has one `minimize`
        finally { y == 0 } minimize misfit(one)
            E15 minimize => `finally` in a scene that minimizes a misfit
        free { dot(y) } minimize misfit(one)
            E15 minimize => `free { ... }` in a scene that minimizes a misfit
    "#;
}

#[test]
fn name_misfit_may_be_taken_by_a_scene() {
    let text = scene("fn misfit(x) = x^2 minimize misfit(y)")
        .replace("free e in 0..=1 = 0.5", "parameters { e = 0.5 }");
    let (derived, _) = describe_text(&text, "s").expect("no mistakes");
    assert!(
        derived.structure.experiments.is_empty() && derived.structure.optimal_control.is_some()
    );
}

#[test]
fn measurements_are_formatted_like_the_statements_around_them() {
    let text = scene(
        "measured  one:\"a.csv\"{y within 1[cm],start{y:2[m],dot(y):0}}\nminimize misfit( one ,huber )",
    );
    let formatted = formatted(&text);
    let wanted = "measured one: \"a.csv\" { y within 1 [cm], start { y: 2 [m], dot(y): 0 } }\nminimize misfit(one, huber)\n";
    assert!(formatted.ends_with(wanted), "{formatted}");
}
