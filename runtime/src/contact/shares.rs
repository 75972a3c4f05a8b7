//! How contacts share their load where more of them hold a motion than it needs: a table on four legs, three feet that stick.
//!
//! The forces `f` of the lines that are held solve `K f = -q`, and where these follow from each other there are many. All of them give the
//! same motion, but for contacts that slide and turn, whose friction differs:
//!
//! ```text
//! f = f_0 + Z y        K f_0 = -q,   K Z = 0
//! ```
//!
//! `f_0` is the smallest, each force measured by the inertia of its line. The contacts hold as long as any of these forces obeys the laws of
//! all of them; how far from not doing so they are is the *margin*, the largest `m` for which there is a `y` with
//!
//! ```text
//! r_i >= m                            of a contact without friction, or one that slides
//! mu_i r_i - |s_i| >= m               of one that sticks
//! ```
//!
//! a program over cones that the logarithmic barrier solves, whose central path gives shares inside of all cones that vary smoothly with the
//! motion. The contacts let go where the margin falls through zero, and those whose own condition vanishes there are the ones that open
//! or slip.
//!
//! Source: Boyd, Vandenberghe, *Convex Optimization* (2004), sections 4.4.2 and 11.4.

use super::line::Line;
use super::mode_error::ModeError;
use super::view::View;
use crate::linalg::dense;
use crate::linalg::least_norm::LeastNorm;
use crate::linalg::products::largest;
use crate::yardstick;
use nalgebra::{DMatrix, DVector};

/// Share of its terms that is left of the coupling of a line with itself while others are held, below which it follows from them.
const FOLLOWS: f64 = 1e-10;
/// Weight of the barrier at the end, as a share of the largest force: so much less than the margin is what it finds.
const LEAST_WEIGHT: f64 = 1e-11;
/// Factor of the weight from one centre to the next.
const FALLS: f64 = 0.03;
/// Most steps of Newton's method to one centre, and halvings of one step.
const STEPS: usize = 25;
const HALVINGS: usize = 30;
/// Decrement of the barrier at which a centre is reached, and rounding errors of its value that hide one.
const CENTRED: f64 = 1e-6;
const ROUNDINGS: f64 = 16.0 * f64::EPSILON;
/// Margin of the smallest forces, in largest ones, above which they are far enough inside.
const INSIDE: f64 = 0.05;
/// Largest margin that is told apart, in largest forces: contacts that press each other have none.
const LARGEST_MARGIN: f64 = 10.0;

/// The law of one contact among the lines: the places of its normal and of its tangents that are held.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Room {
    pub(crate) normal: usize,
    /// Coefficient of friction, and tangents; none of a contact that does not stick.
    pub(crate) friction: f64,
    pub(crate) tangents: [Option<usize>; 2],
}

/// Forces of lines more of which are held than their motion needs.
pub(crate) struct Shares {
    /// The smallest.
    pub(crate) forces: Vec<f64>,
    /// Measure of each force: its size in the smallest ones.
    units: Vec<f64>,
    /// Directions along which the forces may change, as measured.
    free: Vec<Vec<f64>>,
    /// Whether the motion depends on how the load is shared, so that the smallest forces decide it.
    pub(crate) decide: bool,
    /// What the forces miss of what they are to give, and the largest of it, both as measured.
    missed: f64,
    wanted: f64,
}

/// Measures of the forces of lines and of their equations: both of the size of the root of an inertia, that of the line itself.
fn measures(view: &View<'_>, lines: &[Line]) -> (Vec<f64>, Vec<f64>) {
    let own = |line: Line| {
        let plain = match line {
            Line::Normal { contact, .. } => Line::normal(contact),
            other => other,
        };
        view.coupling(plain, plain).abs()
    };
    let measure = |&line: &Line| {
        let contact = line.contact();
        let coupling = match line {
            Line::Normal { .. } => own(line),
            _ if !view.is_in_space(contact) => own(line),
            // The same for both, so that it does not depend on the frame.
            _ => own(Line::tangent(contact)).max(own(Line::Across { contact })),
        };
        let inertia = 1.0 / view.force(contact, 1.0);
        let unit = (coupling / inertia).abs().sqrt();
        let row = 1.0 / (unit * inertia.abs());
        if unit > 0.0 && row.is_finite() {
            (unit, row)
        } else {
            (1.0, 1.0)
        }
    };
    lines.iter().map(measure).unzip()
}

