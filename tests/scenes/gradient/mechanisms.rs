//! Derivatives of closed loops against those of their closed forms.

use super::closed_forms::assert_row;
use super::support::{assert_exists, by_both, scene};
use crate::four_bar::{CRANK, RODS, SIZES};

/// Where the crank begins, how much it bounces off its stop, and the middle of the rocker.
const SEEN: &str = "
    parameters { t0: rad = 1.2, e = 0.5 }
    surface stop: t1 >= 0.2 [rad]
    impact stop: restitution e
    outputs { y3: m = c3.y, z3: m = c3.z }
    horizon 1.1 [s]
";

/// The start of the loop, where two circles meet.
const CLOSED: &str = "
    let e0 = (a*cos(t0) - d, a*sin(t0))
    let w0 = c^2 - |e0|^2 - b^2
    let s0 = sqrt(4*b^2*|e0|^2 - w0^2)
    let u0 = ((w0*e0.y + s0*e0.z)/(2*|e0|^2), (w0*e0.z - s0*e0.y)/(2*|e0|^2))
    start { t1: t0, t2: atan2(u0.z, u0.y), t3: atan2(e0.z + u0.z, e0.y + u0.y) }
";

#[test]
fn four_bar_has_the_derivatives_of_its_closed_form_also_where_its_crank_strikes_a_stop() {
    let names = ["m1", "m2", "m3", "a", "b", "c", "d", "g", "t0", "e"];
    let of = |links: &str, start: &str| {
        let text = format!("{SIZES}{links}{SEEN}{start}");
        by_both(&scene(&text, &[]), &names)
    };
    let (exact, looped) = (of(CRANK, "start { t1: t0 }"), of(RODS, CLOSED));
    for ((run, right), (other, found)) in exact.iter().zip(&looped) {
        assert_exists(right);
        assert_exists(found);
        assert!(!run.events.is_empty() && run.events.len() == other.events.len());
        assert_row(&found.q[0], &right.q[0], "angle of the crank");
        assert_row(&found.v[0], &right.v[0], "its velocity");
        for (found, right) in found.event_times.iter().zip(&right.event_times) {
            assert_row(found, right, "time of an impact");
        }
        let [last, end] = [run, other].map(|run| run.trajectory.time.len() - 1);
        for output in 0..2 {
            let (found, right) = (&found.outputs[output][end], &right.outputs[output][last]);
            assert_row(found, right, "place of the rocker");
        }
    }
}
