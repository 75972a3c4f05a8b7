//! How an optimum and its final time change with parameters, as long as its contact sequence stays.

use hangtime_solver::nlp::{Moved, NlpProblem as _, RangeEnd, RangeLimit, moved};

use crate::model::held::moving;
use crate::ocp::parameters::OptimumGradient;
use crate::ocp::program::sparse_program::Program;
use crate::ocp::search::attempt::Local;
use crate::simulation::{SequenceLimit, SequenceRange};

/// Derivatives by the parameters that stand behind the coordinates and are given; none where there are none.
pub(super) fn gradient(local: &mut Local) -> Option<OptimumGradient> {
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
    let unit = program.program.objective_unit();
    let moved = moved(&mut program.program, &local.solution, &variables);
    let (model, horizon, program) = (program.model, program.horizon, &program.program);
    let units: Vec<f64> = variables.iter().map(|&i| program.unit(i)).collect();
    let ranges = moved.iter().zip(&units);
    let ranges = ranges.map(|(moved, unit)| range(program, moved, *unit));
    let ranges = ranges.collect();
    let objective = moved.iter().zip(&units);
    let final_time = moved.iter().zip(&units).map(|(moved, own)| {
        let x = moved.x.as_ref()?;
        Some(x[horizon] * program.unit(horizon) / own)
    });
    let parameters = model.declaration().parameters;
    Some(OptimumGradient {
        names: indices.iter().map(|&i| parameters[i].name).collect(),
        objective: objective
            .map(|(moved, own)| moved.objective * unit / own)
            .collect(),
        final_time: final_time.collect(),
        ranges,
        parameters: indices,
    })
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
