//! Test problems from text.
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
#![allow(dead_code)]

mod expression;

use expression::{Expression, Work};

use hangtime::mpcc::Mpcc;
use hangtime::nlp::NlpProblem;

/// A problem read from text.
#[derive(Debug, Clone)]
pub(crate) struct TextProblem {
    pub(crate) name: String,
    pub(crate) start: Vec<f64>,
    pub(crate) lower: Vec<f64>,
    pub(crate) upper: Vec<f64>,
    pub(crate) objective: Vec<Expression>,
    pub(crate) rows: Vec<(f64, f64, Expression)>,
    pub(crate) pairs: Vec<(usize, usize)>,
    pub(crate) optimum: Vec<f64>,
    jacobian: Vec<(usize, usize)>,
    hessian: Vec<(usize, usize)>,
    hessian_starts: Vec<usize>,
    work: Work,
}

/// All problems of a text.
pub(crate) fn read_problems(text: &str) -> Vec<TextProblem> {
    let mut problems: Vec<TextProblem> = Vec::new();
    for line in text.lines() {
        let line = line.trim();
        if line.is_empty() || line.starts_with('#') {
            continue;
        }
        let (word, rest) = line.split_once(' ').unwrap_or((line, ""));
        let number = |text: &str| -> f64 {
            text.parse()
                .unwrap_or_else(|_| panic!("`{text}` is not a number in `{line}`"))
        };
        if word == "problem" {
            let (name, n) = rest.split_once(' ').unwrap();
            let n: usize = n.trim().parse().unwrap();
            problems.push(TextProblem {
                name: name.to_owned(),
                start: vec![0.0; n],
                lower: vec![f64::NEG_INFINITY; n],
                upper: vec![f64::INFINITY; n],
                objective: Vec::new(),
                rows: Vec::new(),
                pairs: Vec::new(),
                optimum: Vec::new(),
                jacobian: Vec::new(),
                hessian: Vec::new(),
                hessian_starts: Vec::new(),
                work: Work::default(),
            });
            continue;
        }
        let problem = problems.last_mut().expect("a problem line comes first");
        match word {
            "start" => {
                problem.start = rest.split_whitespace().map(number).collect();
                assert_eq!(problem.start.len(), problem.lower.len(), "{}", problem.name);
            }
            "bounds" => {
                let parts: Vec<&str> = rest.split_whitespace().collect();
                let k: usize = parts[0].parse().unwrap();
                problem.lower[k - 1] = number(parts[1]);
                problem.upper[k - 1] = number(parts[2]);
            }
            "minimize" => problem.objective.push(Expression::parse(rest)),
            "row" => {
                let mut parts = rest.splitn(3, ' ');
                let lower = number(parts.next().unwrap());
                let upper = number(parts.next().unwrap());
                let expression = Expression::parse(parts.next().unwrap());
                problem.rows.push((lower, upper, expression));
            }
            "pair" => {
                let (i, j) = rest.split_once(' ').unwrap();
                let index = |k: &str| k.trim().parse::<usize>().unwrap() - 1;
                problem.pairs.push((index(i), index(j)));
            }
            "optimum" => problem.optimum = rest.split_whitespace().map(number).collect(),
            _ => panic!("unknown word in `{line}`"),
        }
    }
    for problem in &mut problems {
        problem.find_patterns();
    }
    problems
}

impl TextProblem {
    fn find_patterns(&mut self) {
        self.jacobian = Vec::new();
        let mut hessian = Vec::new();
        let mut pairs_of = |expression: &Expression| {
            for &i in &expression.variables {
                for &j in &expression.variables {
                    if i >= j {
                        hessian.push((i, j));
                    }
                }
            }
        };
        self.objective.iter().for_each(&mut pairs_of);
        for (row, (_, _, expression)) in self.rows.iter().enumerate() {
            pairs_of(expression);
            self.jacobian
                .extend(expression.variables.iter().map(|&j| (row, j)));
        }
        hessian.sort_unstable();
        hessian.dedup();
        self.hessian_starts = (0..=self.start.len())
            .map(|i| hessian.partition_point(|&(row, _)| row < i))
            .collect();
        self.hessian = hessian;
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
        for (row, (l, u, _)) in self.rows.iter().enumerate() {
            lower[row] = *l;
            upper[row] = *u;
        }
    }

    fn initial_point(&self, x: &mut [f64]) {
        x.copy_from_slice(&self.start);
    }

    fn objective(&mut self, x: &[f64]) -> f64 {
        let work = &mut self.work;
        self.objective.iter().map(|term| term.value(x, work)).sum()
    }

    fn gradient(&mut self, x: &[f64], gradient: &mut [f64]) {
        gradient.fill(0.0);
        for term in &self.objective {
            term.add_gradient(x, 1.0, &mut self.work, &mut |i, g| gradient[i] += g);
        }
    }

    fn constraint_values(&mut self, x: &[f64], c: &mut [f64]) {
        for (c, (_, _, expression)) in c.iter_mut().zip(&self.rows) {
            *c = expression.value(x, &mut self.work);
        }
    }

    fn jacobian_pattern(&self) -> Vec<(usize, usize)> {
        self.jacobian.clone()
    }

    fn jacobian_values(&mut self, x: &[f64], values: &mut [f64]) {
        values.fill(0.0);
        let mut start = 0;
        for (_, _, expression) in &self.rows {
            let variables = &expression.variables;
            expression.add_gradient(x, 1.0, &mut self.work, &mut |i, g| {
                let position = variables.binary_search(&i).unwrap();
                values[start + position] += g;
            });
            start += variables.len();
        }
    }

    fn hessian_pattern(&self) -> Vec<(usize, usize)> {
        self.hessian.clone()
    }

    fn hessian_values(&mut self, x: &[f64], weight: f64, multipliers: &[f64], values: &mut [f64]) {
        values.fill(0.0);
        let (hessian, starts) = (&self.hessian, &self.hessian_starts);
        let mut add = |i: usize, j: usize, h: f64| {
            let row = &hessian[starts[i]..starts[i + 1]];
            values[starts[i] + row.binary_search(&(i, j)).unwrap()] += h;
        };
        if weight != 0.0 {
            for term in &self.objective {
                term.add_hessian(x, weight, &mut self.work, &mut add);
            }
        }
        for ((_, _, expression), y) in self.rows.iter().zip(multipliers) {
            expression.add_hessian(x, *y, &mut self.work, &mut add);
        }
    }
}

impl Mpcc for TextProblem {
    fn complementarities(&self) -> &[(usize, usize)] {
        &self.pairs
    }
}
