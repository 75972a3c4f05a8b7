//! A start from which rows and bounds hold.
//!
//! A relaxed run whose rows and bounds are far from holding at its start is led by its objective into stationary points of the
//! violation, be the pairs relaxed or not, though points that keep the rows lie near. Without pairs and objective they are found.

use super::Mpcc;
use super::watch::{Purpose, Watch};
use crate::linalg::norms::norm_inf;
use crate::nlp::{self, InputError, IterationInfo, Variant, violation};

/// Violation, scaled, up to which a start keeps the rows: further digits are left to the runs from there.
const KEPT: f64 = 1e-6;

/// A point near the start of a problem at which its rows and bounds hold, whatever the pairs do: on the way to the nearest one, where
/// the rows hold first. `None` where that comes to no such point, and where they hold at the start.
pub(crate) fn start_within_rows(
    problem: &mut dyn Mpcc,
    settings: &nlp::Settings,
    watch: &mut Watch<'_>,
) -> Result<Option<Vec<f64>>, InputError> {
    let mut own = vec![0.0; problem.variables()];
    problem.initial_point(&mut own);
    if keeps_rows(problem, &own) {
        return Ok(None);
    }
    let settings = nlp::Settings {
        tolerance: KEPT,
        constraint_tolerance: KEPT,
        // it is the pairs that take the rank from Jacobians
        permanent_dual_shift: 0.0,
        ..settings.clone()
    };
    let mut holds = false;
    let mut see = |info: &IterationInfo| {
        holds = !info.restoration && info.primal_infeasibility <= KEPT;
        !holds
    };
    let mut near = Variant::nearest(problem, &own);
    let found = watch.run(
        Purpose::Relaxed,
        &settings,
        &mut see,
        |settings, observer| nlp::solve_from(&mut near, settings, None, Some(observer)),
    )?;
    Ok((holds && watch.stop.is_none()).then_some(found.x))
}

/// Whether rows hold at a point, brought within its bounds.
fn keeps_rows(problem: &mut dyn Mpcc, x: &[f64]) -> bool {
    let (mut lower, mut upper) = (vec![0.0; x.len()], vec![0.0; x.len()]);
    problem.variable_bounds(&mut lower, &mut upper);
    let bounds = lower.iter().zip(&upper);
    let x: Vec<f64> = x
        .iter()
        .zip(bounds)
        .map(|(x, (lower, upper))| x.max(*lower).min(*upper))
        .collect();
    let weights = vec![1.0; problem.constraints()];
    let violation = violation(problem, &x, &weights);
    norm_inf(&violation) <= KEPT
}

#[cfg(test)]
mod tests {
    use super::super::{RelaxationRule, Settings, Status, solve};
    use crate::polynomials::{Polynomials, Sum};

    /// `min -100 x + a` s.t. `x^3 - 3 x + 3 = y`, `a - b = x`, `|y| <= 0.05`, `0 <= a _|_ b >= 0`, from `x = -1.1`. The first row
    /// can hold near -2.1 only, and has a stationary violation at 1, where the objective leads.
    fn cubic() -> Polynomials {
        let positive = (0.0, f64::INFINITY);
        let cubic: Sum = vec![(1.0, &[0, 0, 0]), (-3.0, &[0]), (3.0, &[]), (-1.0, &[1])];
        let difference: Sum = vec![(1.0, &[2]), (-1.0, &[3]), (-1.0, &[0])];
        Polynomials {
            bounds: vec![(-10.0, 10.0), (-0.05, 0.05), positive, positive],
            start: vec![-1.1, 0.0, 1.0, 1.0],
            objective: vec![(-100.0, &[0]), (1.0, &[2])],
            rows: vec![(0.0, 0.0, cubic), (0.0, 0.0, difference)],
            pairs: vec![(2, 3)],
        }
    }

    #[test]
    fn start_that_leads_into_a_stationary_violation_is_moved_to_where_the_rows_hold() {
        let one_rule = Settings {
            crossover: false,
            rules: vec![RelaxationRule::RollOff],
            ..Settings::default()
        };
        let led = solve(&mut cubic(), &one_rule).expect("a valid program");
        assert_eq!(led.status, Status::Infeasible);
        assert!((led.x[0] - 1.0).abs() < 1e-6);
        let solution = solve(&mut cubic(), &Settings::default()).expect("a valid program");
        assert!(solution.status.is_solved());
        // x = -2 cosh t solves x^3 - 3 x + q = 0 where 2 cosh 3 t = q; the largest x has y = 0.05
        let root = -2.0 * ((2.95_f64 / 2.0).acosh() / 3.0).cosh();
        assert!((solution.x[0] - root).abs() < 1e-8);
    }
}
