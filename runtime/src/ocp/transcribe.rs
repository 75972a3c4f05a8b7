//! Construction of the collocation program, phase by phase.

use super::collocation::{Collocation, Cut, Phase, Setting, Stage, lagrange};
use super::frame::{Frame, state_name};
use super::friction::{Tangential, Turns, start_rows, tangential};
use super::impact_map::{touches, vanish};
use super::kernel::Kernel;
use super::mode::Mode;
use super::path::Path;
use super::program::Program;
use super::sequence::{Place, Sequence, Switch};
use super::settings::{BoundsAt, ControlShape, PathPoints};
use super::stage_inputs::Elapsed;

/// Least distance of a guessed switch from the ends of its interval and from other switches, relative to the length
/// of the interval.
const GUESS_MARGIN: f64 = 0.02;

/// Shortest phase relative to its interval: in a phase of no length the contact forces are undetermined.
const SHORTEST: f64 = 2e-3;

/// State of the construction.
pub(super) struct Builder<'a, 's> {
    pub(super) setting: Setting<'a>,
    pub(super) program: Program<'a>,
    pub(super) guess: &'s Path,
    pub(super) cuts: &'s [Cut],
    /// Finite elements of a phase in each interval.
    elements: &'s [usize],
    pub(super) frame: Frame<'a>,
    pub(super) phases: Vec<Phase>,
    pub(super) impacts: Vec<(usize, Tangential)>,
    pub(super) modes: Vec<Mode>,
    pub(super) touches: Vec<(Switch, usize)>,
    pub(super) state: Vec<usize>,
    /// What drove the motion at the end of the phase before; nothing at the start, at time 0.
    pub(super) before: Vec<usize>,
    pub(super) n: usize,
}

impl<'a> Collocation<'a> {
    /// The program of a sequence, started at `guess`, with `elements` of each interval's phases.
    pub(super) fn new(
        setting: Setting<'a>,
        sequence: &Sequence,
        guess: &Path,
        cuts: &[Cut],
        elements: &[usize],
    ) -> Self {
        let (model, problem) = (setting.model, setting.problem);
        let mut program = Program::new(model);
        let frame = Frame::add(
            &mut program,
            model,
            problem,
            (guess, setting.shape),
            setting.units,
            setting.bounds,
        );
        let state = frame.start.clone();
        let mut builder = Builder {
            setting,
            program,
            guess,
            cuts,
            elements,
            frame,
            phases: Vec::new(),
            impacts: Vec::new(),
            modes: sequence.initially.clone(),
            touches: Vec::new(),
            state,
            before: Vec::new(),
            n: problem.q.len(),
        };
        builder.free_start();
        for interval in 0..problem.intervals {
            builder.interval(interval, &sequence.switches);
        }
        let last = |switch: &&Switch| switch.interval == problem.intervals;
        for (index, switch) in sequence.switches.iter().enumerate() {
            if last(&switch) && !switch.accompanies {
                let companions = Sequence::companions(&sequence.switches, index);
                let label = "the last interval";
                builder.close((index, switch), companions, label, guess.horizon);
            }
        }
        let (frame, mut program) = (builder.frame, builder.program);
        frame.finish(&mut program, problem, &builder.state);
        Self {
            program: program.finish(&frame.controls),
            model,
            sequence: sequence.clone(),
            phases: builder.phases,
            impacts: builder.impacts,
            touches: builder.touches,
            tableau: setting.tableau,
            horizon: frame.horizon,
            controls: frame.controls,
            shape: setting.shape,
        }
    }
}

impl Builder<'_, '_> {
    /// The closed contacts.
    fn closed(&self) -> Vec<usize> {
        let modes = self.modes.iter().enumerate();
        modes
            .filter(|(_, m)| !m.is_open())
            .map(|(i, _)| i)
            .collect()
    }

