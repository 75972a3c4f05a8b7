//! The iteration log as text; the only file of the solver that formats for people.
//!
//! Columns, from the fields of [`IterationInfo`]:
//!
//! | column | meaning |
//! |---|---|
//! | `iter` | iteration number, `r` appended in the restoration phase |
//! | `objective` | unscaled objective; in the restoration phase that of its own problem |
//! | `inf_pr`, `inf_du`, `inf_co` | primal and dual infeasibility and complementarity, scaled |
//! | `lg(mu)`, `lg(sg)` | decimal logarithm of barrier and relaxation parameter |
//! | `\|\|d\|\|` | largest entry of the step |
//! | `lg(rg)` | decimal logarithm of the Hessian shift, `-` without |
//! | `alpha_du`, `alpha_pr` | dual and primal step length, with the letter of the acceptance |
//! | `ls`, `fa` | trial points, factorizations |
//!
//! # Examples
//! The log of a run as it happens, here into a buffer:
//!
//! ```
//! use hangtime::nlp::{self, ElementProblemBuilder, IterationInfo, Settings, Target, iteration_log};
//!
//! let mut builder = ElementProblemBuilder::new();
//! let x = builder.variable(1.0, f64::INFINITY, 3.0);
//! builder.linear(Target::Objective, 1.0, x);
//! let mut problem = builder.build()?;
//! let mut log = Vec::new();
//! iteration_log::write_heading(&mut log)?;
//! let mut observer = |info: &IterationInfo| iteration_log::write_line(&mut log, info).is_ok();
//! let solution = nlp::solve_from(&mut problem, &Settings::default(), None, Some(&mut observer))?;
//! assert!(solution.status.is_solved());
//! assert_eq!(String::from_utf8(log)?.lines().count(), 1 + solution.history.len());
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

use std::io::{self, Write};

use super::IterationInfo;

/// Writes the heading of the log.
///
/// # Errors
/// Those of the target.
pub fn write_heading(target: &mut dyn Write) -> io::Result<()> {
    writeln!(
        target,
        "  iter    objective   inf_pr   inf_du   inf_co lg(mu) lg(sg)    ||d||  lg(rg) alpha_du alpha_pr  ls fa"
    )
}

/// Writes one line of the log.
///
/// # Errors
/// Those of the target.
pub fn write_line(target: &mut dyn Write, info: &IterationInfo) -> io::Result<()> {
    let logarithm = |value: f64| {
        if value > 0.0 {
            format!("{:.1}", value.log10())
        } else {
            String::from("-")
        }
    };
    writeln!(
        target,
        "{:>5}{} {:>13.6e} {:.2e} {:.2e} {:.2e} {:>6} {:>6} {:.2e} {:>7} {:.2e} {:.2e}{} {:>2} {:>2}",
        info.iteration,
        if info.restoration { 'r' } else { ' ' },
        info.objective,
        info.primal_infeasibility,
        info.dual_infeasibility,
        info.complementarity,
        logarithm(info.barrier_parameter),
        logarithm(info.relaxation_parameter),
        info.step_norm,
        logarithm(info.hessian_shift),
        info.step_length_dual,
        info.step_length_primal,
        info.acceptance,
        info.trials,
        info.factorizations,
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn write_line_has_every_column_under_its_heading() {
        let mut text = Vec::new();
        let info = IterationInfo {
            iteration: 7,
            objective: 17.25,
            barrier_parameter: 1e-2,
            step_length_primal: 0.5,
            step_length_dual: 1.0,
            acceptance: 'f',
            trials: 2,
            factorizations: 1,
            ..IterationInfo::default()
        };
        write_heading(&mut text).unwrap();
        write_line(&mut text, &info).unwrap();
        insta::assert_snapshot!(String::from_utf8(text).unwrap(), @r"
          iter    objective   inf_pr   inf_du   inf_co lg(mu) lg(sg)    ||d||  lg(rg) alpha_du alpha_pr  ls fa
            7     1.725000e1 0.00e0 0.00e0 0.00e0   -2.0      - 0.00e0       - 1.00e0 5.00e-1f  2  1
        ");
    }
}
