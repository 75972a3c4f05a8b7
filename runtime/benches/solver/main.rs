//! Times the nonlinear programming solver on scalable problems.
//!
//! `cargo bench -p hangtime --bench solver -- DIRECTORY` also writes the problems as text files, for
//! `compare_ipopt.py` beside this file, which solves the same problems and prints the ratios.

#[path = "../../tests/solver_support/mod.rs"]
mod solver_support;

mod problems;

use hangtime::nlp::{self, LinearSolver, NlpProblem, Settings};

/// CPU time of this thread in seconds, where the system tells it.
fn cpu_seconds() -> f64 {
    std::fs::read_to_string("/proc/thread-self/schedstat")
        .ok()
        .and_then(|text| text.split_whitespace().next()?.parse::<f64>().ok())
        .map_or(f64::NAN, |nanoseconds| 1e-9 * nanoseconds)
}

fn main() {
    let directory = std::env::args().skip(1).find(|a| !a.starts_with("--"));
    println!(
        "problem variables rows status iterations factorizations seconds linear objective violation"
    );
    for (name, text) in problems::problems() {
        if let Some(directory) = &directory {
            let path = std::path::Path::new(directory).join(format!("{name}.txt"));
            if let Err(error) = std::fs::write(&path, &text) {
                eprintln!("{}: {error}", path.display());
            }
        }
        let mut problem = solver_support::read_problems(&text).remove(0);
        for linear_solver in [LinearSolver::Pivoting, LinearSolver::Static] {
            let mut settings = Settings::default();
            settings.linear_solver = linear_solver;
            settings.maximum_iterations = 1000;
            settings.maximum_seconds = 120.0;
            let start = cpu_seconds();
            let result = nlp::solve(&mut problem, &settings);
            let seconds = cpu_seconds() - start;
            match result {
                Ok(s) => println!(
                    "{name} {} {} {:?} {} {} {:.4} {:.4} {:.10e} {:.1e}",
                    problem.variables(),
                    problem.constraints(),
                    s.status,
                    s.counts.iterations,
                    s.counts.factorizations,
                    seconds,
                    s.linear_seconds,
                    s.objective,
                    s.residuals.primal
                ),
                Err(error) => println!("{name} {error}"),
            }
        }
    }
}
