//! One element of a phase: its unknowns, the rows of its stages, and what holds at its start.

use super::builder::Builder;
use super::discretization::Setting;
use super::friction_rows::Normal;
use super::layout::{Distance, FREE, Kept, Phase, Stage};
use super::stage_inputs::{Elapsed, drive_at, drive_within};
use super::turns::Turns;
use super::{cut_rows, friction_rows, provided, start_conditions};
use crate::model::Pieces;
use crate::model::held::{first_at_stages, is_held};
use crate::ocp::motion::control_grid::ControlShape;
use crate::ocp::motion::model_input::{drive, free_normal_acceleration};
use crate::ocp::program::frame::{Provided, force_name, state_name};
use crate::program::joint_rows::Decided;
use crate::program::kernel::Kernel;
use crate::simulation::per_second;

/// Room of a force at the start of the motion, in the unit of its row: where the start leaves none, as at rest on a curved surface whose
/// force grows with the speed, the row would have no interior but by the controls. A force that pulls is for the re-simulation to see.
const AT_THE_START: f64 = 1e-4;

/// One element of a phase, as the contact sequence asks for it.
pub(super) struct Element<'e> {
    pub(super) interval: usize,
    /// Index in its interval, and the number of elements there.
    pub(super) index: (usize, usize),
    /// Length: `factor` times this variable.
    pub(super) scale: usize,
    pub(super) factor: f64,
    /// What has passed of its interval before it.
    pub(super) elapsed: &'e Elapsed,
    /// Start and end in the guess \[s\].
    pub(super) from: f64,
    pub(super) to: f64,
    /// The switch at the end inside the interval, as an index into the sequence.
    pub(super) ends_with: Option<usize>,
    /// Contacts that close or are touched at the end.
    pub(super) closing: &'e [usize],
    /// Contacts that take over at the end from one that opens.
    pub(super) taking: &'e [usize],
    /// Pieces of edges that act from the end on.
    pub(super) passed: &'e [usize],
    /// Contacts that open, and that are touched, right before the start.
    pub(super) opened: &'e [usize],
    pub(super) touched: &'e [usize],
    pub(super) turns: &'e Turns,
}

impl Element<'_> {
    fn label(&self) -> String {
        format!("interval {}, phase {}", self.interval, self.index.0)
    }

    /// Time of a node in the guess \[s\].
    fn time(&self, node: f64) -> f64 {
        self.from + node * (self.to - self.from)
    }

    /// Whether the gap of an open contact vanishes at the end because another one does: of one that takes over, or that acts
    /// until then in its place. The passage of the edge says where that is.
    fn implies(&self, pieces: &Pieces, contact: usize) -> bool {
        let mut taking = self.taking.iter();
        taking.any(|&taken| pieces.acting(taken) == contact)
    }

    fn is_first_of_motion(&self) -> bool {
        (self.interval, self.index.0) == (0, 0)
    }
}

/// Adds an element.
pub(super) fn add(builder: &mut Builder, element: &Element) {
    let stages = builder.setting.tableau.stages();
    let drives = drives(builder, element);
    let (mut phase, corrections) = unknowns(builder, element, drives);
    let middle = builder.guess.at(element.time(0.5), true);
    let Setting { model, units, .. } = builder.setting;
    let decided = Decided::at(model, &units.states, &middle, element.time(0.5));
    phase.decided = decided.velocities();
    for (stage, corrections) in corrections.iter().enumerate() {
        stage_rows(builder, element, &mut phase, (stage, corrections), &decided);
    }
    provided::at_stages(builder, &mut phase, [element.from, element.to]);
    costs_and_path_rows(builder, element, &phase);
    force_rows_at_start(builder, element, &mut phase);
    opening_rows(builder, element, &mut phase);
    let (program, label) = (&mut builder.program, element.label());
    friction_rows::at_start(program, builder.setting, &mut phase, element.turns, &label);
    cut_rows::add(builder, &mut phase);
    phase.rows.end = builder.program.extent().1;
    let last = &phase.stages[stages - 1];
    builder.state.clone_from(&last.state);
    builder.before.clone_from(&last.drive);
    builder.phases.push(phase);
}

