//! Chained academic problems.

use super::{INF, Stated, Statement, random, x};

/// Chained Rosenbrock function with trigonometric-exponential constraints (Luksan and Vlcek 1999, 5.1).
pub(super) fn luksan_vlcek_1(n: usize, inequality: bool) -> Stated {
    let mut s = Statement::new(&format!("lukvl{}1", if inequality { "i" } else { "e" }));
    for i in 0..n {
        s.variable(-INF, INF, if i % 2 == 0 { -1.2 } else { 1.0 });
    }
    for i in 0..n - 1 {
        let (a, b) = (x(i), x(i + 1));
        s.minimize(format!("100*({a}^2 - {b})^2 + ({a} - 1)^2"));
    }
    for k in 0..n - 2 {
        let (a, b, c) = (x(k), x(k + 1), x(k + 2));
        s.row(
            if inequality { -1.0 } else { 0.0 },
            0.0,
            format!(
                "3*{b}^3 + 2*{c} - 5 + sin({b} - {c})*sin({b} + {c}) + 4*{b} - {a}*exp({a} - {b}) - 3"
            ),
        );
    }
    s.finish()
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
        );
    }
    for k in 5..n - 2 {
        let mut text = format!("(2 + 5*{0}^2)*{0} + 1", x(k));
        for i in k - 5..=k + 1 {
            text += &format!(" + {0}*(1 + {0})", x(i));
        }
        s.equality(text);
    }
    s.finish()
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
        );
    }
    for k in 0..n - 2 {
        let (a, b, c) = (x(k), x(k + 1), x(k + 2));
        s.equality(format!(
            "8*{b}*({b}^2 - {a}) - 2*(1 - {b}) + 4*({b} - {c}^2)"
        ));
    }
    s.finish()
}

/// Chained HS46 with constraints of HS46 (Luksan and Vlcek 1999, 5.7).
pub(super) fn luksan_vlcek_7(n: usize) -> Stated {
    let mut s = Statement::new("lukvle7");
    for i in 0..n {
        s.variable(-INF, INF, [2.0, 1.5, 0.5][i % 3]);
    }
    for j in (0..(n - 2) / 3).map(|i| 3 * i) {
        let [a, b, c, d, e] = [j, j + 1, j + 2, j + 3, j + 4].map(x);
        s.minimize(format!(
            "({a} - {b})^2 + ({c} - 1)^2 + ({d} - 1)^4 + ({e} - 1)^6"
        ));
        s.equality(format!("{a}^2*{d} + sin({d} - {e}) - 1"));
        s.equality(format!("{b} + {c}^4*{d}^2 - 2"));
    }
    s.finish()
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
        s.minimize(format!(
            "({0} - {target})^4 + 0.5*({0} - {1})^2",
            x(i),
            x(near)
        ));
    }
    for row in 0..n / 2 {
        let base = (2 * row).min(n - 9);
        let mut index = || base + (random() * 8.0) as usize;
        let (a, b, c) = (index(), index(), index());
        s.row(-0.5, 1.5, format!("{}*{} + sin({})", x(a), x(b), x(c)));
    }
    s.finish()
}