impl Shares {
    /// Of the forces on `lines` that give them the accelerations, or velocities, `right`; `matrix` are their couplings, row-major.
    ///
    /// Where no forces do, those that come nearest, see [`Self::contradict`].
    ///
    /// # Errors
    /// [`ModeError::Dependent`] of contacts in the plane alone, [`ModeError::NotFinite`] for bad data.
    pub(crate) fn of(
        view: &View<'_>,
        lines: &[Line],
        matrix: &[f64],
        right: &[f64],
    ) -> Result<Self, ModeError> {
        let push = |line: usize, value: f64, to: &mut [f64]| view.push(lines[line], value, to);
        Self::along(view, lines, push, (matrix, right))
    }

    /// The shares of forces that `push` a change of the motion, which may be of several lines each.
    pub(crate) fn along(
        view: &View<'_>,
        lines: &[Line],
        push: impl Fn(usize, f64, &mut [f64]),
        (matrix, right): (&[f64], &[f64]),
    ) -> Result<Self, ModeError> {
        // In the plane redundant contacts are left out one by one, see [`is_free`].
        if !lines.iter().any(|line| view.is_in_space(line.contact())) {
            return Err(ModeError::Dependent);
        }
        let (units, rows) = measures(view, lines);
        let order = lines.len();
        let scaled = matrix.iter().enumerate();
        let scaled: Vec<f64> = scaled
            .map(|(k, entry)| rows[k / order] * entry / units[k % order])
            .collect();
        let wanted: Vec<f64> = right.iter().zip(&rows).map(|(q, row)| q * row).collect();
        let known = LeastNorm::of(&scaled, order).ok_or(ModeError::NotFinite)?;
        let (measured, missed) = known.solve(&wanted);
        let mut shares = Self {
            forces: measured
                .iter()
                .zip(&units)
                .map(|(x, unit)| x / unit)
                .collect(),
            units,
            free: known.idle(),
            decide: false,
            missed,
            wanted: largest(&wanted).max(largest(&measured)),
        };
        shares.keep_motion(view.n, push);
        Ok(shares)
    }

    /// Leaves those directions of the forces that do not change the motion.
    fn keep_motion(&mut self, n: usize, push: impl Fn(usize, f64, &mut [f64])) {
        if self.free.is_empty() {
            return;
        }
        let count = self.free.len();
        let mut moved = vec![0.0; n * (count + 1)];
        let mut sizes = vec![0.0; n];
        for (k, direction) in self.free.iter().enumerate() {
            let mut motion = vec![0.0; n];
            for (line, (value, unit)) in direction.iter().zip(&self.units).enumerate() {
                push(line, value / unit, &mut motion);
            }
            for (i, motion) in motion.into_iter().enumerate() {
                moved[i * (count + 1) + k] = motion;
            }
        }
        // What single forces do is the measure of nothing.
        for (line, unit) in self.units.iter().enumerate() {
            let mut own = vec![0.0; n];
            push(line, 1.0 / unit, &mut own);
            for (size, own) in sizes.iter_mut().zip(own) {
                *size = f64::max(*size, own.abs());
            }
        }
        for (i, size) in sizes.into_iter().enumerate() {
            let row = &mut moved[i * (count + 1)..(i + 1) * (count + 1)];
            for entry in &mut *row {
                *entry = if size > 0.0 { *entry / size } else { 0.0 };
            }
        }
        // A column of ones of its own keeps the largest singular value at one or more.
        let mut rows = moved;
        rows.extend(std::iter::repeat_n(0.0, count));
        rows.push(1.0);
        let Some(known) = LeastNorm::of(&rows, count + 1) else {
            return;
        };
        let idle = known.idle();
        self.decide = idle.len() < count;
        let combined = idle.iter().map(|weights| {
            let mut sum = vec![0.0; self.units.len()];
            for (weight, direction) in weights.iter().zip(&self.free) {
                for (sum, value) in sum.iter_mut().zip(direction) {
                    *sum += weight * value;
                }
            }
            sum
        });
        self.free = combined.collect();
    }

