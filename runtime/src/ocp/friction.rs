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
//! Contacts of one body stop together: the velocity of one of them is asked to vanish, and whether those of the others
//! do is for the re-simulation to judge. Their forces reach the edges of their cones together; how they share the load
//! before is left open.

use super::collocation::{Phase, Setting, Stage, lagrange};
use super::kernel::Kernel;
use super::mode::{Direction, Mode};
use super::program::Program;
use super::sequence::{Place, Switch};
use crate::model::Model;
use crate::rk::ButcherTableau;

/// Room of a sliding velocity at the end of the motion, in its unit: where that is to end at rest, the row would have no
/// interior. Where it is not, the sign is checked afterwards.
const AT_THE_END: f64 = 1e-6;

const FREE: (f64, f64) = (f64::NEG_INFINITY, f64::INFINITY);

/// A closed contact with friction at a stage or in an impact: where its unknown and its conditions are.
pub(super) struct Tangential {
    pub(super) contact: usize,
    pub(super) mode: Mode,
    /// Normal force or impulse.
    pub(super) normal: usize,
    /// Unit of its velocities, and of accelerations times lengths.
    unit: f64,
    /// Tangential force or impulse, if the contact sticks.
    pub(super) force: Option<usize>,
    /// Rows that hold on both sides: of the friction cone, towards the direction in which the contact would slip; or
    /// of the sliding velocity in the direction of the slip.
    pub(super) rows: Vec<(Direction, usize)>,
}

/// What happens to contacts with friction at the ends of an element.
#[derive(Default, Clone)]
pub(super) struct Turns {
    /// Contacts at rest that begin to slip at the start, pulled by a jump of the controls, an impact or the reversal of
    /// their own friction: with an acceleration.
    pub(super) pulled: Vec<usize>,
    /// Contacts that begin to slip at the start because their force has reached the edge of the cone: with the rate
    /// of the acceleration, so that the rows of their sliding velocities would have no interior. Its sign follows from
    /// the force before.
    pub(super) yielded: Vec<usize>,
    /// Contacts whose sliding velocity vanishes at the end.
    pub(super) stopping: Vec<usize>,
    /// The same because they are parts of the body of another one that stops.
    pub(super) stopped: Vec<usize>,
    /// Contacts whose force reaches the edge of the cone at the end.
    pub(super) yielding: Vec<(usize, Direction)>,
    /// Sticking contacts that open at the end: the cone has shrunk to a point.
    pub(super) opening: Vec<usize>,
    /// Whether the motion ends at the end.
    pub(super) finishing: bool,
}

impl Turns {
    /// What a switch asks for at the end of the element before it; `jumps` where the controls may jump between
    /// intervals.
    pub(super) fn end(&mut self, switch: &Switch, before: Mode, jumps: bool) {
        let inside = switch.place == Place::Inside || !jumps;
        match (before, switch.mode) {
            (Mode::Slip(_), Mode::Stick | Mode::Slip(_)) if switch.accompanies => {
                self.stopped.push(switch.contact);
            }
            (Mode::Slip(_), Mode::Stick | Mode::Slip(_)) => self.stopping.push(switch.contact),
            (Mode::Stick, Mode::Slip(direction)) if inside => {
                self.yielding.push((switch.contact, direction));
            }
            (Mode::Stick, Mode::Open) if inside => self.opening.push(switch.contact),
            _ => {}
        }
    }

    /// What a switch leaves at the start of the element after it; `impact` where it belongs to one, `jumps` where the
    /// controls may jump between intervals.
    pub(super) fn start(&mut self, switch: &Switch, before: Mode, impact: bool, jumps: bool) {
        let inside = switch.place == Place::Inside || !jumps;
        match (before, switch.mode) {
            (_, Mode::Slip(_)) if impact && switch.impulse != Mode::Stick => {}
            (Mode::Stick, Mode::Slip(_)) if inside && !impact => {
                self.yielded.push(switch.contact);
            }
            (_, Mode::Slip(_)) => self.pulled.push(switch.contact),
            _ => {}
        }
    }

