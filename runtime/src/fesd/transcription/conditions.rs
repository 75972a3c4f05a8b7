//! What the scene declares for optimal control, as terms of the objective and rows of the program:
//!
//! ```text
//! int L dt = sum_e h_e s_k sum_j b_j theta_j L(X_j)     at the stages j of the elements e
//! int L dt = T / N sum_k L(u_k)                         where L reads nothing but controls
//! c(X_j) = 0, or >= 0                                   at the stages
//! c(u_k) = 0, or >= 0                                   once an interval, where c reads nothing but controls
//! phi(q, v, T), goals                                   at the end
//! ```
//!
//! The clock runs at the speed `theta`. It stands during a jump, which therefore costs nothing. Path constraints hold at the
//! stages of jumps, too: coordinates rest there, and velocities lie between those before and after the jump, so that
//! nothing is lost where the condition is convex in them.

use super::{Block, Transcription};
use crate::model::{ConstraintDeclaration, ConstraintRelation, Model, OptimalControlDeclaration};

/// An argument of the functions of a site.
#[derive(Clone)]
struct Input {
    /// Its variable, or none where it is constant.
    variable: Option<usize>,
    unit: f64,
    /// Its value where it is constant.
    constant: f64,
    /// Whether functions of this site depend on it.
    read: bool,
}

/// Where functions of the scene are evaluated, and what for.
#[derive(Clone)]
pub(super) struct Site {
    /// Whether they are the terminal functions, of `(q, v, T)`, and not the path functions.
    terminal: bool,
    inputs: Vec<Input>,
    /// Functions that are constraints, and their rows.
    rows: Vec<(usize, usize)>,
    /// What function 0 is multiplied by in the objective: a number and variables.
    cost: Option<(f64, Vec<usize>)>,
}

/// A constraint, and the row of its first or only imposition.
fn constraint_of(
    declared: &OptimalControlDeclaration,
    terminal: bool,
    function: usize,
) -> Option<&'static ConstraintDeclaration> {
    if terminal {
        let index = function.checked_sub(usize::from(declared.final_cost))?;
        declared.goals.get(index)
    } else {
        let index = function.checked_sub(usize::from(declared.running_cost))?;
        declared.constraints.get(index)
    }
}

/// Path functions that read nothing but controls, and so have one value an interval; the others.
fn by_interval(transcription: &Transcription<'_>) -> (Vec<usize>, Vec<usize>) {
    let Some(declared) = transcription.declared() else {
        return (Vec::new(), Vec::new());
    };
    let first = 2 * transcription.dcs.system.coordinates();
    let controls = first..first + transcription.dcs.layout.controls();
    (0..declared.path_functions()).partition(|&function| {
        let entries = declared.path_jacobian.entries.iter();
        let mut own = entries.filter(|entry| entry.0 as usize == function);
        own.all(|entry| controls.contains(&(entry.1 as usize)))
    })
}

/// Numbers of the path constraints that are imposed once an interval, and at each stage.
pub(super) fn path_rows(transcription: &Transcription<'_>) -> (usize, usize) {
    let Some(declared) = transcription.declared() else {
        return (0, 0);
    };
    let (once, staged) = by_interval(transcription);
    let count = |functions: &[usize]| {
        let constraints = functions.iter();
        let constraints = constraints.filter(|&&f| constraint_of(&declared, false, f).is_some());
        constraints.count()
    };
    (count(&once), count(&staged))
}

/// The arguments of the path functions at a block, of which those in `read` matter.
fn inputs_at(
    transcription: &Transcription<'_>,
    block: &Block,
    interval: usize,
    read: impl Fn(usize) -> bool,
) -> Vec<Input> {
    let layout = &transcription.dcs.layout;
    let given = transcription.task.controls.values(interval);
    let count = transcription.dcs.system.model.declaration().inputs();
    let inputs = (0..count).map(|k| {
        let place = layout.local_of_input(k);
        let control = place.checked_sub(layout.states());
        Input {
            variable: block.variables[place],
            unit: transcription.unit(place),
            constant: control.and_then(|c| given.get(c)).copied().unwrap_or(0.0),
            read: read(k),
        }
    });
    inputs.collect()
}

