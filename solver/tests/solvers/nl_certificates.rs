//! What is said of ends that are no solutions, or are more than stationary, and what a file gives to start from.

#![allow(clippy::unwrap_used, reason = "a failed step is a failed test")]

use hangtime_solver::mpcc::Stationarity;
use hangtime_solver::nl::{self, Options, Program, SecondOrder, Status};

use crate::nl_texts::{program, solve};

#[test]
fn cusp_has_no_multipliers_and_a_sharp_corner_has() {
    // max x where (a - x)^3 >= y >= 0: the gradient of the row is that of the bound at the solution x = a
    for a in ["1.5", "3"] {
        let row = format!("o1 o5 o1 n{a} v0 n3 v1");
        let rest = "x2\n0 0.5\n1 0.25\nr\n2 0.0\nb\n2 0.0\n2 0.0\n";
        let solution = solve(&program((2, 1), &[&row], "o16 v0", rest));
        assert_eq!(solution.status, Status::Uncertified, "{a}");
        assert_eq!(solution.stationarity, Stationarity::None);
        assert_eq!(solution.second_order, None);
        let diagnosis = solution.diagnosis().unwrap();
        assert!(
            diagnosis.contains("no multipliers were found"),
            "{diagnosis}"
        );
    }
    // a - x >= y instead: y = 1
    let rest = "x2\n0 0.5\n1 0.25\nr\n2 0.0\nb\n2 0.0\n2 0.0\n";
    let solution = solve(&program((2, 1), &["o1 o1 n3 v0 v1"], "o16 v0", rest));
    assert_eq!(solution.stationarity, Stationarity::S);
    assert_eq!(solution.second_order, Some(SecondOrder::Sufficient));
    assert!((solution.multipliers[0] + solution.multipliers[0].signum()).abs() > 1.0);
}

#[test]
fn second_order_word_tells_minimum_valley_inflection_and_descent_apart() {
    let row = |bounds: &str, start: &str| format!("x2\n0 {start}\n1 0.5\nr\n{bounds}\nb\n3\n3\n");
    let of = |body: &str, objective: &str, rest: String| {
        let solution = solve(&program((2, 1), &[body], objective, &rest));
        assert_eq!(solution.status, Status::Solved, "{objective}");
        solution.second_order.unwrap()
    };
    // (x - 1)^2 + y^2 on y = 0
    let bowl = "o0 o5 o1 v0 n1 n2 o5 v1 n2";
    assert_eq!(of("v1", bowl, row("4 0", "3")), SecondOrder::Sufficient);
    // y^2 on x + y = 2: flat along nothing; on y = 0 flat along x
    assert_eq!(
        of("o0 v0 v1", "o5 v1 n2", row("4 2", "3")),
        SecondOrder::Sufficient
    );
    assert_eq!(
        of("v1", "o5 v1 n2", row("4 0", "3")),
        SecondOrder::Necessary
    );
    // x y on x = y is x^2, on x = -y it is -x^2: from its saddle nothing leads away along the row y = 0 but flatness
    assert_eq!(
        of("o1 v0 v1", "o2 v0 v1", row("4 0", "3")),
        SecondOrder::Sufficient
    );
}