    /// The part that belongs to one of the elements between two switches.
    pub(super) fn of_element(&self, first: bool, last: bool) -> Self {
        let mut turns = self.clone();
        if !first {
            (turns.pulled, turns.yielded) = (Vec::new(), Vec::new());
        }
        if !last {
            (turns.stopping, turns.stopped) = (Vec::new(), Vec::new());
            (turns.yielding, turns.opening) = (Vec::new(), Vec::new());
            turns.finishing = false;
        }
        turns
    }
}

/// Adds the tangential force of a contact that sticks, with the unit of its normal force and that of its rows, in the
/// place described by `label`.
pub(super) fn tangential(
    program: &mut Program,
    model: &dyn Model,
    (contact, mode): (usize, Mode),
    (normal, force_unit, unit): (usize, f64, f64),
    label: &str,
) -> Option<Tangential> {
    if !matches!(mode, Mode::Stick | Mode::Slip(_)) {
        return None;
    }
    let name = model.declaration().contacts[contact].name;
    let force = (mode == Mode::Stick).then(|| {
        program.variable(
            format!("friction of `{name}` {label}"),
            FREE,
            0.0,
            force_unit,
        )
    });
    Some(Tangential {
        contact,
        mode,
        normal,
        unit,
        force,
        rows: Vec::new(),
    })
}

impl Tangential {
    /// Adds the effect of the tangential force at `(q, u)`: `coefficient e_k s` for each (row, k, coefficient).
    pub(super) fn push(
        &self,
        program: &mut Program,
        model: &dyn Model,
        (q, u): (&[usize], &[usize]),
        uses: &[(usize, usize, f64)],
    ) {
        let (force, ratio) = match (self.force, self.mode) {
            (Some(force), _) => (force, 1.0),
            (None, Mode::Slip(direction)) => {
                let mu = model.friction(self.contact);
                (self.normal, -direction.sign() * mu)
            }
            (None, _) => return,
        };
        let uses = uses.iter().map(|&(row, k, c)| (row, k, ratio * c));
        let kernel = Kernel::Friction(vec![self.contact]);
        program.block(&kernel, [q, &[], u, &[force]], None, uses.collect());
    }

    /// Adds the conditions at a stage or after an impact, at `(q, v, u)`; `turns` are those at the end of the
    /// element if the stage is the last one.
    pub(super) fn constrain(
        &mut self,
        program: &mut Program,
        model: &dyn Model,
        [q, v, u]: [&[usize]; 3],
        (turns, last): (&Turns, bool),
        label: &str,
    ) {
        let contact = self.contact;
        let name = model.declaration().contacts[contact].name;
        let kernel = Kernel::Sliding(contact);
        let unit = self.unit;
        let velocity = |program: &mut Program, sign: f64, bounds: (f64, f64)| {
            let name = format!("sliding velocity of `{name}` {label}");
            let row = program.row_in(unit, name, bounds.0, bounds.1);
            program.block(&kernel, [q, v, u, &[]], None, vec![(row, 0, sign)]);
            row
        };
        let Some(force) = self.force else {
            let Mode::Slip(direction) = self.mode else {
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
                self.rows.push((direction, row));
            }
            return;
        };
        velocity(program, 1.0, (0.0, 0.0));
        if last && turns.opening.contains(&contact) {
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
            reserve(
                program,
                (row, 1.0),
                model.friction(contact),
                direction,
                (self.normal, force),
            );
            if !reaches {
                self.rows.push((direction, row));
            }
        }
    }
}

/// Adds `weight (mu r + sigma s)`, what is left of the friction cone before the contact slips with the sign `sigma`.
fn reserve(
    program: &mut Program,
    (row, weight): (usize, f64),
    mu: f64,
    direction: Direction,
    (normal, force): (usize, usize),
) {
    program.linear(row, normal, weight * mu);
    program.linear(row, force, weight * direction.sign());
}

