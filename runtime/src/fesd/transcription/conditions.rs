//! What the scene declares for optimal control, as terms of the objective and rows of the program:
//!
//! ```text
//! int L dt = sum_e h_e s_k sum_j b_j theta_j L(X_j)     at the stages j of the elements e
//! int L dt = T / N sum_k L(u_k)                         where L reads nothing but constant controls
//! c(X_j) = 0, or >= 0                                   at the stages
//! c(u_k) = 0, or >= 0                                   once an interval, where c reads nothing but constant controls
//! phi(q, v, T), goals                                   at the end
//! c(q, u, P) >= 0                                       in each impact
//! ```
//!
//! The clock runs at the speed `theta`. It stands during a jump, which therefore costs nothing. Path constraints hold at the
//! stages of jumps, too: coordinates rest there, and velocities lie between those before and after the jump, so that
//! nothing is lost where the condition is convex in them.
//!
//! Where it is known which elements are jumps, functions read what contacts provide ([`provided`](super::provided)). Otherwise that is
//! 0 for all functions, and conditions on it are left out: in numerical time a force is the share of the auxiliary dynamics by the
//! speed of the clock, which has no limit in a jump.

use super::numbered::Place;
use super::provided;
use super::sites::{Functions, Input, Row, Site, conditions_on_forces, constraints_of, product};
use super::{Block, Impact, Interval, Transcription};
use crate::model::OptimalControlDeclaration;

/// The arguments of the functions at a block, what contacts provide at a place behind all else, of which those in `read` matter.
fn inputs_at(
    transcription: &Transcription<'_>,
    (block, interval): (&Block, usize),
    place: Option<Place>,
    length: usize,
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
    let contacts = 0..length - declaration.inputs();
    let provided = contacts.map(|number| provided::input(transcription, place, number));
    inputs.chain(provided).collect()
}

/// The sites of a program whose variables and rows are numbered.
pub(super) fn sites(transcription: &Transcription<'_>) -> Vec<Site> {
    let Some(declared) = transcription.declared() else {
        return Vec::new();
    };
    let mut sites = of_intervals(transcription, &declared);
    sites.extend(of_stages(transcription, &declared));
    sites.extend(of_impacts(transcription));
    if declared.terminal_functions() > 0 {
        sites.push(of_end(transcription, &declared));
    }
    sites
}

/// Whether the running cost is among functions.
fn costs(declared: &OptimalControlDeclaration, functions: &[usize]) -> bool {
    declared.running_cost && functions.contains(&0)
}

/// Path functions that have one value an interval.
fn of_intervals(
    transcription: &Transcription<'_>,
    declared: &OptimalControlDeclaration,
) -> Vec<Site> {
    let (once, _) = transcription.by_interval(declared);
    if once.is_empty() {
        return Vec::new();
    }
    let controls = transcription.control_inputs();
    let length = transcription.dcs.system.model.declaration().path_inputs();
    let count = transcription.intervals.len() as f64;
    let intervals = transcription.intervals.iter().enumerate();
    let site = |(k, interval): (usize, &Interval)| {
        let block = &transcription.elements[k * transcription.task.elements].blocks[0];
        let read = |input| controls.contains(&input);
        Site {
            functions: Functions::Path,
            inputs: inputs_at(transcription, (block, k), None, length, read),
            rows: Row::each(&constraints_of(declared, &once), interval.rows + 2),
            cost: costs(declared, &once).then(|| match transcription.horizon {
                Some(horizon) => (1.0 / count, vec![horizon]),
                None => (transcription.task.horizon / count, Vec::new()),
            }),
        }
    };
    intervals.map(site).collect()
}

/// Path functions at the stages.
fn of_stages(transcription: &Transcription<'_>, declared: &OptimalControlDeclaration) -> Vec<Site> {
    let (_, staged) = transcription.by_interval(declared);
    let declaration = transcription.dcs.system.model.declaration();
    let length = declaration.path_inputs();
    let imposed = constraints_of(declared, &staged);
    let on_forces = conditions_on_forces(declared, declaration.inputs());
    let theta = transcription.dcs.layout.theta();
    let mut sites = Vec::new();
    for (e, element) in transcription.elements.iter().enumerate() {
        let force_rows = transcription.provisions.path_rows.get(e).copied().flatten();
        for (j, b) in transcription.tableau.b().iter().enumerate() {
            let block = &element.blocks[j];
            let mut factors = vec![
                element.length,
                transcription.intervals[element.interval].length,
            ];
            factors.extend(theta.and_then(|place| block.variables[place]));
            let mut rows = Row::each(&imposed, element.path_rows + j * imposed.len());
            if let Some(first) = force_rows {
                rows.extend(Row::each(&on_forces, first + j * on_forces.len()));
            }
            let cost = costs(declared, &staged).then_some((*b, factors));
            if rows.is_empty() && cost.is_none() {
                continue;
            }
            let place = Some(Place::Stage {
                element: e,
                stage: j,
            });
            let at = (block, element.interval);
            sites.push(Site {
                functions: Functions::Path,
                inputs: inputs_at(transcription, at, place, length, |_| true),
                rows,
                cost,
            });
        }
    }
    sites
}

