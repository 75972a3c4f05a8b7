//! What contacts provide, where functions of the scene read it: forces `r` at the stages of the elements in which the clock runs, and
//! impulses `P` of impacts, whose elements are jumps.
//!
//! ```text
//! theta_m r_m = a_bar w_m                        at stage m of a phase
//! P = a_bar s_k sum_e h_e sum_j b_j w_j          over the elements e of an impact, in which theta = 0
//! S = sum over the impacts of what is summed
//! ```
//!
//! with the weight `w` at which a contact presses, and with `mu` times the difference of the two parts of it for what it provides
//! along the sliding velocity. This is possible where it is known which elements are phases and which are jumps: in a relaxed
//! program the force of a jump, which lasts no time, has no bound. An open contact provides nothing, and has no variable for it.

use super::laid_out::spans_of_elements;
use super::numbered::{Impact, Place, Provision};
use super::sites::{Functions, Input, Row, conditions_on_forces};
use super::task::Span;
use super::{Guess, Transcription};
use crate::model::OptimalControlDeclaration;

/// Adds variables and rows for what functions read of contacts, behind all others.
pub(super) fn number(transcription: &mut Transcription<'_>) {
    let Some(declared) = transcription.declared() else {
        return;
    };
    let Guess::Known(intervals) = &transcription.task.guess else {
        return;
    };
    if !declared.contacts.any() {
        return;
    }
    let intervals = intervals.clone();
    let spans = spans_of_elements(&intervals, transcription.task.elements);
    number_sums(transcription, declared.contacts.sums);
    let inputs = transcription.dcs.system.model.declaration().inputs();
    let on_forces = conditions_on_forces(&declared, inputs).len();
    for (e, span) in spans.iter().enumerate() {
        let first = (!span.jumps).then_some(transcription.constraints);
        transcription.provisions.path_rows.push(first);
        if first.is_none() {
            continue;
        }
        let stages = transcription.tableau.stages();
        transcription.constraints += on_forces * stages;
        for stage in 0..stages {
            let place = Place::Stage { element: e, stage };
            let ends = transcription.last_stage() == Some(place);
            let read = |number: usize| {
                let at_end = ends && at_end(transcription, &declared, number);
                at_end || along(&declared, inputs + number)
            };
            let read: Vec<usize> = acting(transcription, span).filter(|&k| read(k)).collect();
            read.into_iter()
                .for_each(|number| add(transcription, place, number));
        }
    }
    number_impacts(transcription, &declared, &spans);
}

/// Whether path functions read that input.
fn along(declared: &OptimalControlDeclaration, input: usize) -> bool {
    let mut functions = 0..declared.path_functions();
    declared.contacts.path && functions.any(|f| Functions::Path.reads_one(declared, f, input))
}

/// Whether terminal functions read what has that number.
fn at_end(
    transcription: &Transcription<'_>,
    declared: &OptimalControlDeclaration,
    number: usize,
) -> bool {
    let declaration = transcription.dcs.system.model.declaration();
    let first = declaration.terminal_inputs() - 2 * declaration.contacts.len();
    let mut functions = 0..declared.terminal_functions();
    declared.contacts.terminal
        && functions.any(|f| Functions::Terminal.reads_one(declared, f, first + number))
}

/// What contacts provide in a span, by number.
fn acting(transcription: &Transcription<'_>, span: &Span) -> impl Iterator<Item = usize> {
    let contacts = transcription.contacts();
    let layout = &transcription.dcs.layout;
    let presses = |i: &usize| span.weights[*i][1];
    let rubs = |i: &usize| {
        let group = layout.slip_group(*i);
        group.is_some_and(|group| span.weights[group].contains(&true))
    };
    let normal = (0..layout.contacts()).filter(presses);
    let tangential = (0..contacts).filter(rubs).map(|i| contacts + i);
    normal.chain(tangential).collect::<Vec<_>>().into_iter()
}

/// Adds a variable and a row for what a contact provides.
fn add(transcription: &mut Transcription<'_>, place: Place, number: usize) {
    let (unit, terms) = transcription.dcs.provision(number);
    if terms.is_empty() {
        return;
    }
    let variable = transcription.take(1);
    let row = transcription.constraints;
    transcription.constraints += 1;
    transcription.provisions.all.push(Provision {
        variable,
        row,
        place,
        number,
        unit,
        terms,
    });
}

/// Adds a variable and a row for each sum over impacts.
fn number_sums(transcription: &mut Transcription<'_>, count: usize) {
    for _ in 0..count {
        let sum = (transcription.take(1), transcription.constraints);
        transcription.provisions.sums.push(sum);
        transcription.constraints += 1;
    }
}