/// Adds `mu r + sigma s` of a sticking contact at the weights of the stages to a row.
pub(super) fn reserve_between(
    program: &mut Program,
    model: &dyn Model,
    (row, contact, direction): (usize, usize, Direction),
    stages: &[Stage],
    weights: &[f64],
) {
    for (stage, &weight) in stages.iter().zip(weights) {
        for tangential in stage.tangential.iter().filter(|t| t.contact == contact) {
            if let Some(force) = tangential.force {
                let mu = model.friction(contact);
                let pair = (tangential.normal, force);
                reserve(program, (row, weight), mu, direction, pair);
            }
        }
    }
}

/// Adds the sliding acceleration at the start of an element at whose start the contact rests, to a row.
pub(super) fn sliding_acceleration(
    program: &mut Program,
    (row, contact, direction): (usize, usize, Direction),
    phase: &Phase,
    tableau: &ButcherTableau,
) {
    let slopes = lagrange(tableau, 0.0, true);
    for (stage, slope) in phase.stages.iter().zip(&slopes[1..]) {
        let (q, v) = stage.state.split_at(stage.state.len() / 2);
        let uses = vec![(row, 0, direction.sign() * slope)];
        let kernel = Kernel::Sliding(contact);
        program.block(&kernel, [q, v, &stage.drive, &[]], None, uses);
    }
}

/// Adds the conditions at the start of an element: the force of a sticking contact, extrapolated from the stages, lies
/// in its cone; a contact that is pulled into slip begins to move its way.
pub(super) fn start_rows(
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
            Mode::Stick => {
                for direction in Direction::BOTH {
                    let name = format!("friction cone of `{name}` at the start of {label}");
                    let unit = units.gap_rows[contact];
                    let row = program.row_in(unit, name, 0.0, f64::INFINITY);
                    let place = (row, contact, direction);
                    reserve_between(program, model, place, &phase.stages, &values);
                    cones.push((contact, direction, row));
                }
            }
            Mode::Slip(direction) if turns.pulled.contains(&contact) => {
                let name = format!("slip of `{name}` at the start of {label}");
                let unit = units.gap_rows[contact];
                let row = program.row_in(unit, name, 0.0, f64::INFINITY);
                sliding_acceleration(program, (row, contact, direction), phase, tableau);
                pulled.push((contact, row));
            }
            _ => {}
        }
    }
    (phase.pulled, phase.cones) = (pulled, cones);
}

#[cfg(test)]
mod tests {
    use super::super::collocation::{Collocation, Cut, CutKind, Places, Setting, parabolas};
    use super::super::contact_implicit::ContactImplicit;
    use super::super::path::Path;
    use super::super::problem::{Problem, bounds};
    use super::super::sequence::Sequence;
    use super::super::settings::{BoundsAt, ControlShape, Guess, PathPoints};
    use super::super::units::Units;
    use super::*;
    use crate::nlp::check_derivatives;
    use crate::rk::Scheme;

    /// The central difference of a function with values and derivatives up to 1e3 is good to about 1e-7 of them.
    const DIFFERENCE: f64 = 1e-5;

    crate::model! {
        /// A sledge on rough waves, between which it may stick.
        Rough {
            parameters { m: kg = 2, g: m/s^2 = 9.81, w: 1/m = 3, mu = 0.4, e = 0.3 }
            coordinates { y: m, z: m, r: m }
            controls { u: N in -5..=5, p: N in -3..=3 }
            fn ground(y) = 0.1[m]*sin(w*y)
            lagrangian m/2*(dot(y)^2 + (2 + sin(w*r))*dot(z)^2 + dot(r)^2) - m*g*z
            forces { y: u*cos(w*y), r: p }
            surface ground: z - ground(y) >= 0
            surface wall: z + y <= 3 [m]
            impact ground: friction mu, restitution e, sliding dot(y) + 0.1[m]*w*cos(w*y)*dot(z)
            impact wall: inelastic, friction 2*mu, sliding dot(y) - dot(z)
            minimize time
            finally { y == 1.5 [m] }
            start { z: 0.5 [m], dot(y): 1 [m/s] }
        }
    }

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