    /// Whether the equations contradict each other, by more than rounding leaves of accelerations with these terms.
    pub(crate) fn contradict(&self, view: &View<'_>, lines: &[Line]) -> bool {
        let (_, rows) = measures(view, lines);
        let terms = lines
            .iter()
            .zip(rows)
            .map(|(&line, row)| row * view.terms(line));
        let size = terms.fold(self.wanted, f64::max);
        self.missed > yardstick::NOTHING * size || self.missed.is_nan()
    }

    /// Whether the load can be shared in several ways with the same motion.
    pub(crate) fn are_many(&self) -> bool {
        !self.free.is_empty()
    }

    /// The shares that are the farthest from violating the laws in `rooms`, or the smallest where they are far from that.
    pub(crate) fn inside(&self, rooms: &[Room]) -> Vec<f64> {
        self.farthest(rooms).0
    }

    /// The shares that are the farthest from violating the laws in `rooms`, with the margin.
    fn farthest(&self, rooms: &[Room]) -> (Vec<f64>, f64, Vec<f64>) {
        let size = self.size();
        if self.free.is_empty() || size == 0.0 {
            return (self.forces.clone(), 0.0, vec![0.0; self.free.len()]);
        }
        let barrier = Barrier::new(self, rooms, size);
        let mut place = vec![0.0; self.free.len() + 1];
        let margin = self.free.len();
        let smallest = barrier.margin(&place);
        if smallest > INSIDE {
            return (self.forces.clone(), size * smallest, place);
        }
        place[margin] = smallest - 1.0;
        let mut weight = 1.0;
        while weight >= LEAST_WEIGHT {
            barrier.centre(&mut place, (1.0 / weight, 1.0), true);
            weight *= FALLS;
        }
        (
            barrier.forces(&place, size),
            size * barrier.margin(&place),
            place,
        )
    }

    /// The smallest shares that obey the laws in `rooms`; `None` where none do.
    pub(crate) fn smallest(&self, rooms: &[Room]) -> Option<Vec<f64>> {
        let size = self.size();
        if size == 0.0 {
            return Some(self.forces.clone());
        }
        let barrier = Barrier::new(self, rooms, size);
        let margin = self.free.len();
        let place = vec![0.0; margin + 1];
        if barrier.margin(&place) >= 0.0 {
            return Some(self.forces.clone());
        }
        let (_, room, mut place) = self.farthest(rooms);
        if room <= 0.0 {
            return None;
        }
        place[margin] = 0.0;
        let mut weight = 1.0;
        while weight >= LEAST_WEIGHT {
            barrier.centre(&mut place, (0.0, 1.0 / weight), false);
            weight *= FALLS;
        }
        Some(barrier.forces(&place, size))
    }

    fn size(&self) -> f64 {
        let sizes = self.forces.iter().map(|force| force.abs());
        sizes.fold(0.0, f64::max)
    }
}

/// The barrier of the laws of some contacts, in units of the largest force; its variables are `y`, then the margin.
struct Barrier<'a> {
    rooms: &'a [Room],
    smallest: Vec<f64>,
    /// What the variables add to each force, a row a line.
    changes: Vec<Vec<f64>>,
}

impl<'a> Barrier<'a> {
    fn new(shares: &Shares, rooms: &'a [Room], size: f64) -> Self {
        let smallest = shares.forces.iter().map(|force| force / size).collect();
        let units = shares.units.iter().enumerate();
        let changes = units.map(|(line, unit)| {
            let own = shares.free.iter();
            own.map(|direction| direction[line] / unit).collect()
        });
        Self {
            rooms,
            smallest,
            changes: changes.collect(),
        }
    }

    fn force(&self, line: usize, place: &[f64]) -> f64 {
        let change = self.changes[line].iter().zip(place);
        self.smallest[line] + change.map(|(a, y)| a * y).sum::<f64>()
    }

    fn forces(&self, place: &[f64], size: f64) -> Vec<f64> {
        let lines = 0..self.smallest.len();
        lines.map(|line| size * self.force(line, place)).collect()
    }

    /// What a contact has left of its law.
    fn room(&self, room: &Room, place: &[f64]) -> f64 {
        let normal = self.force(room.normal, place);
        let tangents = room.tangents.iter().flatten();
        let friction = tangents
            .map(|&line| self.force(line, place).powi(2))
            .sum::<f64>();
        match room.tangents {
            [None, None] => normal,
            _ => room.friction * normal - friction.sqrt(),
        }
    }