/// Adds impulses and conditions of each impact. An impact is the jumps that follow one another in an interval.
fn number_impacts(
    transcription: &mut Transcription<'_>,
    declared: &OptimalControlDeclaration,
    spans: &[&Span],
) {
    let terms = declared.contacts;
    if terms.impact_functions() == 0 {
        return;
    }
    let inputs = transcription.dcs.system.model.declaration().inputs();
    let reads = |function: usize, number: usize| {
        Functions::Impact.reads_one(declared, function, inputs + number)
    };
    let interval = |e: usize| e / transcription.task.elements;
    let follows =
        |e: usize| spans[e].jumps && e > 0 && spans[e - 1].jumps && interval(e) == interval(e - 1);
    let starts: Vec<usize> = (0..spans.len())
        .filter(|&e| spans[e].jumps && !follows(e))
        .collect();
    let ends = |first: usize| (first + 1..spans.len()).find(|&e| !follows(e));
    let impacts: Vec<_> = starts
        .into_iter()
        .map(|first| first..ends(first).unwrap_or(spans.len()))
        .collect();
    for elements in impacts {
        let place = Place::Impact {
            first: elements.start,
        };
        let mut acts: Vec<usize> = elements
            .clone()
            .flat_map(|e| acting(transcription, spans[e]))
            .collect();
        acts.sort_unstable();
        acts.dedup();
        let functions = 0..terms.impact_functions();
        let uses = functions.filter(|&f| acts.iter().any(|&k| reads(f, k)));
        let uses: Vec<usize> = uses.collect();
        for &number in &acts {
            if uses.iter().any(|&f| reads(f, number)) {
                add(transcription, place, number);
            }
        }
        let rows = uses.into_iter().map(|function| {
            let sum = transcription.provisions.sums.get(function);
            let (row, factor) = match sum {
                Some(&(_, row)) => (row, -1.0),
                None => {
                    transcription.constraints += 1;
                    (transcription.constraints - 1, 1.0)
                }
            };
            Row {
                function,
                row,
                factor,
            }
        });
        let rows = rows.collect();
        transcription
            .provisions
            .impacts
            .push(Impact { elements, rows });
    }
}

/// What a contact provides at a place, as an argument of functions.
pub(super) fn input(
    transcription: &Transcription<'_>,
    place: Option<Place>,
    number: usize,
) -> Input {
    let mut all = transcription.provisions.all.iter();
    let own = all.find(|own| Some(own.place) == place && own.number == number);
    Input {
        variable: own.map(|own| own.variable),
        unit: own.map_or(1.0, value_of_one),
        constant: 0.0,
        read: own.is_some(),
    }
}

/// What one of the variable is worth: impulses are their own unit but for `mu`, which stands in their rows.
fn value_of_one(own: &Provision) -> f64 {
    match own.place {
        Place::Stage { .. } => own.unit,
        Place::Impact { .. } => 1.0,
    }
}

/// Whether a force, an impulse or a sum has a variable and a row of which that is true.
pub(super) fn owns(
    transcription: &Transcription<'_>,
    own: impl Fn((usize, usize)) -> bool,
) -> bool {
    let provisions = &transcription.provisions;
    let mut all = provisions.all.iter();
    all.any(|p| own((p.variable, p.row))) || provisions.sums.iter().any(|&sum| own(sum))
}

/// The variables of the weights of a provision at a stage, with their factors.
fn weights(
    transcription: &Transcription<'_>,
    own: &Provision,
    (element, stage): (usize, usize),
) -> impl Iterator<Item = (usize, f64)> {
    let block = &transcription.elements[element].blocks[stage];
    let terms = own.terms.iter();
    terms.filter_map(|&(place, factor)| Some((block.variables[place]?, factor)))
}

/// Variable of the speed of the clock by which a force is multiplied in its row; `None` where that is one.
fn speed_at(transcription: &Transcription<'_>, place: Place) -> Option<usize> {
    let Place::Stage { element, stage } = place else {
        return None;
    };
    let theta = transcription.dcs.layout.theta()?;
    transcription.elements[element].blocks[stage].variables[theta]
}

/// The weight of a provision at a stage.
fn weight(
    transcription: &Transcription<'_>,
    own: &Provision,
    at: (usize, usize),
    x: &[f64],
) -> f64 {
    let terms = weights(transcription, own, at);
    terms.map(|(variable, factor)| factor * x[variable]).sum()
}

