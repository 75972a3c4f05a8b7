//! Coulomb friction in the collocation program.
//!
//! A closed contact with friction carries `d_i r_i + e_i s_i` in place of `d_i r_i`. With all forces times `h`:
//!
//! ```text
//! slips forward (+) or backward (-)    s_i = -+ mu_i r_i        +- v_t,i(Q_m, V_m) >= 0
//! sticks                               v_t,i(Q_m, V_m) = 0      mu_i r_i +- s_i >= 0
//! ```
//!
//! The velocity is constrained and its multiplier is an unknown, so that a sticking contact is of index 2 like a closed
//! one, without position to correct. Slipping ends where `v_t = 0`. Sticking ends inside an interval where its force
//! reaches the edge of the friction cone, `mu r -+ s = 0`; at a jump of the controls it ends inside the cone, with the
//! sliding acceleration in the direction of the slip after it. Between the impulses of an impact the law is the same,
//! with the sliding velocity after the impact (Moreau 1988); a contact that is at rest then may stick or slip.
//!
//! Bounces after a landing are spread over an element by a normal force that may pull for a while. Friction spreads with them, so that
//! there its impulse over the element is what lies in the cone.
//!
//! Contacts of one body stop together: the velocity of one of them is asked to vanish, and whether those of the others
//! do is for the re-simulation to judge. Their forces reach the edges of their cones together; how they share the load
//! before is left open.

use super::discretization::Setting;
use super::layout::{FREE, Phase, Stage, Tangential};
use super::turns::Turns;
use crate::model::Model;
use crate::program::kernel::Kernel;
use crate::program::sparse_program::Program;
use crate::rk::ButcherTableau;
use crate::simulation::{ContactMode, Direction};

/// Room of a sliding velocity at the end of the motion, in its unit: where that is to end at rest, the row would have no
/// interior. Where it is not, the sign is checked afterwards.
const AT_THE_END: f64 = 1e-6;

/// A closed contact with its normal force or impulse.
pub(in crate::ocp) struct Normal {
    pub(in crate::ocp) contact: usize,
    pub(in crate::ocp) mode: ContactMode,
    /// Variable of the force, and its unit.
    pub(in crate::ocp) force: usize,
    pub(in crate::ocp) force_unit: f64,
    /// Unit of velocities, and of accelerations times lengths.
    pub(in crate::ocp) row_unit: f64,
}

/// Adds the tangential force of a contact that sticks, in the place described by `label`; nothing without friction.
pub(in crate::ocp) fn tangential(
    program: &mut Program,
    model: &dyn Model,
    normal: &Normal,
    label: &str,
) -> Option<Tangential> {
    let &Normal { contact, mode, .. } = normal;
    if !matches!(mode, ContactMode::Stick | ContactMode::Slip(_)) {
        return None;
    }
    let name = model.declaration().contacts[contact].name;
    let force = (mode == ContactMode::Stick).then(|| {
        program.variable(
            format!("friction of `{name}` {label}"),
            FREE,
            0.0,
            normal.force_unit,
        )
    });
    let slipping = slipping(program, model, normal, label);
    Some(Tangential {
        contact,
        mode,
        normal: normal.force,
        unit: normal.row_unit,
        force,
        slipping,
        rows: Vec::new(),
    })
}

/// Adds the tangential force `s = -+ mu r` of a contact that slips with a coefficient that is an unknown.
fn slipping(
    program: &mut Program,
    model: &dyn Model,
    normal: &Normal,
    label: &str,
) -> Option<usize> {
    let ContactMode::Slip(direction) = normal.mode else {
        return None;
    };
    let mu = program.laws().friction(normal.contact)?;
    let name = model.declaration().contacts[normal.contact].name;
    let name = format!("friction of `{name}` {label}");
    let guess = -direction.sign() * program.guessed(mu) * program.guessed(normal.force);
    let force = program.variable(name.clone(), FREE, guess, normal.force_unit);
    let row = program.row_in(normal.force_unit, name, 0.0, 0.0);
    program.linear(row, force, 1.0);
    program.bilinear(row, mu, normal.force, direction.sign());
    Some(force)
}

