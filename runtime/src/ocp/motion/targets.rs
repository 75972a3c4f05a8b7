//! Where the goals ask the motion to end, and how long that may take.

use crate::model::{Function, Model, OptimalControlDeclaration};
use crate::ocp::problem::{Horizon, Problem, bounds};
use crate::yardstick;

/// Steps of [`approach`].
const STEPS: usize = 20;

/// A guess of the horizon \[s\]: the longest distance to a goal at the speed of the start, or else the
/// horizon of the scene, or else 1 s.
pub(in crate::ocp) fn horizon_guess(problem: &Problem, model: &dyn Model) -> f64 {
    match problem.horizon {
        Horizon::Fixed(horizon)
        | Horizon::Free {
            guess: Some(horizon),
        } => horizon,
        Horizon::Free { guess: None } => {
            let targets = targets(problem, model).into_iter().enumerate();
            let times =
                targets.filter_map(|(k, target)| Some((target? - problem.q[k]) / problem.v[k]));
            let longest = times.filter(|t| t.is_finite() && *t > 0.0).reduce(f64::max);
            longest.or_else(|| model.horizon()).unwrap_or(1.0)
        }
    }
}

/// Where the goals ask coordinates to be at the end: the state nearest to the start that fulfils them, by the
/// method of Gauss and Newton; `None` for coordinates that they leave alone.
pub(in crate::ocp) fn targets(problem: &Problem, model: &dyn Model) -> Vec<Option<f64>> {
    let n = problem.q.len();
    let mut targets = vec![None; n];
    if let Some(declared) = model.declaration().optimal_control {
        let mut z = problem.start();
        z.push(match problem.horizon {
            Horizon::Fixed(horizon)
            | Horizon::Free {
                guess: Some(horizon),
            } => horizon,
            Horizon::Free { guess: None } => model.horizon().unwrap_or(1.0),
        });
        z.resize(model.declaration().terminal_inputs(), 0.0);
        approach(model, &declared, &mut z);
        let (lower, upper) = bounds(model);
        let ways = z.iter().zip(&problem.q).map(|(z, q)| (z - q).abs());
        let longest = ways.fold(0.0, f64::max).min(1.0);
        for k in 0..n {
            let moved =
                (z[k] - problem.q[k]).abs() > yardstick::NOTHING * problem.q[k].abs().max(longest);
            if moved && z[k].is_finite() && lower[k] <= upper[k] {
                targets[k] = Some(z[k].clamp(lower[k], upper[k]));
            }
        }
    }
    targets
}

/// What is missing from each goal at `(q, v, T)`: its value where it is to be 0, its negative part where it is to be
/// at least 0.
pub(in crate::ocp) fn goal_values(model: &dyn Model, z: &[f64]) -> Vec<f64> {
    let mut values = Vec::new();
    if let Some(declared) = model.declaration().optimal_control {
        let mut all = vec![0.0; declared.terminal_functions()];
        let mut z = z.to_vec();
        z.resize(model.declaration().terminal_inputs(), 0.0);
        model.values(Function::Terminal, &z, &mut all);
        let own = &all[usize::from(declared.final_cost)..];
        let goals = declared.goals.iter().zip(own);
        values
            .extend(goals.map(|(goal, &value)| if goal.equality { value } else { value.min(0.0) }));
    }
    values
}

/// Whether the goals that are equations hold a function of `(q, v)` at its value at `z = (q, v, T)`, to first order: its `gradient` is a
/// combination of theirs.
pub(in crate::ocp) fn goals_hold(model: &dyn Model, z: &[f64], gradient: &[f64]) -> bool {
    let Some(declared) = model.declaration().optimal_control else {
        return false;
    };
    let mut z = z.to_vec();
    z.resize(model.declaration().terminal_inputs(), 0.0);
    let pattern = declared.terminal_jacobian.entries;
    let mut slopes = vec![0.0; pattern.len()];
    model.jacobian(Function::Terminal, &z, &mut slopes);
    let first = usize::from(declared.final_cost);
    let mut gradients = nalgebra::DMatrix::zeros(gradient.len(), declared.goals.len());
    for (&(row, column), slope) in pattern.iter().zip(&slopes) {
        if let Some(goal) = (row as usize).checked_sub(first)
            && declared.goals[goal].equality
            && (column as usize) < gradient.len()
        {
            gradients[(column as usize, goal)] = *slope;
        }
    }
    let gradient = nalgebra::DVector::from_column_slice(gradient);
    let finite = gradients
        .iter()
        .chain(gradient.iter())
        .all(|value| value.is_finite());
    if !finite || declared.goals.is_empty() {
        return false;
    }
    let combination = gradients
        .clone()
        .svd(true, true)
        .solve(&gradient, yardstick::ROUNDING);
    combination.is_ok_and(|weights| {
        (gradients * weights - &gradient).norm() <= yardstick::NOTHING * gradient.norm()
    })
}