/// What drives the motion at each stage.
fn drives(builder: &mut Builder, element: &Element) -> Vec<Vec<usize>> {
    let tableau = builder.setting.tableau;
    let (stages, length) = (tableau.stages(), builder.interval_length());
    let mut drives = Vec::with_capacity(stages);
    for (m, c) in tableau.c().iter().enumerate() {
        let mut moment = element.elapsed.later(element.scale, c * element.factor);
        if element.index.0 + 1 == element.index.1 && m + 1 == stages {
            moment = moment.all();
        }
        // Of phases at any time the share matters to linear controls only, which they do not have.
        let guess = match builder.setting.lengths.span(element.interval) {
            Some(_) => (element.index.0 as f64 + c) / element.index.1 as f64,
            None => element.time(*c) / length - element.interval as f64,
        };
        let place = format!("at stage {m} of {}", element.label());
        drives.push(drive_at(builder, element.interval, &moment, guess, &place));
    }
    drives
}

/// The phase of an element with these contacts closed, without unknowns and rows.
fn without_stages(builder: &Builder, element: &Element, closed: &[usize]) -> Phase {
    Phase {
        interval: element.interval,
        index: element.index,
        closed: closed.to_vec(),
        modes: builder.modes.clone(),
        pieces: builder.pieces.clone(),
        start: builder.state.clone(),
        stages: Vec::with_capacity(builder.setting.tableau.stages()),
        rows: builder.program.extent().1..0,
        scale: element.scale,
        factor: element.factor,
        openings: Vec::new(),
        pulled: Vec::new(),
        cones: Vec::new(),
        settling: Vec::new(),
        between: Vec::new(),
        yielded: element.turns.yielded.clone(),
        decided: Vec::new(),
        ends_with: element.ends_with,
        closing: [element.closing, element.taking].concat(),
    }
}

/// Adds the unknowns of the stages; the phase, without rows, and the position corrections of each stage.
fn unknowns(
    builder: &mut Builder,
    element: &Element,
    drives: Vec<Vec<usize>>,
) -> (Phase, Vec<Vec<usize>>) {
    let closed = builder.closed();
    let Setting {
        model,
        tableau,
        units,
        ..
    } = builder.setting;
    let turns = element.turns;
    let mut phase = without_stages(builder, element, &closed);
    let mut corrections = Vec::with_capacity(drives.len());
    for ((m, c), drive) in tableau.c().iter().enumerate().zip(drives) {
        let last = m + 1 == tableau.stages();
        let sample = builder.guess.at(element.time(*c), !last);
        let at = format!("at stage {m} of {}", element.label());
        let state = stage_state(builder, &sample, &at);
        let mut stage = Stage {
            state,
            drive,
            forces: Vec::new(),
            gap_rows: Vec::new(),
            tangential: Vec::new(),
            provided: Vec::new(),
        };
        let mut shifts = Vec::new();
        let length = element.to - element.from;
        for &i in &closed {
            let declared = &model.declaration().contacts[i];
            let lowest = if turns.settles(model, i) {
                f64::NEG_INFINITY
            } else {
                0.0
            };
            let program = &mut builder.program;
            let unit = units.force[i] * length;
            let force = program.variable(
                format!("{} {at}", force_name(declared)),
                (lowest, f64::INFINITY),
                sample[2 * builder.n + i] * length,
                unit,
            );
            stage.forces.push(force);
            let normal = Normal {
                contact: i,
                mode: builder.modes[i],
                force,
                force_unit: unit,
                row_unit: units.gap_rows[i],
            };
            let tangential = friction_rows::tangential(program, model, &normal, &at);
            stage.tangential.extend(tangential);
            if !declared.dry {
                let name = format!("correction of `{}` {at}", declared.name);
                shifts.push(program.variable(name, FREE, 0.0, units.gap[i]));
            }
        }
        corrections.push(shifts);
        phase.stages.push(stage);
    }
    (phase, corrections)
}

