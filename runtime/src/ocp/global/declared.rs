//! What a scene declares for optimal control in a program of the time-freezing system:
//!
//! ```text
//! int L dt = sum_e h_e s_k sum_j b_j theta_j L(X_j)     at the stages j of the elements e
//! int L dt = T / N sum_k L(u_k)                         where L reads nothing but constant controls
//! c(X_j) = 0, or >= 0                                   at the stages
//! c(u_k) = 0, or >= 0                                   once an interval, where c reads nothing but constant controls
//! phi(q, v, T), goals                                   at the end
//! c(q, u, P) >= 0                                       in each impact
//! theta_m r_m = a_bar w_m                               forces at stage m of a phase
//! P = a_bar s_k sum_e h_e sum_j b_j w_j                 impulses over the elements e of an impact, in which theta = 0
//! ```
//!
//! The clock runs at the speed `theta`. It stands during a jump, which therefore costs nothing. Path constraints hold at the
//! stages of jumps, too: coordinates rest there, and velocities lie between those before and after the jump, so that
//! nothing is lost where the condition is convex in them.
//!
//! Forces `r` and impulses `P` are the weight `w` at which a contact presses, and `mu` times the difference of the two parts of it
//! along the sliding velocity. They are there where it is known which elements are phases and which are jumps: in a relaxed program
//! the force of a jump, which lasts no time, has no bound. Otherwise they are 0 for all functions, and conditions on them are left out.
//! An open contact provides nothing, and has no variable for it.

use std::ops::Range;

use hangtime_solver::nlp::NlpProblem as _;

use crate::model::held::first_of_stages;
use crate::model::{ContactTerms, Function, OptimalControlDeclaration};
use crate::ocp::collocation::provided::read;
use crate::ocp::program::frame::{Frame, Provided, Sum, condition};
use crate::program::kernel::Kernel;
use crate::time_freezing::laid_out::spans_of_elements;
use crate::time_freezing::task::{Guess, Span};
use crate::time_freezing::transcription::Transcription;

/// Bounds of what rows decide.
const FREE: (f64, f64) = (f64::NEG_INFINITY, f64::INFINITY);

/// Whether functions read forces and impulses of which the program knows nothing.
pub(super) fn leaves_out_forces(transcription: &Transcription<'_>) -> bool {
    let declared = transcription.field.model.declaration().optimal_control;
    let terms = declared.map_or(ContactTerms::NONE, |declared| declared.contacts);
    let known = matches!(transcription.task.guess, Guess::Known(_));
    terms.any() && (!known || terms.terminal && !transcription.tableau.stiffly_accurate())
}

/// Adds objective, path constraints and goals to a program that has all else.
pub(super) fn add(transcription: &mut Transcription<'_>, frame: &mut Frame<'_>) {
    let Some(declared) = transcription.field.model.declaration().optimal_control else {
        return;
    };
    let intervals = match &transcription.task.guess {
        Guess::Known(intervals) => intervals.clone(),
        _ => Vec::new(),
    };
    let spans = spans_of_elements(&intervals, transcription.task.elements);
    let constraints = 0..declared.constraints.len();
    let first = usize::from(declared.running_cost);
    let once = |function: usize| has_one_value(transcription, &declared, function);
    let cost_once = declared.running_cost && once(0);
    let (once, staged): (Vec<usize>, Vec<usize>) = constraints.partition(|i| once(first + i));
    for k in 0..transcription.intervals.len() {
        let block = &transcription.elements[k * transcription.task.elements].blocks[0];
        let inputs = transcription.inputs(block);
        let inputs = inputs.each_ref().map(Vec::as_slice);
        let place = format!("in {}", transcription.interval_name(k));
        let program = &mut transcription.program;
        if cost_once {
            let share = 1.0 / transcription.intervals.len() as f64;
            let unknown = Provided::Unknown;
            frame.running_cost(program, inputs, unknown, [frame.horizon], share);
        }
        frame.path_rows_of(program, &once, inputs, Provided::Unknown, &place);
    }
    let mut at_end = Vec::new();
    for e in 0..transcription.elements() {
        let place = format!(
            "in {}",
            transcription.interval_name(transcription.elements[e].interval)
        );
        for stage in 0..transcription.tableau.stages() {
            let runs = spans.get(e).filter(|span| !span.jumps);
            at_end = runs.map_or(Vec::new(), |span| forces(transcription, span, e, stage));
            let known = Provided::Known(&at_end);
            let provided = runs.map_or(Provided::Unknown, |_| known);
            let block = &transcription.elements[e].blocks[stage];
            let inputs = transcription.inputs(block);
            let inputs = inputs.each_ref().map(Vec::as_slice);
            let passing = transcription.passing(e, block);
            let b = transcription.tableau.b()[stage];
            let program = &mut transcription.program;
            if !cost_once {
                frame.running_cost(program, inputs, provided, passing, b);
            }
            frame.path_rows_of(program, &staged, inputs, provided, &place);
        }
    }
    if !spans.is_empty() {
        add_impacts(transcription, frame, (&declared, &spans));
    }
    let reads = declared.contacts.terminal && !transcription.tableau.stiffly_accurate();
    let provided = match spans.is_empty() || reads {
        true => Provided::Unknown,
        false => Provided::Known(&at_end),
    };
    let last = transcription.block_before(transcription.elements());
    let last = last.at(0..2 * transcription.field.coordinates());
    frame.finish(&mut transcription.program, &last, provided, None);
}

