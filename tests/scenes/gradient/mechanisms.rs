//! Derivatives of closed loops against those of their closed forms.

use super::closed_forms::assert_row;
use super::support::{assert_exists, by_both, scene};

/// Links of a four-bar linkage.
const LINKS: &str = "
    parameters { m1: kg = 1, m2: kg = 2, m3: kg = 1.5, a: m = 1, b: m = 2.2, c: m = 1.8, d: m = 2, g: m/s^2 = 9.81, t0: rad = 1.2, e = 0.5 }
    horizon 1.1 [s]
";

/// The stop, and the middle of the rocker.
const SEEN: &str = "
    surface stop: t1 >= 0.2 [rad]
    impact stop: restitution e
    outputs { y3: m = c3.y, z3: m = c3.z }";

/// Three angles and a loop, from where two circles meet.
const LOOP: &str = "
    coordinates { t1: rad, t2: rad, t3: rad }
    let crank = (a*cos(t1), a*sin(t1))
    let c2 = crank + (b*cos(t2), b*sin(t2))/2
    let c3 = (d + c/2*cos(t3), c/2*sin(t3))
    let links = m1*a^2/6*dot(t1)^2 + m2/2*|dot(c2)|^2 + m2*b^2/24*dot(t2)^2 + m3/2*|dot(c3)|^2 + m3*c^2/24*dot(t3)^2
    lagrangian links - g*(m1*crank.z/2 + m2*c2.z + m3*c3.z)
    joint loop: crank + (b*cos(t2), b*sin(t2)) == (d + c*cos(t3), c*sin(t3))
    let e0 = (a*cos(t0) - d, a*sin(t0))
    let w0 = c^2 - |e0|^2 - b^2
    let s0 = sqrt(4*b^2*|e0|^2 - w0^2)
    let u0 = ((w0*e0.y + s0*e0.z)/(2*|e0|^2), (w0*e0.z - s0*e0.y)/(2*|e0|^2))
    start { t1: t0, t2: atan2(u0.z, u0.y), t3: atan2(e0.z + u0.z, e0.y + u0.y) }
";

/// The same by the angle of the crank.
const CRANK: &str = "
    coordinates { t1: rad }
    let e1 = (a*cos(t1) - d, a*sin(t1))
    let w = c^2 - |e1|^2 - b^2
    let s = sqrt(4*b^2*|e1|^2 - w^2)
    let u2 = ((w*e1.y + s*e1.z)/(2*b*|e1|^2), (w*e1.z - s*e1.y)/(2*b*|e1|^2))
    let crank = (a*cos(t1), a*sin(t1))
    let c2 = crank + u2*b/2
    let tip = crank + u2*b
    let c3 = (d/2, 0 [m]) + tip/2
    let links = m1*a^2/6*dot(t1)^2 + m2/2*|dot(c2)|^2 + m2*b^2/24*|dot(u2)|^2 + m3/2*|dot(c3)|^2
    lagrangian links + m3/24*|dot(tip)|^2 - g*(m1*crank.z/2 + m2*c2.z + m3*c3.z)
    start { t1: t0 }
";

#[test]
fn four_bar_has_the_derivatives_of_its_closed_form_also_where_its_crank_strikes_a_stop() {
    let names = ["m1", "m2", "m3", "a", "b", "c", "d", "g", "t0", "e"];
    let of = |links: &str| by_both(&scene(&format!("{LINKS}{links}{SEEN}"), &[]), &names);
    let (exact, looped) = (of(CRANK), of(LOOP));
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
