//! Programs from `.nl` files: what they state, their derivatives, their solutions, and what is refused.

#![allow(clippy::unwrap_used, reason = "test code")]

use hangtime_solver::mpcc::Mpcc as _;
use hangtime_solver::nl::{self, Program, Solution, Status};
use hangtime_solver::nlp::{self, NlpProblem as _};

/// The heading of a file: variables, rows and common expressions.
fn heading(variables: usize, rows: usize, common: usize) -> String {
    heading_of(variables, rows, common, [0, 0])
}

/// The same of a file whose rows and objective have so many nonzeros.
fn heading_of(
    variables: usize,
    rows: usize,
    common: usize,
    [in_rows, in_objective]: [usize; 2],
) -> String {
    format!(
        "g3 1 1 0\t# problem unknown\n {variables} {rows} 1 0 0\n {rows} 1\n 0 0\n {variables} {variables} {variables}\n \
         0 0 0 1\n 0 0 0 0 0\n {in_rows} {in_objective}\n 0 0\n {common} 0 0 0 0\n"
    )
}

/// One line for each word.
fn lines(words: &str) -> String {
    words.split_whitespace().collect::<Vec<_>>().join("\n") + "\n"
}

fn solve(text: &str) -> (Program, Solution) {
    let mut program = Program::read(text.as_bytes()).unwrap();
    let solution = nl::solve(&mut program, 60.0, &mut |_| true).unwrap();
    (program, solution)
}

fn refusal(text: &str) -> String {
    Program::read(text.as_bytes()).unwrap_err().to_string()
}

/// A program with every operator and with shared expressions in rows and objective.
fn every_operator() -> String {
    let mut text = heading_of(3, 3, 2, [2, 1]);
    // v3 = 0.3 x0 + x1 x2, v4 = exp(v3) / (2 + x0^2)
    text += "V3 1 0\n0 0.3\n";
    text += &lines("o2 v1 v2");
    text += "V4 0 0\n";
    text += &lines("o3 o44 v3 o0 n2 o5 v0 n2");
    text += "C0\n";
    text += &lines("o54 6 o37 v0 o38 v1 o39 o0 v2 n3 o40 v3 o41 v4 o2 v4 v3 ");
    text += "C1\n";
    text += &lines(
        "o54 7 o42 o0 v0 n4 o43 o0 v1 n4 o45 v2 o46 v0 o47 o2 n.2 v1 o49 v2 o48 v3 o0 v4 s5",
    );
    text += "C2\n";
    text += &lines("o0 o50 v0 o0 o51 o2 n.3 v1 o0 o52 o0 v4 n2 o1 o53 o2 n.3 v2 o5 o0 v0 n3 v1");
    text += "O0 0\n";
    text += &lines(
        "o54 8 o16 v4 o15 o1 v0 l7 o12 2 v1 o1 v3 n5 o11 3 v0 v2 n9 o6 v1 n8 \
         o35 o21 o22 v0 n9 o34 o24 v1 n8 o2 v0 o2 v1 v4 v1 o5 n1.5 v3 o2 v0 v0",
    );
    text + "J0 2\n0 1.5\n1 0\nG0 1\n2 -2\nr\n3\n3\n3\nb\n3\n3\n3\nx3\n0 0.4\n1 0.7\n2 -0.6\n"
}

/// Largest error of a derivative against central differences.
fn worst_derivative(program: &mut Program) -> f64 {
    let compared = nlp::check_derivatives(program, None).unwrap();
    compared
        .iter()
        .fold(0.0, |worst, entry| worst.max(entry.error))
}

#[test]
fn derivatives_of_every_operator_agree_with_differences() {
    let mut program = Program::read(every_operator().as_bytes()).unwrap();
    assert!(worst_derivative(&mut program) < 1e-6);
    // sums of long products and squares: pairs of operands that meet themselves
    let words = "o5 o54 3 o2 v0 v1 o2 v1 v2 o5 v3 n2 n3";
    let text = heading(3, 0, 1) + "V3 2 0\n0 1\n2 -0.5\n" + &lines("o2 v0 v2") + "O0 0\n";
    let text = text + &lines(words) + "b\n3\n3\n3\nx3\n0 .4\n1 .7\n2 -.6\n";
    let mut program = Program::read(text.as_bytes()).unwrap();
    assert!(worst_derivative(&mut program) < 1e-6);
}