/// Whether a path function has one value an interval, as it reads nothing but controls that are constant there.
fn has_one_value(
    transcription: &Transcription<'_>,
    declared: &OptimalControlDeclaration,
    function: usize,
) -> bool {
    let first = 2 * transcription.field.coordinates();
    let controls = first..first + first_of_stages(transcription.field.model);
    let entries = declared.path_jacobian.entries.iter();
    let mut own = entries.filter(|entry| entry.0 as usize == function);
    !transcription.task.linear && own.all(|entry| controls.contains(&(entry.1 as usize)))
}

/// What contacts provide in a span, by number: the normal forces, then those along the sliding velocities.
fn acting(transcription: &Transcription<'_>, span: &Span) -> Vec<usize> {
    let contacts = transcription.contacts();
    let layout = &transcription.field.layout;
    let presses = |i: &usize| span.weights[*i][1];
    let rubs = |i: &usize| {
        let group = layout.slip_group(*i);
        group.is_some_and(|group| span.weights[group].contains(&true))
    };
    let normal = (0..layout.contacts).filter(presses);
    let tangential = (0..contacts).filter(rubs).map(|i| contacts + i);
    normal.chain(tangential).collect()
}

/// What something provided is made of: the weights at a block, with their factors and further variables, in units of `a_bar`.
fn weights(
    transcription: &Transcription<'_>,
    number: usize,
    (e, stage): (usize, usize),
) -> Vec<(f64, Vec<usize>)> {
    let block = &transcription.elements[e].blocks[stage];
    let terms = transcription.provision(number).into_iter();
    let terms = terms.filter_map(|(place, factor, mut others)| {
        others.push(block.variables[place]?);
        Some((factor, others))
    });
    terms.collect()
}

/// Forces at a stage of a phase, for those that functions read.
fn forces(
    transcription: &mut Transcription<'_>,
    span: &Span,
    e: usize,
    stage: usize,
) -> Vec<Option<usize>> {
    let ends = (e + 1, stage + 1) == (transcription.elements(), transcription.tableau.stages());
    let ends = ends && transcription.tableau.stiffly_accurate();
    let read = read(transcription.field.model.declaration(), ends);
    let mut forces = vec![None; read.len()];
    for number in acting(transcription, span) {
        if read.get(number) != Some(&true) {
            continue;
        }
        let place = transcription.block_name(e, stage);
        let name = format!("force {} at {place}", name_of(transcription, number));
        let a_bar = transcription.field.auxiliary_acceleration;
        let unit = a_bar * transcription.size_of_provision(number);
        let program = &mut transcription.program;
        let force = program.variable(name.clone(), FREE, 0.0, unit);
        let row = program.row_in(unit, name, 0.0, 0.0);
        let block = &transcription.elements[e].blocks[stage];
        let speed = transcription.passing(e, block)[2..].to_vec();
        let weights = weights(transcription, number, (e, stage));
        let guess = value(transcription, &weights) / value(transcription, &[(1.0, speed.clone())]);
        let program = &mut transcription.program;
        program.set_guess(force, a_bar * guess);
        program.product(row, &[&speed[..], &[force]].concat(), 1.0);
        for (factor, variables) in weights {
            program.product(row, &variables, -a_bar * factor);
        }
        forces[number] = Some(force);
    }
    forces
}

