//! What the distances that the method keeps cost a plan.

use hangtime_solver::nlp;

use crate::ocp::collocation::layout::Kept;
use crate::ocp::collocation::program::Collocation;
use crate::ocp::solution::Margin;

/// Share of the objective below which the cost of a margin that the caller chooses is none: multipliers are known to the
/// tolerance of the solver.
const CHOSEN: f64 = 1e-9;
/// The same of one that nobody asked for: above it a plan is another one than the optimum.
const OWN: f64 = 1e-6;

/// The distances that cost something, to first order, the dearest first.
pub(super) fn margins(program: &Collocation, solution: &nlp::Solution) -> Vec<Margin> {
    let unit = program.program.objective_unit();
    let size = program.program.size_of(solution.objective);
    let costs = program.distances.iter().map(|distance| {
        let (multiplier, own) = match distance.kept {
            Kept::Row(row) => (solution.multipliers[row], program.program.row_unit(row)),
            Kept::Variable(variable) => (
                solution.multipliers_lower[variable],
                program.program.unit(variable),
            ),
        };
        Margin {
            name: distance.name.clone(),
            amount: distance.amount,
            unit: distance.unit.clone(),
            cost: (multiplier * distance.amount / own * unit).abs(),
            chosen: distance.chosen,
        }
    });
    let counts = |margin: &Margin| {
        let share = if margin.chosen { CHOSEN } else { OWN };
        margin.cost > share * size
    };
    let mut margins: Vec<Margin> = costs.filter(counts).collect();
    margins.sort_by(|a, b| b.cost.total_cmp(&a.cost));
    margins
}