/// Adds the effect of the tangential force at `(q, v, u)`: `coefficient e_k s` for each (row, k, coefficient).
pub(in crate::ocp) fn push(
    tangential: &Tangential,
    program: &mut Program,
    model: &dyn Model,
    [q, v, u]: [&[usize]; 3],
    uses: &[(usize, usize, f64)],
) {
    let (force, ratio) = match (tangential.force.or(tangential.slipping), tangential.mode) {
        (Some(force), _) => (force, 1.0),
        (None, ContactMode::Slip(direction)) => {
            let mu = model.friction(tangential.contact);
            (tangential.normal, -direction.sign() * mu)
        }
        (None, _) => return,
    };
    let uses = uses.iter().map(|&(row, k, c)| (row, k, ratio * c));
    let kernel = Kernel::Friction(vec![tangential.contact]);
    let v = direction_reads(model, tangential.contact, v);
    program.block(&kernel, [q, v, u, &[force]], None, uses.collect());
}

/// The velocities that the direction of a tangential force reads: those of switches alone.
pub(in crate::ocp) fn direction_reads<'v>(
    model: &dyn Model,
    contact: usize,
    v: &'v [usize],
) -> &'v [usize] {
    match model.declaration().contacts[contact].switch {
        Some(_) => v,
        None => &[],
    }
}

/// Adds the conditions at a stage or after an impact, at `(q, v, u)`; `turns` are those at the end of the
/// element if the stage is the last one.
pub(in crate::ocp) fn constrain(
    tangential: &mut Tangential,
    program: &mut Program,
    model: &dyn Model,
    [q, v, u]: [&[usize]; 3],
    turns: &Turns,
    last: bool,
    label: &str,
) {
    let contact = tangential.contact;
    let name = model.declaration().contacts[contact].name;
    let kernel = Kernel::Sliding(contact);
    let unit = tangential.unit;
    let velocity = |program: &mut Program, sign: f64, bounds: (f64, f64)| {
        let name = format!("sliding velocity of `{name}` {label}");
        let row = program.row_in(unit, name, bounds.0, bounds.1);
        program.block(&kernel, [q, v, u, &[]], None, vec![(row, 0, sign)]);
        row
    };
    let Some(force) = tangential.force else {
        let ContactMode::Slip(direction) = tangential.mode else {
            return;
        };
        if last && turns.stopped.contains(&contact) {
            return;
        }
        let stops = last && turns.stopping.contains(&contact);
        let lower = match stops {
            false if turns.yielded.contains(&contact) => f64::NEG_INFINITY,
            false if last && turns.finishing => -AT_THE_END * unit,
            _ => 0.0,
        };
        let upper = if stops { 0.0 } else { f64::INFINITY };
        let row = velocity(program, direction.sign(), (lower, upper));
        if !stops {
            tangential.rows.push((direction, row));
        }
        return;
    };
    velocity(program, 1.0, (0.0, 0.0));
    let opens = last && turns.opening.contains(&contact);
    if opens || turns.settles(model, contact) {
        return;
    }
    let edge = turns.yielding.iter().find(|edge| edge.0 == contact);
    for direction in Direction::BOTH {
        let (upper, reaches) = match edge.filter(|_| last) {
            Some(&(_, reached)) if reached != direction => continue,
            Some(_) => (0.0, true),
            None => (f64::INFINITY, false),
        };
        let name = format!("friction cone of `{name}` {label}");
        let row = program.row_in(unit, name, 0.0, upper);
        let mu = (contact, model.friction(contact));
        reserve(program, row, 1.0, mu, direction, [tangential.normal, force]);
        if !reaches {
            tangential.rows.push((direction, row));
        }
    }
}

/// Adds `weight (mu r + sigma s)`, what is left of the friction cone before the contact slips with the sign `sigma`.
fn reserve(
    program: &mut Program,
    row: usize,
    weight: f64,
    (contact, mu): (usize, f64),
    direction: Direction,
    [normal, force]: [usize; 2],
) {
    match program.laws().friction(contact) {
        Some(mu) => program.bilinear(row, mu, normal, weight),
        None => program.linear(row, normal, weight * mu),
    }
    program.linear(row, force, weight * direction.sign());
}

