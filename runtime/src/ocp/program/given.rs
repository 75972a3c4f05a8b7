//! What parameters that are unknowns decide of a motion: parts of its start, its length, and the laws of contacts.

use super::units::Units;
use crate::model::{Function, Given, Model, held};
use crate::ocp::problem::Problem;
use crate::program::kernel::Kernel;
use crate::program::laws::Laws;
use crate::program::sparse_program::Program;
use hangtime_solver::nlp::NlpProblem as _;

/// Bounds of what a row decides.
const FREE: (f64, f64) = (f64::NEG_INFINITY, f64::INFINITY);

/// Adds a row for each of the values that parameters decide, `value = f(p)`, and a variable for each that is a coefficient of
/// a law. `start` are the variables of `(q, v)` at the start.
pub(in crate::ocp) fn add(
    program: &mut Program,
    (model, problem): (&dyn Model, &Problem),
    (horizon, start): (usize, &[usize]),
    units: &Units,
) {
    for known in &problem.completed {
        let (k, variable) = (known.component, start[known.component]);
        let name = format!("{} by joints", program.variable_name(variable));
        let rest = known.by.iter();
        let rest = rest.map(|&(parameter, by)| by * program.guessed(start[parameter]));
        let value = problem.start()[k] - rest.sum::<f64>();
        let row = program.row_in(units.states[k], name, value, value);
        program.linear(row, variable, 1.0);
        for &(parameter, by) in &known.by {
            program.linear(row, start[parameter], -by);
        }
    }
    let Some(known) = model.held().filter(|held| !held.given.is_empty()) else {
        return;
    };
    let contacts = model.declaration().contacts;
    let guess: Vec<f64> = start.iter().map(|&i| program.guessed(i)).collect();
    let guess = held::given_at(model, &guess);
    let mut laws = Laws {
        restitution: vec![None; contacts.len()],
        friction: vec![None; contacts.len()],
    };
    let mut uses = Vec::with_capacity(guess.len());
    for (index, (given, guess)) in known.given.iter().zip(guess).enumerate() {
        let coefficient = |program: &mut Program, what: &str, contact: usize| {
            let name = format!("{what} of `{}` by parameters", contacts[contact].name);
            (program.variable(name.clone(), FREE, guess, 1.0), name, 1.0)
        };
        let (variable, name, unit) = match *given {
            Given::Start(k) if problem.completed.iter().any(|known| known.component == k) => {
                continue;
            }
            Given::Start(k) => {
                let name = format!("{} by parameters", program.variable_name(start[k]));
                (start[k], name, units.states[k])
            }
            Given::Horizon => (horizon, "final time by parameters".to_owned(), units.time),
            Given::Restitution(contact) => {
                let known = coefficient(program, "impact law", contact);
                laws.restitution[contact] = Some(known.0);
                known
            }
            Given::Friction(contact) => {
                let known = coefficient(program, "friction", contact);
                laws.friction[contact] = Some(known.0);
                known
            }
        };
        let row = program.row_in(unit, name, 0.0, 0.0);
        program.linear(row, variable, 1.0);
        uses.push((row, index, -1.0));
    }
    let (q, v) = start.split_at(start.len() / 2);
    program.block(
        &Kernel::Whole(Function::Given),
        [q, v, &[], &[]],
        None,
        uses,
    );
    program.set_laws(laws);
}