#[test]
fn inflection_is_no_strict_optimum_and_curvature_that_stays_is_one() {
    let word = |objective: &str, start: &str, bounds: &str| {
        let rest = format!("x2\n0 {start}\n1 0.5\nr\n4 0\nb\n{bounds}\n3\n");
        let solution = solve(&program((2, 1), &["v1"], objective, &rest));
        assert_eq!(solution.status, Status::Solved, "{objective}");
        solution.second_order.unwrap()
    };
    // a (x - b)^p, whose curvature vanishes together with the distance to b, apart from or within bounds
    for (factor, at, power, bounds) in [
        ("1", "0", 3, "3"),
        ("40", "-1.5", 3, "0 -3 9"),
        ("0.02", "0.7", 5, "0 -6 2.5"),
        ("7", "2", 7, "2 1"),
        ("3", "-0.25", 4, "3"),
    ] {
        let objective = format!("o2 n{factor} o5 o1 v0 n{at} n{power}");
        let found = word(&objective, "2.3", bounds);
        assert_ne!(found, SecondOrder::Sufficient, "{objective}");
        assert_ne!(found, SecondOrder::Descends, "{objective}");
    }
    // x^3 - 6 x^2 + 12 x, whose terms cancel
    let cancels = "o0 o5 v0 n3 o0 o2 n-6 o5 v0 n2 o2 n12 v0";
    assert_ne!(word(cancels, "4", "3"), SecondOrder::Sufficient);
    // a (x - b)^3 + c (x - b)^2, and a cosine: the curvature stays
    for (cubic, square, bounds) in [
        ("5", "0.01", "3"),
        ("-2", "300", "0 -2 5"),
        ("1", "1e-3", "3"),
    ] {
        let at = "o1 v0 n0.4";
        let objective = format!("o0 o2 n{cubic} o5 {at} n3 o2 n{square} o5 {at} n2");
        let found = word(&objective, "0.401", bounds);
        assert_eq!(found, SecondOrder::Sufficient, "{objective}");
    }
    assert_eq!(word("o46 v0", "2.5", "3"), SecondOrder::Sufficient);
}

#[test]
fn inflection_along_a_curved_row_is_no_strict_optimum() {
    // min y + w^2 where y >= a x^3 + c x^2
    let word = |cubic: f64, square: f64| {
        let row = format!("o54 3 v1 o2 n{} o5 v0 n3 o2 n{} o5 v0 n2", -cubic, -square);
        let rest = "x3\n0 0.9\n1 2\n2 0.3\nr\n2 0\nb\n0 -0.5 8\n3\n3\n";
        let solution = solve(&program((3, 1), &[&row], "o0 v1 o5 v2 n2", rest));
        assert_eq!(solution.status, Status::Solved);
        let is_inflection = square == 0.0 && solution.x[0].abs() < 0.1;
        (is_inflection, solution.second_order.unwrap())
    };
    let cubics = [0.3, 1.0, 5.0, 15.0];
    for cubic in cubics {
        assert_eq!(
            word(cubic, 25.0),
            (false, SecondOrder::Sufficient),
            "{cubic}"
        );
    }
    // the others pass the inflection and end at the bound
    let words: Vec<_> = cubics.map(|cubic| word(cubic, 0.0)).to_vec();
    assert!(words.iter().any(|word| word.0), "{words:?}");
    for (is_inflection, word) in words {
        assert_eq!(is_inflection, word != SecondOrder::Sufficient);
    }
}

#[test]
fn optimum_is_judged_in_the_units_of_its_variables() {
    let check = |what: &str, text: &str, best: f64| {
        let solution = solve(text);
        assert_eq!(solution.status, Status::Solved, "{what}: {solution:?}");
        let error = (solution.objective - best).abs();
        assert!(
            error < 1e-4 * best,
            "{what}: {} of {best}",
            solution.objective
        );
    };
    for (a, b, c) in [
        (3e-8, 2e7, 5.0),
        (4e-10, 1e9, 0.3),
        (2e9, 5e-10, 1.0),
        (1e-11, 7e10, 40.0),
    ] {
        let best = 2.0 * f64::sqrt(a * b * c);
        // min a x + b y where x y >= c, apart from a square, and a x + b c / x
        let rest = format!("x3\n0 1\n1 1\n2 0\nr\n2 {c}\nb\n2 0\n2 0\n3\n");
        let sum = format!("o54 3 o2 n{a:e} v0 o2 n{b:e} v1 o5 o1 v2 n3 n2");
        check(
            "product",
            &program((3, 1), &["o2 v0 v1"], &sum, &rest),
            best,
        );
        let sum = format!("o0 o2 n{a:e} v0 o3 n{:e} v0", b * c);
        check(
            "quotient",
            &program((1, 0), &[], &sum, "x1\n0 1\nb\n2 0\n"),
            best,
        );
    }
}

