//! Compares the complementarity method with a homotopy on problems from finite elements with switch detection.
//!
//! `cargo bench -p hangtime --bench fesd_mpcc` prints a table: each problem solved by the default settings, by the
//! default settings from a small barrier parameter (only useful for steps, whose guess is a simulation), and by a
//! Scholtes homotopy of nine separate solves. All three end with crossover and certificate, so that objectives are
//! those of exact points; the homotopy is not relaxed again. Words after `--` choose the problems
//! whose names contain one of them.

#[path = "../../../solver/benches/homotopy.rs"]
mod homotopy;
mod problems;
mod scenes;

use hangtime::mpcc::{self, Mpcc as _, Settings, Solution};
use hangtime::nlp::NlpProblem as _;
use homotopy::homotopy;
use problems::Case;

/// Barrier parameter of a start from a simulation.
const WARM: f64 = 1e-5;
/// Relative difference up to which objectives are the same: crossovers solve their programs to 1e-8.
const SAME: f64 = 1e-6;
/// The same in units of the weight of the step equilibration: what it costs that one element is twice as long as the
/// others. Objectives that differ by less differ in where elements end, not in the motion.
const EQUILIBRATION: f64 = 3e-4;

fn solve(case: &Case, settings: &Settings) -> Result<Solution, Box<dyn std::error::Error>> {
    Ok(mpcc::solve(&mut case.program()?, settings)?)
}

fn cells(solution: &Solution) -> String {
    let outcome = if solution.status.is_solved() {
        format!("{:.7}", solution.objective)
    } else {
        format!("{}", solution.status)
    };
    let (all, exact) = (solution.iterations, solution.crossover_iterations);
    format!("{all} ({exact}) | {outcome}")
}

/// Iterations and quality of a column against the homotopy.
#[derive(Default)]
struct Total {
    problems: usize,
    solved: usize,
    /// Solved by both: iterations of this column and of the homotopy, and how often the objective is at
    /// least as good.
    both: usize,
    iterations: usize,
    homotopy: usize,
    as_good: usize,
    close: usize,
}

impl Total {
    fn add(&mut self, solution: &Solution, homotopy: &Solution) {
        self.problems += 1;
        self.solved += usize::from(solution.status.is_solved());
        if solution.status.is_solved() && homotopy.status.is_solved() {
            self.both += 1;
            self.iterations += solution.iterations;
            self.homotopy += homotopy.iterations;
            let (a, b) = (solution.objective, homotopy.objective);
            let scale = b.abs().max(1.0);
            self.as_good += usize::from(a <= b + SAME * scale);
            self.close += usize::from(a <= b + EQUILIBRATION * scale);
        }
    }

    fn print(&self, name: &str) {
        println!(
            "{name}: {} of {} solved; on the {} that the homotopy solves too {} iterations against {} \
             ({:.0} %), objective the same or better on {} to 1e-6, on {} to 3e-4",
            self.solved,
            self.problems,
            self.both,
            self.iterations,
            self.homotopy,
            100.0 * self.iterations as f64 / self.homotopy.max(1) as f64,
            self.as_good,
            self.close,
        );
    }
}

fn row(case: &Case, totals: &mut [Total; 3]) -> Result<(), Box<dyn std::error::Error>> {
    let homotopy = homotopy(&mut case.program()?)?;
    let default = solve(case, &Settings::default())?;
    totals[0].add(&default, &homotopy);
    let warm = if case.is_step() {
        let mut settings = Settings::default();
        settings.interior_point.initial_barrier_parameter = WARM;
        let solution = solve(case, &settings)?;
        totals[1].add(&solution, &homotopy);
        cells(&solution)
    } else {
        "- | -".into()
    };
    totals[2].add(&homotopy, &homotopy);
    let program = case.program()?;
    println!(
        "| {} | {}, {}, {} | {:?} | {} | {warm} | {} |",
        case.name,
        program.variables(),
        program.constraints(),
        program.complementarities().len(),
        default.rule,
        cells(&default),
        cells(&homotopy),
    );
    Ok(())
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    println!(
        "| problem | variables, rows, pairs | rule | default: iterations (crossover) | objective | from 1e-5: \
         iterations (crossover) | objective | homotopy: iterations (crossover) | objective |"
    );
    println!("|---|{}", "---|".repeat(8));
    let mut totals = [Total::default(), Total::default(), Total::default()];
    // the harness of cargo passes `--bench`
    let wanted: Vec<String> = std::env::args()
        .skip(1)
        .filter(|a| !a.starts_with('-'))
        .collect();
    let is_wanted = |case: &Case| wanted.is_empty() || wanted.iter().any(|w| case.name.contains(w));
    for case in problems::cases().into_iter().filter(is_wanted) {
        row(&case, &mut totals)?;
    }
    println!();
    for (total, name) in totals
        .iter()
        .zip(["default", "from 1e-5 (steps)", "homotopy"])
    {
        total.print(name);
    }
    Ok(())
}
