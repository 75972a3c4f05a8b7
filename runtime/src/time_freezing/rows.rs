//! The rows of the time-freezing system, all of them products of unknowns and of functions of the model.

use super::conditions;
use super::layout::{
    AHEAD, ALPHA, BEHIND, BETA, C_MINUS, C_PLUS, FALL, LAMBDA_MINUS, LAMBDA_PLUS, Layout, P, RISE,
    SLIP_MINUS, SLIP_PLUS, W,
};
use super::transcription::{Block, SUMS, Transcription};
use crate::model::held::is_held;
use crate::program::joint_rows::Decided;
use crate::program::kernel::Kernel;
use crate::program::parts::OBJECTIVE;

/// Weight of the step equilibration: small enough to leave the complementarity to the solver, large
/// enough to fix the lengths that nothing else does.
const EQUILIBRATION: f64 = 3e-4;

/// A linear term of a row: a place in the local vector, and what it is multiplied by.
type Term = (usize, f64);

/// Adds all rows, and the step equilibration to the objective.
pub(super) fn add(transcription: &mut Transcription<'_>) {
    add_start(transcription);
    let count = transcription.task.elements;
    for k in 0..transcription.intervals.len() {
        add_interval(transcription, k);
        for e in k * count..(k + 1) * count {
            add_element(transcription, e);
        }
    }
}

/// Rows of a free start, where the first element continues the switching functions and lifted gaps begin as gaps are.
fn add_start(transcription: &mut Transcription<'_>) {
    if !transcription.is_free {
        return;
    }
    let block = transcription.beginning.clone();
    let what = "switching functions at the start";
    add_algebraic(transcription, &block, (&[], what));
    if transcription.gaps_are_free() {
        for contact in 0..transcription.field.layout.contacts {
            add_gap(transcription, &block, contact, what);
        }
    }
}

/// The row `G_i - g_i(q) = 0`.
fn add_gap(transcription: &mut Transcription<'_>, block: &Block, contact: usize, name: &str) {
    let row = transcription.row(name, 0.0);
    let gap = transcription.field.layout.lifted_gap(contact);
    add_terms(transcription, row, block, &[(gap, 1.0)]);
    add_contact(transcription, block, contact, &[], vec![(row, 0, -1.0)]);
}

/// The rows that belong to the whole of an interval: the sum of the lengths of its elements, and its clock.
fn add_interval(transcription: &mut Transcription<'_>, k: usize) {
    let interval = transcription.interval_name(k);
    let name = format!("sum of the element lengths of {interval}");
    let row = transcription.row(name, 1.0);
    let count = transcription.task.elements;
    for element in &transcription.elements[k * count..(k + 1) * count] {
        transcription.program.linear(row, element.length, 1.0);
    }
    let time = transcription.field.layout.time();
    let clock = |block: &Block| block.variables[time];
    let ends = (
        clock(transcription.block_before((k + 1) * count)),
        clock(&transcription.beginning),
    );
    let name = format!("clock at the end of {interval}");
    let row = transcription.row(name, 0.0);
    let share = (k as f64 + 1.0) / transcription.intervals.len() as f64;
    let horizon = transcription.outer.horizon;
    if let (Some(end), Some(start)) = ends {
        transcription.program.linear(row, end, 1.0);
        transcription.program.linear(row, start, -1.0);
        transcription.program.linear(row, horizon, -share);
    }
}

/// The rows of an element, and what it adds to the objective.
fn add_element(transcription: &mut Transcription<'_>, e: usize) {
    let element = transcription.elements[e].clone();
    let name = transcription.element_name(e);
    let per_size = EQUILIBRATION / transcription.nominal().powi(2);
    let (h, even) = (element.length, element.even);
    let program = &mut transcription.program;
    program.product(OBJECTIVE, &[h, h], per_size);
    program.product(OBJECTIVE, &[h], -2.0 * per_size * even);
    program.product(OBJECTIVE, &[], per_size * even * even);
    add_collocation(transcription, e, &name);
    let what = format!("switching functions of {name}");
    for block in &element.blocks {
        let clock = transcription.passing(e, block)[2..].to_vec();
        add_algebraic(transcription, block, (&clock, &what));
    }
    let what = format!("gaps of {name}");
    for correction in &element.corrections {
        for block in &element.blocks {
            add_gap(transcription, block, correction.contact, &what);
        }
    }
    for block in &element.blocks {
        add_drive(transcription, element.interval, block);
    }
    for group in 0..transcription.groups.len() {
        for sum in 0..SUMS {
            let name = format!("cross complementarity of {name}");
            let row = transcription.row(name, 0.0);
            let own = element.sums + SUMS * group + sum;
            let terms = transcription.sum_terms(e, group, sum);
            let program = &mut transcription.program;
            program.linear(row, own, 1.0);
            terms.into_iter().for_each(|i| program.linear(row, i, -1.0));
        }
    }
}

