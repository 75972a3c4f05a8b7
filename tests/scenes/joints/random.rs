//! Random linkages: both methods agree within what they promise.

use super::scene;
use crate::random::Random;
use hangtime::prelude::*;
use hangtime::simulation::{InitialValueProblem, Simulator};
use std::fmt::Write;

/// A chain of rods, each a body with three coordinates, pinned to each other and to a pivot, over a floor that its end
/// strikes; sometimes with the end on a rail, which closes a loop.
fn linkage(random: &mut Random) -> String {
    let count = 1 + random.within(0.0, 2.999) as usize;
    let closed = count > 1 && random.within(0.0, 1.0) < 0.3;
    let (mut coordinates, mut start) = (String::new(), String::new());
    let (mut energy, mut joints) = (String::new(), String::new());
    let (mut pin, mut at) = ("(0 [m], 0 [m])".to_owned(), (0.0, 0.0));
    for k in 1..=count {
        let (l, m) = (random.within(0.5, 1.5), random.within(0.5, 2.0));
        let angle = random.within(0.3, 1.2);
        let center = (at.0 + l / 2.0 * angle.cos(), at.1 + l / 2.0 * angle.sin());
        let _ = write!(coordinates, "x{k}: m, z{k}: m, a{k}: rad, ");
        let _ = write!(
            start,
            "x{k}: {}, z{k}: {}, a{k}: {angle}, dot(a{k}): {}, ",
            center.0,
            center.1,
            random.within(-2.0, 2.0)
        );
        let _ = write!(
            energy,
            "+ {m} [kg]/2*(dot(x{k})^2 + dot(z{k})^2) + {} [kg m^2]/2*dot(a{k})^2 - {m} [kg]*9.81 [m/s^2]*z{k} ",
            m * l * l / 12.0
        );
        let half = |sign: char| {
            format!(
                "(x{k} {sign} {0} [m]*cos(a{k}), z{k} {sign} {0} [m]*sin(a{k}))",
                l / 2.0
            )
        };
        let _ = writeln!(joints, "joint pin{k}: {} == {pin}", half('-'));
        pin = half('+');
        at = (at.0 + l * angle.cos(), at.1 + l * angle.sin());
    }
    if closed {
        let _ = writeln!(joints, "joint rail: ({pin}).y == {} [m]", at.0);
    }
    let law = if random.within(0.0, 1.0) < 0.5 {
        format!("restitution {}", random.within(0.2, 0.9))
    } else {
        "inelastic".to_owned()
    };
    let rubs = match random.within(0.0, 1.0) < 0.5 {
        true => format!(
            ", friction {}, sliding dot(({pin}).y)",
            random.within(0.1, 0.8)
        ),
        false => String::new(),
    };
    format!(
        "coordinates {{ {coordinates} }} lagrangian 0 [J] {energy} {joints}
         surface floor: ({pin}).z >= {} [m] impact floor: {law}{rubs} start {{ {start} }} horizon 1 [s]",
        random.within(-0.6, -0.2)
    )
}

#[test]
fn random_linkages_move_alike_by_both_methods() {
    let mut random = Random(7);
    let (mut solved, mut struck, mut worst) = (0, 0, 0.0_f64);
    for number in 0..100 {
        let text = linkage(&mut random);
        let linkage = scene(&text);
        let run = |method: Box<dyn Simulator>| {
            let problem = InitialValueProblem::of(&linkage, None).expect("a horizon");
            method.simulate(&linkage, &problem, &mut |_| true)
        };
        let runs = [
            run(Box::<Fesd>::default()),
            run(Box::<EventDriven>::default()),
        ];
        let [Ok(elements), Ok(events)] = runs else {
            panic!("{number} is refused: {runs:?}\n{text}");
        };
        if !elements.status.is_solved() || !events.status.is_solved() {
            println!("{number}: {} | {}", elements.status, events.status);
            continue;
        }
        solved += 1;
        struck += usize::from(!events.events.is_empty());
        let estimate = |run: &Simulation| run.error_estimate.expect("an estimate");
        let allowed = estimate(&elements) + estimate(&events) + 1e-10;
        let (own, its) = (
            elements.at(1.0).expect("the end"),
            events.at(1.0).expect("the end"),
        );
        let size = its.q.iter().fold(1.0_f64, |s, q| s.max(q.abs()));
        let off = own
            .q
            .iter()
            .zip(&its.q)
            .fold(0.0_f64, |w, (a, b)| w.max((a - b).abs()));
        worst = worst.max(off / size / allowed);
        assert!(
            off / size <= allowed,
            "{number}: {off:e}, {allowed:e} promised\n{text}"
        );
    }
    println!("{solved} solved, {struck} with impacts, at most {worst:.2} of what is promised");
    assert!(
        solved >= 95 && struck >= 40,
        "{solved} solved, {struck} with impacts"
    );
}
