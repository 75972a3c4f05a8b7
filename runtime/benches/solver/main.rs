//! Times and counts of the solvers.
//!
//! ```text
//! cargo bench -p hangtime --bench solver -- [nlp [NAME|all [TIMES [pivoting|static]]]|text DIRECTORY|strategies|scaling|mpcc [NAME]]
//! ```
//!
//! `nlp` solves the nonlinear programs, or one of them, the given number of times, with one factorization or with both; `text` writes them as text after checking that the text says
//! the same. `compare_ipopt.py` beside this file calls both and solves the same programs by IPOPT in the same run.

#[path = "../../tests/solver_support/mod.rs"]
mod solver_support;

mod agreement;
mod problems;
mod timed;

use cpu_time::ThreadTime;
use hangtime::mpcc::{self, RelaxationRule};
use hangtime::nlp::{self, BarrierStrategy, LinearSolver, NlpProblem, Settings};
use problems::Stated;
use timed::Timed;

fn main() {
    let arguments: Vec<String> = std::env::args()
        .skip(1)
        .filter(|a| !a.starts_with("--"))
        .collect();
    let word = |k: usize| arguments.get(k).map(String::as_str);
    match word(0) {
        Some("nlp") => nonlinear_programs(
            word(1).filter(|&name| name != "all"),
            word(2).and_then(|k| k.parse().ok()).unwrap_or(5),
            word(3),
        ),
        Some("text") => write_texts(word(1).unwrap_or(".")),
        Some("strategies") => strategies(),
        Some("scaling") => scaling(),
        Some("mpcc") => complementarity_problems(word(1)),
        _ => {
            nonlinear_programs(None, 5, None);
            scaling();
            complementarity_problems(None);
        }
    }
}

/// Columns of [`run`].
const HEADING: &str = "problem variables rows factorization status iterations factorizations cpu start evaluation linear rest objective violation";

/// Solves one problem `times` times and prints the line of the fastest run: CPU seconds in all, of evaluations, of
/// factorizations and solves, and of everything else; `start` are those of a run without iterations, analysis of the
/// pattern included.
fn run(stated: Stated, times: usize, linear_solver: LinearSolver) {
    let name = stated.name;
    let mut problem = Timed::new(stated.problem);
    let mut settings = Settings::default();
    settings.linear_solver = linear_solver;
    settings.maximum_iterations = 1000;
    settings.maximum_seconds = 120.0;
    let mut best: Option<(f64, String)> = None;
    for _ in 0..times {
        let mut without = settings.clone();
        without.maximum_iterations = 0;
        let clock = ThreadTime::now();
        let _ = nlp::solve(&mut problem, &without);
        let start = clock.elapsed().as_secs_f64();
        problem.seconds = 0.0;
        let clock = ThreadTime::now();
        let result = nlp::solve(&mut problem, &settings);
        let seconds = clock.elapsed().as_secs_f64();
        let line = match result {
            Ok(s) => format!(
                "{} {} {linear_solver:?} {:?} {} {} {seconds:.5} {start:.5} {:.5} {:.5} {:.5} {:.10e} {:.1e}",
                problem.variables(),
                problem.constraints(),
                s.status,
                s.counts.iterations,
                s.counts.factorizations,
                problem.seconds,
                s.linear_seconds,
                seconds - problem.seconds - s.linear_seconds,
                s.objective,
                s.residuals.primal
            ),
            Err(error) => error.to_string(),
        };
        if best.as_ref().is_none_or(|(least, _)| seconds < *least) {
            best = Some((seconds, line));
        }
    }
    if let Some((_, line)) = best {
        println!("{name} {line}");
    }
}

fn nonlinear_programs(only: Option<&str>, times: usize, factorization: Option<&str>) {
    println!("{HEADING}");
    for (name, make) in problems::problems() {
        if only.is_none_or(|only| only == name) {
            if factorization != Some("static") {
                run(make(), times, LinearSolver::Pivoting);
            }
            if factorization != Some("pivoting") {
                run(make(), times, LinearSolver::Static);
            }
        }
    }
}

fn write_texts(directory: &str) {
    for (_, make) in problems::problems() {
        let mut stated = make();
        let mut read = solver_support::read_problems(&stated.text).remove(0);
        agreement::assert_same(&mut stated.problem, &mut read);
        let path = std::path::Path::new(directory).join(format!("{}.txt", stated.name));
        match std::fs::write(&path, &stated.text) {
            Ok(()) => println!("{}", path.display()),
            Err(error) => eprintln!("{}: {error}", path.display()),
        }
    }
}

