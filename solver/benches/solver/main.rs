//! Times and counts of the solvers.
//!
//! ```text
//! cargo bench -p hangtime-solver --bench solver -- [nlp [NAME|all [TIMES]]|text DIRECTORY|scaling|mpcc [NAME]]
//! ```
//!
//! `nlp` solves the nonlinear programs, or one of them, the given number of times; `text` writes
//! them as text. `compare_ipopt.py` beside this file calls both and solves the same programs by IPOPT in the same run.

#[path = "../../tests/solver_support/mod.rs"]
mod solver_support;

#[path = "../homotopy.rs"]
mod homotopy;
mod problems;

use cpu_time::ThreadTime;
use hangtime_solver::mpcc;
use hangtime_solver::nlp::{self, NlpProblem, Settings};
use problems::Stated;
use solver_support::TextProblem;

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
        ),
        Some("text") => write_texts(word(1).unwrap_or(".")),
        Some("scaling") => scaling(),
        Some("mpcc") => complementarity_problems(word(1)),
        _ => {
            nonlinear_programs(None, 5);
            scaling();
            complementarity_problems(None);
        }
    }
}

/// Columns of [`run`].
const HEADING: &str = "problem variables rows status iterations factorizations cpu start evaluation linear rest objective violation";

/// Solves one problem `times` times and prints the line of the fastest run: CPU seconds in all, of evaluations, of
/// factorizations and solves, and of everything else; `start` are those of a run without iterations, analysis of the
/// pattern included.
fn run(stated: Stated, times: usize) {
    let name = stated.name;
    let mut problem = solver_support::read_problems(&stated.text).remove(0);
    let mut settings = Settings::default();
    settings.maximum_iterations = 1000;
    settings.maximum_seconds = 120.0;
    let mut best: Option<(f64, String)> = None;
    for _ in 0..times {
        let mut without = settings.clone();
        without.maximum_iterations = 0;
        let clock = ThreadTime::now();
        let _ = nlp::solve(&mut problem, &without);
        let start = clock.elapsed().as_secs_f64();
        let clock = ThreadTime::now();
        let result = nlp::solve(&mut problem, &settings);
        let seconds = clock.elapsed().as_secs_f64();
        let line = match result {
            Ok(s) => format!(
                "{} {} {:?} {} {} {seconds:.5} {start:.5} {:.5} {:.5} {:.5} {:.10e} {:.1e}",
                problem.variables(),
                problem.constraints(),
                s.status,
                s.counts.iterations,
                s.counts.factorizations,
                s.cpu.evaluate,
                s.cpu.factorize + s.cpu.solve,
                seconds - s.cpu.evaluate - s.cpu.factorize - s.cpu.solve,
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

fn nonlinear_programs(only: Option<&str>, times: usize) {
    println!("{HEADING}");
    for (name, make) in problems::problems() {
        if only.is_none_or(|only| only == name) {
            run(make(), times);
        }
    }
}

fn write_texts(directory: &str) {
    for (_, make) in problems::problems() {
        let stated = make();
        let path = std::path::Path::new(directory).join(format!("{}.txt", stated.name));
        match std::fs::write(&path, &stated.text) {
            Ok(()) => println!("{}", path.display()),
            Err(error) => eprintln!("{}: {error}", path.display()),
        }
    }
}

fn scaling() {
    println!("{HEADING}");
    for intervals in [4_000, 8_000, 16_000, 32_000, 66_000] {
        run(problems::van_der_pol("van_der_pol", intervals), 3);
    }
    for unknowns in [12_500, 25_000, 50_000, 100_000, 200_000] {
        run(problems::banded(unknowns), 3);
    }
}

/// One way to solve a complementarity problem.
type Method = fn(&mut TextProblem) -> Result<mpcc::Solution, nlp::InputError>;

fn complementarity_problems(only: Option<&str>) {
    println!(
        "problem method status iterations crossover factorizations objective complementarity cpu"
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
        let by_rules = |problem: &mut TextProblem| mpcc::solve(problem, &mpcc::Settings::default());
        let by_homotopy = |problem: &mut TextProblem| homotopy::homotopy(problem);
        let methods: [(&str, Method); 2] = [("default", by_rules), ("homotopy", by_homotopy)];
        for (name, solve) in methods {
            let start = ThreadTime::now();
            match solve(&mut problem.clone()) {
                Ok(s) => println!(
                    "{} {name} {:?} {} {} {} {:.8e} {:.1e} {:.3}",
                    problem.name,
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