/// Adds `mu r + sigma s` of a sticking contact at the weights of the stages to a row.
pub(in crate::ocp) fn reserve_between(
    program: &mut Program,
    model: &dyn Model,
    row: usize,
    contact: usize,
    direction: Direction,
    stages: &[Stage],
    weights: &[f64],
) {
    for (stage, &weight) in stages.iter().zip(weights) {
        for tangential in stage.tangential.iter().filter(|t| t.contact == contact) {
            if let Some(force) = tangential.force {
                let mu = (contact, model.friction(contact));
                let forces = [tangential.normal, force];
                reserve(program, row, weight, mu, direction, forces);
            }
        }
    }
}

/// Adds the sliding acceleration at the start of an element at whose start the contact rests, to a row.
pub(in crate::ocp) fn sliding_acceleration(
    program: &mut Program,
    row: usize,
    contact: usize,
    direction: Direction,
    phase: &Phase,
    tableau: &ButcherTableau,
) {
    let slopes = tableau.slopes_with_start(0.0);
    for (stage, slope) in phase.stages.iter().zip(&slopes[1..]) {
        let (q, v) = stage.state.split_at(stage.state.len() / 2);
        let uses = vec![(row, 0, direction.sign() * slope)];
        let kernel = Kernel::Sliding(contact);
        program.block(&kernel, [q, v, &stage.drive, &[]], None, uses);
    }
}

/// Adds the conditions at the start of an element: the force of a sticking contact, extrapolated from the stages, lies
/// in its cone, or, of one that bounces until it rests, the impulse over the element; a contact that is pulled into slip begins to
/// move its way.
pub(in crate::ocp) fn at_start(
    program: &mut Program,
    setting: Setting,
    phase: &mut Phase,
    turns: &Turns,
    label: &str,
) {
    let Setting {
        model,
        tableau,
        units,
        ..
    } = setting;
    let mut values = vec![0.0; tableau.stages()];
    tableau.lagrange_values(0.0, &mut values);
    let (mut pulled, mut cones) = (Vec::new(), Vec::new());
    for (contact, mode) in phase.modes.iter().enumerate() {
        let name = model.declaration().contacts[contact].name;
        match *mode {
            ContactMode::Stick => {
                let settles = phase.settles(contact);
                let (place, weights) = if settles {
                    ("over", tableau.b())
                } else {
                    ("at the start of", &values[..])
                };
                for direction in Direction::BOTH {
                    let name = format!("friction cone of `{name}` {place} {label}");
                    let unit = units.gap_rows[contact];
                    let row = program.row_in(unit, name, 0.0, f64::INFINITY);
                    let stages = &phase.stages;
                    reserve_between(program, model, row, contact, direction, stages, weights);
                    cones.push((contact, direction, row));
                }
            }
            ContactMode::Slip(direction) if turns.pulled.contains(&contact) => {
                let name = format!("slip of `{name}` at the start of {label}");
                let unit = units.gap_rows[contact];
                let row = program.row_in(unit, name, 0.0, f64::INFINITY);
                sliding_acceleration(program, row, contact, direction, phase, tableau);
                pulled.push((contact, row));
            }
            _ => {}
        }
    }
    (phase.pulled, phase.cones) = (pulled, cones);
}

#[cfg(test)]
mod tests {
    use crate::model::Model;
    use crate::model::Pieces;
    use crate::ocp::collocation::discretization::parabolas;
    use crate::ocp::collocation::layout::{Cut, CutKind};
    use crate::ocp::collocation::test_scene::with_setting;
    use crate::ocp::collocation::transcribe::transcribe;
    use crate::ocp::motion::control_grid::ControlShape;
    use crate::ocp::motion::sequence::{Place, Sequence, Switch};
    use crate::ocp::problem::Problem;
    use crate::ocp::settings::Guess;
    use crate::simulation::{ContactMode, Direction};
    use hangtime_solver::nlp::check_derivatives;