#[test]
fn valley_at_whose_end_curvature_changes_its_sign_is_not_said_to_descend() {
    // (y - a x^2)^2 and y^2 beside it: the curvature along x is -4 a (y - a x^2), of either sign beside the minimum
    for factor in ["1", "9"] {
        let valley = format!("o5 o1 v1 o2 n{factor} o5 v0 n2 n2");
        for start in ["0.1", "-0.2"] {
            let rest = format!("x2\n0 0\n1 {start}\nb\n3\n3\n");
            let solution = solve(&program((2, 0), &[], &valley, &rest));
            assert_eq!(solution.status, Status::Solved);
            let found = solution.second_order.unwrap();
            assert_ne!(found, SecondOrder::Descends, "{factor} from {start}");
            assert_ne!(found, SecondOrder::Sufficient, "{factor} from {start}");
        }
    }
}

#[test]
fn factor_of_the_objective_changes_neither_point_nor_verdict() {
    // x^2 + 2 y^2 where x + y >= 1, and exp(z) for z >= 0 or beside a pair z _|_ 2 - z - x
    let run = |factor: f64, pairs: usize| {
        let sum = format!("o2 n{factor:e} o54 3 o5 v0 n2 o2 n2 o5 v1 n2 o44 v2");
        let pair = if pairs > 0 { "5 1 3\n" } else { "1 2\n" };
        let rest = format!("x3\n0 3\n1 2\n2 1.5\nr\n2 1\n{pair}b\n3\n3\n2 0\n");
        let rows = [
            "o0 v0 v1",
            if pairs > 0 {
                "o54 3 n2 o16 v2 o16 v0"
            } else {
                "o0 v2 v0"
            },
        ];
        solve(&program((3, 2), &rows, &sum, &rest))
    };
    for pairs in [0, 1] {
        let own = run(1.0, pairs);
        for factor in [1e-8, 1e-6, 4e-4, 30.0, 1e6] {
            let other = run(factor, pairs);
            assert_eq!(other.status, Status::Solved, "{factor}");
            assert_eq!(other.stationarity, Stationarity::S);
            assert_eq!(other.second_order, Some(SecondOrder::Sufficient));
            for (x, expected) in other.x.iter().zip([2.0 / 3.0, 1.0 / 3.0, 0.0]) {
                assert!((x - expected).abs() < 1e-7, "{factor}: {:?}", other.x);
            }
            assert_eq!(other.work.iterations, own.work.iterations, "{factor}");
        }
    }
}

#[test]
fn multipliers_in_the_file_save_two_thirds_of_the_iterations() {
    // min sum (x_i - i/4)^2 + exp(x_i) where sum x_i >= b and 0 <= x_i <= 1; the same with a slightly larger b next
    let n = 8;
    let text = |b: f64, start: &str, duals: &str| {
        let sum = format!(
            "o54 {n} {}",
            (0..n).map(|i| format!("v{i} ")).collect::<String>()
        );
        let terms = (0..n).map(|i| format!("o0 o5 o1 v{i} n{} n2 o44 v{i} ", i as f64 / 4.0));
        let objective = format!("o54 {n} {}", terms.collect::<String>());
        let rest = format!("{start}{duals}r\n2 {b}\nb\n{}", "0 0.0 1.0\n".repeat(n));
        program((n, 1), &[&sum], &objective, &rest)
    };
    let mut first = Program::read(text(3.0, "", "").as_bytes()).unwrap();
    let first = nl::solve(&mut first, 60.0, &mut |_| true).unwrap();
    let points: String = first
        .x
        .iter()
        .enumerate()
        .map(|(i, x)| format!("{i} {x:e}\n"))
        .collect();
    let start = format!("x{n}\n{points}");
    let mut duals = format!("d1\n0 {:e}\n", first.multipliers[0]);
    for (name, values) in ["ipopt_zL_in", "ipopt_zU_in"]
        .iter()
        .zip(&first.bound_multipliers)
    {
        duals += &format!("S4 {n} {name}\n");
        duals.extend(
            values
                .iter()
                .enumerate()
                .map(|(i, z)| format!("{i} {z:e}\n")),
        );
    }
    for b in [3.01, 2.98, 3.05] {
        let run = |text: String| {
            let mut program = Program::read(text.as_bytes()).unwrap();
            nl::solve_with(&mut program, &Options::default(), &mut |_| true).unwrap()
        };
        let (cold, warm) = (run(text(b, "", "")), run(text(b, &start, &duals)));
        assert!(warm.status.is_solved() && cold.status.is_solved());
        assert!((warm.objective - cold.objective).abs() < 1e-6);
        assert!(
            3 * warm.work.iterations <= cold.work.iterations,
            "{} of {} iterations at {b}",
            warm.work.iterations,
            cold.work.iterations
        );
    }
}