    fn interval(&mut self, interval: usize, switches: &[Switch]) {
        let share = 1.0 / self.setting.problem.intervals as f64;
        let here = |place: Place| {
            let all = switches.iter().enumerate();
            all.filter(move |(_, s)| s.interval == interval && s.place == place && !s.accompanies)
        };
        let (mut openings, mut before) = (Vec::new(), self.state.clone());
        let mut touched: Vec<usize> = Vec::new();
        let jumps = self.setting.shape == ControlShape::Constant;
        let mut turns = Turns::default();
        if interval == 0 {
            turns.pulled = self.pulled_at_start();
        }
        for (index, switch) in here(Place::Start) {
            let companions = Sequence::companions(switches, index);
            for other in std::iter::once(switch).chain(companions) {
                turns.start(other, self.modes[other.contact], switch.closes, jumps);
            }
            if switch.closes {
                let time = self.guess.horizon * interval as f64 * share;
                let label = format!("interval {}", interval - 1);
                self.close((index, switch), companions, &label, time);
                touched.extend(touches(switch, companions));
                before.clone_from(&self.state);
            } else {
                if switch.opens() {
                    openings.push(switch.contact);
                }
                // Controls that do not jump let go of a contact where its force vanishes.
                if let (true, ControlShape::Linear, Some(phase)) =
                    (switch.opens(), self.setting.shape, self.phases.last())
                {
                    vanish(&mut self.program, phase, switch.contact);
                }
                self.enter(switch, companions);
            }
        }
        let inside: Vec<(usize, &Switch)> = here(Place::Inside).collect();
        let elements = self.elements[interval];
        let length = self.guess.horizon / self.setting.problem.intervals as f64;
        let count = inside.len() + 1;
        let margin = GUESS_MARGIN.min(0.5 / count as f64);
        let mut ends: Vec<f64> = Vec::with_capacity(count);
        for (p, (_, switch)) in inside.iter().enumerate() {
            let before = ends.last().copied().unwrap_or(0.0);
            let least = before + margin;
            let most = 1.0 - (count - 1 - p) as f64 * margin;
            ends.push((switch.time - interval as f64).max(least).min(most));
        }
        ends.push(1.0);
        let durations: Vec<usize> = if count == 1 {
            Vec::new()
        } else {
            let row = self
                .program
                .row(format!("length of interval {interval}"), 0.0, 0.0);
            self.program.linear(row, self.frame.horizon, -share);
            (0..count)
                .map(|p| {
                    let begin = if p == 0 { 0.0 } else { ends[p - 1] };
                    let duration = self.program.variable(
                        format!("length of phase {p} of interval {interval}"),
                        (SHORTEST * length, f64::INFINITY),
                        (ends[p] - begin) * length,
                        length,
                    );
                    self.program.linear(row, duration, 1.0);
                    duration
                })
                .collect()
        };
        let mut begin = 0.0;
        let mut elapsed = Elapsed::none(self.frame.horizon, self.setting.problem.intervals);
        for (p, &end) in ends.iter().enumerate() {
            let (scale, factor) = match durations.get(p) {
                Some(&duration) => (duration, 1.0),
                None => (self.frame.horizon, share),
            };
            let factor = factor / elements as f64;
            let times = (
                (interval as f64 + begin) * length,
                (interval as f64 + end) * length,
            );
            let ending = inside.get(p).copied();
            let opened: Vec<usize> = match p.checked_sub(1).map(|before| inside[before].1) {
                None => openings.clone(),
                Some(before) if before.opens() => vec![before.contact],
                Some(_) => Vec::new(),
            };
            let ends = |(index, switch): (usize, &Switch)| match ending {
                Some((first, _)) => {
                    let companions = Sequence::companions(switches, first).len();
                    (first..=first + companions).contains(&index)
                }
                None => switch.interval == interval + 1 && switch.place == Place::Start,
            };
            turns.finishing = interval + 1 == self.setting.problem.intervals && p + 1 == count;
            let (mut closing, mut impact) = (Vec::new(), false);
            for (index, switch) in switches.iter().enumerate() {
                impact = switch.closes || impact && switch.accompanies;
                if !ends((index, switch)) {
                    continue;
                }
                if switch.closes {
                    closing.push(switch.contact);
                } else if !impact {
                    turns.end(switch, self.modes[switch.contact], jumps);
                }
            }
            for e in 0..elements {
                let (first, last) = (e == 0, e + 1 == elements);
                let turns = turns.of_element(first, last);
                let time = |e: usize| times.0 + e as f64 / elements as f64 * (times.1 - times.0);
                self.phase(
                    (interval, (p * elements + e, count * elements)),
                    (scale, factor),
                    (&elapsed, time(e), time(e + 1)),
                    (ending.filter(|_| last), if last { &closing } else { &[] }),
                    if first {
                        (&opened, &touched, &turns)
                    } else {
                        (&[], &[], &turns)
                    },
                );
                elapsed = elapsed.later(scale, factor);
            }
            turns = Turns::default();
            if let Some((index, switch)) = ending {
                let companions = Sequence::companions(switches, index);
                for other in std::iter::once(switch).chain(companions) {
                    turns.start(other, self.modes[other.contact], switch.closes, jumps);
                }
                self.switch((index, switch), companions, (interval, p), times.1);
            }
            touched = match ending {
                Some((index, switch)) => touches(switch, Sequence::companions(switches, index)),
                None => Vec::new(),
            };
            begin = end;
        }
        self.node(interval, &before);
    }