    #[test]
    fn coordinate_that_friction_rubs_is_no_parabola() {
        assert_eq!(parabolas(&Flat::default(), &[0.0; 6]), [false, false, true]);
    }

    #[test]
    fn derivatives_with_friction_in_all_modes_agree_with_differences() {
        let model = Rough::default();
        let problem = Problem::of(&model, 4);
        let (lower, upper) = bounds(&model);
        let bounds = (&lower[..], &upper[..]);
        let guess = Path::guess(&model, &problem, &Guess::Perturbed { seed: 3 }, bounds).unwrap();
        let units = Units::new(&model, &guess, bounds);
        let mut coarse = ContactImplicit::new(&model, &problem, 2, &guess, &units, bounds);
        let report = check_derivatives(&mut coarse.program, None).unwrap();
        assert!(report.worst() < DIFFERENCE, "{:?}", report.worst_entry());

        let tableau = ButcherTableau::new(Scheme::RadauIia, 3).unwrap();
        let start: Vec<f64> = problem.q.iter().chain(&problem.v).copied().collect();
        let parabolas = parabolas(&model, &start);
        assert_eq!(parabolas, [false; 3]);
        let setting = |shape| Setting {
            model: &model,
            shape,
            problem: &problem,
            tableau: &tableau,
            units: &units,
            bounds,
            parabolas: &parabolas,
            places: Places {
                bounds: BoundsAt::AllTimes,
                path: PathPoints::Both,
            },
        };
        let forward = Mode::Slip(Direction::Forward);
        let backward = Mode::Slip(Direction::Backward);
        let switch = |contact, (closes, mode, impulse), place, time: f64| Switch {
            contact,
            closes,
            mode,
            impulse,
            accompanies: false,
            interval: time.floor() as usize,
            place,
            time,
        };
        let slides = |mode| (false, mode, mode);
        let sequence = Sequence {
            initially: vec![Mode::Open; 2],
            switches: vec![
                switch(0, (true, Mode::Stick, Mode::Stick), Place::Inside, 0.3),
                switch(0, slides(forward), Place::Inside, 0.6),
                switch(0, slides(Mode::Stick), Place::Start, 1.0),
                switch(0, slides(backward), Place::Start, 2.0),
                switch(1, (true, backward, backward), Place::Inside, 2.3),
                Switch {
                    accompanies: true,
                    ..switch(0, (false, forward, Mode::Stick), Place::Inside, 2.3)
                },
                switch(1, (false, Mode::Open, Mode::Open), Place::Inside, 2.6),
                switch(0, slides(backward), Place::Inside, 3.5),
            ],
        };
        let sequence = sequence.ordered(4).unwrap();
        assert!(sequence.switches[5].accompanies);
        let cut = |phase, interval, kind| Cut {
            interval,
            phase,
            theta: 0.3,
            kind,
        };
        let cuts = [
            cut((1, 3), 0, CutKind::Cone(0, Direction::Forward)),
            cut((2, 3), 0, CutKind::Slip(0)),
        ];
        for shape in [ControlShape::Constant, ControlShape::Linear] {
            let setting = setting(shape);
            let mut fine = Collocation::new(setting, &sequence, &guess, &cuts, &[1, 2, 1, 1]);
            assert_eq!((fine.phases.len(), fine.impacts.len()), (10, 3));
            let report = check_derivatives(&mut fine.program, None).unwrap();
            assert!(report.worst() < DIFFERENCE, "{:?}", report.worst_entry());
        }
    }
}
