//! Chained academic problems.

use hangtime_solver::nlp::{DualNum, Element};

use super::{INF, Stated, Statement, random, x};

struct Rosenbrock;

impl Element<2, 1> for Rosenbrock {
    fn evaluate<D: DualNum<Primitive = f64> + Copy>(&self, [a, b]: &[D; 2]) -> [D; 1] {
        [(*a * *a - *b).powi(2) * 100.0 + (*a - 1.0).powi(2)]
    }
}

struct TrigonometricExponential;

impl Element<3, 1> for TrigonometricExponential {
    fn evaluate<D: DualNum<Primitive = f64> + Copy>(&self, [a, b, c]: &[D; 3]) -> [D; 1] {
        [b.powi(3) * 3.0 + (*b - *c).sin() * (*b + *c).sin() - *a * (*a - *b).exp() - 8.0]
    }
}

/// Chained Rosenbrock function with trigonometric-exponential constraints (Luksan and Vlcek 1999, 5.1).
pub(super) fn luksan_vlcek_1(n: usize, inequality: bool) -> Stated {
    let mut s = Statement::new(&format!("lukvl{}1", if inequality { "i" } else { "e" }));
    for i in 0..n {
        s.variable(-INF, INF, if i % 2 == 0 { -1.2 } else { 1.0 });
    }
    for i in 0..n - 1 {
        let (a, b) = (x(i), x(i + 1));
        let text = format!("100*({a}^2 - {b})^2 + ({a} - 1)^2");
        s.minimize(text, Rosenbrock, [i, i + 1]);
    }
    for k in 0..n - 2 {
        let (a, b, c) = (x(k), x(k + 1), x(k + 2));
        let row = s.row(
            if inequality { -1.0 } else { 0.0 },
            0.0,
            format!(
                "3*{b}^3 + 2*{c} - 5 + sin({b} - {c})*sin({b} + {c}) + 4*{b} - {a}*exp({a} - {b}) - 3"
            ),
        );
        s.add(row, 1.0, TrigonometricExponential, [k, k + 1, k + 2]);
        s.linear(row, &[(2.0, k + 2), (4.0, k + 1)]);
    }
    s.finish()
}

struct Wood;

impl Element<4, 1> for Wood {
    fn evaluate<D: DualNum<Primitive = f64> + Copy>(&self, [a, b, c, d]: &[D; 4]) -> [D; 1] {
        [(*a * *a - *b).powi(2) * 100.0
            + (*a - 1.0).powi(2)
            + (*c * *c - *d).powi(2) * 90.0
            + (*c - 1.0).powi(2)
            + (*b + *d - 2.0).powi(2) * 10.0
            + (*b - *d).powi(2) * 0.1]
    }
}

/// `5 x^3 + 2 x + 1`.
struct Cubic;

impl Element<1, 1> for Cubic {
    fn evaluate<D: DualNum<Primitive = f64> + Copy>(&self, [x]: &[D; 1]) -> [D; 1] {
        [(*x * *x * 5.0 + 2.0) * *x + 1.0]
    }
}

/// `x (1 + x)`.
struct Parabola;

impl Element<1, 1> for Parabola {
    fn evaluate<D: DualNum<Primitive = f64> + Copy>(&self, [x]: &[D; 1]) -> [D; 1] {
        [*x * (*x + 1.0)]
    }
}

/// Chained Wood function with Broyden banded constraints (Luksan and Vlcek 1999, 5.2, first form).
pub(super) fn luksan_vlcek_2(n: usize) -> Stated {
    let mut s = Statement::new("lukvle2");
    for i in 0..n {
        s.variable(-INF, INF, if i % 2 == 0 { -2.0 } else { 1.0 });
    }
    for i in 0..n / 2 - 1 {
        let v = [2 * i, 2 * i + 1, 2 * i + 2, 2 * i + 3];
        let [a, b, c, d] = v.map(x);
        s.minimize(
            format!(
                "100*({a}^2 - {b})^2 + ({a} - 1)^2 + 90*({c}^2 - {d})^2 + ({c} - 1)^2 + 10*({b} + {d} - 2)^2 + 0.1*({b} - {d})^2"
            ),
            Wood,
            v,
        );
    }
    let mut rows_of = vec![Vec::new(); n];
    for k in 5..n - 2 {
        let mut text = format!("(2 + 5*{0}^2)*{0} + 1", x(k));
        for i in k - 5..=k + 1 {
            text += &format!(" + {0}*(1 + {0})", x(i));
        }
        let row = s.equality(text);
        s.add(row, 1.0, Cubic, [k]);
        for rows in &mut rows_of[k - 5..=k + 1] {
            rows.push((row, 1.0));
        }
    }
    for (i, rows) in rows_of.iter().enumerate() {
        s.builder.element(Parabola, [i], [rows]);
    }
    s.finish()
}

struct CraggLevy;

impl Element<4, 1> for CraggLevy {
    fn evaluate<D: DualNum<Primitive = f64> + Copy>(&self, [a, b, c, d]: &[D; 4]) -> [D; 1] {
        let (sine, cosine) = (*c - *d).sin_cos();
        [(a.exp() - *b).powi(4)
            + (*b - *c).powi(6) * 100.0
            + (sine / cosine).powi(4)
            + a.powi(8)
            + (*d - 1.0).powi(2)]
    }
}

struct Tridiagonal;

impl Element<3, 1> for Tridiagonal {
    fn evaluate<D: DualNum<Primitive = f64> + Copy>(&self, [a, b, c]: &[D; 3]) -> [D; 1] {
        [*b * (*b * *b - *a) * 8.0 - *c * *c * 4.0 - 2.0]
    }
}

