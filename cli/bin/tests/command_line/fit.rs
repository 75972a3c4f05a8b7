//! `solve` of scenes that compare with measurements.

use std::fs;

use crate::support::{Scratch, json, solved, unsolved};

/// A ball that is dropped from 1 m, and compared with a table.
pub(crate) const DROP: &str = "parameters { m: kg = 1, g: m/s^2 = 9.81 }\nfree e in 0..=1 = 0.5\ncoordinates { z: m }\n\
     lagrangian m/2*dot(z)^2 - m*g*z\nsurface floor: z >= 0\nimpact floor: restitution e\nstart { z: 1 [m] }\n\
     measured drop: \"drop.csv\" { z within 1 [cm] }\nminimize misfit(drop)\n";

/// A scene in a file, with a table of the ball that bounces once with 0.8, seen every 50 ms.
fn dropped(scene: &str) -> (Scratch, String) {
    let scratch = Scratch::new("fit");
    let (g, e) = (9.81_f64, 0.8);
    let fall = (2.0 / g).sqrt();
    let mut rows = String::from("time [ms], z [mm], note\n");
    for k in 1..20 {
        let t = 0.05 * f64::from(k);
        let s = t - fall;
        let z = match s < 0.0 {
            true => 1.0 - 0.5 * g * t * t,
            false => e * g * fall * s - 0.5 * g * s * s,
        };
        rows += &format!("{}, {}, seen\n", 1e3 * t, 1e3 * z);
    }
    scratch.write("drop.csv", rows);
    let file = scratch.write("ball.hang", scene);
    (scratch, file)
}

#[test]
fn estimate_stands_in_the_document_the_report_and_the_files() {
    let (scratch, file) = dropped(DROP);
    let document = json(&format!("solve {file} --json"));
    let found = &document["free"]["e"];
    let value = found["value"].as_f64().unwrap();
    assert!((value - 0.8).abs() < 1e-9, "{value}");
    assert_eq!(document["parameters"]["e"], found["value"]);
    assert_eq!(
        (&document["status"], &document["measurements"]),
        (&"solved".into(), &19.into())
    );
    // With z = e g T s - g s^2/2 behind the fall T, the derivative by e is g T s, and the variance 1/sum (g T s/w)^2.
    let (g, within) = (9.81_f64, 0.01);
    let fall = (2.0 / g).sqrt();
    let slopes = (1..20)
        .map(|k| 0.05 * f64::from(k) - fall)
        .filter(|s| *s > 0.0);
    let sum: f64 = slopes.map(|s| (g * fall * s / within).powi(2)).sum();
    let deviation = found["deviation"].as_f64().unwrap();
    assert!((deviation * sum.sqrt() - 1.0).abs() < 1e-6, "{deviation}");
    assert_eq!(
        document["knowledge"]["correlation"],
        serde_json::json!([[1.0]])
    );
    let experiment = &document["experiments"][0];
    assert_eq!(
        experiment["quantities"][0]["residuals"]
            .as_array()
            .unwrap()
            .len(),
        19
    );
    let text = solved(&format!("solve {file}"));
    assert!(
        text.contains("status        solved") && text.contains("0.8000000000"),
        "{text}"
    );
    let out = scratch.0.join("out");
    solved(&format!("solve {file} --out {}", out.display()));
    let page = fs::read_to_string(out.join("ball-fitted.html")).unwrap();
    assert!(page.contains("residuals in standard deviations") && page.contains("+-"));
    let rows = fs::read_to_string(out.join("ball-fitted-residuals-drop.csv")).unwrap();
    assert!(
        rows.starts_with("t [s],z measured [m],z computed [m],z residual\n"),
        "{rows}"
    );
    assert_eq!(rows.lines().count(), 20);
}

#[test]
fn explain_tells_what_is_compared() {
    let (_scratch, file) = dropped(DROP);
    let text = solved(&format!("explain {file}"));
    for line in [
        "minimize    misfit(drop)\n",
        "measured    drop in drop.csv: z within 0.01 m\n",
        "free        e in 0..=1, a parameter\n",
    ] {
        assert!(text.contains(line), "{text}");
    }
    // It is simulated with the value to begin with.
    let run = json(&format!("simulate {file} --horizon 1 --json"));
    assert!(
        run["notes"][0]
            .as_str()
            .unwrap()
            .contains("the value with which `solve` begins")
    );
}

#[test]
fn what_is_not_determined_ends_with_status_3_and_its_name() {
    let heavy = "free e in 0..=1 = 0.5 free mass: kg in 1..=3 = 2";
    let scene = DROP.replace("m/2*dot(z)^2 - m*g*z", "mass/2*dot(z)^2 - mass*g*z");
    let scene = scene
        .replace("m: kg = 1, ", "")
        .replace("free e in 0..=1 = 0.5", heavy);
    let (_scratch, file) = dropped(&scene);
    let (document, complaint) = unsolved(&format!("solve {file} --json"));
    assert!(
        complaint.contains("undetermined: no measurement changes with `mass`"),
        "{complaint}"
    );
    assert_eq!(
        document["undetermined"][0]["parameters"],
        serde_json::json!(["mass"])
    );
    assert!(document["free"]["mass"]["deviation"].is_null());
}
