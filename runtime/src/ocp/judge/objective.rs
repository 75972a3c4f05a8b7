//! The objective of the re-simulated motion, where it reads neither forces nor impulses.
//!
//! A plan adds up its running cost at the stages of its elements, which may be too coarse for it although the end of the motion agrees.
//! So the cost is added up once more along the event-driven motion ([`Dense`]): the integral of each step is that of Gauss and Legendre with
//! four points. With `h` between instants this errs by `O(h^6)`. What every second instant gives tells the error: that is no difference from
//! the plan.

use super::dense::Dense;
use crate::model::{Function, Model};
use crate::ocp::motion::control_grid::ControlGrid;
use crate::simulation::Simulation;
use crate::yardstick;

/// Share of that by which the error of the sum may be off.
const TELLS: f64 = 0.1;

/// How many times as large the error is with half as many instants: `2^6`, less the error itself.
const COARSER: f64 = 63.0;

/// Nodes and weights on `[-1, 1]` of the rule of Gauss and Legendre with four points (Abramowitz and Stegun, table 25.4).
const GAUSS: [(f64, f64); 4] = [
    (-0.861_136_311_594_052_6, 0.347_854_845_137_453_85),
    (-0.339_981_043_584_856_26, 0.652_145_154_862_546_1),
    (0.339_981_043_584_856_26, 0.652_145_154_862_546_1),
    (0.861_136_311_594_052_6, 0.347_854_845_137_453_85),
];

/// The objective of a re-simulation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Replayed {
    pub(super) cost: f64,
    /// Difference from that of the plan, as a share of what is let pass.
    pub(super) departure: f64,
    /// Whether its instants are too far apart to tell so small a difference.
    pub(super) is_coarse: bool,
}

/// The objective along a re-simulation under `controls`, beside that of its plan, and the unit of both: of one that vanishes as squares do the
/// square of what is let pass is let pass. None where it reads what contacts do, or nothing was simulated.
pub(super) fn replayed(
    model: &dyn Model,
    controls: &ControlGrid,
    replay: &Simulation,
    (planned, unit): (f64, f64),
) -> Option<Replayed> {
    let declaration = model.declaration();
    let declared = declaration.optimal_control?;
    let ends_at = 2 * declaration.coordinates.len() + 1;
    let runs = declared.running_cost && declared.path_jacobian.reads(0, declaration.inputs());
    let ends = declared.final_cost && declared.terminal_jacobian.reads(0, ends_at);
    let motion = &replay.trajectory;
    let (q, v, time) = (motion.q.last()?, motion.v.last()?, *motion.time.last()?);
    if runs || ends || !(declared.running_cost || declared.final_cost) {
        return None;
    }
    let (mut cost, mut size, mut error) = (0.0, 0.0, 0.0);
    if declared.running_cost {
        let dense = Dense::new(model, controls, replay);
        let (every, second) = (1, 2);
        (cost, size) = integral(&dense, every);
        let (coarser, _) = integral(&dense, second);
        error = (cost - coarser).abs() / COARSER;
    }
    if declared.final_cost {
        let mut z = [&q[..], v, &[time]].concat();
        z.resize(declaration.terminal_inputs(), 0.0);
        let mut values = vec![0.0; declared.terminal_functions()];
        model.values(Function::Terminal, &z, &mut values);
        cost += values[0];
        size += values[0].abs();
    }
    let difference = (cost - planned).abs() - error;
    let same = yardstick::PROMISE * size.max(yardstick::PROMISE * unit);
    let departure = if difference > 0.0 {
        difference / same
    } else {
        0.0
    };
    Some(Replayed {
        cost,
        departure,
        is_coarse: error > TELLS * same,
    })
}

/// The integrals of the running cost and of its absolute value over a motion, from one in so many of its instants.
fn integral(dense: &Dense, one_in: usize) -> (f64, f64) {
    let (mut sum, mut absolute) = (0.0, 0.0);
    for step in &dense.steps(one_in) {
        for (node, weight) in GAUSS {
            let (middle, half) = (0.5 * (step.from + step.to), 0.5 * (step.to - step.from));
            let x = dense.input(step, middle + half * node);
            let value = half * weight * dense.path_functions(&x)[0];
            sum += value;
            absolute += value.abs();
        }
    }
    (sum, absolute)
}