#[test]
fn several_starts_keep_the_best_end_and_a_limit_on_iterations_is_said() {
    // x^4 - 8 x^2 + x has minima near 1.97 and -2.03, of which the second is better
    let objective = "o0 o1 o5 v0 n4 o2 n8 o5 v0 n2 v0";
    let text = program((1, 0), &[], objective, "x1\n0 1.5\nb\n3\n");
    let run = |starts, most| {
        let mut options = Options::default();
        (options.starts, options.maximum_iterations) = (starts, most);
        let mut program = Program::read(text.as_bytes()).unwrap();
        nl::solve_with(&mut program, &options, &mut |_| true).unwrap()
    };
    let (one, many) = (run(1, None), run(12, None));
    assert!(
        one.x[0] > 1.9 && many.x[0] < -2.0,
        "{} {}",
        one.x[0],
        many.x[0]
    );
    assert_eq!(many.second_order, Some(SecondOrder::Sufficient));
    assert_eq!(run(1, Some(1)).status, Status::IterationLimit);
}

#[test]
fn solution_file_has_the_suffixes_and_refused_files_get_one_without_values() {
    // max 3 - x^2 at x >= 2: the objective changes by -4 with the bound
    let text = program((1, 0), &[], "o16 o1 n3 o5 v0 n2", "x1\n0 3\nb\n2 2\n");
    let mut read = Program::read(text.as_bytes()).unwrap();
    let solution = nl::solve(&mut read, 60.0, &mut |_| true).unwrap();
    assert!((solution.bound_multipliers[0][0] - 4.0).abs() < 1e-6);
    let sol = solution.file_text_with_suffixes(&read);
    assert!(
        sol.contains("objno 0 0\nsuffix 4 1 13 0 0\nipopt_zL_out\n0 "),
        "{sol}"
    );
    assert!(
        sol.contains("suffix 3 1 13 0 0\nstationarity\n0 2\n"),
        "{sol}"
    );
    assert!(
        sol.contains("suffix 3 1 13 0 0\nsecond_order\n0 3\n"),
        "{sol}"
    );
    let refused = nl::refusal_text(text.as_bytes(), "no\n\nreason").unwrap();
    let lines: Vec<&str> = refused.lines().collect();
    assert_eq!(lines[..4], ["no reason", "", "Options", "3"]);
    assert_eq!(
        lines[lines.len() - 5..],
        ["0", "0", "1", "0", "objno 0 500"]
    );
    assert_eq!(nl::refusal_text(b"x", "no"), None);
}