#[test]
fn expressions_have_the_values_of_the_format() {
    // the same formulas in Rust
    let [x, y, z] = [0.4_f64, 0.7, -0.6];
    let v3: f64 = 0.3 * x + y * z;
    let v4 = v3.exp() / (2.0 + x * x);
    let expected = -v4
        + (x - 7.0).abs()
        + y.max(v3 - 5.0)
        + x.min(z).min(9.0)
        + (y - 8.0).max(0.0)
        + x * (y * v4)
        + 1.5_f64.powf(v3)
        + x * x
        - 2.0 * z;
    let mut program = Program::read(every_operator().as_bytes()).unwrap();
    let mut v = [0.0; 3];
    program.initial_point(&mut v);
    assert!((program.objective(&v) - expected).abs() < 1e-14);
    let mut c = [0.0; 3];
    program.constraint_values(&v, &mut c);
    let first = x.tanh() + y.tan() + (z + 3.0).sqrt() + v3.sinh() + v4.sin() + v4 * v3 + 1.5 * x;
    assert!((c[0] - first).abs() < 1e-14, "{} {first}", c[0]);
}

/// `min (x - 4)^2 + (y - 2)^2` where `F = a y + b x - c` complements `x` by the bounds of `kind`.
fn complementing(kind: usize, bounds: &str, (a, b, c): (f64, f64, f64)) -> String {
    let row = lines(&format!("o54 3 o2 n{a} v1 o2 n{b} v0 n{}", -c));
    heading(2, 1, 0)
        + "C0\n"
        + &row
        + "O0 0\n"
        + &lines("o0 o5 o1 v0 n4 n2 o5 o1 v1 n2 n2")
        + &format!("r\n5 {kind} 1\nb\n{bounds}\n3\nx1\n0 1\n")
}

#[test]
fn complementarity_at_each_kind_of_bound_has_its_closed_form() {
    // x >= 1, F = y - x + 1: x = 1 and y >= 0, or y = x - 1: (3.5, 2.5) costs 0.5
    let (_, lower) = solve(&complementing(1, "2 1", (1.0, -1.0, -1.0)));
    // x <= 3, F = y + x - 3 <= 0: x = 3 and y <= 0, or y = 3 - x: (2.5, 0.5) costs 4.5
    let (_, upper) = solve(&complementing(2, "1 3", (1.0, 1.0, 3.0)));
    // 0 <= x <= 3, F = y - 1: y = 1 inside, y <= 1 at 3, y >= 1 at 0: (3, 1) costs 2
    let (_, both) = solve(&complementing(3, "0 0 3", (1.0, 0.0, 1.0)));
    // a free variable: F = 2 y - x = 0: the foot (4, 2) itself
    let (_, free) = solve(&complementing(0, "3", (2.0, -1.0, 0.0)));
    for (solution, x, objective) in [
        (lower, [3.5, 2.5], 0.5),
        (upper, [2.5, 0.5], 4.5),
        (both, [3.0, 1.0], 2.0),
        (free, [4.0, 2.0], 0.0),
    ] {
        assert_eq!(solution.status, Status::Solved, "{x:?}");
        assert!(
            (solution.objective - objective).abs() < 1e-7,
            "{solution:?}"
        );
        for (found, expected) in solution.x.iter().zip(x) {
            // the objective is quadratic: half the digits of its accuracy
            assert!((found - expected).abs() < 1e-4, "{solution:?}");
        }
    }
}

#[test]
fn side_that_is_one_variable_needs_no_slack_and_one_that_is_not_does() {
    let pairs = |text: &str| {
        let program = Program::read(text.as_bytes()).unwrap();
        let pairs = program.complementarities().to_vec();
        (program.variables(), program.constraints(), pairs)
    };
    // F = 2 y - 3: y measured from 1.5
    assert_eq!(
        pairs(&complementing(1, "2 1", (2.0, 0.0, 3.0))),
        (2, 0, vec![(0, 1)])
    );
    let slack = pairs(&complementing(1, "2 1", (2.0, 1.0, 3.0)));
    assert_eq!(slack, (3, 1, vec![(0, 2)]));
    // both bounds: the distance from the upper one and two parts of F
    let both = pairs(&complementing(3, "0 1 2", (1.0, 0.0, 1.0)));
    assert_eq!(both, (5, 2, vec![(0, 3), (2, 4)]));
    // 1e20 is no bound: of both only the upper one is left
    let one = pairs(&complementing(2, "1 3", (1.0, 1.0, 3.0)));
    assert_eq!(pairs(&complementing(3, "0 -1e20 3", (1.0, 1.0, 3.0))), one);
    // x itself: it stays at its bound
    assert_eq!(
        pairs(&complementing(1, "2 1", (0.0, 1.0, 1.0))),
        (2, 0, vec![])
    );
}