/// Collocation of an element, in which rows of joints stand in the place of those that they decide.
fn add_collocation(transcription: &mut Transcription<'_>, e: usize, name: &str) {
    let element = transcription.elements[e].clone();
    let before = transcription.block_before(e).clone();
    let layout = transcription.field.layout.clone();
    let decided = decided(transcription, &element.blocks[0]);
    let directions: Vec<Vec<f64>> = element
        .corrections
        .iter()
        .map(|correction| direction(transcription, &element.blocks[0], correction.contact))
        .collect();
    let mut rows = Vec::with_capacity(element.blocks.len());
    for (m, block) in element.blocks.iter().enumerate() {
        let mut own = Vec::with_capacity(layout.states());
        for k in 0..layout.states() {
            let state = k < layout.time();
            if state && (is_held(transcription.field.model, k) || decided.contains(k)) {
                own.push(None);
                continue;
            }
            let row = transcription.row(format!("collocation of {name}"), 0.0);
            add_terms(transcription, row, block, &[(k, 1.0)]);
            add_terms(transcription, row, &before, &[(k, -1.0)]);
            for (correction, direction) in element.corrections.iter().zip(&directions) {
                if let Some(d) = direction.get(k) {
                    let mu = correction.variables[m];
                    transcription.program.linear(row, mu, -d);
                }
            }
            own.push(Some(row));
        }
        rows.push(own);
        let [q, v, u] = transcription.inputs(block);
        let place = transcription.block_name(e, m);
        let program = &mut transcription.program;
        decided.add_rows(program, [&q, &v, &u], &place);
    }
    conditions::add_rows(transcription, e, &rows);
    for j in 0..transcription.tableau.stages() {
        let weights: Vec<(f64, &Vec<Option<usize>>)> = rows
            .iter()
            .enumerate()
            .map(|(m, rows)| (-transcription.weight(m, j), rows))
            .collect();
        add_rates(transcription, e, &element.blocks[j], &weights);
    }
}

/// The components that joints decide in an element, in the metric of the mass matrix at the guess.
fn decided(transcription: &Transcription<'_>, block: &Block) -> Decided {
    let model = transcription.field.model;
    let n = transcription.field.coordinates();
    let (places, time) = (
        block.at(0..2 * n),
        block.variables[transcription.field.layout.time()],
    );
    let value = |i: usize| transcription.program.guessed(i);
    let state: Vec<f64> = places.into_iter().map(value).collect();
    let time = time.map_or(0.0, value);
    let mut units = vec![1.0; 2 * n];
    if model.declaration().joints.is_some() {
        let mut input = state.clone();
        input.resize(model.declaration().inputs(), 0.0);
        if model.declaration().explicit_time
            && let Some(last) = input.last_mut()
        {
            *last = time;
        }
        let mut mass = vec![0.0; n * n];
        model.mass_matrix(&input, &mut mass);
        for (k, unit) in units.iter_mut().enumerate() {
            let size = mass[k % n * (n + 1)];
            *unit = if size > 0.0 { size.sqrt().recip() } else { 1.0 };
        }
    }
    Decided::at(model, &units, &state, time)
}

/// The direction of a contact at the guess of a block.
fn direction(transcription: &mut Transcription<'_>, block: &Block, contact: usize) -> Vec<f64> {
    let inputs = transcription.inputs(block).concat();
    let value = |i: usize| transcription.program.guessed(i);
    let x: Vec<f64> = inputs.into_iter().map(value).collect();
    transcription.field.evaluate(&x);
    transcription.field.direction(contact).to_vec()
}

