//! Problems made of elements.

#![allow(clippy::unwrap_used, reason = "test code")]

use crate::solver_support::read_problems;
use hangtime_solver::nlp::{
    self, DualNum, Element, ElementProblem, ElementProblemBuilder, NlpProblem, Settings, Status,
    Target,
};

/// `p x y^2 + sin(x)` and `exp(x y)`.
struct Mixed {
    p: f64,
}

impl Element<2, 2> for Mixed {
    fn evaluate<D: DualNum<Primitive = f64> + Copy>(&self, [x, y]: &[D; 2]) -> [D; 2] {
        [*x * *y * *y * self.p + x.sin(), (*x * *y).exp()]
    }
}

/// `x^4`.
struct Quartic;

impl Element<1, 1> for Quartic {
    fn evaluate<D: DualNum<Primitive = f64> + Copy>(&self, [x]: &[D; 1]) -> [D; 1] {
        [x.powi(4)]
    }
}

const INF: f64 = f64::INFINITY;

/// Elements of two types, one value in three targets, an element that takes one variable twice, linear terms that
/// repeat, constants.
fn example() -> ElementProblem {
    let mut builder = ElementProblemBuilder::new();
    let x = [0.3, -0.7, 1.1].map(|start| builder.variable(-INF, INF, start));
    let (first, second) = (builder.row(-2.0, 5.0), builder.row(1.0, 1.0));
    let (first, second) = (Target::Row(first), Target::Row(second));
    let everywhere = [(Target::Objective, 2.0), (first, -1.0), (second, 0.5)];
    builder.element(Mixed { p: 3.0 }, [x[0], x[1]], [&everywhere, &[]]);
    builder.element(
        Mixed { p: -1.0 },
        [x[2], x[2]],
        [&[(first, 1.0)], &[(Target::Objective, 1.5)]],
    );
    builder.element(Quartic, [x[2]], [&[(Target::Objective, 1.0)]]);
    builder.linear(second, 4.0, x[0]);
    builder.linear(second, -1.0, x[0]);
    builder.linear(Target::Objective, 7.0, x[1]);
    builder.constant(first, 0.25);
    builder.constant(Target::Objective, -3.0);
    builder.name_variable(x[1], "speed");
    builder.name_row(1, "balance");
    builder.build().unwrap()
}

#[test]
fn values_are_the_sums_that_were_declared() {
    let mut problem = example();
    let (a, b, c): (f64, f64, f64) = (0.4, -0.2, 0.9);
    let x = [a, b, c];
    let mixed = |p: f64, x: f64, y: f64| (p * x * y * y + x.sin(), (x * y).exp());
    let ((u, _), (v, w)) = (mixed(3.0, a, b), mixed(-1.0, c, c));
    let mut rows = [0.0; 2];
    problem.constraint_values(&x, &mut rows);
    // sums of a few terms of size one
    assert!((rows[0] - (v - u + 0.25)).abs() < 1e-14);
    assert!((rows[1] - (0.5 * u + 3.0 * a)).abs() < 1e-14);
    let objective = 2.0 * u + 1.5 * w + c.powi(4) + 7.0 * b - 3.0;
    assert!((problem.objective(&x) - objective).abs() < 1e-14);
}

#[test]
fn derivatives_match_differences_also_where_a_variable_stands_twice() {
    let mut problem = example();
    for x in [[0.3, -0.7, 1.1], [0.0, 0.0, 0.0], [-1.2, 2.0, 0.5]] {
        let compared = nlp::check_derivatives(&mut problem, Some(&x)).unwrap();
        // central differences of functions of size ten err by 1e-10 times their third derivatives
        assert!(compared[0].error < 1e-7, "{:?}", compared[0]);
        assert!(compared.iter().all(|entry| !entry.missing));
    }
}

