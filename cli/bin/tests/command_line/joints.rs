//! Joints at the command line: forces in JSON, what `explain` says, and refusals.

use crate::support::{Scratch, json, solved};

/// A pendulum as a point on a rod, that also is held by its velocity along a line in space.
pub(crate) const ROD: &str = "
    parameters { m: kg = 2, g: m/s^2 = 9.81, l: m = 1.5 }
    coordinates { x: m, y: m, z: m }
    lagrangian m/2*|dot((x, y, z))|^2 - m*g*z
    /// A rod and a plane.
    joint rod: (x^2 + y^2 + z^2, y/1 [1/m]) == (l^2, 0 [m^2])
    joint still: dot(y) == 0
    start { z: -1.5 }
    horizon 1 [s]
";

#[test]
fn forces_of_joints_stand_beside_the_trajectory() {
    let scratch = Scratch::new("joints");
    let held = ROD.replace("joint still: dot(y) == 0", "joint still: dot(x) == 0");
    let file = scratch.write("rod.hang", held);
    let run = json(&format!("simulate {file} --json"));
    let rows = run["trajectory"]["time"].as_array().unwrap().len();
    let rod = run["joints"]["rod"]["force"].as_array().unwrap();
    let still = run["joints"]["still"]["force"].as_array().unwrap();
    assert_eq!((rod.len(), still.len()), (rows, rows));
    for (rod, still) in rod.iter().zip(still) {
        // It hangs: -2 l force carries the weight.
        let force = rod[0].as_f64().unwrap();
        assert!((3.0 * force + 2.0 * 9.81).abs() < 1e-10, "{force}");
        assert!(rod[1].as_f64().unwrap().abs() < 1e-12);
        assert!(still.as_f64().unwrap().abs() < 1e-12);
    }
    let free = json("simulate ski-jump --json --horizon 0.1");
    assert!(free.get("joints").is_none());
}

#[test]
fn explain_names_joints_and_what_they_add() {
    let scratch = Scratch::new("joints-explained");
    let file = scratch.write("rod.hang", ROD);
    let text = solved(&format!("explain {file}"));
    assert!(
        text.contains("joint       rod [m^2]: 2 equations between positions, and their rates"),
        "{text}"
    );
    assert!(
        text.contains("joint       still [m]: an equation between velocities"),
        "{text}"
    );
    assert!(text.contains("joint(rod.1)' = 0"), "{text}");
}