/// Adds the variables of the state at a stage; the bounds of those coordinates hold there for which nothing better is
/// known.
fn stage_state(builder: &mut Builder, sample: &[f64], at: &str) -> Vec<usize> {
    let Setting {
        model,
        units,
        bounds,
        parabolas,
        ..
    } = builder.setting;
    let n = builder.n;
    (0..2 * n)
        .map(|k| {
            let range = if k < n && !parabolas[k] {
                (bounds.0[k], bounds.1[k])
            } else {
                FREE
            };
            if is_held(model, k) {
                return builder.frame.start[k];
            }
            let name = format!("{} {at}", state_name(model, k));
            builder
                .program
                .variable(name, range, sample[k], units.states[k])
        })
        .collect()
}

/// Adds the rows of a stage: collocation, friction, gaps.
fn stage_rows(
    builder: &mut Builder,
    element: &Element,
    phase: &mut Phase,
    (stage, corrections): (usize, &[usize]),
    decided: &Decided,
) {
    let model = builder.setting.model;
    let (n, last) = (builder.n, stage + 1 == builder.setting.tableau.stages());
    let mut tangentials = std::mem::take(&mut phase.stages[stage].tangential);
    let state = phase.stages[stage].state.clone();
    let u = phase.stages[stage].drive.clone();
    let (q, v) = state.split_at(n);
    let [moved, pushed] = collocation_rows(builder, element, phase, stage, decided);
    let each = |coefficient: f64, rows: &[(usize, usize)]| -> Vec<(usize, usize, f64)> {
        let rows = rows.iter();
        rows.map(|&(row, k)| (row, k, coefficient)).collect()
    };
    let (moves, pushes) = (each(-1.0, &moved), each(-1.0, &pushed));
    let program = &mut builder.program;
    let place = format!("stage {stage}, {}", element.label());
    decided.add_rows(program, [q, v, &u], &place);
    let kernel = Kernel::Acceleration(Vec::new());
    let free = each(-element.factor, &pushed);
    program.block(&kernel, [q, v, &u, &[]], Some(element.scale), free);
    if !phase.closed.is_empty() {
        let at = format!("at stage {stage} of {}", element.label());
        for tangential in &mut tangentials {
            friction_rows::push(tangential, program, model, [q, v, &u], &pushes);
            let turns = element.turns;
            friction_rows::constrain(tangential, program, model, [q, v, &u], turns, last, &at);
        }
        // Each surface has a correction; dry friction, which stands behind them, has no normal.
        let surfaces = phase.closed[..corrections.len()].to_vec();
        let forces = &phase.stages[stage].forces[..corrections.len()];
        if !surfaces.is_empty() {
            let kernel = Kernel::Push(surfaces);
            program.block(&kernel, [q, &[], &u, forces], None, pushes);
            program.block(&kernel, [q, &[], &u, corrections], None, moves);
        }
        given_forces(builder, element, phase, stage, corrections.len());
    }
    phase.stages[stage].tangential = tangentials;
    phase.stages[stage].gap_rows = gap_rows(builder, element, phase, stage);
}

/// Adds the rows of the given forces of dry friction, the closed contacts from `first` on.
fn given_forces(
    builder: &mut Builder,
    element: &Element,
    phase: &Phase,
    stage: usize,
    first: usize,
) {
    let Setting { model, units, .. } = builder.setting;
    let place = format!("stage {stage}, {}", element.label());
    let Stage {
        state,
        drive,
        forces,
        ..
    } = &phase.stages[stage];
    let (q, v) = state.split_at(builder.n);
    let program = &mut builder.program;
    for (&contact, &force) in phase.closed.iter().zip(forces).skip(first) {
        let declared = &model.declaration().contacts[contact];
        let name = format!("{}, {place}", force_name(declared));
        let row = program.row_in(units.gap_rows[contact], name, 0.0, 0.0);
        program.linear(row, force, 1.0);
        let uses = vec![(row, 1, -element.factor)];
        let kernel = Kernel::Contact(contact);
        program.block(&kernel, [q, v, drive, &[]], Some(element.scale), uses);
    }
}

