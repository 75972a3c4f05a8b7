//! Scalable nonlinear programs, stated as text, so that another solver can read the very same ones.

mod chained;
mod control;
mod grid;
mod network;

pub(crate) use chained::banded;
pub(crate) use control::van_der_pol;

const INF: f64 = f64::INFINITY;

/// A problem under construction.
struct Statement {
    name: String,
    bounds: Vec<(f64, f64)>,
    start: Vec<f64>,
    minimize: Vec<String>,
    rows: Vec<(f64, f64, String)>,
}

impl Statement {
    fn new(name: &str) -> Self {
        Self {
            name: name.to_owned(),
            bounds: Vec::new(),
            start: Vec::new(),
            minimize: Vec::new(),
            rows: Vec::new(),
        }
    }

    fn variable(&mut self, lower: f64, upper: f64, start: f64) -> usize {
        self.bounds.push((lower, upper));
        self.start.push(start);
        self.start.len() - 1
    }

    fn row(&mut self, lower: f64, upper: f64, text: String) {
        self.rows.push((lower, upper, text));
    }

    fn equality(&mut self, text: String) {
        self.row(0.0, 0.0, text);
    }

    /// A term of the objective.
    fn minimize(&mut self, text: String) {
        self.minimize.push(text);
    }

    fn finish(self) -> String {
        let mut lines = vec![
            format!("problem {} {}", self.name, self.start.len()),
            format!(
                "start {}",
                self.start
                    .iter()
                    .map(f64::to_string)
                    .collect::<Vec<_>>()
                    .join(" ")
            ),
        ];
        for (k, (lower, upper)) in self.bounds.iter().enumerate() {
            if lower.is_finite() || upper.is_finite() {
                lines.push(format!("bounds {} {lower} {upper}", k + 1));
            }
        }
        lines.extend(self.minimize.iter().map(|term| format!("minimize {term}")));
        lines.extend(
            self.rows
                .iter()
                .map(|(lower, upper, row)| format!("row {lower} {upper} {row}")),
        );
        lines.join("\n") + "\n"
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

/// A problem's name, and how to state it.
type Named = (&'static str, fn() -> String);

/// The problems of the comparison, by name, stated one at a time.
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