    /// The least of them.
    fn margin(&self, place: &[f64]) -> f64 {
        let rooms = self.rooms.iter().map(|room| self.room(room, place));
        rooms.fold(LARGEST_MARGIN, f64::min)
    }

    /// `weights.1 |y|^2 / 2 - weights.0 m` and the barrier; infinite outside of it.
    fn value(&self, place: &[f64], weights: (f64, f64)) -> f64 {
        let (y, margin) = (&place[..place.len() - 1], place[place.len() - 1]);
        let squares: f64 = y.iter().map(|y| y * y).sum();
        let mut value = 0.5 * weights.1 * squares - weights.0 * margin;
        value -= (LARGEST_MARGIN - margin).ln();
        for room in self.rooms {
            let tangents = room.tangents.iter().flatten();
            let friction = tangents
                .map(|&line| self.force(line, place).powi(2))
                .sum::<f64>();
            let normal = self.force(room.normal, place);
            let left = match room.tangents {
                [None, None] => normal - margin,
                _ => room.friction * normal - margin,
            };
            if left <= friction.sqrt() {
                return f64::INFINITY;
            }
            value -= match room.tangents {
                [None, None] => left.ln(),
                _ => (left * left - friction).ln(),
            };
        }
        if value.is_nan() { f64::INFINITY } else { value }
    }

    /// Gradient and Hessian of that.
    fn slopes(&self, place: &[f64], weights: (f64, f64)) -> (DVector<f64>, DMatrix<f64>) {
        let last = place.len() - 1;
        let mut gradient = DVector::zeros(last + 1);
        let mut hessian = DMatrix::zeros(last + 1, last + 1);
        for k in 0..last {
            gradient[k] = weights.1 * place[k];
            hessian[(k, k)] = weights.1;
        }
        let room = LARGEST_MARGIN - place[last];
        gradient[last] = 1.0 / room - weights.0;
        hessian[(last, last)] = 1.0 / (room * room);
        let row = |line: usize, factor: f64, margin: f64| {
            let own = self.changes[line].iter().map(|a| factor * a);
            DVector::from_iterator(last + 1, own.chain([margin]))
        };
        for room in self.rooms {
            let normal = self.force(room.normal, place);
            if room.tangents == [None, None] {
                let (left, own) = (normal - place[last], row(room.normal, 1.0, -1.0));
                gradient -= &own / left;
                hessian += &own * own.transpose() / (left * left);
                continue;
            }
            let left = room.friction * normal - place[last];
            let own = row(room.normal, room.friction, -1.0);
            let (mut square, mut along) = (left * left, 2.0 * left * &own);
            let mut curvature = 2.0 * &own * own.transpose();
            for &line in room.tangents.iter().flatten() {
                let (force, own) = (self.force(line, place), row(line, 1.0, 0.0));
                square -= force * force;
                along -= 2.0 * force * &own;
                curvature -= 2.0 * &own * own.transpose();
            }
            gradient -= &along / square;
            hessian += &along * along.transpose() / (square * square) - curvature / square;
        }
        (gradient, hessian)
    }

    /// Goes to the least value by Newton's method, with the margin or without changing it.
    fn centre(&self, place: &mut [f64], weights: (f64, f64), with_margin: bool) {
        let count = place.len() - usize::from(!with_margin);
        let mut value = self.value(place, weights);
        for _ in 0..STEPS {
            let (gradient, hessian) = self.slopes(place, weights);
            let gradient = gradient.rows(0, count).into_owned();
            let Some(factors) = hessian.view((0, 0), (count, count)).into_owned().cholesky() else {
                return;
            };
            let step = factors.solve(&gradient);
            let decrement = step.dot(&gradient);
            if decrement <= CENTRED + ROUNDINGS * value.abs() || decrement.is_nan() {
                return;
            }
            let mut share = 1.0;
            let before = place.to_vec();
            for halving in 0..=HALVINGS {
                for (k, place) in place[..count].iter_mut().enumerate() {
                    *place = before[k] - share * step[k];
                }
                let now = self.value(place, weights);
                if now < value {
                    value = now;
                    break;
                }
                if halving == HALVINGS {
                    place.copy_from_slice(&before);
                    return;
                }
                share *= 0.5;
            }
        }
    }
}