/// Moves `z = (q, v, T)`, and what terminal functions read of contacts behind it, by shortest Newton steps towards fulfilling the terminal conditions.
fn approach(model: &dyn Model, declared: &OptimalControlDeclaration, z: &mut [f64]) {
    let first = usize::from(declared.final_cost);
    let pattern = declared.terminal_jacobian.entries;
    let mut values = vec![0.0; declared.terminal_functions()];
    let mut slopes = vec![0.0; pattern.len()];
    for _ in 0..STEPS {
        model.values(Function::Terminal, z, &mut values);
        model.jacobian(Function::Terminal, z, &mut slopes);
        let residuals = declared.goals.iter().zip(&values[first..]);
        let residuals =
            residuals.map(|(goal, &value)| if goal.equality { value } else { value.min(0.0) });
        let residual = nalgebra::DVector::from_iterator(declared.goals.len(), residuals);
        let mut jacobian = nalgebra::DMatrix::zeros(declared.goals.len(), z.len());
        for (&(row, column), slope) in pattern.iter().zip(&slopes) {
            if let Some(goal) = (row as usize).checked_sub(first)
                && residual[goal] != 0.0
            {
                jacobian[(goal, column as usize)] = *slope;
            }
        }
        let finite = |values: &[f64]| values.iter().all(|value| value.is_finite());
        if residual.amax() == 0.0 || !finite(residual.as_slice()) || !finite(jacobian.as_slice()) {
            return;
        }
        let Ok(mut step) = jacobian
            .clone()
            .svd(true, true)
            .solve(&residual, yardstick::ROUNDING)
        else {
            return;
        };
        // The shortest step leaves alone what no goal reads; rounding of the decomposition does not, and would look like a way to go.
        for (step, column) in step.iter_mut().zip(jacobian.column_iter()) {
            if column.iter().all(|slope| *slope == 0.0) {
                *step = 0.0;
            }
        }
        for (z, step) in z.iter_mut().zip(step.iter()) {
            *z -= step;
        }
        // Singular values and steps are measured in the units of the scene.
        if step.amax() <= yardstick::ROUNDING {
            return;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::targets;
    use crate::ocp::problem::Problem;

    crate::model! {
        /// A rod that slides over the ground is to come to rest somewhere, its angle anyhow.
        Braked {
            parameters { m: kg = 130, j: kg m^2 = 9, g: m/s^2 = 9.81, h: m = 0.4, b: m = 0.5, v: m/s = 9, way: m = 0 }
            coordinates { y: m, z: m, a: rad }
            controls { u: kN in 0..=3 }
            lagrangian m/2*(dot(y)^2 + dot(z)^2) + j/2*dot(a)^2 - m*g*z
            forces { y: -u, a: -u*h }
            surface rear: z - b*sin(a) >= h*cos(a)
            impact rear: inelastic
            minimize time
            finally { dot(y) + dot(z)/3 == dot(a)*h/7, z >= h + way }
            start { z: h, dot(y): v }
            horizon 2 [s]
        }
    }

    #[test]
    fn coordinates_that_no_goal_reads_are_asked_to_go_nowhere() {
        for v in [0.3, 9.0, 17.0] {
            let braked = Braked {
                v,
                ..Braked::default()
            };
            assert_eq!(targets(&Problem::of(&braked, 3), &braked), [None; 3], "{v}");
        }
        for way in [2e-7, 3e-4, 30.0] {
            let braked = Braked {
                way,
                ..Braked::default()
            };
            let [None, Some(z), None] = targets(&Problem::of(&braked, 3), &braked)[..] else {
                panic!("{way} {:?}", targets(&Problem::of(&braked, 3), &braked));
            };
            assert!((z - 0.4 - way).abs() < 1e-9 * way + 1e-15, "{way} {z}");
        }
    }
}