/// Adds the collocation rows of a stage with all that is linear in the unknowns, and the velocities: those of the coordinates that move
/// and that no joint decides. Rows of coordinates and of their velocities, each with the coordinate.
fn collocation_rows(
    builder: &mut Builder,
    element: &Element,
    phase: &Phase,
    stage: usize,
    decided: &Decided,
) -> [Vec<(usize, usize)>; 2] {
    let Setting {
        model,
        units,
        tableau,
        ..
    } = builder.setting;
    let (n, program) = (builder.n, &mut builder.program);
    let slopes = tableau.slopes_with_start(tableau.c()[stage]);
    let place = format!("stage {stage}, {}", element.label());
    let mut rows = [const { Vec::new() }; 2];
    for (k, &before) in phase.start.iter().enumerate() {
        if is_held(model, k) || decided.contains(k) {
            continue;
        }
        let name = format!("collocation of {}, {place}", state_name(model, k));
        let row = program.row_in(units.states[k], name, 0.0, 0.0);
        program.linear(row, before, slopes[0]);
        for (stage, slope) in phase.stages.iter().zip(&slopes[1..]) {
            program.linear(row, stage.state[k], *slope);
        }
        if k < n {
            let velocity = phase.stages[stage].state[n + k];
            program.bilinear(row, element.scale, velocity, -element.factor);
        }
        rows[k / n].push((row, k % n));
    }
    rows
}

/// Adds the rows of the gaps at a stage, and of the normal velocities of closed contacts.
fn gap_rows(
    builder: &mut Builder,
    element: &Element,
    phase: &Phase,
    stage: usize,
) -> Vec<Option<usize>> {
    let Setting {
        model,
        units,
        tableau,
        ..
    } = builder.setting;
    let last = stage + 1 == tableau.stages();
    let place = format!("stage {stage}, {}", element.label());
    let Stage { state, drive, .. } = &phase.stages[stage];
    let (q, v) = state.split_at(builder.n);
    let mut rows = Vec::with_capacity(builder.modes.len());
    let surfaces = model.declaration().contacts.iter().filter(|c| !c.dry);
    for (i, contact) in surfaces.enumerate() {
        if phase.pieces.is_idle(i) {
            rows.push(idle_row(builder, element, phase, stage, i));
            continue;
        }
        let program = &mut builder.program;
        let closed = phase.closed.contains(&i);
        let takes = element.passed.is_empty() && element.taking.contains(&i);
        let closes = last && (element.closing.contains(&i) || takes);
        let upper = if closed || closes { 0.0 } else { f64::INFINITY };
        let name = format!("gap `{}`, {place}", contact.name);
        // Right after an opening the gap is of third order in time, so that its rows would have no
        // interior: its sign follows from the force before, and is checked afterwards.
        let implied = last && !closed && element.implies(&phase.pieces, i);
        let lower = if (element.opened.contains(&i) || implied) && upper > 0.0 {
            f64::NEG_INFINITY
        } else {
            0.0
        };
        let row = program.row_in(units.gap_rows[i], name, lower, upper);
        rows.push(Some(row));
        let mut uses = vec![(row, 0, 1.0)];
        if closed {
            let name = format!("normal velocity of `{}`, {place}", contact.name);
            let row = program.row_in(units.gap_rows[i], name, 0.0, 0.0);
            uses.push((row, 1, 1.0));
        }
        program.block(&Kernel::Contact(i), [q, v, drive, &[]], None, uses);
    }
    rows
}

