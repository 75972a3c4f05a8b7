//! How an optimum and its final time change with parameters, as long as its contact sequence stays.

use hangtime_solver::mpcc::{Moved, RangeEnd, RangeLimit, moved};
use hangtime_solver::nlp::NlpProblem as _;

use crate::derivative::{SequenceLimit, SequenceRange};
use crate::model::held::moving;
use crate::ocp::collocation::program::Collocation;
use crate::ocp::parameters::{OptimumGradient, OptimumSides};
use crate::ocp::search::attempt::Local;
use crate::program::sparse_program::Program;

/// Derivatives by the parameters that stand behind the coordinates and are given; `None` where there are none.
pub(in crate::ocp) fn gradient(local: &mut Local) -> Option<OptimumGradient> {
    let program = &mut local.program;
    let held = program.model.held()?;
    let first = moving(program.model);
    let start = &program.phases.first()?.start;
    let given = held.parameters.iter().zip(&start[first..]);
    let given = given.filter(|&(_, &variable)| {
        let (lower, upper) = program.program.bounds(variable);
        lower >= upper
    });
    let given = given.map(|(&index, &variable)| (index, variable));
    let (indices, variables): (Vec<usize>, Vec<usize>) = given.unzip();
    if indices.is_empty() || variables.iter().any(|&i| i >= program.program.variables()) {
        return None;
    }
    let unit = program.program.objective_unit;
    let moved = moved(&mut program.program, &local.solution, &variables);
    let time_alone = slope_of_time(program, &local.solution.x);
    let (model, horizon, program) = (program.model, program.horizon, &program.program);
    let parameters = model.declaration().parameters;
    let mut gradient = OptimumGradient {
        names: indices.iter().map(|&i| parameters[i].name).collect(),
        parameters: indices,
        ..OptimumGradient::default()
    };
    for (moved, &variable) in moved.iter().zip(&variables) {
        let own = program.unit(variable);
        let [left, right] = moved.objective.map(|by| by * unit / own);
        let known = moved
            .x
            .as_ref()
            .map(|x| x[horizon] * program.unit(horizon) / own);
        let obstacle = obstacle([left, right]);
        let times = obstacle.as_ref().and(time_alone);
        let times = times.map(|slope| {
            moved
                .objective
                .map(|by| by / slope * program.unit(horizon) / own)
        });
        gradient
            .objective
            .push(if obstacle.is_some() { f64::NAN } else { left });
        gradient.final_time.push(known);
        gradient.ranges.push(range(program, moved, own));
        gradient.sides.push(obstacle.as_ref().map(|_| OptimumSides {
            objective: [left, right],
            final_time: times,
        }));
        gradient.obstacles.push(obstacle);
    }
    Some(gradient)
}

/// Why there is no derivative where those to both sides are these.
fn obstacle([left, right]: [f64; 2]) -> Option<String> {
    let why = match (left.is_nan(), right.is_nan()) {
        (false, false) if left == right => return None,
        (false, false) => {
            "bounds and conditions of the plan that hold depend on each other, or hold without need: others decide towards smaller \
             values than towards larger ones"
        }
        (true, true) => {
            "the multipliers of the plan are not unique, and what they allow was not found"
        }
        (true, false) => "towards smaller values there is no plan of this kind, to first order",
        (false, true) => "towards larger values there is no plan of this kind, to first order",
    };
    Some(why.to_owned())
}

/// Slope of the objective by the final time, both as the solver sees them, if it depends on nothing else.
fn slope_of_time(program: &mut Collocation<'_>, x: &[f64]) -> Option<f64> {
    let mut gradient = vec![0.0; x.len()];
    program.program.gradient(x, &mut gradient);
    let slope = std::mem::take(&mut gradient[program.horizon]);
    (slope != 0.0 && gradient.iter().all(|by| *by == 0.0)).then_some(slope)
}

/// How far a parameter of this unit may go, in the names of the program.
fn range(program: &Program<'_>, moved: &Moved, unit: f64) -> SequenceRange {
    let limit = |end: Option<RangeEnd>| {
        end.map(|end| SequenceLimit {
            change: end.change * unit,
            because: match end.at {
                RangeLimit::RowReached(row) => {
                    format!("the {} comes to its bound", program.constraint_name(row))
                }
                RangeLimit::RowLeft(row) => {
                    format!("the {} leaves its bound", program.constraint_name(row))
                }
                RangeLimit::BoundReached(variable) => {
                    format!("{} comes to its bound", program.variable_name(variable))
                }
                RangeLimit::BoundLeft(variable) => {
                    format!("{} leaves its bound", program.variable_name(variable))
                }
            },
        })
    };
    let [below, above] = moved.range;
    SequenceRange {
        below: limit(below),
        above: limit(above),
    }
}