    fn phase(
        &mut self,
        (interval, index): (usize, (usize, usize)),
        (scale, factor): (usize, f64),
        (elapsed, from, to): (&Elapsed, f64, f64),
        (ending, closing): (Option<(usize, &Switch)>, &[usize]),
        (opened, touched, turns): (&[usize], &[usize], &Turns),
    ) {
        let Setting {
            model,
            problem,
            units,
            bounds,
            parabolas,
            tableau,
            places,
            shape,
            ..
        } = self.setting;
        let n = self.n;
        let contacts = model.declaration().contacts;
        let free = (f64::NEG_INFINITY, f64::INFINITY);
        let closed = self.closed();
        let label = format!("interval {interval}, phase {}", index.0);
        let stages = tableau.stages();
        let mut drives = Vec::with_capacity(stages);
        let length = self.guess.horizon / problem.intervals as f64;
        for (m, c) in tableau.c().iter().enumerate() {
            let mut moment = elapsed.later(scale, c * factor);
            if index.0 + 1 == index.1 && m + 1 == stages {
                moment = moment.all();
            }
            let guess = (from + c * (to - from)) / length - interval as f64;
            let place = format!("at stage {m} of {label}");
            drives.push(self.drive_at(interval, &moment, guess, &place));
        }
        let program = &mut self.program;
        let mut phase = Phase {
            interval,
            index,
            closed: closed.clone(),
            modes: self.modes.clone(),
            start: self.state.clone(),
            stages: Vec::with_capacity(stages),
            scale,
            factor,
            openings: Vec::new(),
            pulled: Vec::new(),
            cones: Vec::new(),
            yielded: turns.yielded.clone(),
            ends_with: ending.map(|(index, _)| index),
            closing: closing.to_vec(),
        };
        let mut corrections = Vec::with_capacity(stages);
        for (m, c) in tableau.c().iter().enumerate() {
            let sample = self.guess.at(from + c * (to - from), m + 1 < stages);
            let state: Vec<usize> = (0..2 * n)
                .map(|k| {
                    let bounded = k < n
                        && match places.bounds {
                            BoundsAt::AllTimes => !parabolas[k],
                            BoundsAt::Nodes => m + 1 == stages,
                        };
                    let range = if bounded {
                        (bounds.0[k], bounds.1[k])
                    } else {
                        free
                    };
                    let name = format!("{} at stage {m} of {label}", state_name(model, k));
                    program.variable(name, range, sample[k], units.states[k])
                })
                .collect();
            let mut forces = Vec::new();
            let mut shifts = Vec::new();
            let mut rubbing = Vec::new();
            for &i in &closed {
                let name = contacts[i].name;
                let length = to - from;
                let unit = units.force[i] * length;
                let force = program.variable(
                    format!("force of `{name}` at stage {m} of {label}"),
                    (0.0, f64::INFINITY),
                    sample[2 * n + i] * length,
                    unit,
                );
                forces.push(force);
                let at = format!("at stage {m} of {label}");
                let mode = (i, self.modes[i]);
                rubbing.extend(tangential(
                    program,
                    model,
                    mode,
                    (force, unit, units.gap_rows[i]),
                    &at,
                ));
                let name = format!("correction of `{name}` at stage {m} of {label}");
                shifts.push(program.variable(name, free, 0.0, units.gap[i]));
            }
            corrections.push(shifts);
            phase.stages.push(Stage {
                state,
                drive: std::mem::take(&mut drives[m]),
                forces,
                gap_rows: Vec::new(),
                tangential: rubbing,
            });
        }
        for (m, corrections) in corrections.iter().enumerate() {
            let mut rubbing = std::mem::take(&mut phase.stages[m].tangential);
            let Stage {
                state,
                drive: u,
                forces,
                ..
            } = &phase.stages[m];
            let mut gap_rows = Vec::with_capacity(contacts.len());
            let (q, v) = state.split_at(n);
            let slopes = lagrange(tableau, tableau.c()[m], true);
            let (mut moves, mut pushes, mut free_pushes) = (Vec::new(), Vec::new(), Vec::new());
            for (k, &before) in phase.start.iter().enumerate() {
                let name = format!(
                    "collocation of {}, stage {m}, {label}",
                    state_name(model, k)
                );
                let row = program.row_in(units.states[k], name, 0.0, 0.0);
                program.linear(row, before, slopes[0]);
                for (stage, slope) in phase.stages.iter().zip(&slopes[1..]) {
                    program.linear(row, stage.state[k], *slope);
                }
                if k < n {
                    program.bilinear(row, scale, v[k], -factor);
                    moves.push((row, k, -1.0));
                } else {
                    free_pushes.push((row, k - n, -factor));
                    pushes.push((row, k - n, -1.0));
                }
            }
            let kernel = Kernel::Acceleration(Vec::new());
            program.block(&kernel, [q, v, u, &[]], Some(scale), free_pushes);
            if !closed.is_empty() {
                for tangential in &mut rubbing {
                    let place = (turns, m + 1 == stages);
                    let label = format!("at stage {m} of {label}");
                    tangential.push(program, model, (q, u), &pushes);
                    tangential.constrain(program, model, [q, v, u], place, &label);
                }
                let kernel = Kernel::Push(closed.clone());
                program.block(&kernel, [q, &[], u, forces], None, pushes);
                program.block(&kernel, [q, &[], u, corrections], None, moves);
            }
            for (i, contact) in contacts.iter().enumerate() {
                let last = m + 1 == stages;
                let closes = last && closing.contains(&i);
                let upper = if closed.contains(&i) || closes {
                    0.0
                } else {
                    f64::INFINITY
                };
                let name = format!("gap `{}`, stage {m}, {label}", contact.name);
                // Right after an opening the gap is of third order in time, so that its rows would have no
                // interior: its sign follows from the force before, and is checked afterwards.
                let lower = if opened.contains(&i) && upper > 0.0 {
                    f64::NEG_INFINITY
                } else {
                    0.0
                };
                let row = program.row_in(units.gap_rows[i], name, lower, upper);
                gap_rows.push(row);
                let mut uses = vec![(row, 0, 1.0)];
                if closed.contains(&i) {
                    let name = format!("normal velocity of `{}`, stage {m}, {label}", contact.name);
                    let row = program.row_in(units.gap_rows[i], name, 0.0, 0.0);
                    uses.push((row, 1, 1.0));
                }
                program.block(&Kernel::Contact(i), [q, v, u, &[]], None, uses);
            }
            phase.stages[m].gap_rows = gap_rows;
            phase.stages[m].tangential = rubbing;
        }
        for (m, stage) in phase.stages.iter().enumerate() {
            let (q, v) = stage.state.split_at(n);
            let (u, weight) = (&stage.drive[..], (scale, factor * tableau.b()[m]));
            self.frame.running_cost(program, problem, [q, v, u], weight);
            if places.path != PathPoints::Ends || m + 1 == stages {
                let place = format!("at stage {m} of {label}");
                self.frame.path_rows(program, problem, [q, v, u], &place);
            }
        }
        if places.path == PathPoints::Both && (interval, index.0) != (0, 0) {
            let (q, v) = phase.start.split_at(n);
            let place = format!("at the start of {label}");
            let u = self.drive_within(&phase, 0.0, &place);
            self.frame
                .path_rows(&mut self.program, problem, [q, v, &u], &place);
        }
        if (interval, index.0) == (0, 0) {
            self.first_path_rows(&phase);
        }
        let program = &mut self.program;
        // The force right at the start of a contact phase, extrapolated from the stages.
        let mut values = vec![0.0; stages];
        tableau.lagrange_values(0.0, &mut values);
        for (slot, &i) in closed.iter().enumerate() {
            let name = format!("force of `{}` at the start of {label}", contacts[i].name);
            let row = program.row_in(units.gap_rows[i], name, 0.0, f64::INFINITY);
            for (stage, weight) in phase.stages.iter().zip(&values) {
                program.linear(row, stage.forces[slot], *weight);
            }
        }
        // The normal acceleration after an opening at a jump of the controls: the slope of the normal
        // velocity, which starts from 0.
        // The same after a touch without a bounce.
        let jumps = index.0 == 0 && shape == ControlShape::Constant;
        let jump = opened.iter().filter(|_| jumps);
        let plastic = touched.iter().filter(|&&i| model.restitution(i) == 0.0);
        for &i in jump.chain(plastic) {
            let name = format!("opening of `{}` at the start of {label}", contacts[i].name);
            let row = program.row_in(units.gap_rows[i], name, 0.0, f64::INFINITY);
            let slopes = lagrange(tableau, 0.0, true);
            for (stage, slope) in phase.stages.iter().zip(&slopes[1..]) {
                let (q, v) = stage.state.split_at(n);
                let uses = vec![(row, 1, *slope)];
                let kernel = Kernel::Contact(i);
                program.block(&kernel, [q, v, &stage.drive, &[]], None, uses);
            }
            phase.openings.push((i, row));
        }
        start_rows(program, self.setting, &mut phase, turns, &label);
        self.add_cuts(&phase);
        if let Some(stage) = phase.stages.last() {
            self.state.clone_from(&stage.state);
            self.before.clone_from(&stage.drive);
        }
        self.phases.push(phase);
    }
}

