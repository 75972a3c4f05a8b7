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
#![allow(dead_code, reason = "each test uses a part")]
#![allow(clippy::unwrap_used, reason = "test code")]

mod batch;
mod expression;

use batch::Batch;
use expression::Expression;

use std::io::Read as _;

use hangtime_solver::mpcc::Mpcc;
use hangtime_solver::nlp::NlpProblem;

/// A problem read from text.
// Many fields: what the file of a problem states.
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
    terms: Vec<Batch>,
    term_variables: Vec<Vec<Vec<usize>>>,
    row_groups: Vec<Batch>,
    /// Positions in the value arrays: of the Jacobian by (batch, instance, local variable), of the Hessian
    /// of objective and rows by (batch, instance, local row, local column); upper entries are absent.
    jacobian_places: Vec<Vec<Vec<usize>>>,
    term_places: Vec<Vec<Vec<usize>>>,
    row_places: Vec<Vec<Vec<usize>>>,
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
                terms: Vec::new(),
                term_variables: Vec::new(),
                row_groups: Vec::new(),
                jacobian_places: Vec::new(),
                term_places: Vec::new(),
                row_places: Vec::new(),
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
        self.hessian = hessian;
        self.terms = batch::group(self.objective.iter());
        self.row_groups = batch::group(self.rows.iter().map(|(_, _, expression)| expression));
        let mut starts = vec![0];
        for (_, _, expression) in &self.rows {
            starts.push(starts[starts.len() - 1] + expression.variables.len());
        }
        self.jacobian_places = self
            .row_groups
            .iter()
            .map(|batch| {
                batch
                    .members
                    .iter()
                    .zip(&batch.variables)
                    .map(|(&row, variables)| {
                        let sorted = &self.rows[row].2.variables;
                        variables
                            .iter()
                            .map(|v| starts[row] + sorted.binary_search(v).unwrap())
                            .collect()
                    })
                    .collect()
            })
            .collect();
        self.term_variables = self
            .terms
            .iter()
            .map(|batch| batch.variables.clone())
            .collect();
        self.term_places = places(&self.terms, &self.hessian);
        self.row_places = places(&self.row_groups, &self.hessian);
    }
}

/// Position of each pair of local variables in the sorted Hessian pattern, `usize::MAX` for row < column.
fn places(batches: &[Batch], hessian: &[(usize, usize)]) -> Vec<Vec<Vec<usize>>> {
    batches
        .iter()
        .map(|batch| {
            batch
                .variables
                .iter()
                .map(|variables| {
                    let pairs = variables
                        .iter()
                        .flat_map(|&i| variables.iter().map(move |&j| (i, j)));
                    pairs
                        .map(|(i, j)| {
                            if i < j {
                                usize::MAX
                            } else {
                                hessian.binary_search(&(i, j)).unwrap()
                            }
                        })
                        .collect()
                })
                .collect()
        })
        .collect()
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
        let mut sum = 0.0;
        for batch in &mut self.terms {
            batch.values(x, &mut |_, value| sum += value);
        }
        sum
    }

    fn gradient(&mut self, x: &[f64], gradient: &mut [f64]) {
        gradient.fill(0.0);
        for (batch, variables) in self.terms.iter_mut().zip(&self.term_variables) {
            batch.gradients(x, &mut |k, v, g| gradient[variables[k][v]] += g);
        }
    }

    fn constraint_values(&mut self, x: &[f64], c: &mut [f64]) {
        for batch in &mut self.row_groups {
            batch.values(x, &mut |row, value| c[row] = value);
        }
    }

    fn jacobian_pattern(&self) -> Vec<(usize, usize)> {
        self.jacobian.clone()
    }

    fn jacobian_values(&mut self, x: &[f64], values: &mut [f64]) {
        values.fill(0.0);
        for (batch, places) in self.row_groups.iter_mut().zip(&self.jacobian_places) {
            batch.gradients(x, &mut |k, v, g| values[places[k][v]] += g);
        }
    }

    fn hessian_pattern(&self) -> Vec<(usize, usize)> {
        self.hessian.clone()
    }

    fn hessian_values(&mut self, x: &[f64], weight: f64, multipliers: &[f64], values: &mut [f64]) {
        values.fill(0.0);
        let add = |values: &mut [f64], places: &[usize], i: usize, j: usize, h: f64| {
            let width = places.len().isqrt();
            let place = places[i * width + j];
            if place != usize::MAX {
                values[place] += h;
            }
        };
        for (batch, places) in self.terms.iter_mut().zip(&self.term_places) {
            batch.hessians(x, &|_| weight, &mut |k, i, j, h| {
                add(values, &places[k], i, j, h)
            });
        }
        for (batch, places) in self.row_groups.iter_mut().zip(&self.row_places) {
            batch.hessians(x, &|row| multipliers[row], &mut |k, i, j, h| {
                add(values, &places[k], i, j, h);
            });
        }
    }
}

impl Mpcc for TextProblem {
    fn complementarities(&self) -> &[(usize, usize)] {
        &self.pairs
    }
}
