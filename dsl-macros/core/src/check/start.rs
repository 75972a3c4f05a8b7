//! E06 and E08 where they are certain at compile time: at the declared start, for the defaults of the
//! parameters.

use super::checker::Checker;
use super::states;
use super::values::StartValues;
use crate::ast::{Name, Scene, Statement};
use crate::diagnostics::{Checked, Diagnostics, Reported};
use crate::evaluate::rounded;
use crate::graph::{self, Sym, Variable};
use crate::scene::CheckedScene;

/// Gaps above `-GAP` times the scale of the coordinates are rounding. The run-time check of a start is
/// stricter; here the other parameters that a user may set are not known.
const GAP: f64 = 1e-6;

/// Pivots below `PIVOT` times the largest entry of the mass matrix are rounding.
const PIVOT: f64 = 1e-12;

/// E06: checks the mass matrix. Where the start of no coordinate is declared, zero may well be a place that no motion
/// visits.
pub(crate) fn inertia_at_start(
    declared: &Scene,
    scene: &CheckedScene,
    mass: &[Sym],
    diagnostics: &mut Diagnostics,
) -> Checked<()> {
    let positions = declared.statements.iter().any(|statement| {
        matches!(statement, Statement::Start(list) if list.iter().any(|own| !own.velocity))
    });
    let known: Vec<f64> = scene.parameters.iter().map(|known| known.default).collect();
    let at = Start::new(known, (&scene.start.0, &scene.start.1));
    inertia(scene, &at, mass, positions, diagnostics)
}

/// E08: no gap is negative at the start. Told at the value that moves the gap most; where no start is declared at all a
/// warning, as a run may bring its own.
pub(super) fn gaps(
    checker: &mut Checker<'_>,
    declared: &Scene,
    start: &StartValues,
    complete: bool,
) {
    let has = |wanted: fn(&Statement) -> bool| declared.statements.iter().any(wanted);
    // A start that is to be found, or that joints complete, is not a given one.
    if has(|statement| matches!(statement, Statement::Free(_) | Statement::Joint { .. })) {
        return;
    }
    let n = checker.coordinates.len();
    let [q, v] = states::of_coordinates(&start.declared, n);
    let parameters = checker
        .parameters
        .iter()
        .map(|known| known.default)
        .collect();
    let at = Start::new(parameters, (&q, &v));
    let positions = start.declared[..n].iter().any(Option::is_some);
    let scale = at.coordinates.iter().fold(1.0, |s: f64, q| s.max(q.abs()));
    let surfaces = std::mem::take(&mut checker.surfaces);
    for surface in &surfaces {
        // Of the largest of several gaps, the one that is the largest.
        let own = at.value(surface.gap).filter(|gap| *gap < -GAP * scale);
        let mut others = surface
            .alternatives
            .iter()
            .map(|&i| at.value(surfaces[i].gap));
        let gap = own.filter(|own| others.all(|its| its.is_some_and(|its| its < *own)));
        if let Some(gap) = gap
            && !checker.scope.units.faulty.contains(&surface.name.text)
        {
            let rate = steepness(&at, surface.gap, n);
            let known = |i: usize| {
                let name = &checker.coordinates[i].name.text;
                let whole = complete && start.complete;
                (whole || start.declared[i].is_some()) && !checker.scope.units.faulty.contains(name)
            };
            if (0..n).filter(|&i| rate[i] > 0.0).all(known) {
                let gap = checker.scope.units.shown_gap(&surface.name.text, gap);
                inside(checker, &surface.name, &gap, (start, &rate, positions));
            }
        }
    }
    checker.surfaces = surfaces;
    // Numbers that were put in say nothing about the constants of the declaration.
    graph::take_fault();
}

/// How fast a gap changes with each coordinate, absolutely.
fn steepness(at: &Start, gap: Sym, n: usize) -> Vec<f64> {
    let by = Variable::coordinates(n);
    let slopes = graph::gradient(gap, &by).into_iter();
    slopes
        // What has no value here, as at a tip, still depends on the coordinate.
        .map(|slope| at.value(slope).map_or(f64::MIN_POSITIVE, f64::abs))
        .collect()
}

fn inside(
    checker: &mut Checker<'_>,
    surface: &Name,
    gap: &str,
    (start, rate, positions): (&StartValues, &[f64], bool),
) {
    let text = &surface.text;
    if !positions {
        let steepest = (0..rate.len()).max_by(|&a, &b| rate[a].total_cmp(&rate[b]));
        let name = steepest.map_or("", |i| checker.coordinates[i].name.text.as_str());
        let message = format!(
            "no `start` is declared, and where all coordinates are zero the gap of surface `{text}` is {gap} < 0 with the \
             defaults of the parameters; write `start {{ {name}: ... }}` with a gap of 0 or more"
        );
        checker.diagnostics.warn("E08", surface.place(), message);
        return;
    }
    let declared = start.declared.iter().zip(rate);
    let declared = declared.filter_map(|(value, &rate)| Some((value.as_ref()?.1, rate)));
    let place = declared
        .filter(|(_, rate)| *rate > 0.0)
        .max_by(|a, b| a.1.total_cmp(&b.1))
        .map_or_else(|| surface.place(), |(place, _)| place);
    checker.diagnostics.report(
        "E08",
        place,
        format!(
            "the start lies inside the ground: with the defaults of the parameters the gap of surface `{text}` is \
             {gap} < 0; start at a gap of 0 or more, or exchange `>=` and `<=` if the free side is the other one"
        ),
    );
}

/// Numbers of a scene before anything is set at run time.
struct Start {
    parameters: Vec<f64>,
    coordinates: Vec<f64>,
    velocities: Vec<f64>,
}

impl Start {
    fn new(parameters: Vec<f64>, (q, v): (&[Sym], &[Sym])) -> Self {
        let mut start = Self {
            parameters,
            coordinates: Vec::new(),
            velocities: Vec::new(),
        };
        let numbers = |values: &[Sym]| -> Vec<f64> {
            let value = |&sym| start.value(sym).unwrap_or(f64::NAN);
            values.iter().map(value).collect()
        };
        let (q, v) = (numbers(q), numbers(v));
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