    /// The central difference of a function with values and derivatives up to 1e3 is good to about 1e-7 of them.
    const DIFFERENCE: f64 = 1e-5;

    crate::model! {
        /// A block on a floor, with a rider.
        Flat {
            parameters { m: kg = 2, g: m/s^2 = 9.81, mu = 0.4 }
            coordinates { y: m, z: m, r: m }
            controls { u: N, p: N }
            lagrangian m/2*(dot(y)^2 + dot(z)^2 + dot(r)^2) - m*g*z
            forces { y: u, r: p }
            surface floor: z >= 0
            impact floor: inelastic, friction mu, sliding dot(y)
        }
    }

    crate::model! {
        /// A sledge on rough waves with a mass on a rail that is the drier the further it is pulled out.
        Railed {
            parameters { m: kg = 2, g: m/s^2 = 9.81, w: 1/m = 3, mu = 0.4, f: N = 3 }
            coordinates { y: m, z: m, r: m }
            controls { u: N in -5..=5, p: N in -3..=3 }
            lagrangian m/2*(dot(y)^2 + dot(z)^2 + dot(y + r)^2) - m*g*z
            forces { y: u*cos(w*y), r: p }
            surface ground: z >= 0.1[m]*sin(w*y)
            impact ground: friction mu, inelastic, sliding dot(y) + 0.1[m]*w*cos(w*y)*dot(z)
            dry friction rail: bound f*(2 + sin(w*r)*cos(w*y) + t/1[s]), sliding dot(r)*(2 + cos(w*r)) - dot(z)
            minimize time
            finally { y == 1.5 [m] }
            start { z: 0.5 [m], dot(y): 1 [m/s] }
        }
    }

    crate::model! {
        /// A sledge on rough waves, between which it may stick, and of which forces and impulses are read in every statement.
        Felt {
            parameters { m: kg = 2, g: m/s^2 = 9.81, w: 1/m = 3, mu = 0.4, e = 0.3 }
            coordinates { y: m, z: m, r: m }
            controls { u: N in -5..=5, p: N in -3..=3 }
            fn ground(y) = 0.1[m]*sin(w*y)
            lagrangian m/2*(dot(y)^2 + (2 + sin(w*r))*dot(z)^2 + dot(r)^2) - m*g*z
            forces { y: u*cos(w*y), r: p }
            surface ground: z - ground(y) >= 0
            surface wall: z + y <= 3 [m]
            impact ground: friction mu, restitution e, sliding dot(y) + 0.1[m]*w*cos(w*y)*dot(z)
            impact wall: inelastic, friction 2*mu, sliding dot(y) - dot(z) - 0.2[m/s]*cos(w*y)
            minimize integral(force(ground)^2*y + friction_force(wall)*friction_force(ground)*sin(t/1 [s])*1 [m])
                + sum(impulse(wall)^2*impulse(ground)*t)*1 [m/N/s^3] + force(ground)^2*z*time
            constraint strong: force(ground)*cos(w*r) + friction_force(wall) + u <= 90 [N]
            constraint soft: impulse(ground)*cos(w*r) + friction_impulse(wall) <= 9 [N s]
            finally { y == 1.5 [m], friction_force(ground) + sum(friction_impulse(ground))/1 [s] <= 8 [N] }
            start { z: 0.5 [m], dot(y): 1 [m/s] }
        }
    }

    #[test]
    fn coordinate_that_friction_acts_on_is_no_parabola() {
        assert_eq!(parabolas(&Flat::default(), &[0.0; 6]), [false, false, true]);
    }