/// A sum of products at the guess.
fn value(transcription: &Transcription<'_>, terms: &[(f64, Vec<usize>)]) -> f64 {
    let guessed = |&i: &usize| transcription.program.guessed(i);
    let term = |(factor, variables): &(f64, Vec<usize>)| {
        factor * variables.iter().map(guessed).product::<f64>()
    };
    terms.iter().map(term).sum()
}

/// The words for a contact that provides something.
fn name_of(transcription: &Transcription<'_>, number: usize) -> String {
    let contacts = transcription.field.model.declaration().contacts;
    let name = contacts[number % contacts.len()].name;
    if number < contacts.len() {
        format!("of {name}")
    } else {
        format!("along the sliding velocity of {name}")
    }
}

/// The impacts of a known motion: the jumps that follow one another in an interval.
fn impacts(transcription: &Transcription<'_>, spans: &[&Span]) -> Vec<Range<usize>> {
    let interval = |e: usize| transcription.elements[e].interval;
    let follows =
        |e: usize| spans[e].jumps && e > 0 && spans[e - 1].jumps && interval(e) == interval(e - 1);
    let starts = (0..spans.len()).filter(|&e| spans[e].jumps && !follows(e));
    let end = |first: usize| (first + 1..spans.len()).find(|&e| !follows(e));
    let range = |first: usize| first..end(first).unwrap_or(spans.len());
    starts.map(range).collect()
}

/// Adds sums over impacts, impulses, and conditions on them.
fn add_impacts(
    transcription: &mut Transcription<'_>,
    frame: &mut Frame<'_>,
    (declared, spans): (&OptimalControlDeclaration, &[&Span]),
) {
    let terms = declared.contacts;
    if terms.impact_functions() == 0 {
        return;
    }
    for k in 0..terms.sums {
        let name = format!("sum {k} over impacts");
        let variable = transcription.take(name.clone(), FREE);
        let row = transcription.row(name, 0.0);
        transcription.program.linear(row, variable, 1.0);
        frame.sums.push(Sum { variable, row });
    }
    for elements in impacts(transcription, spans) {
        add_impact(transcription, frame, (terms, spans), elements);
    }
    let program = &mut transcription.program;
    let (variables, rows) = program.extent();
    let (mut x, mut c) = (vec![0.0; variables], vec![0.0; rows]);
    program.initial_point(&mut x);
    program.constraint_values(&x, &mut c);
    for sum in &frame.sums {
        program.set_guess(sum.variable, -c[sum.row]);
    }
}

/// Adds what an impact over these elements adds to the sums, and the conditions on it.
fn add_impact(
    transcription: &mut Transcription<'_>,
    frame: &Frame<'_>,
    (terms, spans): (ContactTerms, &[&Span]),
    elements: Range<usize>,
) {
    let inputs = transcription.field.model.declaration().inputs();
    let reads = |function: usize, number: usize| {
        let mut entries = terms.impact_jacobian.entries.iter();
        let own = (function, inputs + number);
        entries.any(|&(row, column)| (row as usize, column as usize) == own)
    };
    let own = elements.clone();
    let mut acts: Vec<usize> = own.flat_map(|e| acting(transcription, spans[e])).collect();
    acts.sort_unstable();
    acts.dedup();
    let functions = 0..terms.impact_functions();
    let uses = functions.filter(|&f| acts.iter().any(|&k| reads(f, k)));
    let uses: Vec<usize> = uses.collect();
    acts.retain(|&number| uses.iter().any(|&f| reads(f, number)));
    let mut provided = vec![None; 2 * transcription.contacts()];
    for number in acts {
        provided[number] = Some(impulse(transcription, number, elements.clone()));
    }
    let program = &mut transcription.program;
    let uses = uses.into_iter().map(|function| {
        let constraint = function.checked_sub(frame.sums.len());
        match constraint.map(|i| &terms.constraints[i]) {
            None => (frame.sums[function].row, function, -1.0),
            Some(declared) => {
                let row = condition(program, declared, 1.0, "in an impact");
                (row, function, 1.0)
            }
        }
    });
    let uses: Vec<(usize, usize, f64)> = uses.collect();
    if !uses.is_empty() {
        let last = transcription.block_before(elements.end);
        let [q, v, u] = transcription.inputs(last);
        let program = &mut transcription.program;
        program.block_behind(
            &Kernel::Whole(Function::Impact),
            [&q, &v, &u],
            &provided,
            None,
            uses,
        );
    }
}