/// Adds the rates of all states at a stage to rows of collocation, `(weight, row of each state)`.
fn add_rates(
    transcription: &mut Transcription<'_>,
    e: usize,
    block: &Block,
    rows: &[(f64, &Vec<Option<usize>>)],
) {
    let layout = transcription.field.layout.clone();
    let (n, a_bar) = (
        transcription.field.coordinates(),
        transcription.field.auxiliary_acceleration,
    );
    let passing = transcription.passing(e, block);
    let lengths = passing[..2].to_vec();
    // Uses of output `k` for a state, for each `k` and `state`.
    let uses = |outputs: &[(usize, usize)], factor: f64| -> Vec<(usize, usize, f64)> {
        let of = |(weight, rows): &(f64, &Vec<Option<usize>>)| {
            let uses = outputs.iter().filter_map(|&(k, state)| {
                let row = rows[state]?;
                Some((row, k, factor * weight))
            });
            uses.collect::<Vec<_>>()
        };
        rows.iter().flat_map(of).collect()
    };
    let program = &mut transcription.program;
    for &(weight, rows) in rows {
        for (row, v) in rows[..n].iter().zip(&block.variables[n..]) {
            if let (&Some(row), &Some(v)) = (row, v) {
                program.product(row, &[&passing[..], &[v]].concat(), weight);
            }
        }
        if let Some(row) = rows[layout.time()] {
            program.product(row, &passing, weight);
        }
    }
    let [q, v, u] = transcription.inputs(block);
    let velocities: Vec<(usize, usize)> = (0..n).map(|k| (k, n + k)).collect();
    transcription.program.block(
        &Kernel::Acceleration(Vec::new()),
        [&q, &v, &u, &[]],
        passing.iter().copied(),
        uses(&velocities, 1.0),
    );
    let contacts = transcription.contacts();
    for number in 0..2 * contacts {
        for (place, factor, scale) in transcription.provision(number) {
            let kernel = match number.checked_sub(contacts) {
                None => Kernel::Push(vec![number]),
                Some(contact) => Kernel::Friction(vec![contact]),
            };
            let force: Vec<usize> = block.variables[place].into_iter().collect();
            let inputs = [&q[..], &v, &u, &force];
            let scales = lengths.iter().copied().chain(scale);
            let uses = uses(&velocities, a_bar * factor);
            transcription.program.block(&kernel, inputs, scales, uses);
        }
    }
    for contact in 0..layout.contacts {
        let gap = uses(&[(1, layout.lifted_gap(contact))], 1.0);
        add_contact(transcription, block, contact, &passing, gap.clone());
        let beta = block.variables[layout.algebraic(contact, BETA)];
        let dipping: Vec<usize> = lengths.iter().copied().chain(beta).collect();
        if layout.moves_in_jumps(contact) {
            add_contact(transcription, block, contact, &dipping, gap);
        }
        if let Some(dip) = layout.dip(contact) {
            let dip = uses(&[(1, dip)], 1.0);
            add_contact(transcription, block, contact, &dipping, dip);
        }
    }
}

/// Adds uses of gap and normal velocity of a contact, times a product of variables.
fn add_contact(
    transcription: &mut Transcription<'_>,
    block: &Block,
    contact: usize,
    scale: &[usize],
    uses: Vec<(usize, usize, f64)>,
) {
    let [q, v, u] = transcription.inputs(block);
    let (kernel, scale) = (Kernel::Contact(contact), scale.iter().copied());
    let program = &mut transcription.program;
    program.block(&kernel, [&q, &v, &u, &[]], scale, uses);
}

/// Adds linear terms of the local vector to a row.
fn add_terms(transcription: &mut Transcription<'_>, row: usize, block: &Block, terms: &[Term]) {
    for &(place, factor) in terms {
        if let Some(variable) = block.variables[place] {
            transcription.program.linear(row, variable, factor);
        }
    }
}

/// Terms of the margin of a contact before velocities count, and before its dip does.
fn margin(layout: &Layout, contact: usize) -> Vec<Term> {
    let gap = (layout.lifted_gap(contact), 1.0);
    if layout.bounces(contact) {
        vec![gap]
    } else {
        vec![gap, (layout.algebraic(contact, P), 1.0)]
    }
}

/// The rows of the step form at a block, of which the end of an element has those of switching functions; `clock` is the speed of
/// the clock.
fn add_algebraic(
    transcription: &mut Transcription<'_>,
    block: &Block,
    (clock, name): (&[usize], &str),
) {
    let layout = transcription.field.layout.clone();
    for contact in 0..layout.contacts {
        let place = |offset: usize| layout.algebraic(contact, offset);
        let new = |transcription: &mut Transcription<'_>, value: f64, terms: &[Term]| {
            let row = transcription.row(name, value);
            add_terms(transcription, row, block, terms);
            row
        };
        if !block.boundary {
            let weights = [(place(ALPHA), 1.0), (place(BETA), 1.0)];
            new(transcription, 1.0, &weights);
        }
        let mut parts = vec![(place(P), 1.0), (place(W), -1.0)];
        if !layout.bounces(contact) {
            parts.push((layout.lifted_gap(contact), 1.0));
        }
        let row = new(transcription, 0.0, &parts);
        add_contact(transcription, block, contact, &[], vec![(row, 1, -1.0)]);
        let mut terms = margin(&layout, contact);
        terms.extend(layout.dip(contact).map(|place| (place, 1.0)));
        terms.extend([(place(LAMBDA_PLUS), -1.0), (place(LAMBDA_MINUS), 1.0)]);
        let ahead = layout.edges_of(contact);
        terms.extend(ahead.map(|(k, _)| (layout.edge_place(k, AHEAD), 1.0)));
        new(transcription, 0.0, &terms);
    }
    add_friction(transcription, block, (clock, name));
    if !block.boundary {
        for (j, contact) in layout.elastic.iter().copied().enumerate() {
            let row = transcription.row(name, 0.0);
            let parts = [FALL, RISE].map(|offset| (layout.rebound_place(j, offset), 1.0));
            let weight = (layout.algebraic(contact, BETA), -1.0);
            add_terms(transcription, row, block, &parts);
            add_terms(transcription, row, block, &[weight]);
        }
    }
    for contact in 0..layout.contacts {
        let mut before = margin(&layout, contact);
        for (k, other) in layout.edges_of(contact) {
            let row = transcription.row(name, 0.0);
            let (ahead, behind) = (layout.edge_place(k, AHEAD), layout.edge_place(k, BEHIND));
            let lead = [
                (layout.lifted_gap(other), -1.0),
                (layout.lifted_gap(contact), 1.0),
            ];
            add_terms(transcription, row, block, &before);
            add_terms(transcription, row, block, &[(ahead, 1.0), (behind, -1.0)]);
            add_terms(transcription, row, block, &lead);
            before.push((ahead, 1.0));
        }
    }
    if block.boundary {
        return;
    }
    for count in 2..=layout.contacts {
        let row = transcription.row(name, 0.0);
        add_terms(transcription, row, block, &[(layout.product(count), 1.0)]);
        let factors = [
            layout.product(count - 1),
            layout.algebraic(count - 1, ALPHA),
        ];
        let factors: Vec<usize> = factors.iter().filter_map(|&k| block.variables[k]).collect();
        transcription.program.product(row, &factors, -1.0);
    }
}