#[cfg(test)]
mod tests {
    use super::super::collocation::{CutKind, Places, Setting, parabolas};
    use super::super::contact_implicit::ContactImplicit;
    use super::super::problem::{Goal, Horizon, Objective, Problem, bounds};
    use super::super::settings::{Guess, PathPoints};
    use super::super::test_scene::{Demanding, Sledge};
    use super::super::units::Units;
    use super::*;
    use crate::nlp::check_derivatives;
    use crate::rk::{ButcherTableau, Scheme};

    /// The central difference of a function with values and derivatives up to 1e3 is good to about 1e-7 of them.
    const DIFFERENCE: f64 = 1e-5;

    fn problem(model: &Demanding) -> Problem {
        let goal = Goal {
            component: super::super::problem::Component::Coordinate(0),
            value: 1.5,
        };
        let objective = Objective {
            final_time: 1.0,
            control_effort: 0.1,
            final_coordinates: vec![(2, 0.3)],
            final_velocities: vec![(1, -0.2)],
        };
        Problem {
            horizon: Horizon::Free { guess: Some(1.2) },
            declared: true,
            ..Problem::new(model, objective, vec![goal], 3)
        }
    }

    #[test]
    fn derivatives_of_both_programs_agree_with_differences() {
        for shape in [ControlShape::Constant, ControlShape::Linear] {
            check_both(shape);
        }
    }

