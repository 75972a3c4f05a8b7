//! Free parameters, and `solve --gradient`.

use crate::support::{Scratch, json, solved};

/// A sledge on a ramp.
pub(crate) const RAMP: &str = "parameters { m: kg = 1, g: m/s^2 = 9.81 } free angle: rad in 0.2..=1.4 = 0.5 coordinates { s: m } \
    lagrangian m/2*dot(s)^2 + m*g*s*sin(angle) minimize time finally { s*cos(angle) == 2 [m] } horizon 1 [s]";
const FREE: &str = "free angle: rad in 0.2..=1.4 = 0.5";
const GIVEN: &str = "parameters { angle: rad = 0.6 }";

/// The ramp with another statement that declares its angle, in a file.
fn ramp(angle: &str) -> (Scratch, String) {
    let scratch = Scratch::new("design");
    let file = scratch.write("ramp.hang", RAMP.replace(FREE, angle));
    (scratch, file)
}

#[test]
fn found_parameter_stands_in_the_document_and_in_the_report() {
    let (_scratch, file) = ramp(FREE);
    let document = json(&format!("solve {file} --intervals 2 --json"));
    let found = &document["free"]["angle"];
    let value = found["value"].as_f64().unwrap();
    assert!((value - std::f64::consts::FRAC_PI_4).abs() < 1e-7);
    assert_eq!(document["parameters"]["angle"], found["value"]);
    assert_eq!(
        (&found["unit"], found["at_bound"].is_null()),
        (&"rad".into(), true)
    );
    assert_eq!(document["quantities"]["q"].as_array().unwrap().len(), 1);
    let text = solved(&format!("solve {file} --intervals 2"));
    assert!(
        text.contains("\nfound         angle = 0.785398 rad\n"),
        "{text}"
    );
    // A value that is given is kept.
    let given = json(&format!(
        "solve {file} --intervals 2 --set angle=0.6 --json"
    ));
    assert!(given["free"].is_null());
    assert_eq!(given["parameters"]["angle"], 0.6);
}

#[test]
fn parameter_at_an_end_of_its_range_is_noted() {
    let (_scratch, file) = ramp(&FREE.replace("1.4", "0.6"));
    let document = json(&format!("solve {file} --intervals 2 --json"));
    assert_eq!(document["free"]["angle"]["at_bound"], "upper");
    let notes = document["notes"].to_string();
    assert!(
        notes.contains("angle = 0.6 rad, at the upper end of its range"),
        "{notes}"
    );
}

#[test]
fn simulation_says_which_value_it_takes() {
    let (_scratch, file) = ramp(FREE);
    let note = "the free parameter `angle` is 0.5 rad here, the value with which `solve` begins";
    let document = json(&format!("simulate {file} --json"));
    assert_eq!(document["notes"][0], note);
    let given = json(&format!("simulate {file} --set angle=0.6 --json"));
    assert!(!given["notes"].to_string().contains("free parameter"));
    let text = solved(&format!("explain {file}"));
    assert!(
        text.contains("free        angle [rad] in 0.2..=1.4, a parameter"),
        "{text}"
    );
}

#[test]
fn derivatives_of_an_optimum_stand_in_the_order_asked_for() {
    let (_scratch, file) = ramp(GIVEN);
    let line = format!("solve {file} --intervals 2 --gradient g,angle");
    let document = json(&format!("{line} --json"));
    let gradient = &document["gradient"];
    assert_eq!(
        gradient["with_respect_to"],
        serde_json::json!(["g", "angle"])
    );
    // T = sqrt(4 / (g sin(angle) cos(angle)))
    let time = document["objective"].as_f64().unwrap();
    let right = [-time / (2.0 * 9.81), -time / 1.2_f64.tan()];
    for of in ["objective", "final_time"] {
        for (k, right) in right.iter().enumerate() {
            let found = gradient[of][k].as_f64().unwrap();
            assert!(
                (found - right).abs() < 1e-8,
                "{of}: {found} instead of {right}"
            );
        }
    }
    let text = solved(&line);
    assert!(
        text.contains("as long as the contact sequence stays"),
        "{text}"
    );
}