/// Adds the row of a piece of an edge that does not act at a stage, if it has one: it lies under a piece that touches,
/// and comes to be as large as the one that acts where the motion passes the edge. A passage at a jump of the controls
/// is none of the motion: both pieces are kept there.
fn idle_row(
    builder: &mut Builder,
    element: &Element,
    phase: &Phase,
    stage: usize,
    contact: usize,
) -> Option<usize> {
    let Setting { model, units, .. } = builder.setting;
    let acting = phase.pieces.acting(contact);
    let last = stage + 1 == phase.stages.len();
    let touches = phase.closed.contains(&acting) || last && element.closing.contains(&acting);
    let passes = last && element.passed.contains(&contact);
    let takes = element.taking.contains(&contact);
    let closed = |other: &usize| phase.closed.contains(&phase.pieces.acting(*other));
    if passes && takes && element.passed.iter().any(closed) && !touches {
        // The edge at which the other contact ends is the same place.
        return None;
    }
    let moves = passes && !touches && (takes || element.ends_with.is_some());
    let (lower, upper) = match (touches, passes) {
        (true, false) => (f64::NEG_INFINITY, 0.0),
        (false, true) if !moves => (0.0, f64::INFINITY),
        (_, true) => (0.0, 0.0),
        (false, false) => return None,
    };
    let Stage { state, drive, .. } = &phase.stages[stage];
    let q = &state[..builder.n];
    let name = model.declaration().contacts[contact].name;
    let name = format!("gap `{name}`, stage {stage}, {}", element.label());
    let program = &mut builder.program;
    let row = program.row_in(units.gap_rows[contact], name, lower, upper);
    let mut block = |contact: usize, sign: f64| {
        let uses = vec![(row, 0, sign)];
        program.block(&Kernel::Contact(contact), [q, &[], drive, &[]], None, uses);
    };
    block(contact, 1.0);
    if moves {
        block(acting, -1.0);
    }
    Some(row)
}

/// Adds the running cost of an element and the path constraints at its stages and its start.
fn costs_and_path_rows(builder: &mut Builder, element: &Element, phase: &Phase) {
    let tableau = builder.setting.tableau;
    let n = builder.n;
    let label = element.label();
    for (m, stage) in phase.stages.iter().enumerate() {
        let (q, v) = stage.state.split_at(n);
        let (frame, program) = (&builder.frame, &mut builder.program);
        let (inputs, factor) = ([q, v, &stage.drive[..]], element.factor * tableau.b()[m]);
        let known = Provided::Known(&stage.provided);
        frame.running_cost(program, inputs, known, [element.scale], factor);
        let place = format!("at stage {m} of {label}");
        frame.path_rows(program, inputs, known, &place);
    }
    if element.is_first_of_motion() {
        start_conditions::path_rows(builder, phase);
        return;
    }
    let at_start = provided::at_start(builder.setting.model.declaration());
    let first = first_at_stages(builder.setting.model);
    let chosen: Vec<usize> = (0..first).filter(|&i| at_start(i)).collect();
    if !chosen.is_empty() {
        let (q, v) = phase.start.split_at(n);
        let place = format!("at the start of {label}");
        let u = drive_within(builder, phase, 0.0, &place);
        let provided = provided::within(builder, phase, 0.0, &place);
        let (program, known) = (&mut builder.program, Provided::Known(&provided));
        builder
            .frame
            .path_rows_of(program, &chosen, [q, v, &u], known, &place);
    }
}

/// Whether nothing but controls gives a contact a force at the start of the motion.
fn starts_without_force(builder: &Builder, contact: usize) -> bool {
    let model = builder.setting.model;
    let controls = vec![0.0; model.declaration().controls.len()];
    let mut x = builder.guess.at(0.0, true);
    x.truncate(2 * builder.n);
    x.extend(drive(model, &controls, 0.0));
    free_normal_acceleration(model, contact, &x) == 0.0
}

/// Adds the sign of the force right at the start of a contact phase, extrapolated from the stages.
fn force_rows_at_start(builder: &mut Builder, element: &Element, phase: &mut Phase) {
    let Setting {
        model,
        units,
        tableau,
        ..
    } = builder.setting;
    let mut values = vec![0.0; tableau.stages()];
    tableau.lagrange_values(0.0, &mut values);
    for (slot, &i) in phase.closed.iter().enumerate() {
        let declared = &model.declaration().contacts[i];
        if declared.dry {
            continue;
        }
        if element.turns.settles(model, i) {
            let row = settling_row(builder, element, phase, slot);
            phase.settling.push((i, row));
            continue;
        }
        let name = declared.name;
        let name = format!("force of `{name}` at the start of {}", element.label());
        let unit = units.gap_rows[i];
        let least = if element.is_first_of_motion() && starts_without_force(builder, i) {
            -AT_THE_START * unit
        } else {
            0.0
        };
        let program = &mut builder.program;
        let row = program.row_in(unit, name, least, f64::INFINITY);
        for (stage, weight) in phase.stages.iter().zip(&values) {
            program.linear(row, stage.forces[slot], *weight);
        }
    }
}

