//! `simulate --gradient`.

use serde_json::Value;

use crate::support::{Scratch, json, solved};

/// One second of a ball that bounces, differentiated by all parameters.
const BOUNCING_BY_ALL: &str = "simulate bouncing-ball --horizon 1 --gradient all";
/// A ball whose first impact is at 0.5 s with 4 m/s.
const EVEN: &str = "simulate bouncing-ball --set g=8 --set height=1 --set e=0.5";

fn numbers(value: &Value) -> Vec<f64> {
    let list = value.as_array().unwrap().iter();
    list.map(|number| number.as_f64().unwrap()).collect()
}

#[track_caller]
fn assert_close(found: &[f64], right: &[f64]) {
    assert_eq!(found.len(), right.len());
    for (found, right) in found.iter().zip(right) {
        assert!((found - right).abs() < 1e-9, "{found} instead of {right}");
    }
}

#[test]
fn gradient_of_a_shipped_scene_has_the_fields_of_the_contract() {
    // Before the first impact at sqrt(2 h / g); its speed there is sqrt(2 g h).
    let document = json(&format!(
        "{EVEN} --horizon 0.8 --gradient e,g,height --json"
    ));
    let gradient = &document["gradient"];
    assert_eq!(
        gradient["with_respect_to"],
        serde_json::json!(["e", "g", "height"])
    );
    assert_eq!(gradient["exists"], true);
    assert!(gradient["error_estimate"].as_f64().unwrap() < 1e-9);
    // The impact is at 0.5 s with 4 m/s; 0.3 s later z = 2*0.3 - 8/2*0.09 at e = 0.5.
    let times = gradient["event_times"].as_array().unwrap();
    assert_close(&numbers(&times[0]), &[0.0, -0.5 / 16.0, 0.25]);
    let rows = document["quantities"]["q"].as_array().unwrap();
    let height = rows.iter().position(|row| row["name"] == "z").unwrap();
    // dz = e dv t' - v' dt with the speed v' = 2 - 8*0.3 there, and dv = 4/16 by g, 2 by h; by g also -0.09/2.
    let (rate, since) = (2.0 - 8.0 * 0.3, 0.3);
    let right = [
        4.0 * since,
        0.5 * 0.25 * since - since * since / 2.0 + rate * 0.5 / 16.0,
        0.5 * 2.0 * since - rate * 0.25,
    ];
    assert_close(&numbers(&gradient["final"]["q"][height]), &right);
}

#[test]
fn gradient_is_a_table_with_units_for_people() {
    let text = solved(BOUNCING_BY_ALL);
    let line = |begin: &str| {
        let mut lines = text.lines().map(str::trim);
        lines
            .find(|line| line.starts_with(begin))
            .unwrap_or_else(|| panic!("{begin}\n{text}"))
    };
    assert!(line("derivative of").contains("by g [m/s^2]"), "{text}");
    assert!(
        line("error       of derivatives").contains("about"),
        "{text}"
    );
    assert!(
        line("time of impact at").ends_with(|c: char| c.is_ascii_digit()),
        "{text}"
    );
    let without = solved("simulate bouncing-ball --horizon 1");
    assert!(!without.contains("derivative"), "{without}");
    let document = json("simulate bouncing-ball --horizon 1 --json");
    assert!(document.get("gradient").is_none());
}

#[test]
fn values_at_the_end_are_differentiated_backwards_where_they_are_fewer() {
    let with = |more: &str| format!("{BOUNCING_BY_ALL} {more}");
    let document = json(&with("--json"));
    let whole = &document["gradient"];
    assert_eq!(whole["mode"], "forward");
    let range = whole["range"].as_array().unwrap();
    assert_eq!(
        range.len(),
        whole["with_respect_to"].as_array().unwrap().len()
    );
    let alone = json(&with("--json --gradient-of z,dot(z)"));
    let alone = &alone["gradient"];
    assert_eq!(alone["mode"], "adjoint");
    assert!(alone.get("final").is_none() && alone.get("event_times").is_none());
    let mut rows = document["quantities"]["q"].as_array().unwrap().iter();
    let height = rows.position(|row| row["name"] == "z").unwrap();
    let forced = json(&with("--json --gradient-of z --gradient-mode forward"));
    assert_eq!(forced["gradient"]["mode"], "forward");
    for (k, name) in ["z", "dot(z)"].iter().enumerate() {
        let part = if k == 0 { "q" } else { "v" };
        let right = numbers(&whole["final"][part][height]);
        assert_close(&numbers(&alone["values"][name]), &right);
    }
    let text = solved(&with("--gradient-of z,event_times[0]"));
    assert!(text.contains("z at the end [m]") && text.contains("event_times[0] [s]"));
    assert!(!text.contains("time of impact at"), "{text}");
}

