//! Pictures of all starts by `hangtime sweep`: where switched systems come to from a grid of starts, against their closed forms.

use crate::support::{Scratch, solved};

/// The cells of a sweep of a scene over the starts of its two states, without the heading.
fn table(name: &str, scene: &str, over: [&str; 2], record: &str) -> Vec<Vec<String>> {
    let scratch = Scratch::new(name);
    let scene = scratch.write("scene.hang", scene);
    let out = format!("{}/t.csv", scratch.text());
    let [x, y] = over;
    solved(&format!(
        "sweep {scene} --over {x} --over {y} --record {record} --out {out}"
    ));
    let table = scratch.read("t.csv");
    let cells = |line: &str| line.split(',').map(str::to_owned).collect();
    table.lines().skip(1).map(cells).collect()
}

fn number(cell: &str) -> f64 {
    cell.parse().expect("a number")
}

/// What default runs promise of values of the order of one.
const PROMISED: f64 = 2e-6;

#[test]
fn relay_goes_round_on_parabolas_from_every_start() {
    let scene = "parameters { from: m = 1, speed: m/s = 0 } states { x: m, v: m/s }
        rates { x: v, v: -1 [m/s^2]*sign(x) } start { x: from, v: speed } horizon 7 [s]";
    let over = ["from=-1:1:4", "speed=-1.1:1.3:7"];
    let rows = table("relay-starts", scene, over, "final.x,final.v,events");
    assert_eq!(rows.len(), 28);
    for row in rows {
        assert_eq!(row[3], "solved");
        let (mut x, mut v, mut left, mut events) = (number(&row[1]), number(&row[2]), 7.0, 0);
        let mut side: f64 = x.signum();
        loop {
            // Back at 0 when side (x + v t) = t^2/2.
            let (out, away) = (side * x, side * v);
            let time = away + (away * away + 2.0 * out).sqrt();
            let step = time.min(left);
            (x, v) = (x + v * step - side * step * step / 2.0, v - side * step);
            left -= step;
            if left <= 0.0 {
                break;
            }
            (x, side, events) = (0.0, -side, events + 1);
        }
        assert!((number(&row[6]) - x).abs() < PROMISED, "{row:?} {x}");
        assert!((number(&row[7]) - v).abs() < PROMISED, "{row:?} {v}");
        assert_eq!(row[8], events.to_string(), "{row:?}");
    }
}

#[test]
fn genes_come_to_their_cycle_from_every_start() {
    let scene = "parameters { from = 0.1, other = 0.2 } states { x, y }
        rates { x: step(0.6 - y)*1 [1/s] - x*1 [1/s], y: step(x - 0.4)*1 [1/s] - y*1 [1/s] }
        start { x: from, y: other } horizon 3 [s]";
    let over = ["from=0.05:0.95:5", "other=0.1:0.9:4"];
    let rows = table("gene-starts", scene, over, "final.x,final.y,events");
    assert_eq!(rows.len(), 20);
    for row in rows {
        assert_eq!(row[3], "solved");
        let (mut x, mut y, mut left, mut events) = (number(&row[1]), number(&row[2]), 3.0, 0);
        let (mut much, mut little) = (x > 0.4, y < 0.6);
        loop {
            let focus = (f64::from(u8::from(little)), f64::from(u8::from(much)));
            let meets = |value: f64, focus: f64, threshold: f64, above: bool| {
                let share = (focus - threshold) / (focus - value);
                let leaves = (focus > threshold) != above;
                if leaves && share > 0.0 {
                    -share.ln()
                } else {
                    f64::INFINITY
                }
            };
            let (a, b) = (
                meets(x, focus.0, 0.4, much),
                meets(y, focus.1, 0.6, !little),
            );
            let step = a.min(b).min(left);
            let decayed = (-step).exp();
            (x, y) = (
                focus.0 + (x - focus.0) * decayed,
                focus.1 + (y - focus.1) * decayed,
            );
            left -= step;
            if left <= 0.0 {
                break;
            }
            events += 1;
            if a < b {
                much = !much;
            } else {
                little = !little;
            }
        }
        assert!((number(&row[6]) - x).abs() < PROMISED, "{row:?} {x}");
        assert!((number(&row[7]) - y).abs() < PROMISED, "{row:?} {y}");
        assert_eq!(row[8], events.to_string(), "{row:?}");
    }
}