/// Adds the time that a contact needs to come to rest. A plan spreads the bounces after a landing over the element, by a force that may
/// pull for a while; its impulse is theirs. With the normal velocity `v` after the impact and the normal acceleration `a` they take
/// `2 v / (a (1 - e))`, so that an element that holds all of them gives the impulse `(1 + e) / (1 - e) v` at least.
fn settling_row(builder: &mut Builder, element: &Element, phase: &Phase, slot: usize) -> usize {
    let Setting {
        model,
        units,
        tableau,
        ..
    } = builder.setting;
    let contact = phase.closed[slot];
    let found = builder.program.laws().restitution(contact);
    let e = found.map_or_else(
        || model.restitution(contact),
        |e| builder.program.guessed(e),
    );
    let declared = &model.declaration().contacts[contact];
    let name = declared.name;
    let name = format!(
        "time in which `{name}` comes to rest in {}",
        element.label()
    );
    let drive = drive_within(builder, phase, 0.0, &name);
    let program = &mut builder.program;
    let unit = units.gap_rows[contact];
    let row = program.row_in(unit, name.clone(), 0.0, f64::INFINITY);
    let weights = phase.stages.iter().zip(tableau.b());
    let impulse: Vec<(usize, f64)> = weights
        .map(|(stage, weight)| (stage.forces[slot], (1.0 - e) * weight))
        .collect();
    let (q, v) = phase.start.split_at(builder.n);
    let kernel = Kernel::Contact(contact);
    let inputs = [q, v, &drive[..], &[]];
    if let Some(e) = found {
        for (stage, weight) in phase.stages.iter().zip(tableau.b()) {
            program.linear(row, stage.forces[slot], *weight);
            program.bilinear(row, e, stage.forces[slot], -weight);
        }
        program.block(&kernel, inputs, Some(e), vec![(row, 1, -1.0)]);
        program.block(&kernel, inputs, None, vec![(row, 1, -1.0)]);
    } else {
        for &(force, weight) in &impulse {
            program.linear(row, force, weight);
        }
        program.block(&kernel, inputs, None, vec![(row, 1, -(1.0 + e))]);
    }
    builder.distances.push(Distance {
        name,
        kept: Kept::Settling {
            row,
            contact,
            impulse,
        },
        amount: unit,
        unit: per_second(declared.unit),
        chosen: false,
    });
    row
}

/// Adds the sign of the normal acceleration after an opening at a jump of the controls, and after a touch without a
/// bounce, unless that is at an edge beyond which another piece acts: the slope of the normal velocity, which starts from 0.
fn opening_rows(builder: &mut Builder, element: &Element, phase: &mut Phase) {
    let Setting {
        model,
        units,
        tableau,
        shape,
        ..
    } = builder.setting;
    let (n, program) = (builder.n, &mut builder.program);
    let jumps = element.index.0 == 0 && shape == ControlShape::Constant;
    let jump = element.opened.iter().filter(|_| jumps);
    let plastic = element.touched.iter();
    let plastic = plastic.filter(|&&i| model.restitution(i) == 0.0 && !phase.pieces.is_idle(i));
    for &i in jump.chain(plastic) {
        let name = model.declaration().contacts[i].name;
        let name = format!("opening of `{name}` at the start of {}", element.label());
        let row = program.row_in(units.gap_rows[i], name, 0.0, f64::INFINITY);
        let slopes = tableau.slopes_with_start(0.0);
        for (stage, slope) in phase.stages.iter().zip(&slopes[1..]) {
            let (q, v) = stage.state.split_at(n);
            let uses = vec![(row, 1, *slope)];
            let kernel = Kernel::Contact(i);
            program.block(&kernel, [q, v, &stage.drive, &[]], None, uses);
        }
        phase.openings.push((i, row));
    }
}