/// Functions of the impulses of each impact.
fn of_impacts(transcription: &Transcription<'_>) -> Vec<Site> {
    let length = transcription.dcs.system.model.declaration().impact_inputs();
    let impacts = transcription.provisions.impacts.iter();
    let site = |impact: &Impact| {
        let element = &transcription.elements[impact.elements.end - 1];
        let at = (element.blocks.last()?, element.interval);
        let place = Some(Place::Impact {
            first: impact.elements.start,
        });
        Some(Site {
            functions: Functions::Impact,
            inputs: inputs_at(transcription, at, place, length, |_| true),
            rows: impact.rows.clone(),
            cost: None,
        })
    };
    impacts.filter_map(site).collect()
}

/// The terminal functions.
fn of_end(transcription: &Transcription<'_>, declared: &OptimalControlDeclaration) -> Site {
    let n = transcription.dcs.system.coordinates();
    let state = transcription.final_state()[..2 * n].iter();
    let provisions = &transcription.provisions;
    let sums = (0..declared.contacts.sums).map(|k| provisions.sums.get(k).map(|sum| sum.0));
    let time = transcription.horizon;
    let mut inputs: Vec<Input> = state
        .copied()
        .chain([time])
        .chain(sums)
        .enumerate()
        .map(|(k, variable)| Input {
            variable,
            unit: 1.0,
            constant: if k == 2 * n {
                transcription.task.horizon
            } else {
                0.0
            },
            read: true,
        })
        .collect();
    let declaration = transcription.dcs.system.model.declaration();
    let place = transcription.last_stage();
    let contacts = 0..declaration.terminal_inputs() - inputs.len();
    inputs.extend(contacts.map(|number| provided::input(transcription, place, number)));
    Site {
        functions: Functions::Terminal,
        inputs,
        rows: Row::each(&transcription.goals(), transcription.goal_rows),
        cost: declared.final_cost.then(|| (1.0, Vec::new())),
    }
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
    let sites = || transcription.sites.iter().filter(|s| !s.rows.is_empty());
    sites()
        .flat_map(|site| &site.rows)
        .for_each(|at| c[at.row] = 0.0);
    for site in sites() {
        let values = site.values(model, &declared, x);
        for at in &site.rows {
            c[at.row] += at.factor * values[at.function];
        }
    }
}

/// Writes the upper bounds of the path constraints and the terminal conditions; the lower ones are 0.
pub(super) fn write_bounds(transcription: &Transcription<'_>, upper: &mut [f64]) {
    let Some(declared) = transcription.declared() else {
        return;
    };
    for site in &transcription.sites {
        for at in &site.rows {
            let constraint = site.functions.constraint(&declared, at.function);
            if constraint.is_some_and(|c| !c.equality) {
                upper[at.row] = f64::INFINITY;
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
        for own in &site.rows {
            for (variable, slope) in site.gradient_of(&declared, &at.slopes, own.function) {
                add(own.row, variable, own.factor * slope);
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
        for own in &site.rows {
            weights[own.function] += own.factor * multipliers[own.row];
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
        for (a, b, curvature) in site.curvatures(model, &declared, &at.input, &weights) {
            add(a, b, curvature);
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
    let (functions, function) = sites.find_map(|site| {
        let mut rows = site.rows.iter();
        let own = rows.find(|own| own.row == row)?;
        Some((site.functions, own.function))
    })?;
    let name = functions.constraint(&declared, function)?.name;
    Some(match functions {
        Functions::Path => format!("`{name}` in {}", place()),
        Functions::Terminal => format!("`{name}` at the end"),
        Functions::Impact => format!("`{name}` in an impact"),
    })
}