    fn check_both(shape: ControlShape) {
        let model = Demanding(Sledge::default());
        let problem = problem(&model);
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
        assert_eq!(parabolas, [false, false, true]);
        let setting = Setting {
            model: &model,
            problem: &problem,
            tableau: &tableau,
            units: &units,
            bounds,
            parabolas: &parabolas,
            places: Places {
                bounds: BoundsAt::AllTimes,
                path: PathPoints::Both,
            },
            shape,
        };
        let switch = |closes, interval, place, time| Switch {
            contact: 0,
            closes,
            mode: if closes {
                Mode::Frictionless
            } else {
                Mode::Open
            },
            impulse: Mode::Frictionless,
            accompanies: false,
            interval,
            place,
            time,
        };
        let sequence = Sequence {
            initially: vec![Mode::Open],
            switches: vec![
                switch(true, 0, Place::Inside, 0.4),
                switch(false, 0, Place::Inside, 0.8),
                switch(true, 1, Place::Start, 1.0),
                switch(false, 2, Place::Start, 2.0),
            ],
        };
        let cut = |phase, interval, kind| Cut {
            interval,
            phase,
            theta: 0.3,
            kind,
        };
        let cuts = [
            cut((0, 3), 0, CutKind::Gap(0, 1e-5)),
            cut((0, 1), 2, CutKind::Bounds(0)),
            cut((0, 1), 2, CutKind::Departure(0)),
            cut((0, 1), 2, CutKind::Path(0)),
        ];
        let mut fine = Collocation::new(setting, &sequence, &guess, &cuts, &[1, 2, 1]);
        assert_eq!(fine.phases.len(), 6);
        let report = check_derivatives(&mut fine.program, None).unwrap();
        assert!(report.worst() < DIFFERENCE, "{:?}", report.worst_entry());
    }
}