/// Iterations and CPU seconds over the Hock-Schittkowski problems and the larger ones, with and without the parts of the
/// method that can be left out.
fn strategies() {
    let settings = |barrier_strategy, watchdog_steps, soft_restoration_steps| {
        let mut settings = Settings::default();
        settings.barrier_strategy = barrier_strategy;
        settings.watchdog_steps = watchdog_steps;
        settings.soft_restoration_steps = soft_restoration_steps;
        settings.maximum_iterations = 1000;
        settings.maximum_seconds = 60.0;
        settings
    };
    let text = include_str!("../../tests/data/hock_schittkowski.txt");
    println!(
        "strategy watchdog soft | solved iterations of 158 | solved iterations cpu of the larger ones | failures"
    );
    for (strategy, watchdog, soft) in [
        (BarrierStrategy::Monotone, 0, 0),
        (BarrierStrategy::Monotone, 10, 0),
        (BarrierStrategy::Monotone, 0, 10),
        (BarrierStrategy::Monotone, 10, 10),
        (BarrierStrategy::Adaptive, 0, 0),
        (BarrierStrategy::Adaptive, 10, 10),
    ] {
        let settings = settings(strategy, watchdog, soft);
        let mut failures = Vec::new();
        let mut total = |name: &str, problem: &mut dyn NlpProblem| -> (usize, usize, String) {
            match nlp::solve(problem, &settings) {
                Ok(s) if s.status.is_solved() => {
                    (1, s.counts.iterations, format!("{:.9e}", s.objective))
                }
                Ok(s) => {
                    failures.push(format!("{name}: {}", s.status));
                    (0, 0, String::new())
                }
                Err(error) => {
                    failures.push(format!("{name}: {error}"));
                    (0, 0, String::new())
                }
            }
        };
        let (mut small, mut large) = ((0, 0), (0, 0));
        for mut problem in solver_support::read_problems(text) {
            let name = problem.name.clone();
            let (solved, iterations, _) = total(&name, &mut problem);
            small = (small.0 + solved, small.1 + iterations);
        }
        let mut seconds = 0.0;
        let mut each = Vec::new();
        for (name, make) in problems::problems() {
            let mut problem = make().problem;
            let clock = ThreadTime::now();
            let (solved, iterations, objective) = total(name, &mut problem);
            seconds += clock.elapsed().as_secs_f64();
            large = (large.0 + solved, large.1 + iterations);
            each.push(format!("{name} {iterations} {objective}"));
        }
        println!(
            "{strategy:?} {watchdog} {soft} | {} {} | {} {} {seconds:.2} | {}",
            small.0,
            small.1,
            large.0,
            large.1,
            failures.join("; ")
        );
        println!("    {}", each.join(", "));
    }
}

fn scaling() {
    println!("{HEADING}");
    for intervals in [4_000, 8_000, 16_000, 32_000, 66_000] {
        for linear_solver in [LinearSolver::Pivoting, LinearSolver::Static] {
            run(
                problems::van_der_pol("van_der_pol", intervals),
                3,
                linear_solver,
            );
        }
    }
    for unknowns in [12_500, 25_000, 50_000, 100_000, 200_000] {
        for linear_solver in [LinearSolver::Pivoting, LinearSolver::Static] {
            run(problems::banded(unknowns), 3, linear_solver);
        }
    }
}

fn complementarity_problems(only: Option<&str>) {
    println!(
        "problem rule status iterations crossover factorizations objective complementarity cpu"
    );
    let texts = [
        include_bytes!("../../tests/data/mpcc_finite_elements.txt.gz").as_slice(),
        include_bytes!("data/finite_elements.txt.gz"),
    ];
    for problem in texts
        .iter()
        .flat_map(|text| solver_support::read_problems(&solver_support::unpack(text)))
        .filter(|problem| only.is_none_or(|only| only == problem.name))
    {
        let mut homotopy = mpcc::Settings::default();
        homotopy.rules = vec![RelaxationRule::Homotopy];
        for settings in [mpcc::Settings::default(), homotopy] {
            let start = ThreadTime::now();
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
                    start.elapsed().as_secs_f64()
                ),
                Err(error) => println!("{} {error}", problem.name),
            }
        }
    }
}