/// Chained Cragg-Levy function with tridiagonal constraints (Luksan and Vlcek 1999, 5.4).
pub(super) fn luksan_vlcek_4(n: usize) -> Stated {
    let mut s = Statement::new("lukvle4");
    for i in 0..n {
        s.variable(-INF, INF, if i % 4 == 0 { 1.0 } else { 2.0 });
    }
    for i in 0..n / 2 - 1 {
        let v = [2 * i, 2 * i + 1, 2 * i + 2, 2 * i + 3];
        let [a, b, c, d] = v.map(x);
        s.minimize(
            format!(
                "(exp({a}) - {b})^4 + 100*({b} - {c})^6 + (sin({c} - {d})/cos({c} - {d}))^4 + {a}^8 + ({d} - 1)^2"
            ),
            CraggLevy,
            v,
        );
    }
    for k in 0..n - 2 {
        let (a, b, c) = (x(k), x(k + 1), x(k + 2));
        let row = s.equality(format!(
            "8*{b}*({b}^2 - {a}) - 2*(1 - {b}) + 4*({b} - {c}^2)"
        ));
        s.add(row, 1.0, Tridiagonal, [k, k + 1, k + 2]);
        s.linear(row, &[(6.0, k + 1)]);
    }
    s.finish()
}

/// `(x - target)^power`.
struct Power {
    target: f64,
    power: i32,
}

impl Element<1, 1> for Power {
    fn evaluate<D: DualNum<Primitive = f64> + Copy>(&self, [x]: &[D; 1]) -> [D; 1] {
        [(*x - self.target).powi(self.power)]
    }
}

/// `weight (x - y)^2`.
struct Difference {
    weight: f64,
}

impl Element<2, 1> for Difference {
    fn evaluate<D: DualNum<Primitive = f64> + Copy>(&self, [x, y]: &[D; 2]) -> [D; 1] {
        [(*x - *y).powi(2) * self.weight]
    }
}

/// `x^2 z + sin(z - w)`.
struct FirstOfHs46;

impl Element<3, 1> for FirstOfHs46 {
    fn evaluate<D: DualNum<Primitive = f64> + Copy>(&self, [x, z, w]: &[D; 3]) -> [D; 1] {
        [*x * *x * *z + (*z - *w).sin() - 1.0]
    }
}

/// `y^4 z^2`.
struct SecondOfHs46;

impl Element<2, 1> for SecondOfHs46 {
    fn evaluate<D: DualNum<Primitive = f64> + Copy>(&self, [y, z]: &[D; 2]) -> [D; 1] {
        [y.powi(4) * *z * *z - 2.0]
    }
}

/// Chained HS46 with constraints of HS46 (Luksan and Vlcek 1999, 5.7).
pub(super) fn luksan_vlcek_7(n: usize) -> Stated {
    let mut s = Statement::new("lukvle7");
    for i in 0..n {
        s.variable(-INF, INF, [2.0, 1.5, 0.5][i % 3]);
    }
    for j in (0..(n - 2) / 3).map(|i| 3 * i) {
        let [a, b, c, d, e] = [j, j + 1, j + 2, j + 3, j + 4].map(x);
        s.minimize.push(format!(
            "({a} - {b})^2 + ({c} - 1)^2 + ({d} - 1)^4 + ({e} - 1)^6"
        ));
        let objective = hangtime_solver::nlp::Target::Objective;
        s.add(objective, 1.0, Difference { weight: 1.0 }, [j, j + 1]);
        for (variable, power) in [(j + 2, 2), (j + 3, 4), (j + 4, 6)] {
            s.add(objective, 1.0, Power { target: 1.0, power }, [variable]);
        }
        let row = s.equality(format!("{a}^2*{d} + sin({d} - {e}) - 1"));
        s.add(row, 1.0, FirstOfHs46, [j, j + 3, j + 4]);
        let row = s.equality(format!("{b} + {c}^4*{d}^2 - 2"));
        s.add(row, 1.0, SecondOfHs46, [j + 2, j + 3]);
        s.linear(row, &[(1.0, j + 1)]);
    }
    s.finish()
}

struct Product;

impl Element<2, 1> for Product {
    fn evaluate<D: DualNum<Primitive = f64> + Copy>(&self, [x, y]: &[D; 2]) -> [D; 1] {
        [*x * *y]
    }
}

struct Sine;

impl Element<1, 1> for Sine {
    fn evaluate<D: DualNum<Primitive = f64> + Copy>(&self, [x]: &[D; 1]) -> [D; 1] {
        [x.sin()]
    }
}

/// A sparse program without the structure of time: random coupling within a band, `n` unknowns, `n/2` rows.
pub(crate) fn banded(n: usize) -> Stated {
    let mut s = Statement::new("random_banded");
    let mut random = random(99);
    for _ in 0..n {
        s.variable(-1.0, 2.0, 0.5);
    }
    for i in 0..n {
        let near = (i + 1 + (random() * 6.0) as usize).min(n - 1);
        let target = 3.0 * random() - 1.0;
        s.minimize.push(format!(
            "({0} - {target})^4 + 0.5*({0} - {1})^2",
            x(i),
            x(near)
        ));
        let objective = hangtime_solver::nlp::Target::Objective;
        s.add(objective, 1.0, Power { target, power: 4 }, [i]);
        s.add(objective, 1.0, Difference { weight: 0.5 }, [i, near]);
    }
    for row in 0..n / 2 {
        let base = (2 * row).min(n - 9);
        let mut index = || base + (random() * 8.0) as usize;
        let (a, b, c) = (index(), index(), index());
        let row = s.row(-0.5, 1.5, format!("{}*{} + sin({})", x(a), x(b), x(c)));
        s.add(row, 1.0, Product, [a, b]);
        s.add(row, 1.0, Sine, [c]);
    }
    s.finish()
}
