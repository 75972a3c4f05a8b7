//! E06 and E08 where they are certain at compile time: at the declared start, for the defaults of the
//! parameters.

use crate::diagnostics::{Checked, Diagnostics, Reported};
use crate::graph::{self, Sym, Variable};
use crate::scene::CheckedScene;

/// Gaps above `-GAP` times the scale of the coordinates are rounding. The run-time check of a start is
/// stricter; here the other parameters that a user may set are not known.
const GAP: f64 = 1e-6;

/// Pivots below `PIVOT` times the largest entry of the mass matrix are rounding.
const PIVOT: f64 = 1e-12;

/// Checks the mass matrix and the gaps. `positions` tells whether the start of some coordinate is
/// declared; where nothing is, zero may well be a place that no motion visits.
pub(crate) fn at_start(
    scene: &CheckedScene,
    mass: &[Sym],
    positions: bool,
    diagnostics: &mut Diagnostics,
) -> Checked<()> {
    let at = Start::of(scene);
    let mut result = inertia(scene, &at, mass, positions, diagnostics);
    let free = scene
        .optimal_control
        .as_ref()
        .is_some_and(|problem| !problem.free_start.is_empty());
    if positions && !free {
        let scale = at.coordinates.iter().fold(1.0, |s: f64, q| s.max(q.abs()));
        for contact in &scene.contacts {
            let Some(gap) = at.value(contact.gap).filter(|gap| *gap < -GAP * scale) else {
                continue;
            };
            let unit = contact
                .unit
                .map_or_else(String::new, |unit| format!(" {unit}"));
            result = Err(diagnostics.report(
                "E08",
                contact.name.place(),
                format!(
                    "the start lies inside the ground: with the defaults of the parameters the gap of surface \
                     `{}` is {}{unit} < 0; start at a gap of 0 or more, or exchange `>=` and `<=` if the \
                     free side is the other one",
                    contact.name.text,
                    rounded(gap)
                ),
            ));
        }
    }
    result
}

/// Numbers of a scene before anything is set at run time.
struct Start {
    parameters: Vec<f64>,
    coordinates: Vec<f64>,
    velocities: Vec<f64>,
}

impl Start {
    fn of(scene: &CheckedScene) -> Self {
        let mut start = Self {
            parameters: scene.parameters.iter().map(|known| known.default).collect(),
            coordinates: Vec::new(),
            velocities: Vec::new(),
        };
        let numbers = |values: &[Sym]| -> Vec<f64> {
            let value = |&sym| start.value(sym).unwrap_or(f64::NAN);
            values.iter().map(value).collect()
        };
        let (q, v) = (numbers(&scene.start.0), numbers(&scene.start.1));
        (start.coordinates, start.velocities) = (q, v);
        start
    }

    /// The number that an expression is, if it is finite and depends on nothing else.
    fn value(&self, sym: Sym) -> Option<f64> {
        let find = |list: &[f64], i: u16| list.get(usize::from(i)).map(|&x| Sym::number(x));
        let image = graph::substitute(&[sym], |variable| match variable {
            Variable::Parameter(i) => find(&self.parameters, i),
            Variable::Coordinate(i) => find(&self.coordinates, i),
            Variable::Velocity(i) => find(&self.velocities, i),
            Variable::Time => Some(Sym::ZERO),
            _ => None,
        });
        image[0].as_number().filter(|value| value.is_finite())
    }
}

/// E06: the kinetic energy is positive for every motion. Factorizes the mass matrix; a pivot that is not
/// positive belongs to a direction of motion, of which the message tells.
fn inertia(
    scene: &CheckedScene,
    at: &Start,
    mass: &[Sym],
    positions: bool,
    diagnostics: &mut Diagnostics,
) -> Checked<()> {
    let n = scene.coordinates.len();
    let Some(mass) = mass
        .iter()
        .map(|&entry| at.value(entry))
        .collect::<Option<Vec<f64>>>()
    else {
        return Ok(());
    };
    let largest = mass.iter().fold(0.0_f64, |l, m| l.max(m.abs()));
    let mut lower = vec![0.0; n * n];
    let mut pivots = Vec::with_capacity(n);
    for j in 0..n {
        let known = |lower: &[f64], i: usize| -> f64 {
            (0..j)
                .map(|k| lower[i * n + k] * lower[j * n + k] * pivots[k])
                .sum()
        };
        let pivot = mass[j * n + j] - known(&lower, j);
        let negative = pivot < -PIVOT * largest;
        if negative || (positions && pivot <= PIVOT * largest) {
            let direction = direction(&lower, n, j);
            return Err(not_positive(scene, &direction, negative, j, diagnostics));
        }
        if pivot <= PIVOT * largest {
            // Singular where nothing is known to move: the check of the run decides.
            return Ok(());
        }
        for i in j + 1..n {
            lower[i * n + j] = (mass[i * n + j] - known(&lower, i)) / pivot;
        }
        pivots.push(pivot);
    }
    Ok(())
}

/// The velocities whose kinetic energy is half the pivot `j`: `L' v = e_j`.
fn direction(lower: &[f64], n: usize, j: usize) -> Vec<f64> {
    let mut v = vec![0.0; n];
    v[j] = 1.0;
    for i in (0..j).rev() {
        v[i] = -(i + 1..=j).map(|k| lower[k * n + i] * v[k]).sum::<f64>();
    }
    v
}

/// To four digits behind the point, or to the leading one.
fn rounded(value: f64) -> f64 {
    let scale = if value.abs() < 1e-3 { 1e9 } else { 1e4 };
    (value * scale).round() / scale
}

fn not_positive(
    scene: &CheckedScene,
    direction: &[f64],
    negative: bool,
    coordinate: usize,
    diagnostics: &mut Diagnostics,
) -> Reported {
    let moving: Vec<String> = scene
        .coordinates
        .iter()
        .zip(direction)
        .filter(|(_, v)| v.abs() > 1e-9)
        .map(|(coordinate, v)| format!("dot({}) = {}", coordinate.name.text, rounded(*v)))
        .collect();
    let moving = moving.join(", ");
    let message = if negative {
        format!(
            "the mass matrix is not positive definite: with the defaults of the parameters the kinetic energy of \
             a motion with {moving} is negative; the Lagrangian is kinetic minus potential energy, check its \
             signs and the masses"
        )
    } else {
        format!(
            "the mass matrix is not positive definite at the start: with the defaults of the parameters a motion \
             with {moving} has no kinetic energy; add its inertia, start elsewhere or leave a coordinate out"
        )
    };
    let place = scene.coordinates[coordinate].name.place();
    diagnostics.report("E06", place, message)
}
