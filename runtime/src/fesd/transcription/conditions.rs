//! What the scene declares for optimal control, as terms of the objective and rows of the program:
//!
//! ```text
//! int L dt = sum_e h_e s_k sum_j b_j theta_j L(X_j)     at the stages j of the elements e
//! int L dt = T / N sum_k L(u_k)                         where L reads nothing but constant controls
//! c(X_j) = 0, or >= 0                                   at the stages
//! c(u_k) = 0, or >= 0                                   once an interval, where c reads nothing but constant controls
//! phi(q, v, T), goals                                   at the end
//! ```
//!
//! The clock runs at the speed `theta`. It stands during a jump, which therefore costs nothing. Path constraints hold at the
//! stages of jumps, too: coordinates rest there, and velocities lie between those before and after the jump, so that
//! nothing is lost where the condition is convex in them.
//!
//! What contacts provide is 0 for all functions, and conditions on that are left out: in numerical time a force is the share of the
//! auxiliary dynamics by the speed of the clock, which has no limit in a jump.

use super::sites::{Input, Site, constraint_of, constraints_of, product};
use super::{Block, Transcription};

/// The arguments of the path functions at a block, of which those in `read` matter.
fn inputs_at(
    transcription: &Transcription<'_>,
    block: &Block,
    interval: usize,
    read: impl Fn(usize) -> bool,
) -> Vec<Input> {
    let layout = &transcription.dcs.layout;
    let given = transcription.task.controls.values(interval);
    let declaration = transcription.dcs.system.model.declaration();
    let inputs = (0..declaration.inputs()).map(|k| {
        let place = layout.local_of_input(k);
        let control = place.checked_sub(layout.states());
        Input {
            variable: block.variables[place],
            unit: transcription.unit(place),
            constant: control.and_then(|c| given.get(c)).copied().unwrap_or(0.0),
            read: read(k),
        }
    });
    let contacts = declaration.inputs()..declaration.path_inputs();
    inputs.chain(contacts.map(|_| NOTHING)).collect()
}

/// What a contact provides.
const NOTHING: Input = Input {
    variable: None,
    unit: 1.0,
    constant: 0.0,
    read: false,
};

/// The sites of a program whose variables and rows are numbered.
pub(super) fn sites(transcription: &Transcription<'_>) -> Vec<Site> {
    let Some(declared) = transcription.declared() else {
        return Vec::new();
    };
    let mut sites = Vec::new();
    let controls = transcription.control_inputs();
    let (once, staged) = transcription.by_interval(&declared);
    let rows = |functions: &[usize], first: usize| {
        let constraints = constraints_of(&declared, functions).into_iter();
        constraints.zip(first..).collect::<Vec<_>>()
    };
    let costs = |functions: &[usize]| declared.running_cost && functions.contains(&0);
    if !once.is_empty() {
        let count = transcription.intervals.len() as f64;
        for (k, interval) in transcription.intervals.iter().enumerate() {
            let block = &transcription.elements[k * transcription.task.elements].blocks[0];
            sites.push(Site {
                terminal: false,
                inputs: inputs_at(transcription, block, k, |input| controls.contains(&input)),
                rows: rows(&once, interval.rows + 2),
                cost: costs(&once).then(|| match transcription.horizon {
                    Some(horizon) => (1.0 / count, vec![horizon]),
                    None => (transcription.task.horizon / count, Vec::new()),
                }),
            });
        }
    }
    if !staged.is_empty() {
        let theta = transcription.dcs.layout.theta();
        let imposed = constraints_of(&declared, &staged).len();
        for element in &transcription.elements {
            let length = transcription.intervals[element.interval].length;
            for (j, b) in transcription.tableau.b().iter().enumerate() {
                let block = &element.blocks[j];
                let mut factors = vec![element.length, length];
                factors.extend(theta.and_then(|place| block.variables[place]));
                sites.push(Site {
                    terminal: false,
                    inputs: inputs_at(transcription, block, element.interval, |_| true),
                    rows: rows(&staged, element.path_rows + j * imposed),
                    cost: costs(&staged).then_some((*b, factors)),
                });
            }
        }
    }
    if declared.terminal_functions() > 0 {
        let n = transcription.dcs.system.coordinates();
        let state = transcription.final_state()[..2 * n].iter();
        let variables = state.copied().chain([transcription.horizon]);
        let states_and_time = variables.map(|variable| Input {
            variable,
            unit: 1.0,
            constant: transcription.task.horizon,
            read: true,
        });
        let inputs = transcription
            .dcs
            .system
            .model
            .declaration()
            .terminal_inputs();
        let contacts = (2 * n + 1..inputs).map(|_| NOTHING);
        let goals = transcription.goals().into_iter();
        sites.push(Site {
            terminal: true,
            inputs: states_and_time.chain(contacts).collect(),
            rows: goals.zip(transcription.goal_rows..).collect(),
            cost: declared.final_cost.then(|| (1.0, Vec::new())),
        });
    }
    sites
}

/// The objective that the scene declares.
pub(super) fn objective(transcription: &Transcription<'_>, x: &[f64]) -> f64 {
    let Some(declared) = transcription.declared() else {
        return 0.0;
    };
    let model = transcription.dcs.system.model;
    let terms = transcription.sites.iter().filter_map(|site| {
        let (factor, variables) = site.cost.as_ref()?;
        let value = site.values(model, &declared, x)[0];
        Some(product(*factor, variables, &[], x) * value)
    });
    terms.sum()
}

