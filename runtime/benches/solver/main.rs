//! Times and counts of the solvers.
//!
//! `cargo bench -p hangtime --bench solver -- [nlp|scaling|mpcc] [DIRECTORY]`. With a directory the nonlinear
//! programs are written there as text, for `compare_ipopt.py` beside this file, which solves the same ones.

#[path = "../../tests/solver_support/mod.rs"]
mod solver_support;

mod problems;
mod timed;

use hangtime::mpcc::{self, RelaxationRule};
use hangtime::nlp::{self, LinearSolver, NlpProblem, Settings};
use timed::{Timed, cpu_seconds};

fn main() {
    let arguments: Vec<String> = std::env::args()
        .skip(1)
        .filter(|a| !a.starts_with("--"))
        .collect();
    let wants = |name: &str| {
        let named = ["nlp", "scaling", "mpcc"];
        arguments.iter().any(|a| a == name)
            || !arguments.iter().any(|a| named.contains(&a.as_str()))
    };
    let directory = arguments.iter().find(|a| a.contains('/'));
    if wants("nlp") {
        nonlinear_programs(directory);
    }
    if wants("scaling") {
        scaling();
    }
    if wants("mpcc") {
        complementarity_problems();
    }
}

/// Solves one problem and prints its line: CPU seconds in all, the share of evaluations in the time, and the
/// share of linear algebra in the rest.
fn run(name: &str, text: &str, linear_solver: LinearSolver) {
    let mut problem = Timed::new(solver_support::read_problems(text).remove(0));
    let mut settings = Settings::default();
    settings.linear_solver = linear_solver;
    settings.maximum_iterations = 1000;
    settings.maximum_seconds = 120.0;
    let start = cpu_seconds();
    let result = nlp::solve(&mut problem, &settings);
    let seconds = cpu_seconds() - start;
    match result {
        Ok(s) => println!(
            "{name} {} {} {linear_solver:?} {:?} {} {} {seconds:.4} {:.2} {:.2} {:.10e} {:.1e}",
            problem.variables(),
            problem.constraints(),
            s.status,
            s.counts.iterations,
            s.counts.factorizations,
            // shares of wall-clock time, which a loaded machine stretches alike
            problem.seconds / s.seconds,
            s.linear_seconds / (s.seconds - problem.seconds),
            s.objective,
            s.residuals.primal
        ),
        Err(error) => println!("{name} {error}"),
    }
}

const HEADING: &str = "problem variables rows factorization status iterations factorizations cpu evaluation_share linear_share_of_rest objective violation";

fn nonlinear_programs(directory: Option<&String>) {
    println!("{HEADING}");
    for (name, text) in problems::problems() {
        if let Some(directory) = directory {
            let path = std::path::Path::new(directory).join(format!("{name}.txt"));
            if let Err(error) = std::fs::write(&path, &text) {
                eprintln!("{}: {error}", path.display());
            }
        }
        for linear_solver in [LinearSolver::Pivoting, LinearSolver::Static] {
            run(&name, &text, linear_solver);
        }
    }
}

fn scaling() {
    println!("{HEADING}");
    for intervals in [4_000, 8_000, 16_000, 32_000, 66_000] {
        let (name, text) = problems::chain(intervals);
        run(&name, &text, LinearSolver::Pivoting);
        run(&name, &text, LinearSolver::Static);
    }
    for unknowns in [12_500, 25_000, 50_000, 100_000, 200_000] {
        let (name, text) = problems::banded(unknowns);
        run(&name, &text, LinearSolver::Pivoting);
        run(&name, &text, LinearSolver::Static);
    }
}

fn complementarity_problems() {
    println!(
        "problem rule status iterations crossover factorizations objective complementarity cpu"
    );
    let texts = [
        include_str!("../../tests/data/mpcc_finite_elements.txt"),
        include_str!("data/finite_elements.txt"),
    ];
    for problem in texts
        .iter()
        .flat_map(|text| solver_support::read_problems(text))
    {
        let mut homotopy = mpcc::Settings::default();
        homotopy.rules = vec![RelaxationRule::Homotopy];
        for settings in [mpcc::Settings::default(), homotopy] {
            let start = cpu_seconds();
            match mpcc::solve(&mut problem.clone(), &settings) {
                Ok(s) => println!(
                    "{} {:?} {:?} {} {} {} {:.8e} {:.1e} {:.3}",
                    problem.name,
                    s.rule,
                    s.status,
                    s.iterations,
                    s.crossover_iterations,
                    s.factorizations,
                    s.objective,
                    s.residuals.complementarity,
                    cpu_seconds() - start
                ),
                Err(error) => println!("{} {error}", problem.name),
            }
        }
    }
}
