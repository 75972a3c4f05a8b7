//! Programs whose objective has no bound are called so, and none is that has one.

use hangtime_solver::mpcc::Stationarity;
use hangtime_solver::nl::{Solution, Status};

use crate::nl_texts::{program, solve};

/// Objectives that fall for ever with `x0`, in prefix notation.
const OBJECTIVES: [&str; 4] = ["o16 v0", "o16 o5 v0 n2", "o16 o5 v0 n3", "o2 n-2 v0"];

/// `exp (k x0)`, `cosh (k x0)` and `x0 exp (k x0)`: at least 1 from the start on, and beyond 1e20 soon.
fn growing(k: &str) -> [String; 3] {
    [
        format!("o44 o2 n{k} v0"),
        format!("o45 o2 n{k} v0"),
        format!("o2 v0 o44 o2 n{k} v0"),
    ]
}

fn is_unbounded(what: &str, solution: &Solution) {
    assert_eq!(solution.status, Status::Unbounded, "{what}: {solution:?}");
    assert_eq!(solution.stationarity, Stationarity::None, "{what}");
    assert_eq!(solution.second_order, None, "{what}");
}

#[test]
fn row_that_outgrows_its_multiplier_bounds_nothing() {
    for objective in OBJECTIVES {
        for k in ["0.4", "2.1"] {
            for row in growing(k) {
                let rest = "x1\n0 1.3\nr\n2 1.0\nb\n3\n";
                let solution = solve(&program((1, 1), &[&row], objective, rest));
                is_unbounded(&format!("{objective}, {row}"), &solution);
                // the same of the other sign
                let rest = "x1\n0 1.3\nr\n1 -1.0\nb\n3\n";
                let row = format!("o16 {row}");
                let solution = solve(&program((1, 1), &[&row], objective, rest));
                is_unbounded(&format!("{objective}, {row}"), &solution);
            }
        }
    }
}

#[test]
fn row_that_outgrows_its_multiplier_bounds_nothing_beside_complementarity() {
    for objective in OBJECTIVES {
        for row in growing("0.45") {
            let what = format!("{objective}, {row}");
            // x0 and x1 complement each other beside it
            let rest = "x2\n0 1.3\n1 0.5\nr\n2 1.0\n5 1 1\nb\n2 0.0\n2 0.0\n";
            is_unbounded(
                &what,
                &solve(&program((2, 2), &[&row, "v1"], objective, rest)),
            );
            // it complements x1 itself
            let rest = "x2\n0 1.3\n1 0.5\nr\n5 1 2\nb\n3\n2 0.0\n";
            is_unbounded(&what, &solve(&program((2, 1), &[&row], objective, rest)));
            // three rows, of which two grow
            let second = format!("o0 {row} v1");
            let rest = "x2\n0 1.3\n1 0.5\nr\n2 1.0\n2 0.5\n5 1 1\nb\n2 0.0\n2 0.0\n";
            let rows = [&row[..], &second, "v1"];
            is_unbounded(&what, &solve(&program((2, 3), &rows, objective, rest)));
        }
    }
}

#[test]
fn variable_that_measures_a_growing_row_is_no_bound() {
    // s = c(x) of which s >= 1 is asked
    for objective in OBJECTIVES {
        for row in growing("0.45") {
            let row = format!("o1 {row} v1");
            let rest = "x2\n0 1.3\n1 5\nr\n4 0.0\nb\n3\n2 1.0\n";
            let solution = solve(&program((2, 1), &[&row], objective, rest));
            is_unbounded(&format!("{objective}, {row}"), &solution);
        }
    }
}

#[test]
fn ray_may_need_several_variables_at_once() {
    // min -x0 - x1 + (x0 - 2 x1)^2 where exp(x0) >= 1 and x0 - 2 x1 = 3
    let objective = "o0 o16 o0 v0 v1 o5 o1 v0 o2 n2 v1 n2";
    let rows = ["o44 v0", "o1 v0 o2 n2 v1"];
    let rest = "x2\n0 4\n1 0.5\nr\n2 1.0\n4 3.0\nb\n3\n3\n";
    is_unbounded("line", &solve(&program((2, 2), &rows, objective, rest)));
}

#[test]
fn far_bounds_and_objectives_that_level_off_are_bounds() {
    let is_bounded = |what: &str, text: &str| {
        let solution = solve(text);
        assert_ne!(solution.status, Status::Unbounded, "{what}");
        solution
    };
    for row in growing("0.4") {
        // what ends the ray: x0^2 <= 4e6, sin-like rows, a bound, a complement
        let rest = "x1\n0 1.3\nr\n2 1.0\n1 4e6\nb\n3\n";
        let text = program((1, 2), &[&row, "o5 v0 n2"], "o16 v0", rest);
        is_bounded("x0^2 <= 4e6", &text);
        let rest = "x1\n0 1.3\nr\n2 1.0\nb\n1 700\n";
        let solution = is_bounded("x0 <= 700", &program((1, 1), &[&row], "o16 v0", rest));
        // solved only where it is
        if solution.status.is_solved() {
            assert!((solution.x[0] - 700.0).abs() < 1e-3, "{solution:?}");
        }
    }
    // exp(-x0) and x0 / (1 + |x0|) fall for ever, to a limit
    for objective in ["o44 o16 v0", "o16 o3 v0 o0 n1 o15 v0"] {
        let rest = "x1\n0 1.3\nr\n2 1.0\nb\n3\n";
        is_bounded(objective, &program((1, 1), &["o44 v0"], objective, rest));
    }
    // the row x0 - 1e-9 x1 <= 1 ends the way of x0, not near
    let rest = "x2\n0 0.5\n1 1\nr\n1 1.0\nb\n3\n0 0.0 1.0\n";
    let row = "o1 v0 o2 n1e-9 v1";
    let solution = is_bounded("tilted", &program((2, 1), &[row], "o16 v0", rest));
    assert!(solution.status.is_solved() && (solution.x[0] - 1.0).abs() < 1e-6);
}