/// Adds the gradient of the objective that the scene declares.
pub(super) fn add_gradient(transcription: &Transcription<'_>, x: &[f64], gradient: &mut [f64]) {
    let Some(declared) = transcription.declared() else {
        return;
    };
    let model = transcription.dcs.system.model;
    for site in &transcription.sites {
        let Some((factor, variables)) = &site.cost else {
            continue;
        };
        let at = site.evaluate(model, &declared, x);
        for (place, &variable) in variables.iter().enumerate() {
            gradient[variable] += product(*factor, variables, &[place], x) * at.values[0];
        }
        let scale = product(*factor, variables, &[], x);
        for (variable, slope) in site.gradient_of(&declared, &at.slopes, 0) {
            gradient[variable] += scale * slope;
        }
    }
}

/// Writes the values of the path constraints and the terminal conditions.
pub(super) fn write_rows(transcription: &Transcription<'_>, x: &[f64], c: &mut [f64]) {
    let Some(declared) = transcription.declared() else {
        return;
    };
    let model = transcription.dcs.system.model;
    for site in transcription.sites.iter().filter(|s| !s.rows.is_empty()) {
        let values = site.values(model, &declared, x);
        for &(function, row) in &site.rows {
            c[row] = values[function];
        }
    }
}

/// Writes the upper bounds of the path constraints and the terminal conditions; the lower ones are 0.
pub(super) fn write_bounds(transcription: &Transcription<'_>, upper: &mut [f64]) {
    let Some(declared) = transcription.declared() else {
        return;
    };
    for site in &transcription.sites {
        for &(function, row) in &site.rows {
            let constraint = constraint_of(&declared, site.terminal, function);
            if constraint.is_some_and(|c| !c.equality) {
                upper[row] = f64::INFINITY;
            }
        }
    }
}

/// Entries of the Jacobian of the path constraints and the terminal conditions, always in the same order.
pub(super) fn add_jacobian(
    transcription: &Transcription<'_>,
    x: &[f64],
    add: &mut dyn FnMut(usize, usize, f64),
) {
    let Some(declared) = transcription.declared() else {
        return;
    };
    let model = transcription.dcs.system.model;
    for site in transcription.sites.iter().filter(|s| !s.rows.is_empty()) {
        let at = site.evaluate(model, &declared, x);
        for &(function, row) in &site.rows {
            for (variable, slope) in site.gradient_of(&declared, &at.slopes, function) {
                add(row, variable, slope);
            }
        }
    }
}

/// Entries of the Hessian of the Lagrangian, always in the same order.
pub(super) fn add_hessian(
    transcription: &Transcription<'_>,
    x: &[f64],
    weight: f64,
    multipliers: &[f64],
    add: &mut dyn FnMut(usize, usize, f64),
) {
    let Some(declared) = transcription.declared() else {
        return;
    };
    let model = transcription.dcs.system.model;
    for site in &transcription.sites {
        let at = site.evaluate(model, &declared, x);
        let mut weights = vec![0.0; at.values.len()];
        for &(function, row) in &site.rows {
            weights[function] = multipliers[row];
        }
        if let Some((factor, variables)) = &site.cost {
            weights[0] = weight * product(*factor, variables, &[], x);
            for (place, &variable) in variables.iter().enumerate() {
                for (before, &other) in variables[..place].iter().enumerate() {
                    let scale = product(*factor, variables, &[before, place], x);
                    add(variable, other, weight * scale * at.values[0]);
                }
                let scale = weight * product(*factor, variables, &[place], x);
                for (argument, slope) in site.gradient_of(&declared, &at.slopes, 0) {
                    add(variable, argument, scale * slope);
                }
            }
        }
        let pattern = if site.terminal {
            declared.terminal_hessian
        } else {
            declared.path_hessian
        };
        let mut curvatures = vec![0.0; pattern.entries.len()];
        if site.terminal {
            model.terminal_hessian(&at.input, &weights, &mut curvatures);
        } else {
            model.path_hessian(&at.input, &weights, &mut curvatures);
        }
        for (&(i, j), curvature) in pattern.entries.iter().zip(&curvatures) {
            if let (Some((a, of_a)), Some((b, of_b))) = (site.argument(i), site.argument(j)) {
                add(a, b, of_a * of_b * curvature);
            }
        }
    }
}

/// Name of the row of a path constraint or terminal condition, with `place` for those along the motion.
pub(super) fn row_name(
    transcription: &Transcription<'_>,
    row: usize,
    place: impl Fn() -> String,
) -> Option<String> {
    let declared = transcription.declared()?;
    let mut sites = transcription.sites.iter();
    let (terminal, function) = sites.find_map(|site| {
        let mut rows = site.rows.iter();
        let (function, _) = rows.find(|(_, own)| *own == row)?;
        Some((site.terminal, *function))
    })?;
    let name = constraint_of(&declared, terminal, function)?.name;
    Some(if terminal {
        format!("`{name}` at the end")
    } else {
        format!("`{name}` in {}", place())
    })
}
