//! What the distances that the method keeps cost a plan.

use crate::yardstick;
use hangtime_solver::nlp;

use crate::model::{Function, contact_point};
use crate::ocp::collocation::layout::{Kept, Phase};
use crate::ocp::collocation::program::Collocation;
use crate::ocp::motion::targets::goals_hold;
use crate::ocp::solution::Margin;

/// The distances that cost something, to first order, the dearest first.
pub(super) fn margins(program: &Collocation, solution: &nlp::Solution) -> Vec<Margin> {
    let unit = program.program.objective_unit;
    let size = program.program.size_of(solution.objective);
    let x = program.program.physical(&solution.x);
    let of_row = |row: usize| (solution.multipliers[row], program.program.row_unit(row));
    let kept = program.distances.iter();
    let kept = kept.filter(|distance| !is_asked_for(program, &x, &distance.kept));
    let costs = kept.map(|distance| {
        let (multiplier, own) = match distance.kept {
            Kept::Row(row) | Kept::Settling { row, .. } => of_row(row),
            Kept::Variable(variable) => (
                solution.multipliers_lower[variable],
                program.program.unit(variable),
            ),
        };
        let amount = match &distance.kept {
            Kept::Settling { impulse, .. } => {
                impulse.iter().map(|(part, factor)| factor * x[*part]).sum()
            }
            Kept::Row(_) | Kept::Variable(_) => distance.amount,
        };
        Margin {
            name: distance.name.clone(),
            amount,
            unit: distance.unit.clone(),
            cost: (multiplier * amount / own * unit).abs(),
            chosen: distance.chosen,
        }
    });
    let counts = |margin: &Margin| {
        let share = if margin.chosen {
            yardstick::NOTHING
        } else {
            yardstick::PROMISE
        };
        margin.cost > share * size
    };
    let mut margins: Vec<Margin> = costs.filter(counts).collect();
    margins.sort_by(|a, b| b.cost.total_cmp(&a.cost));
    margins
}

/// Whether it is the scene that asks for it: a contact comes to rest in the last interval and stays until the end, where goals hold it
/// at rest.
fn is_asked_for(program: &Collocation, x: &[f64], kept: &Kept) -> bool {
    let (Kept::Settling { row, contact, .. }, Some(last)) = (kept, program.phases.last()) else {
        return false;
    };
    let settles = |phase: &Phase| phase.settling.contains(&(*contact, *row));
    let Some(landed) = program.phases.iter().position(settles) else {
        return false;
    };
    let mut rest = program.phases[landed..].iter();
    if !rest.all(|phase| phase.interval == last.interval && phase.closed.contains(contact)) {
        return false;
    }
    let Some(stage) = last.stages.last() else {
        return false;
    };
    let input: Vec<f64> = stage
        .state
        .iter()
        .chain(&stage.drive)
        .map(|&i| x[i])
        .collect();
    let pattern = program.model.declaration().contacts[*contact]
        .jacobian
        .entries;
    let mut slopes = vec![0.0; pattern.len()];
    program
        .model
        .jacobian(Function::Contact(*contact), &input, &mut slopes);
    let mut gradient = vec![0.0; stage.state.len()];
    for (&(output, column), slope) in pattern.iter().zip(&slopes) {
        let (output, column) = (output as usize, column as usize);
        if output == contact_point::NORMAL_VELOCITY && column < gradient.len() {
            gradient[column] = *slope;
        }
    }
    let mut end: Vec<f64> = stage.state.iter().map(|&i| x[i]).collect();
    end.push(program.horizon_at(x));
    goals_hold(program.model, &end, &gradient)
}