#[test]
fn evaluation_at_another_point_forgets_the_last() {
    let mut problem = example();
    let (p, q) = ([0.1, 0.2, 0.3], [0.3, 0.2, 0.1]);
    let at_p = problem.objective(&p);
    let at_q = problem.objective(&q);
    assert_ne!(at_p, at_q);
    assert_eq!(problem.objective(&p), at_p);
    let mut rows = [0.0; 2];
    problem.constraint_values(&q, &mut rows);
    assert_eq!(problem.objective(&q), at_q);
}

#[test]
fn names_appear_in_diagnoses() {
    let problem = example();
    assert_eq!(problem.variable_name(0), "x[0]");
    assert_eq!(problem.variable_name(1), "speed");
    assert_eq!(problem.constraint_name(1), "balance");
}

#[test]
fn build_index_out_of_range_is_refused_by_name() {
    let mut builder = ElementProblemBuilder::new();
    let x = builder.variable(0.0, 1.0, 0.5);
    builder.element(Quartic, [x + 3], [&[(Target::Objective, 1.0)]]);
    let error = builder.build().map(|_| ()).unwrap_err().to_string();
    insta::assert_snapshot!(error, @"a term names variable 3, but there are 1; use the indices that the builder returned");

    let mut builder = ElementProblemBuilder::new();
    let x = builder.variable(0.0, 1.0, 0.5);
    builder.linear(Target::Row(0), 1.0, x);
    let error = builder.build().map(|_| ()).unwrap_err().to_string();
    insta::assert_snapshot!(error, @"a term names row 0, but there are 0; use the indices that the builder returned");
}

/// `x_a x_d (x_a + x_b + x_c)`.
struct Cost;

impl Element<4, 1> for Cost {
    fn evaluate<D: DualNum<Primitive = f64> + Copy>(&self, [a, b, c, d]: &[D; 4]) -> [D; 1] {
        [*a * *d * (*a + *b + *c)]
    }
}

struct Product;

impl Element<4, 1> for Product {
    fn evaluate<D: DualNum<Primitive = f64> + Copy>(&self, [a, b, c, d]: &[D; 4]) -> [D; 1] {
        [*a * *b * *c * *d]
    }
}

struct Square;

impl Element<1, 1> for Square {
    fn evaluate<D: DualNum<Primitive = f64> + Copy>(&self, [x]: &[D; 1]) -> [D; 1] {
        [*x * *x]
    }
}

#[test]
fn solve_hs71_takes_the_path_of_its_text() {
    let mut builder = ElementProblemBuilder::new();
    let x = [1.0, 5.0, 5.0, 1.0].map(|start| builder.variable(1.0, 5.0, start));
    let product = Target::Row(builder.row(25.0, INF));
    let sphere = Target::Row(builder.row(40.0, 40.0));
    builder.element(Cost, x, [&[(Target::Objective, 1.0)]]);
    builder.linear(Target::Objective, 1.0, x[2]);
    builder.element(Product, x, [&[(product, 1.0)]]);
    for x in x {
        builder.element(Square, [x], [&[(sphere, 1.0)]]);
    }
    let mut elements = builder.build().unwrap();
    let of_elements = nlp::solve(&mut elements, &Settings::default()).unwrap();

    let text = include_str!("../data/hock_schittkowski.txt");
    let mut text = read_problems(text)
        .into_iter()
        .find(|p| p.name == "hs71")
        .unwrap();
    let of_text = nlp::solve(&mut text, &Settings::default()).unwrap();
    assert_eq!(of_elements.status, Status::Solved);
    assert_eq!(of_elements.counts.iterations, of_text.counts.iterations);
    // the published optimum has eight digits
    assert!((of_elements.objective - 17.0140173).abs() < 1e-7 * 17.0);
    for (p, q) in of_elements.x.iter().zip(&of_text.x) {
        // both within the tolerance 1e-8 of the same point
        assert!((p - q).abs() < 1e-7, "{p} and {q}");
    }
}