#[test]
fn struck_side_of_a_graze_has_the_number_of_its_root() {
    let scratch = Scratch::new("graze");
    let text = "
        parameters { v0: m/s = 4 }
        coordinates { z: m }
        lagrangian 1[kg]*(dot(z)^2/2 - 8[m/s^2]*z)
        surface ceiling: 1[m] - z >= 0
        impact ceiling: restitution 0.5
        start { dot(z): v0 }
        horizon 1 [s]
    ";
    let file = scratch.write("ceiling.hang", text);
    let line = format!("simulate {file} --gradient v0");
    let document = json(&format!("{line} --json"));
    let sides = &document["gradient"]["one_sided"];
    // Struck at sqrt(8 h), it is lower by (1 + e) sqrt(8 h)/2; where it is not struck it rises by the velocity times 1 s.
    assert!(sides["above"]["final"]["q"][0][0].is_null());
    let root = numbers(&sides["above"]["square_root"]["final"]["q"][0]);
    // The default tolerance of a motion over the distance of its neighbours.
    assert!((root[0] + 0.75 * 8.0_f64.sqrt()).abs() < 1e-3, "{root:?}");
    assert!((numbers(&sides["below"]["final"]["q"][0])[0] - 1.0).abs() < 1e-6);
    assert!(sides["below"].get("square_root").is_none());
    assert!(solved(&line).contains("square_root in --json"));
}

#[test]
fn quantity_without_a_derivative_leaves_those_of_others() {
    // A ball that does not bounce: below a restitution of 0 there is nothing.
    let document = json(
        "simulate bouncing-ball --set e=0 --horizon 0.3 --set height=0.2 --gradient e,height --json",
    );
    let gradient = &document["gradient"];
    let missing = gradient["exists"].as_str().unwrap();
    assert!(missing.contains("restitution of 0"), "{missing}");
    assert_eq!(gradient["exists_by"][0], gradient["exists"]);
    assert_eq!(gradient["exists_by"][1], true);
    let times = gradient["event_times"][0].as_array().unwrap();
    assert!(times[0].is_null() && times[1].is_f64(), "{gradient}");
}

#[test]
fn optimum_with_bounds_that_are_one_has_sides() {
    let scratch = Scratch::new("sides");
    let text = "
        parameters { d: m = 1, a: N = 1 }
        coordinates { y: m }
        controls { u: N in -1..=1 }
        constraint up: u <= a
        lagrangian 1[kg]/2*dot(y)^2
        forces { y: u }
        minimize time
        finally { y == d, dot(y) == 0 }
    ";
    let file = scratch.write("cart.hang", text);
    let line = format!("solve {file} --intervals 2 --gradient d,a");
    let document = json(&format!("{line} --json"));
    let gradient = &document["gradient"];
    // T = 2 sqrt(d/a), and more than 1 is not allowed.
    assert_eq!(gradient["exists"][0], true);
    assert!(gradient["exists"][1].is_string() && gradient["objective"][1].is_null());
    let sides = &gradient["sides"];
    assert!(sides["objective"][0].is_null());
    let found = numbers(&sides["objective"][1]);
    assert!(
        (found[0] + 1.0).abs() < 1e-5 && found[1].abs() < 1e-5,
        "{found:?}"
    );
    assert_eq!(sides["objective"][1], sides["final_time"][1]);
    assert!(solved(&line).contains("no derivative by a"));
}