/// The elements of the impact that begins with that one.
fn elements_of(transcription: &Transcription<'_>, first: usize) -> std::ops::Range<usize> {
    let mut impacts = transcription.provisions.impacts.iter();
    let own = impacts.find(|impact| impact.elements.start == first);
    own.map_or(0..0, |impact| impact.elements.clone())
}

/// What the row of a provision says that its variable is, over the speed of the clock in a phase.
fn provided(transcription: &Transcription<'_>, own: &Provision, x: &[f64]) -> f64 {
    match own.place {
        Place::Stage { element, stage } => weight(transcription, own, (element, stage), x),
        Place::Impact { first } => {
            let of_element = |e: usize| {
                let stages = transcription.tableau.b().iter().enumerate();
                let mean: f64 = stages
                    .map(|(j, b)| b * weight(transcription, own, (e, j), x))
                    .sum();
                transcription.numerical_length(x, e) * mean
            };
            let integral: f64 = elements_of(transcription, first).map(of_element).sum();
            own.unit * integral
        }
    }
}

/// Writes the rows of forces and impulses, and completes those of the sums.
pub(super) fn write_rows(transcription: &Transcription<'_>, x: &[f64], c: &mut [f64]) {
    for own in &transcription.provisions.all {
        let speed = speed_at(transcription, own.place).map_or(1.0, |variable| x[variable]);
        c[own.row] = speed * x[own.variable] - provided(transcription, own, x);
    }
    for &(variable, row) in &transcription.provisions.sums {
        if !adds(transcription, row) {
            c[row] = 0.0;
        }
        c[row] += x[variable];
    }
}

/// Whether an impact adds to the sum of a row.
fn adds(transcription: &Transcription<'_>, row: usize) -> bool {
    let impacts = transcription.provisions.impacts.iter();
    impacts.flat_map(|i| &i.rows).any(|own| own.row == row)
}

/// Entries of the Jacobian of the rows, always in the same order.
pub(super) fn add_jacobian(
    transcription: &Transcription<'_>,
    x: &[f64],
    add: &mut dyn FnMut(usize, usize, f64),
) {
    for own in &transcription.provisions.all {
        match own.place {
            Place::Stage { element, stage } => {
                match speed_at(transcription, own.place) {
                    Some(speed) => {
                        add(own.row, own.variable, x[speed]);
                        add(own.row, speed, x[own.variable]);
                    }
                    None => add(own.row, own.variable, 1.0),
                }
                for (variable, factor) in weights(transcription, own, (element, stage)) {
                    add(own.row, variable, -factor);
                }
            }
            Place::Impact { first } => {
                add(own.row, own.variable, 1.0);
                for_each_product(transcription, own, first, |[h, s, w], scale| {
                    add(own.row, h, -scale * x[s] * x[w]);
                    add(own.row, s, -scale * x[h] * x[w]);
                    add(own.row, w, -scale * x[h] * x[s]);
                });
            }
        }
    }
    for &(variable, row) in &transcription.provisions.sums {
        add(row, variable, 1.0);
    }
}

/// The products `h_e s_k w_j` of the impact that begins with an element, and their factors.
fn for_each_product(
    transcription: &Transcription<'_>,
    own: &Provision,
    first: usize,
    mut visit: impl FnMut([usize; 3], f64),
) {
    for e in elements_of(transcription, first) {
        let element = &transcription.elements[e];
        let length = transcription.intervals[element.interval].length;
        for (j, b) in transcription.tableau.b().iter().enumerate() {
            for (variable, factor) in weights(transcription, own, (e, j)) {
                visit([element.length, length, variable], own.unit * b * factor);
            }
        }
    }
}

/// Entries of the Hessian of the weighted rows, always in the same order.
pub(super) fn add_hessian(
    transcription: &Transcription<'_>,
    x: &[f64],
    multipliers: &[f64],
    add: &mut dyn FnMut(usize, usize, f64),
) {
    for own in &transcription.provisions.all {
        let multiplier = multipliers[own.row];
        match own.place {
            Place::Stage { .. } => {
                if let Some(speed) = speed_at(transcription, own.place) {
                    add(own.variable, speed, multiplier);
                }
            }
            Place::Impact { first } => {
                for_each_product(transcription, own, first, |[h, s, w], scale| {
                    let weight = -scale * multiplier;
                    add(h, s, weight * x[w]);
                    add(h, w, weight * x[s]);
                    add(s, w, weight * x[h]);
                });
            }
        }
    }
}