/// The rows of friction at a block: how it is split, and the parts of the sliding velocity.
fn add_friction(
    transcription: &mut Transcription<'_>,
    block: &Block,
    (clock, name): (&[usize], &str),
) {
    let layout = transcription.field.layout.clone();
    let a_bar = transcription.field.auxiliary_acceleration;
    for (r, contact) in layout.rough.iter().copied().enumerate() {
        let place = |offset: usize| layout.friction_place(r, offset);
        if !block.boundary {
            let all = f64::from(layout.is_condition(contact));
            let row = transcription.row(name, all);
            let parts = [(place(SLIP_PLUS), 1.0), (place(SLIP_MINUS), 1.0)];
            add_terms(transcription, row, block, &parts);
            if layout.is_condition(contact) {
                // Its weights are its shares, whatever the clock does.
            } else if layout.is_dry(contact) {
                let uses = vec![(row, 1, -1.0 / a_bar)];
                add_contact(transcription, block, contact, clock, uses);
            } else {
                for (place, factor, scale) in transcription.pressing(contact) {
                    let weight = block.variables[place].into_iter();
                    let factors: Vec<usize> = weight.chain(scale).collect();
                    transcription.program.product(row, &factors, -factor);
                }
            }
        }
        let row = transcription.row(name, 0.0);
        let parts = [(place(C_PLUS), -1.0), (place(C_MINUS), 1.0)];
        add_terms(transcription, row, block, &parts);
        let [q, v, u] = transcription.inputs(block);
        let kernel = Kernel::Sliding(contact);
        let uses = vec![(row, 0, 1.0)];
        let program = &mut transcription.program;
        program.block(&kernel, [&q, &v, &u, &[]], None, uses);
    }
}

/// What controls that are linear in the physical time are at a block, by its clock. Between nodes `u_k` and `u_{k+1}`, with the
/// length `T` of the motion and its start `t_0`, over the guess of `T`:
///
/// ```text
/// 0 = T (u_m - u_k) - (u_{k+1} - u_k) (N (t_m - t_0) - k T)
/// ```
fn add_drive(transcription: &mut Transcription<'_>, interval: usize, block: &Block) {
    let layout = transcription.field.layout.clone();
    let Some(clock) = block.variables[layout.time()] else {
        return;
    };
    let horizon = transcription.outer.horizon;
    let length = transcription.program.guessed(horizon);
    let count = transcription.task.intervals as f64;
    let (start, k) = (transcription.task.time, interval as f64);
    let own = transcription.intervals[interval].clone();
    let first = crate::model::held::first_of_stages(transcription.field.model);
    for (i, before) in own.controls.iter().copied().enumerate().take(first) {
        let control = block.variables[layout.states() + i].filter(|&own| own != before);
        let Some(control) = control else { continue };
        let unit = transcription.program.unit(control);
        let name = format!("line of {}", transcription.program.name(control));
        if let Some(&after) = own.ends.get(i) {
            let program = &mut transcription.program;
            let row = program.row_in(unit, name, 0.0, 0.0);
            program.bilinear(row, horizon, control, 1.0 / length);
            program.bilinear(row, horizon, before, -(1.0 + k) / length);
            program.bilinear(row, horizon, after, k / length);
            program.bilinear(row, clock, before, count / length);
            program.bilinear(row, clock, after, -count / length);
            program.linear(row, before, -count * start / length);
            program.linear(row, after, count * start / length);
        }
    }
}
