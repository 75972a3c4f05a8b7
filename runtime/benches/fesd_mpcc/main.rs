//! Compares the rules of the complementarity method on problems from finite elements with switch detection.
//!
//! `cargo bench -p hangtime --bench fesd_mpcc` prints a table: each problem solved by the default rules, by
//! the default rules from a small barrier parameter (only useful for steps, whose guess is a simulation),
//! and by a Scholtes homotopy of nine separate solves. All three end at `sigma = 1e-8` without crossover, so
//! that the columns count the same work; the last column is the status that the default settings, crossover
//! and certificate included, lead to.

mod problems;
mod scenes;

use hangtime::mpcc::{self, Mpcc as _, RelaxationRule, Settings, Solution, Status};
use hangtime::nlp::NlpProblem as _;
use hangtime::ocp::TimeFreezing;
use problems::Case;

/// Barrier parameter of a start from a simulation.
const WARM: f64 = 1e-5;
/// Violation and complementarity product of a solution.
const SOLVED: f64 = 1.1e-8;

/// One way to solve a problem.
struct Run {
    solution: Solution,
    /// Largest product of a pair.
    product: f64,
}

impl Run {
    fn new(case: &Case, settings: &Settings) -> Result<Self, Box<dyn std::error::Error>> {
        let mut program = case.program()?;
        let solution = mpcc::solve(&mut program, settings)?;
        let products = program.complementarities().iter();
        let product = products.map(|&(i, j)| solution.x[i] * solution.x[j]);
        Ok(Self {
            product: product.fold(0.0, f64::max),
            solution,
        })
    }

    fn solved(&self) -> bool {
        self.solution.residuals.primal.max(self.product) <= SOLVED
            && !matches!(self.solution.status, Status::Failed(_) | Status::Infeasible)
    }

    fn cells(&self) -> String {
        let outcome = if self.solved() {
            format!("{:.6}", self.solution.objective)
        } else {
            format!("{}", self.solution.status)
        };
        format!(
            "{} | {outcome} | {:.0e} | {:.0e}",
            self.solution.iterations, self.solution.residuals.primal, self.product
        )
    }
}

fn relaxed() -> Settings {
    let mut settings = Settings::default();
    settings.crossover = false;
    settings
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
    /// Within one per cent.
    close: usize,
}

impl Total {
    fn add(&mut self, run: &Run, homotopy: &Run) {
        self.problems += 1;
        self.solved += usize::from(run.solved());
        if run.solved() && homotopy.solved() {
            self.both += 1;
            self.iterations += run.solution.iterations;
            self.homotopy += homotopy.solution.iterations;
            let (a, b) = (run.solution.objective, homotopy.solution.objective);
            self.as_good += usize::from(a <= b + 1e-4 * b.abs().max(1.0));
            self.close += usize::from(a <= b + 1e-2 * b.abs().max(1.0));
        }
    }

    fn print(&self, name: &str) {
        println!(
            "{name}: {} of {} solved; on the {} that the homotopy solves too {} iterations against {} \
             ({:.0} %), objective as good (to 1e-4) on {}, within 1 % on {}",
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
    let mut homotopy = relaxed();
    homotopy.rules = vec![RelaxationRule::Homotopy];
    let homotopy = Run::new(case, &homotopy)?;
    let default = Run::new(case, &relaxed())?;
    totals[0].add(&default, &homotopy);
    let warm = if case.is_step() {
        let mut settings = relaxed();
        settings.interior_point.initial_barrier_parameter = WARM;
        let run = Run::new(case, &settings)?;
        totals[1].add(&run, &homotopy);
        run.cells()
    } else {
        "- | - | - | -".into()
    };
    totals[2].add(&homotopy, &homotopy);
    let certified = Run::new(case, &Settings::default())?;
    let program: TimeFreezing<'_> = case.program()?;
    println!(
        "| {} | {} | {} | {} | {} | {warm} | {} | {} ({}) |",
        case.name,
        program.variables(),
        program.complementarities().len(),
        program.constraints(),
        default.cells(),
        homotopy.cells(),
        certified.solution.status,
        certified.solution.iterations,
    );
    Ok(())
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    println!(
        "| problem | variables | pairs | rows | default: iterations | objective | primal | product | warm: \
         iterations | objective | primal | product | homotopy: iterations | objective | primal | product | \
         with crossover (iterations) |"
    );
    println!("|---|{}", "---|".repeat(16));
    let mut totals = [Total::default(), Total::default(), Total::default()];
    for case in problems::cases() {
        row(&case, &mut totals)?;
    }
    println!();
    for (total, name) in totals.iter().zip(["default", "warm (steps)", "homotopy"]) {
        total.print(name);
    }
    Ok(())
}
