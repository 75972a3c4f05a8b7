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
use crate::model::{ContactTerms, OptimalControlDeclaration};
use crate::ocp::collocation::provided::read;
use crate::ocp::program::frame::{Frame, Provided, Sum, condition};
use crate::program::kernel::Kernel;
use crate::size::Purpose;
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
    let normal = (0..layout.contacts()).filter(presses);
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
        let force = transcription.take_in(unit, name.clone(), Purpose::ForceTerm, FREE);
        let row = transcription.row_in(unit, name, Purpose::ForceTerm, 0.0);
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
        let variable = transcription.take(name.clone(), Purpose::ForceTerm, FREE);
        let row = transcription.row(name, Purpose::ForceTerm, 0.0);
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
        program.block_behind(&Kernel::Impact, [&q, &v, &u], &provided, None, uses);
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
    let impulse = transcription.take(name.clone(), Purpose::ForceTerm, FREE);
    let row = transcription.row(name, Purpose::ForceTerm, 0.0);
    let guess = value(transcription, &terms);
    let program = &mut transcription.program;
    program.set_guess(impulse, guess);
    program.linear(row, impulse, 1.0);
    for (factor, variables) in terms {
        program.product(row, &variables, -factor);
    }
    impulse
}