/// Adds the impulse of a contact in an impact over these elements.
fn impulse(transcription: &mut Transcription<'_>, number: usize, elements: Range<usize>) -> usize {
    let a_bar = transcription.field.auxiliary_acceleration;
    let mut terms = Vec::new();
    let first = transcription.element_name(elements.start);
    for e in elements {
        let element = &transcription.elements[e];
        let lengths = [
            element.length,
            transcription.intervals[element.interval].length,
        ];
        for (stage, b) in transcription.tableau.b().iter().enumerate() {
            for (factor, mut variables) in weights(transcription, number, (e, stage)) {
                variables.extend(lengths);
                terms.push((a_bar * b * factor, variables));
            }
        }
    }
    let name = format!("impulse {} from {first} on", name_of(transcription, number));
    let impulse = transcription.take(name.clone(), FREE);
    let row = transcription.row(name, 0.0);
    let guess = value(transcription, &terms);
    let program = &mut transcription.program;
    program.set_guess(impulse, guess);
    program.linear(row, impulse, 1.0);
    for (factor, variables) in terms {
        program.product(row, &variables, -factor);
    }
    impulse
}

#[cfg(test)]
mod tests {
    use hangtime_solver::nlp::{NlpProblem, check_derivatives};

    use super::super::time_freezing::TimeFreezing;
    use crate::ocp::motion::control_grid::ControlGrid;
    use crate::ocp::motion::trajectory::Trajectory;
    use crate::ocp::problem::{Horizon, Problem};
    use crate::ocp::settings::TimeFreezingSettings;
    use crate::rk::Scheme;
    use crate::time_freezing::task::{Guess, Span, Task};

    crate::model! {
        /// A bead that strikes a floor on which it slides, and a wall that throws it back, and reads what both do to it.
        StruckBead {
            parameters { m: kg = 2, g: m/s^2 = 9.81, k: 1/m = 1.5 }
            coordinates { y: m, z: m }
            controls { u: N }
            lagrangian m/2*(dot(y)^2 + (2 + sin(k*y))*dot(z)^2) - m*g*z
            forces { y: u*cos(k*y) }
            surface floor: z - sin(k*y)/(4*k) >= 0
            surface wall: 1[m] - y - k*z^2/8 >= 0
            impact floor: inelastic, friction 0.4, sliding dot(y) + cos(k*y)/4*dot(z)
            impact wall: restitution 0.6
            minimize sum(impulse(wall)^2 + y*friction_impulse(floor)^2/1[m])/1[N^2*s^2] + force(floor)/1[N]
                + integral(force(floor)^2/1[N^2] + u*friction_force(floor)/1[N^2])/1[s]
            constraint grip: force(floor) - u^2/1[N] >= 0
            constraint pace: dot(y)^2 + z*u*1[m/(N*s^2)] >= 0
            constraint soft: impulse(floor) <= 3[N*s]
            finally { friction_force(floor)*y == 2[N*m], sum(impulse(floor))*dot(y) <= 5[J] }
        }
    }

