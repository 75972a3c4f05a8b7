//! The protocol by which modelling languages call solvers.

use crate::nlp::file;
use crate::support::{Said, Scratch, hangtime, program, solved};

/// Runs the protocol on a program that is written first; the status, standard output and the `.sol` file.
fn answered(scratch: &Scratch, text: &str, options: &str) -> (Option<i32>, String, String) {
    let path = scratch.write("p.nl", text);
    let said = hangtime(&format!("{} -AMPL {options}", path.trim_end_matches(".nl")));
    (said.status, said.out, scratch.read("p.sol"))
}

fn number(sol: &str) -> usize {
    let line = sol.lines().find_map(|line| line.strip_prefix("objno 0 "));
    line.unwrap().parse().unwrap()
}

#[test]
fn ampl_answers_by_a_file_with_suffixes_a_log_and_status_0() {
    let scratch = Scratch::new("ampl");
    let (status, log, sol) = answered(&scratch, &file(0.0, "2 0", "3"), "");
    assert_eq!(status, Some(0));
    assert!(
        log.contains("inf_pr") && log.contains("hangtime: solved"),
        "{log}"
    );
    assert_eq!(number(&sol), 0);
    assert!(
        sol.contains("\nstationarity\n0 2\n") && sol.contains("ipopt_zL_out"),
        "{sol}"
    );
    let (_, log, _) = answered(&scratch, &file(0.0, "2 0", "3"), "print_level=0");
    assert_eq!(log, "");
}

#[test]
fn ampl_tells_limits_infeasible_and_refused_programs_by_their_numbers() {
    let scratch = Scratch::new("ampl-numbers");
    let (status, _, sol) = answered(&scratch, &file(3.0, "2 1", "1 1"), "");
    assert_eq!((status, number(&sol)), (Some(0), 200));
    let (status, _, sol) = answered(&scratch, &file(0.0, "2 0", "3"), "toll=1e-7");
    assert_eq!((status, number(&sol)), (Some(0), 500));
    assert!(
        sol.starts_with("hangtime: there is no option `toll`"),
        "{sol}"
    );
    // the first of the two variables is binary
    let whole = file(0.0, "2 0", "3").replacen("0 0 0 0 0", "1 0 0 0 0", 1);
    let (status, log, sol) = answered(&scratch, &whole, "");
    assert_eq!((status, number(&sol)), (Some(0), 500));
    assert!(
        sol.contains("whole number") && log.contains("whole number"),
        "{sol}"
    );
    // log x has no value at the start 0 of a free variable
    let outside = file(0.0, "3", "3").replace("o5\no1\nv0\nn2\nn2", "o43\no5\nv0\nn2");
    let (status, _, sol) = answered(&scratch, &outside, "");
    assert_eq!((status, number(&sol)), (Some(0), 500));
}

#[test]
fn ampl_takes_options_from_the_environment_and_then_from_the_line() {
    let scratch = Scratch::new("ampl-environment");
    let path = scratch.write("p.nl", file(0.0, "2 0", "3"));
    let run = |words: &[&str]| {
        let mut command = program();
        let command = command.args([&path, "-AMPL"]).args(words);
        let said = Said::by(command.env("hangtime_options", "print_level=0 max_iter=1"));
        assert_eq!(said.status, Some(0));
        (said.out.len(), number(&scratch.read("p.sol")))
    };
    let (printed, limited) = run(&[]);
    assert_eq!(printed, 0);
    assert!(limited >= 400, "{limited}");
    assert_eq!(run(&["max_iter=1000"]), (0, 0));
}

#[test]
fn ampl_is_told_the_version_and_the_options_before_it_solves() {
    // Pyomo calls a solver available if `-v` says a version.
    assert_eq!(
        solved("-v"),
        format!("hangtime {}\n", env!("CARGO_PKG_VERSION"))
    );
    let options = solved("-=");
    for name in ["tol ", "max_iter ", "warm_start ", "print_level "] {
        assert!(
            options.lines().any(|line| line.starts_with(name)),
            "{options}"
        );
    }
}