    /// Two contacts that close, stick, slip both ways and open, one at an impact of the other.
    fn sequence_of_all_modes() -> Sequence {
        use ContactMode::{Open, Stick};
        let forward = ContactMode::Slip(Direction::Forward);
        let backward = ContactMode::Slip(Direction::Backward);
        let switch = |contact, (closes, mode, impulse), place, time: f64| Switch {
            impulse,
            place,
            ..Switch::inside(contact, closes, mode, time)
        };
        let slides = |mode| (false, mode, mode);
        let sequence = Sequence {
            initially: vec![Open; 2],
            pieces: Pieces::default(),
            switches: vec![
                switch(0, (true, Stick, Stick), Place::Inside, 0.3),
                switch(0, slides(forward), Place::Inside, 0.6),
                switch(0, slides(Stick), Place::Start, 1.0),
                switch(0, slides(backward), Place::Start, 2.0),
                switch(1, (true, backward, backward), Place::Inside, 2.3),
                Switch {
                    accompanies: true,
                    ..switch(0, (false, forward, Stick), Place::Inside, 2.3)
                },
                switch(1, (false, Open, Open), Place::Inside, 2.6),
                switch(0, slides(backward), Place::Inside, 3.5),
            ],
        };
        let sequence = sequence.ordered(4).unwrap();
        assert!(sequence.switches[5].accompanies);
        sequence
    }

    /// A sledge that lands, sticks and slips, with a mass on a dry rail that slips from the start, rests, and slips again.
    fn sequence_with_a_rail() -> Sequence {
        use ContactMode::{Open, Stick};
        let forward = ContactMode::Slip(Direction::Forward);
        let backward = ContactMode::Slip(Direction::Backward);
        let switch = |contact, closes, mode, place, time: f64| Switch {
            place,
            ..Switch::inside(contact, closes, mode, time)
        };
        let sequence = Sequence {
            initially: vec![Open, forward],
            pieces: Pieces::default(),
            switches: vec![
                switch(1, false, Stick, Place::Inside, 0.4),
                switch(0, true, forward, Place::Inside, 0.7),
                Switch {
                    accompanies: true,
                    ..switch(1, false, backward, Place::Inside, 0.7)
                },
                switch(1, false, Stick, Place::Inside, 1.3),
                switch(1, false, forward, Place::Start, 2.0),
                switch(0, false, Stick, Place::Inside, 2.5),
            ],
        };
        sequence.ordered(4).unwrap()
    }

    #[test]
    fn derivatives_with_friction_forces_and_impulses_in_all_modes_agree_with_differences() {
        let cone = CutKind::Cone(0, Direction::Forward);
        let path = CutKind::Path(0);
        for cuts in [[(0, path), (1, path)], [(0, cone), (0, CutKind::Slip(0))]] {
            compare_derivatives(&Felt::default(), &sequence_of_all_modes(), cuts, (10, 3));
        }
    }

    #[test]
    fn derivatives_with_dry_friction_agree_with_differences() {
        let cuts = [
            (1, CutKind::Cone(1, Direction::Forward)),
            (2, CutKind::Slip(1)),
        ];
        compare_derivatives(&Railed::default(), &sequence_with_a_rail(), cuts, (10, 1));
    }

    /// Compares the derivatives of the programs of a sequence with elements in its second interval, with cuts in phases
    /// of the first one; `counts` are its phases, and the contacts with friction in its impacts.
    fn compare_derivatives(
        model: &dyn Model,
        sequence: &Sequence,
        cuts: [(usize, CutKind); 2],
        counts: (usize, usize),
    ) {
        let problem = Problem::of(model, 4);
        let cuts = cuts.map(|(phase, kind)| Cut {
            interval: 0,
            phase: (phase, 3),
            theta: 0.3,
            kind,
        });
        for shape in [ControlShape::Constant, ControlShape::Linear] {
            let with = (shape, 3, Guess::Perturbed(3));
            with_setting((model, &problem), with, |setting, guessed| {
                assert_eq!(setting.parabolas, [false; 3]);
                let mut fine = transcribe(setting, sequence, guessed, &cuts, &[1, 2, 1, 1]);
                assert_eq!((fine.phases.len(), fine.impacts.len()), counts);
                let compared = check_derivatives(&mut fine.program, None).unwrap();
                assert!(compared[0].error < DIFFERENCE, "{:?}", compared[0]);
            });
        }
    }
}