/// The sites of a program whose variables and rows are numbered.
pub(super) fn sites(transcription: &Transcription<'_>) -> Vec<Site> {
    let Some(declared) = transcription.declared() else {
        return Vec::new();
    };
    let mut sites = Vec::new();
    let (once, staged) = by_interval(transcription);
    let rows = |functions: &[usize], first: usize| {
        let constraints = functions.iter().copied();
        let constraints = constraints.filter(|&f| constraint_of(&declared, false, f).is_some());
        constraints.zip(first..).collect::<Vec<_>>()
    };
    let costs = |functions: &[usize]| declared.running_cost && functions.contains(&0);
    if !once.is_empty() {
        let count = transcription.intervals.len() as f64;
        let first = 2 * transcription.dcs.system.coordinates();
        let controls = first..first + transcription.dcs.layout.controls();
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
        let imposed = path_rows(transcription).1;
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
        let goals = (0..declared.terminal_functions())
            .filter(|&function| constraint_of(&declared, true, function).is_some());
        sites.push(Site {
            terminal: true,
            inputs: variables
                .map(|variable| Input {
                    variable,
                    unit: 1.0,
                    constant: transcription.task.horizon,
                    read: true,
                })
                .collect(),
            rows: goals.zip(transcription.goal_rows..).collect(),
            cost: declared.final_cost.then(|| (1.0, Vec::new())),
        });
    }
    sites
}

/// Functions of a site with their derivatives at a point.
struct Evaluated {
    values: Vec<f64>,
    slopes: Vec<f64>,
    input: Vec<f64>,
}

impl Site {
    fn input(&self, x: &[f64]) -> Vec<f64> {
        let inputs = self.inputs.iter();
        inputs
            .map(|input| input.variable.map_or(input.constant, |v| input.unit * x[v]))
            .collect()
    }

    fn values(
        &self,
        model: &dyn Model,
        declared: &OptimalControlDeclaration,
        x: &[f64],
    ) -> Vec<f64> {
        let input = self.input(x);
        if self.terminal {
            let mut values = vec![0.0; declared.terminal_functions()];
            model.terminal_functions(&input, &mut values);
            values
        } else {
            let mut values = vec![0.0; declared.path_functions()];
            model.path_functions(&input, &mut values);
            values
        }
    }

    fn evaluate(
        &self,
        model: &dyn Model,
        declared: &OptimalControlDeclaration,
        x: &[f64],
    ) -> Evaluated {
        let input = self.input(x);
        let values = self.values(model, declared, x);
        let mut slopes = vec![0.0; self.jacobian(declared).len()];
        if self.terminal {
            model.terminal_jacobian(&input, &mut slopes);
        } else {
            model.path_jacobian(&input, &mut slopes);
        }
        Evaluated {
            values,
            slopes,
            input,
        }
    }

    fn jacobian(&self, declared: &OptimalControlDeclaration) -> &'static [(u32, u32)] {
        if self.terminal {
            declared.terminal_jacobian.entries
        } else {
            declared.path_jacobian.entries
        }
    }

    /// Variable and unit of an argument on which functions of this site depend.
    fn argument(&self, k: u32) -> Option<(usize, f64)> {
        let input = &self.inputs[k as usize];
        input.variable.filter(|_| input.read).zip(Some(input.unit))
    }

    /// Variables and slopes of one function.
    fn gradient_of(
        &self,
        declared: &OptimalControlDeclaration,
        slopes: &[f64],
        function: usize,
    ) -> impl Iterator<Item = (usize, f64)> {
        let entries = self.jacobian(declared).iter().zip(slopes);
        entries.filter_map(move |(&(row, column), slope)| {
            let (variable, unit) = self.argument(column)?;
            (row as usize == function).then_some((variable, unit * slope))
        })
    }
}

/// `factor` times the product of the variables but those at the places `left_out`.
fn product(factor: f64, variables: &[usize], left_out: &[usize], x: &[f64]) -> f64 {
    let kept = variables.iter().enumerate();
    let kept = kept.filter(|(place, _)| !left_out.contains(place));
    kept.fold(factor, |product, (_, &variable)| product * x[variable])
}

impl Transcription<'_> {
    /// What the scene declares for optimal control, if it is asked for.
    pub(super) fn declared(&self) -> Option<OptimalControlDeclaration> {
        let declared = self.dcs.system.model.declaration().optimal_control;
        declared.filter(|_| self.task.declared)
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
            if constraint.is_some_and(|c| c.relation == ConstraintRelation::NonNegative) {
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