/// Copies of `min a x + b y - z` where `z <= 6 x`, `z <= 6 y` and `0 <= x` complements `y >= 0`: the solution 0 is B-stationary, and it takes
/// both branches to see that. Behind them a variable without complementarity, `(w - 3)^2`. Where there is a `most`, the row
/// `sum x + y + z + w <= most` ties all together; beyond the 3 of the solution it never holds.
fn copies(count: usize, [a, b]: [f64; 2], most: Option<f64>) -> String {
    let n = 3 * count + 1;
    let (mut rows, mut complements) = (Vec::new(), Vec::new());
    let mut sum = format!("o54 {} o5 o1 v{} n3 n2", count + 1, n - 1);
    for k in 0..count {
        let [x, y, z] = [3 * k, 3 * k + 1, 3 * k + 2];
        rows.push(format!("o0 o2 n-6 v{x} v{z}"));
        rows.push(format!("o0 o2 n-6 v{y} v{z}"));
        complements.push(format!("v{y}"));
        sum += &format!(" o0 o0 o2 n{a} v{x} o2 n{b} v{y} o16 v{z}");
    }
    let mut bounds = "1 0.0\n".repeat(2 * count);
    if let Some(most) = most {
        let all: String = (0..n).map(|i| format!(" v{i}")).collect();
        rows.push(format!("o54 {n}{all}"));
        bounds += &format!("1 {most}\n");
    }
    let demands: String = (0..count).map(|k| format!("5 1 {}\n", 3 * k + 1)).collect();
    let variables = "2 0.0\n2 0.0\n3\n".repeat(count);
    let start: String = (0..n).map(|i| format!("{i} 0.{}\n", 3 + i % 4)).collect();
    let rest = format!("x{n}\n{start}r\n{bounds}{demands}b\n{variables}3\n");
    rows.extend(complements);
    let rows: Vec<&str> = rows.iter().map(String::as_str).collect();
    program((n, rows.len()), &rows, &sum, &rest)
}

#[test]
fn copies_of_a_program_are_certified_one_by_one() {
    let price = [2.0, 2.5];
    let one = solve(&copies(1, price, None));
    for (count, most) in [
        (1, None),
        (12, None),
        (12, Some(7.5)),
        (9, Some(2.95)),
        (14, Some(2.98)),
        (30, Some(1e3)),
        (150, None),
    ] {
        let many = solve(&copies(count, price, most));
        assert_eq!(many.status, Status::Solved, "{count}: {many:?}");
        assert_eq!(many.stationarity, Stationarity::B);
        let last = most.map_or(3.0, |most: f64| most.min(3.0));
        assert!((many.objective - (last - 3.0).powi(2)).abs() < 1e-6);
        assert!((many.x.last().unwrap() - last).abs() < 1e-6);
        // as many times the work of one, as much again for a second opinion, and that of the path
        let bound = 2 * count * one.work.iterations + 40;
        let took = many.work.iterations;
        assert!(took <= bound, "{count}: {took} of {bound} iterations");
    }
}

#[test]
fn parts_are_measured_and_maximized_as_the_whole() {
    // max sum of -(x_i - i)^2 where x_0 >= 1/2 and x_1, x_2 complement each other
    let objective = "o54 3 o16 o5 v0 n2 o16 o5 o1 v1 n1 n2 o16 o5 o1 v2 n2 n2";
    let rest = "x3\n0 3\n1 0.2\n2 0.4\nr\n5 1 2\n2 0.5\nb\n3\n2 0.0\n2 0.0\n";
    let text = program((3, 2), &["v2", "v0"], objective, rest).replace("O0 0", "O0 1");
    let solution = solve(&text);
    assert_eq!(solution.status, Status::Solved);
    let signs = [0.5, 0.0, 2.0];
    for (x, right) in solution.x.iter().zip(signs) {
        assert!((x - right).abs() < 1e-6, "{solution:?}");
    }
    assert!((solution.objective + 1.25).abs() < 1e-6);
    // the row x0 >= 1/2 costs 2 * 1/2
    let sensitivity = solution.multipliers[1];
    assert!((sensitivity + 1.0).abs() < 1e-6, "{sensitivity}");
}
