//! Test problems from text; what their functions are is read by `nl`.
//!
//! ```text
//! problem name n            variables x1..xn
//! start a b ...             starting point, one value for each variable
//! bounds k lower upper      of variable xk; variables without a line are free
//! minimize expression       several such lines add up
//! row lower upper expression
//! pair i j                  0 <= xi  _|_  xj >= 0
//! optimum value             reference value of the objective
//! ```
#![allow(dead_code, reason = "each test uses a part")]
#![allow(clippy::unwrap_used, reason = "test code")]

mod expression;

use std::cell::Cell;
use std::io::Read as _;

use hangtime_solver::mpcc::Mpcc;
use hangtime_solver::nl::Program;
use hangtime_solver::nlp::NlpProblem;

/// A problem read from text.
#[derive(Debug, Clone, Default)]
pub(crate) struct TextProblem {
    pub(crate) name: String,
    pub(crate) start: Vec<f64>,
    pub(crate) lower: Vec<f64>,
    pub(crate) upper: Vec<f64>,
    /// Bounds of the rows.
    pub(crate) rows: Vec<(f64, f64)>,
    pub(crate) pairs: Vec<(usize, usize)>,
    pub(crate) optimum: Vec<f64>,
    functions: Functions,
}

/// Objective and rows, in words of `.nl` files.
#[derive(Debug, Default)]
struct Functions {
    variables: usize,
    terms: Vec<String>,
    rows: Vec<String>,
    common: Vec<String>,
    program: Option<Program>,
}

impl Clone for Functions {
    fn clone(&self) -> Self {
        let mut copy = Self {
            variables: self.variables,
            terms: self.terms.clone(),
            rows: self.rows.clone(),
            common: self.common.clone(),
            program: None,
        };
        copy.read();
        copy
    }
}

/// A text that is kept compressed; its checksum is checked.
pub(crate) fn unpack(compressed: &[u8]) -> String {
    let mut text = String::new();
    flate2::read::GzDecoder::new(compressed)
        .read_to_string(&mut text)
        .expect("the data is whole");
    text
}

/// All problems of a text.
pub(crate) fn read_problems(text: &str) -> Vec<TextProblem> {
    let mut problems: Vec<TextProblem> = Vec::new();
    for line in text.lines().map(str::trim) {
        if line.is_empty() || line.starts_with('#') {
            continue;
        }
        let (word, rest) = line.split_once(' ').unwrap_or((line, ""));
        if word == "problem" {
            let (name, n) = rest.split_once(' ').unwrap();
            let variables: usize = n.trim().parse().unwrap();
            problems.push(TextProblem {
                name: name.to_owned(),
                start: vec![0.0; variables],
                lower: vec![f64::NEG_INFINITY; variables],
                upper: vec![f64::INFINITY; variables],
                ..TextProblem::default()
            });
        } else {
            let problem = problems.last_mut().expect("a problem line comes first");
            problem.read(word, rest);
        }
    }
    for problem in &mut problems {
        problem.functions.variables = problem.start.len();
        problem.functions.read();
    }
    problems
}

impl TextProblem {
    fn read(&mut self, word: &str, rest: &str) {
        let number = |text: &str| -> f64 {
            let number = text.parse();
            number.unwrap_or_else(|_| panic!("`{text}` is not a number in `{rest}`"))
        };
        let index = |text: &str| text.trim().parse::<usize>().unwrap() - 1;
        let n = self.start.len();
        let functions = &mut self.functions;
        let mut expression = |text: &str| expression::words(text, n, &mut functions.common);
        match word {
            "start" => {
                self.start = rest.split_whitespace().map(number).collect();
                assert_eq!(self.start.len(), n, "{}", self.name);
            }
            "bounds" => {
                let parts: Vec<&str> = rest.split_whitespace().collect();
                self.lower[index(parts[0])] = number(parts[1]);
                self.upper[index(parts[0])] = number(parts[2]);
            }
            "minimize" => {
                let words = expression(rest);
                functions.terms.push(words);
            }
            "row" => {
                let parts: Vec<&str> = rest.splitn(3, ' ').collect();
                self.rows.push((number(parts[0]), number(parts[1])));
                let words = expression(parts[2]);
                functions.rows.push(words);
            }
            "pair" => {
                let (i, j) = rest.split_once(' ').unwrap();
                self.pairs.push((index(i), index(j)));
            }
            "optimum" => self.optimum = rest.split_whitespace().map(number).collect(),
            _ => panic!("unknown word `{word}`"),
        }
    }
}

impl Functions {
    /// Makes the program of the words; its variables and rows are free.
    fn read(&mut self) {
        let (n, m, common) = (self.variables, self.rows.len(), self.common.len());
        let mut text = format!(
            "g3 1 1 0\n {n} {m} 1 0 0\n {m} 1\n 0 0\n {n} {n} {n}\n 0 0 0 1\n 0 0 0 0 0\n 0 0\n 0 0\n {common} 0 0 0 0\n"
        );
        let mut add = |heading: String, words: &str| {
            text += &format!("{heading}\n{}\n", words.replace(' ', "\n"));
        };
        for (index, words) in self.common.iter().enumerate() {
            add(format!("V{} 0 0", n + index), words);
        }
        for (index, words) in self.rows.iter().enumerate() {
            add(format!("C{index}"), words);
        }
        let sum = match &self.terms[..] {
            [] => "n0".to_owned(),
            [term] => term.clone(),
            terms => format!("o54 {} {}", terms.len(), terms.join(" ")),
        };
        add("O0 0".to_owned(), &sum);
        text += &format!("r\n{}b\n{}", "3\n".repeat(m), "3\n".repeat(n));
        self.program = Some(Program::read(text.as_bytes()).unwrap());
    }