/// Gives forces and impulses the values that the rest of the guess asks for.
pub(super) fn guess_forces(transcription: &mut Transcription<'_>) {
    let mut x = std::mem::take(&mut transcription.guess);
    for own in &transcription.provisions.all {
        let speed = speed_at(transcription, own.place).map_or(1.0, |variable| x[variable]);
        x[own.variable] = provided(transcription, own, &x) / speed;
    }
    transcription.guess = x;
}

/// Gives the sums over impacts the values that the rows of the conditions ask for.
pub(super) fn guess_sums(transcription: &mut Transcription<'_>, rows: &[f64]) {
    let guess = &mut transcription.guess;
    for &(variable, row) in &transcription.provisions.sums {
        guess[variable] = -rows[row];
    }
}

#[cfg(test)]
mod tests {
    use super::super::test_scenes::StruckBead;
    use super::super::{Controls, Task, transcribe};
    use crate::dcs::HeavisideSystem;
    use crate::fesd::finite_element::State;
    use crate::fesd::transcription::Span;
    use crate::rk::{ButcherTableau, Scheme};
    use crate::time_freezing::TimeFreezingSystem;
    use hangtime_solver::nlp::{NlpProblem, check_derivatives};

    /// A bead that flies, strikes the wall and is thrown back, flies, and lands on the floor, where it slides.
    fn struck(bead: &StruckBead, tableau: &ButcherTableau) -> super::Transcription<'static> {
        let bead: &'static StruckBead = Box::leak(Box::new(bead.clone()));
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
        let start = State {
            time: 0.0,
            q: vec![0.4, 0.3],
            v: vec![0.5, -0.8],
        };
        let mut task = Task::step(&start, &[0.8], 0.4, 4);
        task.intervals = 2;
        task.declared = true;
        task.guess = super::Guess::Known(vec![first, second]);
        task.controls = Controls::Free {
            lower: vec![-3.0],
            upper: vec![2.0],
            guess: vec![vec![0.8]; 2],
            linear: false,
        };
        let system = TimeFreezingSystem::new(bead, 50.0);
        transcribe(HeavisideSystem::new(system), tableau, task)
    }

    #[test]
    fn forces_and_impulses_stand_where_contacts_act_and_their_derivatives_are_right() {
        let tableau = ButcherTableau::new(Scheme::RadauIia, 2).expect("two stages");
        let mut program = struck(&StruckBead::default(), &tableau);
        assert!(!program.leaves_out_forces());
        // The normal force and that of sliding at two stages of the two last elements; the impulse of the wall; both of the floor.
        let places = program.provisions.all.iter();
        let forces = places.filter(|own| matches!(own.place, super::Place::Stage { .. }));
        assert_eq!(forces.count(), 8);
        assert_eq!(program.provisions.all.len(), 11);
        assert_eq!(program.provisions.impacts[0].elements, 1..3);
        // Conditions on forces hold at the stages of phases: five elements of eight are none.
        let path_rows = program.provisions.path_rows.iter();
        let jumps: Vec<bool> = path_rows.map(Option::is_none).collect();
        assert_eq!(jumps, [false, true, true, false, false, true, false, false]);
        let mut x = vec![0.0; program.variables()];
        program.initial_point(&mut x);
        // What is guessed satisfies its rows.
        let mut rows = vec![0.0; program.constraints()];
        program.constraint_values(&x, &mut rows);
        for own in &program.provisions.all {
            assert!(rows[own.row].abs() < 1e-12 && x[own.variable] != 0.0);
        }
        for &(variable, row) in &program.provisions.sums {
            assert!(rows[row].abs() < 1e-12 && x[variable] != 0.0);
        }
        for (i, value) in x.iter_mut().enumerate() {
            *value += 0.1 + 0.05 * (i as f64).sin();
        }
        let compared = check_derivatives(&mut program, Some(&x)).expect("finite at the start");
        assert!(compared.iter().all(|entry| !entry.missing));
        assert!(compared[0].error < 1e-6, "{:?}", compared[0]);
        let name = |index: usize| program.variable_name(index);
        assert_eq!(
            name(program.provisions.all[0].variable),
            "force of floor at stage 0 of element 2 of interval 1, 0.2000 to 0.4000 s"
        );
    }

    #[test]
    fn scheme_without_a_stage_at_the_end_leaves_out_forces_there() {
        let tableau = ButcherTableau::new(Scheme::GaussLegendre, 2).expect("two stages");
        let program = struck(&StruckBead::default(), &tableau);
        assert!(program.leaves_out_forces());
        let rows = (program.goal_rows..program.constraints).map(|row| program.constraint_name(row));
        let goals = rows.filter(|name| name.ends_with("at the end"));
        assert_eq!(goals.count(), 1);
    }
}
