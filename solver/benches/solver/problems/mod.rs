//! Scalable nonlinear programs as texts, so that another solver can read the very same ones.

mod chained;
mod control;
mod grid;
mod network;

pub(crate) use chained::banded;
pub(crate) use control::van_der_pol;

const INF: f64 = f64::INFINITY;

/// A problem and its name.
pub(crate) struct Stated {
    pub(crate) name: String,
    pub(crate) text: String,
}

/// A problem under construction.
#[derive(Default)]
struct Statement {
    name: String,
    start: Vec<String>,
    /// Lines of bounds, terms of the objective and rows.
    lines: Vec<String>,
}

impl Statement {
    fn new(name: &str) -> Self {
        Self {
            name: name.to_owned(),
            ..Self::default()
        }
    }

    fn variable(&mut self, lower: f64, upper: f64, start: f64) -> usize {
        self.start.push(start.to_string());
        let number = self.start.len();
        if lower.is_finite() || upper.is_finite() {
            self.lines.push(format!("bounds {number} {lower} {upper}"));
        }
        number - 1
    }

    fn row(&mut self, lower: f64, upper: f64, text: String) {
        self.lines.push(format!("row {lower} {upper} {text}"));
    }

    fn equality(&mut self, text: String) {
        self.row(0.0, 0.0, text);
    }

    fn minimize(&mut self, text: String) {
        self.lines.push(format!("minimize {text}"));
    }

    fn finish(self) -> Stated {
        let (count, start) = (self.start.len(), self.start.join(" "));
        let heading = format!("problem {} {count}\nstart {start}\n", self.name);
        Stated {
            name: self.name,
            text: heading + &self.lines.join("\n") + "\n",
        }
    }
}

/// Name of a variable in the text.
fn x(variable: usize) -> String {
    format!("x{}", variable + 1)
}

/// A generator of numbers in [0, 1), the same everywhere.
fn random(seed: u64) -> impl FnMut() -> f64 {
    let mut state = seed;
    move || {
        state = state
            .wrapping_mul(6364136223846793005)
            .wrapping_add(1442695040888963407);
        (state >> 11) as f64 / (1_u64 << 53) as f64
    }
}

/// A problem's name, and how to build it.
type Named = (&'static str, fn() -> Stated);

/// The problems of the comparison, by name, built one at a time.
pub(crate) fn problems() -> Vec<Named> {
    vec![
        ("lukvle1", || chained::luksan_vlcek_1(5000, false)),
        ("lukvli1", || chained::luksan_vlcek_1(5000, true)),
        ("lukvle2", || chained::luksan_vlcek_2(2000)),
        ("lukvle4", || chained::luksan_vlcek_4(4000)),
        ("lukvle7", || chained::luksan_vlcek_7(5000)),
        ("van_der_pol", || control::van_der_pol("van_der_pol", 1500)),
        ("brachistochrone", || control::brachistochrone(800)),
        ("double_integrator", || control::double_integrator(1500)),
        ("cart_pole", || control::cart_pole("cart_pole", 600)),
        ("pendulum_swing_up", || control::pendulum(800)),
        ("catalyst_mixing", || control::catalyst_mixing(1000)),
        ("goddard_rocket", || control::goddard(600)),
        ("hanging_chain", || grid::hanging_chain(1000)),
        ("elliptic_control", || grid::elliptic_control(40)),
        ("obstacle_surface", || grid::obstacle_surface(60)),
        ("random_quadratic", || network::random_quadratic(6000, 3000)),
        ("network_flow", || network::network_flow(2000)),
        ("polygon", || network::polygon(30)),
        ("van_der_pol_fine", || {
            control::van_der_pol("van_der_pol_fine", 6000)
        }),
        ("cart_pole_fine", || {
            control::cart_pole("cart_pole_fine", 2000)
        }),
    ]
}