/// Whether no velocity of the lines follows from the others.
pub(crate) fn are_independent(view: &View<'_>, lines: &[Line]) -> bool {
    let mut pivots = vec![0; lines.len()];
    dense::factorize_independent(&mut view.couplings(lines), &mut pivots)
}

/// Whether the velocity of `line` is free while others are `held`. The couplings of switches have no symmetry, so that what is left of the
/// coupling of a line with itself may have either sign.
pub(crate) fn is_free(view: &View<'_>, held: &[Line], line: Line) -> Result<bool, ModeError> {
    let whole = view.coupling(line, line);
    let left = reduced_couplings(view, held, &[line])?[0];
    Ok(left.abs() > FOLLOWS * whole.abs().max((whole - left).abs()))
}

/// Couplings of `lines` while the `held` ones keep their velocity: `D_UU - D_UH D_HH^-1 D_HU`.
pub(crate) fn reduced_couplings(
    view: &View<'_>,
    held: &[Line],
    lines: &[Line],
) -> Result<Vec<f64>, ModeError> {
    let mut matrix = view.couplings(lines);
    if held.is_empty() {
        return Ok(matrix);
    }
    let couplings = view.couplings(held);
    let mut factors = couplings.clone();
    let mut pivots = vec![0; held.len()];
    let independent = dense::factorize_independent(&mut factors, &mut pivots);
    for (column, &j) in lines.iter().enumerate() {
        let mut response: Vec<f64> = held.iter().map(|&h| view.coupling(h, j)).collect();
        if independent {
            dense::solve(&factors, &pivots, &mut response);
        } else {
            response = Shares::of(view, held, &couplings, &response)?.forces;
        }
        for (row, &i) in lines.iter().enumerate() {
            let through: f64 = held
                .iter()
                .zip(&response)
                .map(|(&h, value)| view.coupling(i, h) * value)
                .sum();
            matrix[row * lines.len() + column] -= through;
        }
    }
    Ok(matrix)
}

/// The forces on lines that give them the motion `right`, which they replace: the only ones, or the smallest of many.
///
/// Where none do, those that come nearest.
///
/// # Errors
/// [`ModeError::Dependent`] of contacts in the plane that depend on each other, [`ModeError::NotFinite`] for bad data.
pub(crate) fn hold(view: &View<'_>, lines: &[Line], right: &mut [f64]) -> Result<(), ModeError> {
    let mut factors = view.couplings(lines);
    let mut pivots = vec![0; lines.len()];
    if dense::factorize_independent(&mut factors, &mut pivots) {
        dense::solve(&factors, &pivots, right);
        return Ok(());
    }
    let shares = Shares::of(view, lines, &view.couplings(lines), right)?;
    right.copy_from_slice(&shares.forces);
    Ok(())
}

/// Whether forces obey the laws in `rooms`, but for rounding.
pub(crate) fn obey(rooms: &[Room], forces: &[f64]) -> bool {
    let largest = forces
        .iter()
        .fold(0.0_f64, |most, force| most.max(force.abs()));
    rooms.iter().all(|room| {
        let tangents = room.tangents.iter().flatten();
        let friction = tangents
            .map(|&line| forces[line].powi(2))
            .sum::<f64>()
            .sqrt();
        let bound = match room.tangents {
            [None, None] => forces[room.normal],
            _ => room.friction * forces[room.normal],
        };
        bound - friction >= -yardstick::NOTHING * largest
    })
}

/// The laws of contacts whose normals, and tangents where they stick, are among the lines.
pub(crate) fn rooms(view: &View<'_>, lines: &[Line]) -> Vec<Room> {
    let normals = lines
        .iter()
        .enumerate()
        .filter_map(|(place, line)| match line {
            Line::Normal { contact, .. } => Some((place, *contact)),
            _ => None,
        });
    let room = |(normal, contact): (usize, usize)| {
        let own = |across: bool| {
            lines.iter().position(|line| match line {
                Line::Tangent { contact: other, .. } => !across && *other == contact,
                Line::Across { contact: other } => across && *other == contact,
                Line::Normal { .. } => false,
            })
        };
        let tangents = [own(false), own(true)];
        // The force of dry friction is given, whatever its sign.
        (!view.is_dry(contact) || tangents != [None, None]).then_some(Room {
            normal,
            friction: view.friction(contact),
            tangents,
        })
    };
    normals.filter_map(room).collect()
}