    fn program(&self) -> &Program {
        self.program.as_ref().unwrap()
    }

    fn program_mut(&mut self) -> &mut Program {
        self.program.as_mut().unwrap()
    }
}

impl NlpProblem for TextProblem {
    fn variables(&self) -> usize {
        self.start.len()
    }

    fn constraints(&self) -> usize {
        self.rows.len()
    }

    fn variable_bounds(&self, lower: &mut [f64], upper: &mut [f64]) {
        lower.copy_from_slice(&self.lower);
        upper.copy_from_slice(&self.upper);
    }

    fn constraint_bounds(&self, lower: &mut [f64], upper: &mut [f64]) {
        for (row, bounds) in self.rows.iter().enumerate() {
            (lower[row], upper[row]) = *bounds;
        }
    }

    fn initial_point(&self, x: &mut [f64]) {
        x.copy_from_slice(&self.start);
    }

    fn objective(&mut self, x: &[f64]) -> f64 {
        self.functions.program_mut().objective(x)
    }

    fn gradient(&mut self, x: &[f64], gradient: &mut [f64]) {
        self.functions.program_mut().gradient(x, gradient);
    }

    fn constraint_values(&mut self, x: &[f64], c: &mut [f64]) {
        self.functions.program_mut().constraint_values(x, c);
    }

    fn jacobian_pattern(&self) -> Vec<(usize, usize)> {
        self.functions.program().jacobian_pattern()
    }

    fn jacobian_values(&mut self, x: &[f64], values: &mut [f64]) {
        self.functions.program_mut().jacobian_values(x, values);
    }

    fn hessian_pattern(&self) -> Vec<(usize, usize)> {
        self.functions.program().hessian_pattern()
    }

    fn hessian_values(&mut self, x: &[f64], weight: f64, multipliers: &[f64], values: &mut [f64]) {
        let program = self.functions.program_mut();
        program.hessian_values(x, weight, multipliers, values);
    }
}

impl Mpcc for TextProblem {
    fn complementarities(&self) -> &[(usize, usize)] {
        &self.pairs
    }
}

/// What a problem is asked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Asked {
    Objective,
    Gradient,
    Rows,
    Jacobian,
    Hessian,
}

/// A problem whose answers are seen, and may be changed, before they are given.
pub(crate) struct Watched<F> {
    pub(crate) problem: TextProblem,
    pub(crate) watch: F,
    /// Sides that vanish, where the problem decides them itself, and how often it was asked for them.
    pub(crate) sides: Option<(Vec<usize>, Cell<usize>)>,
}

impl<F: FnMut(Asked, &[f64], &mut [f64])> Watched<F> {
    pub(crate) fn new(problem: TextProblem, watch: F) -> Self {
        let sides = None;
        Self {
            problem,
            watch,
            sides,
        }
    }
}

impl<F: FnMut(Asked, &[f64], &mut [f64])> NlpProblem for Watched<F> {
    fn variables(&self) -> usize {
        self.problem.variables()
    }

    fn constraints(&self) -> usize {
        self.problem.constraints()
    }

    fn variable_bounds(&self, lower: &mut [f64], upper: &mut [f64]) {
        self.problem.variable_bounds(lower, upper);
    }

    fn constraint_bounds(&self, lower: &mut [f64], upper: &mut [f64]) {
        self.problem.constraint_bounds(lower, upper);
    }

    fn initial_point(&self, x: &mut [f64]) {
        self.problem.initial_point(x);
    }

    fn objective(&mut self, x: &[f64]) -> f64 {
        let mut value = [NlpProblem::objective(&mut self.problem, x)];
        (self.watch)(Asked::Objective, x, &mut value);
        value[0]
    }

    fn gradient(&mut self, x: &[f64], gradient: &mut [f64]) {
        self.problem.gradient(x, gradient);
        (self.watch)(Asked::Gradient, x, gradient);
    }

    fn constraint_values(&mut self, x: &[f64], c: &mut [f64]) {
        self.problem.constraint_values(x, c);
        (self.watch)(Asked::Rows, x, c);
    }

    fn jacobian_pattern(&self) -> Vec<(usize, usize)> {
        self.problem.jacobian_pattern()
    }

    fn jacobian_values(&mut self, x: &[f64], values: &mut [f64]) {
        self.problem.jacobian_values(x, values);
        (self.watch)(Asked::Jacobian, x, values);
    }

    fn hessian_pattern(&self) -> Vec<(usize, usize)> {
        self.problem.hessian_pattern()
    }

    fn hessian_values(&mut self, x: &[f64], weight: f64, multipliers: &[f64], values: &mut [f64]) {
        self.problem.hessian_values(x, weight, multipliers, values);
        (self.watch)(Asked::Hessian, x, values);
    }
}

impl<F: FnMut(Asked, &[f64], &mut [f64])> Mpcc for Watched<F> {
    fn complementarities(&self) -> &[(usize, usize)] {
        &self.problem.pairs
    }

    fn vanishing_sides(&self, _: &[f64], vanishes: &mut [bool]) -> bool {
        let Some((sides, asked)) = &self.sides else {
            return false;
        };
        asked.set(asked.get() + 1);
        for &side in sides {
            vanishes[side] = true;
        }
        true
    }
}