    /// The program of a bead that flies, strikes the wall and is thrown back, flies, and lands on the floor, where it slides.
    fn struck(bead: &StruckBead, scheme: Scheme) -> TimeFreezing<'_> {
        // Weights of floor and wall, of sliding on the floor, and of fall and rise at the wall.
        let open = [[true, false], [true, false], [false, false], [false, false]];
        let fall = [[true, false], [false, true], [false, false], [true, false]];
        let rise = [[true, false], [false, true], [false, false], [false, true]];
        let land = [[false, true], [true, false], [true, false], [false, false]];
        let slide = [[true, true], [true, false], [true, false], [false, false]];
        let span = |weights: [[bool; 2]; 4], jumps: bool, [from, to]: [f64; 2], share: f64| {
            let point = |time: f64| {
                let states = [0.4, 0.3, 0.5, -0.8, time, 0.2, 0.1];
                let alpha = |contact: usize| match weights[contact] {
                    [true, true] => share,
                    [free, _] => f64::from(u8::from(free)),
                };
                [&states[..], &[alpha(0), alpha(1), 1.0, 0.6]].concat()
            };
            Span {
                length: if jumps { 0.05 } else { to - from },
                jumps,
                weights: weights.to_vec(),
                sets: Vec::new(),
                points: vec![point(from), point(to)],
            }
        };
        let first = vec![
            span(open, false, [0.0, 0.1], 1.0),
            span(fall, true, [0.1, 0.1], 1.0),
            span(rise, true, [0.1, 0.1], 1.0),
            span(open, false, [0.1, 0.2], 1.0),
        ];
        let second = vec![
            span(open, false, [0.2, 0.3], 1.0),
            span(land, true, [0.3, 0.3], 0.0),
            span(slide, false, [0.3, 0.4], 0.7),
        ];
        let mut problem = Problem::of(bead, 2);
        problem.horizon = Horizon::Fixed(0.4);
        (problem.q, problem.v) = (vec![0.4, 0.3], vec![0.5, -0.8]);
        let state = vec![0.4, 0.3, 0.5, -0.8, 0.0, 0.0];
        let guess = Trajectory {
            horizon: 0.4,
            controls: ControlGrid::constant(vec![vec![0.8]; 2]),
            time: vec![0.0, 0.4],
            states: vec![state.clone(), state],
        };
        let task = Task {
            time: 0.0,
            linear: false,
            intervals: 2,
            elements: 4,
            coordinate_bounds: (vec![f64::NEG_INFINITY; 2], vec![f64::INFINITY; 2]),
            guess: Guess::Known(vec![first, second]),
        };
        let mut settings = TimeFreezingSettings::default();
        (settings.scheme, settings.auxiliary_acceleration) = (scheme, 50.0);
        let program = TimeFreezing::transcribed((bead, &problem, &settings), &guess, task);
        program.expect("valid")
    }

    /// Names of the variables or rows that begin so.
    fn named(names: &[String], start: &str) -> usize {
        names.iter().filter(|name| name.starts_with(start)).count()
    }

    #[test]
    fn forces_and_impulses_stand_where_contacts_act_and_their_derivatives_are_right() {
        let bead = StruckBead::default();
        let mut program = struck(&bead, Scheme::RadauIia);
        assert!(!program.leaves_out_forces());
        let count = program.variables();
        let names: Vec<String> = (0..count).map(|i| program.variable_name(i)).collect();
        let rows: Vec<String> = (0..program.constraints())
            .map(|i| program.constraint_name(i))
            .collect();
        // The normal force and that of sliding at two stages of the two last elements; the impulse of the wall; both of the floor.
        assert_eq!(named(&names, "force of floor at stage"), 4);
        assert_eq!(
            named(&names, "force along the sliding velocity of floor"),
            4
        );
        assert_eq!(
            named(&names, "impulse of wall from element 1 of interval 0"),
            1
        );
        assert_eq!(
            named(&names, "impulse of floor from element 1 of interval 1"),
            1
        );
        assert_eq!(
            named(&names, "impulse along the sliding velocity of floor"),
            1
        );
        // Conditions on forces hold at the stages of phases: five elements of eight are none of the jumps. Only the floor's impulse is bounded.
        assert_eq!(named(&rows, "`grip`"), 2 * 5);
        assert_eq!(named(&rows, "`pace`"), 2 * 8);
        assert_eq!(named(&rows, "`soft` in an impact"), 1);
        let mut x = vec![0.0; count];
        program.initial_point(&mut x);
        // What is guessed satisfies its rows.
        let mut values = vec![0.0; rows.len()];
        program.constraint_values(&x, &mut values);
        for (row, name) in rows.iter().enumerate() {
            if ["force ", "impulse ", "sum 0", "sum 1"]
                .iter()
                .any(|own| name.starts_with(own))
            {
                let variable = names.iter().position(|own| own == name);
                assert!(values[row].abs() < 1e-12, "{name}: {}", values[row]);
                assert!(x[variable.expect("a variable")] != 0.0, "{name}");
            }
        }
        for (i, value) in x.iter_mut().enumerate() {
            *value += 0.1 + 0.05 * (i as f64).sin();
        }
        let compared = check_derivatives(&mut program, Some(&x)).expect("finite at the start");
        assert!(compared.iter().all(|entry| !entry.missing));
        assert!(compared[0].error < 1e-6, "{:?}", compared[0]);
    }

    #[test]
    fn scheme_without_a_stage_at_the_end_leaves_out_forces_there() {
        let bead = StruckBead::default();
        let program = struck(&bead, Scheme::GaussLegendre);
        assert!(program.leaves_out_forces());
        let rows = (0..program.constraints()).map(|row| program.constraint_name(row));
        let goals = rows.filter(|name| name.ends_with("at the end"));
        assert_eq!(goals.filter(|name| name.starts_with('`')).count(), 1);
    }
}