/// `max 3 x + 2 y` subject to `x + y <= 4`, `x + 3 y <= 9`, `0 <= x <= 3`, `y >= 0`: (3, 1), where the first row is worth 2.
const LINEAR: &str = "C0\nn0\nC1\nn0\nO0 1\nn0\nr\n1 4\n1 9\nb\n0 0 3\n2 0\nk1\n2\nJ0 2\n0 1\n1 1\nJ1 2\n0 1\n1 3\nG0 2\n0 3\n1 2\n";

#[test]
fn maximum_and_its_multipliers_are_those_of_the_file() {
    let (program, solution) = solve(&(heading_of(2, 2, 0, [4, 2]) + LINEAR));
    assert_eq!(solution.status, Status::Solved);
    assert!((solution.objective - 11.0).abs() < 1e-6);
    // one more of the first right-hand side is one more y
    assert!((solution.multipliers[0] - 2.0).abs() < 1e-6);
    assert!(solution.multipliers[1].abs() < 1e-6);
    let text = solution.file_text(&program);
    let body: Vec<&str> = text.split("\n\n").nth(1).unwrap().lines().collect();
    assert_eq!(
        body[..9],
        ["Options", "3", "1", "1", "0", "2", "2", "2", "2"]
    );
    assert_eq!(body[13..], ["objno 0 0"]);
    assert!((body[11].parse::<f64>().unwrap() - 3.0).abs() < 1e-6);
    assert!((body[12].parse::<f64>().unwrap() - 1.0).abs() < 1e-6);
}

#[test]
fn binary_file_states_the_same_program_as_its_text() {
    let text = complementing(1, "2 1", (1.0, -1.0, -1.0));
    let mut bytes = heading(2, 1, 0).replace("g3", "b3").into_bytes();
    let mut put = |key: u8, numbers: &[i32], reals: &[f64]| {
        bytes.push(key);
        bytes.extend(numbers.iter().flat_map(|n| n.to_le_bytes()));
        bytes.extend(reals.iter().flat_map(|r| r.to_le_bytes()));
    };
    put(b'C', &[0], &[]);
    for (key, numbers, reals) in [
        (b'o', &[54, 3][..], &[][..]),
        (b'v', &[1], &[]),
        (b'o', &[16], &[]),
        (b'v', &[0], &[]),
        (b'n', &[], &[1.0]),
    ] {
        put(key, numbers, reals);
    }
    put(b'O', &[0, 0], &[]);
    put(b'o', &[0], &[]);
    for (variable, at) in [(0, 4.0), (1, 2.0)] {
        put(b'o', &[5], &[]);
        put(b'o', &[1], &[]);
        put(b'v', &[variable], &[]);
        put(b'n', &[], &[at]);
        put(b'l', &[2], &[]);
    }
    put(b'x', &[1, 0], &[1.0]);
    put(b'S', &[0, 1, 3], &[]);
    bytes.extend(b"sos");
    bytes.extend([1_i32, 7].iter().flat_map(|n| n.to_le_bytes()));
    bytes.extend(b"r5");
    bytes.extend([1_i32, 1].iter().flat_map(|n| n.to_le_bytes()));
    bytes.extend(b"b2");
    bytes.extend(1.0_f64.to_le_bytes());
    bytes.extend(b"3");
    let mut program = Program::read(&bytes).unwrap();
    let solution = nl::solve(&mut program, 60.0, &mut |_| true).unwrap();
    let (_, expected) = solve(&text);
    assert_eq!(solution.status, Status::Solved);
    assert_eq!(solution.x, expected.x);
    assert_eq!(solution.work.iterations, expected.work.iterations);
}

#[test]
fn what_is_not_solved_here_is_refused_by_its_name() {
    let whole = (heading_of(2, 2, 0, [4, 2]) + LINEAR)
        .replace(" 0 0 0 0 0\n 4 2\n 0 0\n", " 0 1 0 0 0\n 4 2\n 0 0\n");
    let names = vec!["price".to_owned(), "number of ships".to_owned()];
    let error = Program::read_named(whole.as_bytes(), names, Vec::new()).unwrap_err();
    let objective =
        |words: &str| heading(1, 0, 0) + "F0 1 -1 bessel\nO0 0\n" + &lines(words) + "b\n3\n";
    let refusals = [
        error.to_string(),
        refusal(&objective("o13 v0")),
        refusal(&objective("f0 1 v0")),
        refusal(&objective("o64 2 n1 n0 n2 v0")),
        refusal(&objective("o99 v0")),
        refusal(&objective("v1")),
        refusal(&(heading(2, 1, 0) + "L0\n")),
        refusal(&complementing(1, "3", (1.0, 1.0, 0.0))),
    ];
    insta::assert_snapshot!(refusals.join("\n"));
}

#[test]
fn damaged_file_is_refused_with_its_line() {
    let good = heading_of(2, 2, 0, [4, 2]) + LINEAR;
    let refusals = [
        refusal(""),
        refusal("NAME bell\nROWS\n"),
        refusal(&good[..60]),
        refusal(&good[..good.find("b\n").unwrap()]),
        refusal(&good.replace("0 0 3\n2 0\n", "0 3 0\n2 0\n")),
        refusal(&good.replace("J1 2\n", "J7 2\n")),
        refusal(&good.replace("J1 2\n0 1\n1 3\n", "J1 2\n0 1\n1 three\n")),
        refusal(&good.replace("G0 2\n0 3\n", "G0 2\n0 inf\n")),
        refusal(&good.replace(" 2 2 1", " 200000000 2 1")),
        refusal(&good.replace("C1\nn0\n", "C1\no2\nn0\n")),
        // Cut off between two segments, or one of them left out or there twice.
        refusal(&good[..good.find("J0").unwrap()]),
        refusal(&good[..good.find("G0").unwrap()]),
        refusal(&good.replace("O0 1\nn0\n", "")),
        refusal(&good.replace("C1\nn0\n", "C1\nn0\nC1\nn0\n")),
        refusal(&good.replace("k1\n", "r\n1 4\n1 9\nk1\n")),
        refusal(&(good + "?")),
    ];
    insta::assert_snapshot!(refusals.join("\n"));
}

/// Numbers from a fixed seed (xorshift).
struct Random(u64);

impl Random {
    fn below(&mut self, bound: usize) -> usize {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 % bound as u64) as usize
    }
}

#[test]
fn mutated_files_give_a_message_or_a_program_but_never_a_panic() {
    let files = [
        every_operator(),
        heading_of(2, 2, 0, [4, 2]) + LINEAR,
        complementing(3, "0 0 3", (1.0, -1.0, 1.0)),
    ];
    let pieces: [&[u8]; 8] = [
        b"9",
        b"-",
        b"\n",
        b"o",
        b"v",
        b"4294967295",
        b"1e308",
        b"\xff",
    ];
    let mut random = Random(0x9e37_79b9_7f4a_7c15);
    let (mut read, mut refused) = (0, 0);
    for round in 0..3000 {
        let mut bytes = files[round % files.len()].clone().into_bytes();
        if round % 20 == 0 {
            bytes[0] = b'b';
        }
        for _ in 0..=random.below(2) {
            let at = random.below(bytes.len());
            match random.below(4) {
                0 => bytes.truncate(at),
                1 => {
                    bytes.remove(at);
                }
                2 => bytes[at] = pieces[random.below(8)][0],
                _ => {
                    let piece = pieces[random.below(8)];
                    bytes.splice(at..at, piece.iter().copied());
                }
            }
            if bytes.is_empty() {
                break;
            }
        }
        match Program::read(&bytes) {
            Ok(mut program) => {
                read += 1;
                // what was read is a program: the solver ends with a status or names what is wrong with it
                let mut left = 15;
                let _ = nl::solve(&mut program, 1.0, &mut |_| {
                    left -= 1;
                    left > 0
                });
            }
            Err(error) => {
                refused += 1;
                let message = error.to_string();
                assert!(
                    message.len() < 300 && !message.contains('\n'),
                    "{message:?}"
                );
            }
        }
    }
    // both happen often, so that the loop shows something
    assert!(
        read > 300 && refused > 1000,
        "{read} read, {refused} refused"
    );
}

#[test]
fn nesting_and_long_sums_cost_no_stack_and_no_square() {
    // a chain of 200 000 sums, right and left, and of functions
    let count = 200_000;
    let body = |head: &str, tail: &str| {
        let words = format!("{}v0\n{}", head.repeat(count), tail.repeat(count));
        heading(2, 0, 0) + "O0 0\n" + &words + "b\n3\n3\nx2\n0 .5\n1 .25\n"
    };
    for (head, tail, expected) in [
        ("o0\n", "v1\n", 0.5 + 0.25 * count as f64),
        ("o0\nv1\n", "", 0.5 + 0.25 * count as f64),
        ("o1\nv1\n", "", 0.5),
        ("o5\n", "n1\n", 0.5),
        ("o16\n", "", 0.5),
    ] {
        let mut program = Program::read(body(head, tail).as_bytes()).unwrap();
        let value = program.objective(&[0.5, 0.25]);
        assert!(
            (value - expected).abs() < 1e-6 * expected,
            "{head:?}: {value}"
        );
    }
}
