//! The initial value problem that every simulator takes, and the checks that come before it.

use super::sentences::negative_bound;
use crate::InputError;
use crate::model::rounding::{ROUNDINGS, rounding_error_at_start};
use crate::model::{
    ContactDeclaration, ControlPiece, ImpactLaw, Model, SparsityPattern, Switching, contact_point,
    friction_share,
};
use crate::refusal;
use crate::yardstick;

/// Gaps above minus this share of what the free motion covers within the horizon count as "on the surface": a body at 0 in front of a bump that
/// fades like `exp(-w^2)` is inside of it by what no motion could tell from nothing.
const MOTION_TOLERANCE: f64 = 1e-13;
/// Share of the horizon that is short beside any motion.
pub(in crate::simulation) const MOMENT: f64 = 1e-7;

/// Horizons \[s\] of which a share, and the square of a share, is still a number of full precision.
const HORIZONS: std::ops::RangeInclusive<f64> = 1e-100..=1e100;
/// Fewest points that a trajectory can be asked to keep.
const FEWEST_POINTS: usize = 100;

/// Initial state, horizon and controls of a simulation.
#[derive(Debug, Clone)]
pub struct InitialValueProblem {
    /// Initial coordinates, length `n_q`.
    pub q: Vec<f64>,
    /// Initial velocities, length `n_q`.
    pub v: Vec<f64>,
    /// Length of the simulation \[s\].
    pub horizon: f64,
    /// Controls over time.
    pub controls: ControlSignal,
    /// Most points of the trajectory that are kept, at least 100; default 100 000. Of more, those between events are left out evenly, with a note.
    pub points: usize,
}

/// Controls as a function of physical time.
///
/// ```
/// use hangtime::prelude::*;
///
/// let (times, values) = (vec![0.0, 2.0], vec![vec![1.0], vec![5.0]]);
/// let ramp = ControlSignal::PiecewiseLinear { times, values };
/// let mut u = [0.0];
/// ramp.write(0.5, &mut u)?;
/// assert_eq!(u, [2.0]);
/// ramp.write(3.0, &mut u)?;
/// assert_eq!(u, [5.0]);
/// // One control is asked for, two are given.
/// assert!(ControlSignal::constant(&[1.0, 0.0]).write(0.0, &mut u).is_err());
/// # Ok::<(), InputError>(())
/// ```
#[derive(Debug, Clone, Default, PartialEq)]
pub enum ControlSignal {
    /// All controls zero.
    #[default]
    Zero,
    /// Constant on intervals: `values[k]` (length `n_u`) holds on `times[k] <= t < times[k + 1]`; the
    /// last one holds to the end.
    PiecewiseConstant {
        /// Start of each interval \[s\], increasing, the first at most 0.
        times: Vec<f64>,
        /// Control values of each interval.
        values: Vec<Vec<f64>>,
    },
    /// Continuous and linear between nodes: `values[k]` (length `n_u`) at `times[k]`; the last one holds to the end.
    PiecewiseLinear {
        /// The nodes \[s\], increasing, the first at most 0.
        times: Vec<f64>,
        /// Control values at each node.
        values: Vec<Vec<f64>>,
    },
}

impl ControlSignal {
    /// Controls that are constant in time, in order of declaration.
    #[must_use]
    pub fn constant(values: &[f64]) -> Self {
        Self::PiecewiseConstant {
            times: vec![0.0],
            values: vec![values.to_vec()],
        }
    }

    /// Writes the controls that hold right after time `t` into `u`.
    ///
    /// # Errors
    /// [`InputError`] if times or values are none, in disorder, or not as many as `u` is long.
    pub fn write(&self, t: f64, u: &mut [f64]) -> Result<(), InputError> {
        self.check(u.len())?;
        self.write_checked(t, u);
        Ok(())
    }

    fn write_checked(&self, t: f64, u: &mut [f64]) {
        let mut piece = ControlPiece::default();
        self.take_piece(t, u.len(), &mut piece);
        piece.write(t, u);
    }

    /// Checks the signal of that many controls.
    fn check(&self, controls: usize) -> Result<(), InputError> {
        let (Self::PiecewiseConstant { times, values } | Self::PiecewiseLinear { times, values }) =
            self
        else {
            return Ok(());
        };
        length("control values over time", values.len(), times.len())?;
        for &time in times {
            finite("a control time", time)?;
        }
        let disordered = times.windows(2).find(|pair| pair[0] >= pair[1]);
        let late = times.first().copied().filter(|&first| first > 0.0);
        let wrong = late.or_else(|| disordered.map(|pair| pair[1]));
        if times.is_empty() || wrong.is_some() {
            return Err(refusal::out_of_range(
                "control time",
                wrong.unwrap_or(f64::NAN),
                "s",
                "one of increasing times, the first at most 0",
            ));
        }
        for value in values {
            length("a control value", value.len(), controls)?;
            for &u in value {
                finite("a control value", u)?;
            }
        }
        Ok(())
    }

    /// The next time after `t` at which the controls jump or change their slope, if any.
    #[must_use]
    pub(crate) fn next_break(&self, t: f64) -> Option<f64> {
        let (Self::PiecewiseConstant { times, .. } | Self::PiecewiseLinear { times, .. }) = self
        else {
            return None;
        };
        let next = times.partition_point(|&start| start <= t);
        times.get(next).copied()
    }

    /// Whether the controls may jump where pieces meet.
    pub(crate) fn jumps(&self) -> bool {
        matches!(self, Self::PiecewiseConstant { .. })
    }

    /// The `count` controls on the piece that holds right after time `t`.
    pub(crate) fn take_piece(&self, t: f64, count: usize, piece: &mut ControlPiece) {
        let (Self::PiecewiseConstant { times, values } | Self::PiecewiseLinear { times, values }) =
            self
        else {
            piece.set_constant((0..count).map(|_| 0.0));
            return;
        };
        let k = times.partition_point(|&start| start <= t).max(1) - 1;
        match (self, times.get(k + 1), values.get(k + 1)) {
            (Self::PiecewiseLinear { .. }, Some(&end), Some(next)) => {
                piece.set_linear((times[k], &values[k]), (end, next));
            }
            _ => piece.set_constant(values[k].iter().copied()),
        }
    }
}

impl InitialValueProblem {
    /// Default of [`points`](Self::points): some ten megabytes for small scenes.
    pub(crate) const DEFAULT_POINTS: usize = 100_000;

    /// The problem that the scene declares: its start, `horizon` or else its own, no control.
    ///
    /// # Errors
    /// [`InputError`] if neither gives a horizon.
    pub fn of(model: &dyn Model, horizon: Option<f64>) -> Result<Self, InputError> {
        let n = model.declaration().coordinates.len();
        let (mut q, mut v) = (vec![0.0; n], vec![0.0; n]);
        model.start(&mut q, &mut v);
        let Some(horizon) = horizon.or_else(|| model.horizon()) else {
            return Err(InputError::new(
                "the scene declares no horizon, and none is given; write `horizon 5 [s]` into it, or give one",
            ));
        };
        Ok(Self {
            q,
            v,
            horizon,
            controls: ControlSignal::Zero,
            points: Self::DEFAULT_POINTS,
        })
    }

    /// Checks everything that can be known before the first step.
    ///
    /// # Errors
    /// The first [`InputError`] found: parameters, lengths, finiteness, horizon, controls, mass
    /// matrix, gaps.
    pub fn check(&self, model: &dyn Model) -> Result<(), InputError> {
        self.check_numbers(model)?;
        self.check_contacts(model, &self.input(model))
    }

    /// Checks all but the contacts.
    pub(in crate::simulation) fn check_numbers(&self, model: &dyn Model) -> Result<(), InputError> {
        let declaration = model.declaration();
        for (index, parameter) in declaration.parameters.iter().enumerate() {
            let value = model.parameter(index);
            finite(&format!("parameter `{}`", parameter.name), value)?;
            if parameter.positive && value <= 0.0 {
                return Err(refusal::out_of_range(
                    format!("parameter `{}`", parameter.name),
                    value,
                    parameter.unit,
                    "above 0",
                ));
            }
        }
        let mut positive = model.positive().into_iter();
        if let Some((what, unit, value)) = positive.find(|own| own.2.is_nan() || own.2 <= 0.0) {
            let bound = "above 0, for these parameters";
            return Err(refusal::out_of_range(what, value, unit, bound));
        }
        let n = declaration.coordinates.len();
        length("initial coordinates", self.q.len(), n)?;
        length("initial velocities", self.v.len(), n)?;
        for (i, coordinate) in declaration.coordinates.iter().enumerate() {
            finite(&format!("initial `{}`", coordinate.name), self.q[i])?;
            match declaration.state(i) {
                None => finite(&format!("initial d`{}`/dt", coordinate.name), self.v[i])?,
                Some(state) => finite(&format!("initial `{}`", state.name), self.v[i])?,
            }
        }
        finite("horizon", self.horizon)?;
        if self.horizon <= 0.0 {
            return Err(refusal::out_of_range(
                "horizon",
                self.horizon,
                "s",
                "above 0",
            ));
        }
        if !HORIZONS.contains(&self.horizon) {
            let (least, most) = (HORIZONS.start(), HORIZONS.end());
            return Err(refusal::out_of_range(
                "horizon",
                self.horizon,
                "s",
                format!("from {least:e} to {most:e}; declare the scene with other units for more"),
            ));
        }
        if self.points < FEWEST_POINTS {
            return Err(refusal::out_of_range(
                "points of the trajectory",
                self.points as f64,
                "",
                format!("at least {FEWEST_POINTS}"),
            ));
        }
        self.controls.check(declaration.controls.len())?;
        check_mass(model, &self.input(model))
    }

    /// Rounding error of a gap at the start `x`.
    fn gap_rounding(&self, model: &dyn Model, contact: usize, x: &[f64]) -> f64 {
        let mut a = vec![0.0; self.q.len()];
        model.free_acceleration(x, &mut a);
        let moment = MOMENT * self.horizon;
        let error = rounding_error_at_start(x, &a, moment, |x| model.gap(contact, x));
        // NaN where the gap has no value nearby.
        error.max(0.0)
    }

    /// Size of what a gap with this `normal` covers within the horizon without contacts, `sum_k |n_k| (|v_k| T + |a_k| T^2)`.
    fn way(&self, model: &dyn Model, x: &[f64], normal: &[f64]) -> f64 {
        let mut a = vec![0.0; self.q.len()];
        model.free_acceleration(x, &mut a);
        let terms = normal.iter().zip(self.v.iter().zip(&a));
        let way = terms.map(|(n, (v, a))| n.abs() * (v.abs() + a.abs() * self.horizon));
        self.horizon * way.sum::<f64>()
    }

    /// Up to which size the gap of a contact at the start `x`, where it is evaluated, is none.
    fn closed_gap(&self, model: &dyn Model, contact: usize, (x, point): (&[f64], &[f64])) -> f64 {
        let normal = &point[contact_point::NORMAL..][..self.q.len()];
        let terms = normal.iter().zip(&self.q).map(|(n, q)| (n * q).abs());
        let way = MOTION_TOLERANCE * self.way(model, x, normal);
        let rounding = ROUNDINGS * self.gap_rounding(model, contact, x);
        (yardstick::NOTHING * terms.sum::<f64>())
            .max(way)
            .max(rounding)
    }

    /// Checks gaps and coefficients at the start `x`.
    fn check_contacts(&self, model: &dyn Model, x: &[f64]) -> Result<(), InputError> {
        let declaration = model.declaration();
        let n = declaration.coordinates.len();
        let mut point = vec![0.0; contact_point::length(n)];
        for (i, contact) in declaration.contacts.iter().enumerate() {
            let gap = model.gap(i, x);
            finite(&format!("initial gap `{}`", contact.name), gap)?;
            model.contact(i, x, &mut point);
            let may_be_inside = gap < 0.0 && acts(model, i, x);
            if may_be_inside && gap < -self.closed_gap(model, i, (x, &point)) {
                return Err(InputError::new(format!(
                    "start inside the ground (E08): gap `{}` = {gap:e} {} < 0; start at gap >= 0, which the formula of the \
                     surface gives where it is meant to be touched, or write the surface with the other sign if the free \
                     side is meant to be there",
                    contact.name, contact.unit
                )));
            }
            if contact.dry {
                let pressed = -point[contact_point::CURVATURE];
                finite(
                    &format!("bound of dry friction `{}` at the start", contact.name),
                    pressed,
                )?;
                if pressed < 0.0 {
                    return Err(InputError::new(format!(
                        "{} (E10)",
                        negative_bound(contact.name)
                    )));
                }
            }
            let restitution = model.restitution(i);
            if !(0.0..=1.0).contains(&restitution) {
                return Err(refusal::out_of_range(
                    format!("restitution of `{}` (E10)", contact.name),
                    restitution,
                    "",
                    "in 0..=1",
                ));
            }
            let friction = model.friction(i);
            if !(0.0..f64::INFINITY).contains(&friction) {
                return Err(refusal::out_of_range(
                    format!("coefficient of friction of `{}` (E10)", contact.name),
                    friction,
                    "",
                    "at least 0",
                ));
            }
            check_coefficients(model, i, x)?;
        }
        Self::check_breaking(model)
    }

    /// Refuses a scene with a surface that bounces or rubs, for methods that treat neither.
    pub(crate) fn check_inelastic(model: &dyn Model, method: &str) -> Result<(), InputError> {
        let contacts = model.declaration().contacts;
        let beyond = |c: &&ContactDeclaration| {
            c.law != ImpactLaw::Inelastic || c.friction.is_some() && !c.dry
        };
        match contacts.iter().find(beyond) {
            None => Ok(()),
            Some(contact) => Err(refusal::unsupported_law(method, contact.name)),
        }
    }

    /// Refuses a scene that wants contacts to be struck one after the other, for methods whose impacts are all at once.
    pub(crate) fn check_at_once(model: &dyn Model, method: &str) -> Result<(), InputError> {
        let contacts = model.declaration().contacts;
        match contacts.iter().find(|known| known.sequence) {
            None => Ok(()),
            Some(contact) => Err(refusal::unsupported(
                format!(
                    "the impact law of `{}`, in sequence, by {method}",
                    contact.name
                ),
                "simulate by finite elements or from event to event, or leave `in sequence` out",
            )),
        }
    }

    /// Refuses a scene in which something is set where a condition comes true, for methods that do not locate that.
    pub(crate) fn check_resets(
        model: &dyn Model,
        what: &str,
        remedy: &str,
    ) -> Result<(), InputError> {
        let contacts = model.declaration().contacts;
        let resets = |known: &&ContactDeclaration| known.switch == Some(Switching::Resets);
        match contacts.iter().find(resets) {
            None => Ok(()),
            Some(contact) => Err(refusal::unsupported(
                format!("`when {}`, by {what}", contact.name),
                remedy,
            )),
        }
    }

    /// Refuses a scene in which something switches, for what knows smooth functions only; `what` is refused with a `remedy`.
    pub(crate) fn check_switches(
        model: &dyn Model,
        what: &str,
        remedy: &str,
    ) -> Result<(), InputError> {
        let contacts = model.declaration().contacts;
        match contacts.iter().find(|known| known.switch.is_some()) {
            None => Ok(()),
            Some(contact) => Err(refusal::unsupported(
                format!("the switch `{}`, by {what}", contact.name),
                remedy,
            )),
        }
    }

    /// Refuses friction in space, friction that changes with the speed or at rest, and dry friction that follows velocities or forces,
    /// for what knows one coefficient a contact and bounds of positions only; `what` is refused with a `remedy`.
    pub(crate) fn check_friction(
        model: &dyn Model,
        what: &str,
        remedy: &str,
    ) -> Result<(), InputError> {
        let contacts = model.declaration().contacts.iter();
        for contact in contacts {
            let asked = if contact.friction.is_some_and(|friction| friction.kinetic) {
                "friction with coefficients of its own at rest and in sliding"
            } else if contact
                .friction
                .is_some_and(|friction| friction.across.is_some())
            {
                "friction in space, with two sliding velocities"
            } else if contact.friction.is_some_and(|friction| friction.share) {
                "friction that changes with the speed of sliding or the place"
            } else if contact.dry
                && contact.switch.is_none()
                && reads_velocities(model, &contact.jacobian, 1)
            {
                "a bound that changes with velocities"
            } else if !contact.loads.is_empty() {
                "a bound that follows forces of surfaces or joints"
            } else {
                continue;
            };
            let asked = format!("{asked}, of `{}`, by {what}", contact.name);
            return Err(refusal::unsupported(asked, remedy));
        }
        Ok(())
    }

    /// Refuses more contacts that rest and slide with coefficients of their own than states are tried for. Beside a contact in space
    /// nothing is tried.
    fn check_breaking(model: &dyn Model) -> Result<(), InputError> {
        const MOST: usize = 6;
        let contacts = || {
            let contacts = model.declaration().contacts.iter();
            contacts.filter_map(|known| Some((known.name, known.friction?)))
        };
        let mut breaking = contacts().filter(|(_, friction)| friction.kinetic);
        let in_space = contacts().any(|(_, friction)| friction.across.is_some());
        match breaking.nth(MOST) {
            Some((name, _)) if !in_space => Err(refusal::unsupported(
                format!(
                    "`{name}`, the contact number {} with coefficients of its own at rest and in sliding,",
                    MOST + 1
                ),
                "give them one coefficient each, as in `friction mu`",
            )),
            _ => Ok(()),
        }
    }

    /// The input vector `x = (q, v, u)` at the start of a problem that was checked.
    pub(crate) fn input(&self, model: &dyn Model) -> Vec<f64> {
        let declaration = model.declaration();
        let n = declaration.coordinates.len();
        let mut x = vec![0.0; declaration.inputs()];
        x[..n].copy_from_slice(&self.q);
        x[n..2 * n].copy_from_slice(&self.v);
        self.controls
            .write_checked(0.0, &mut x[2 * n..2 * n + declaration.controls.len()]);
        x
    }
}

/// Whether no other piece of the edge that a contact belongs to is larger at the input `x`.
fn acts(model: &dyn Model, contact: usize, x: &[f64]) -> bool {
    let gap = model.gap(contact, x);
    let others = model.declaration().contacts[contact].alternatives.iter();
    others.copied().all(|other| model.gap(other, x) <= gap)
}

/// Whether a contact is closed at the start `x` of a problem that was checked.
pub(in crate::simulation) fn touches_at_start(
    model: &dyn Model,
    problem: &InitialValueProblem,
    contact: usize,
    x: &[f64],
) -> bool {
    let mut point = vec![0.0; contact_point::length(problem.q.len())];
    model.contact(contact, x, &mut point);
    let closed = problem.closed_gap(model, contact, (x, &point));
    acts(model, contact, x) && model.gap(contact, x) <= closed
}

/// What is wrong where the inertia has fallen to nothing: the first coordinate whose pivot in the mass matrix is below the share
/// [`yardstick::PROMISE`] of what it was at the start `begin`; `x` is the input here.
pub(crate) fn vanishing_inertia(model: &dyn Model, begin: &[f64], x: &[f64]) -> Option<String> {
    let coordinates = model.declaration().coordinates;
    let (then, now) = (pivots(model, begin), pivots(model, x));
    let pairs = coordinates.iter().zip(then.iter().zip(&now));
    let fallen = |(then, now): (&f64, &f64)| *now < yardstick::PROMISE * then;
    pairs
        .filter(|(_, pivots)| fallen(*pivots))
        .map(|(coordinate, (then, now))| {
            format!(
                "the inertia of `{}` falls to nothing here, {:.1e} of what it was at the start, so that its velocity grows beyond \
                 all bounds; check the kinetic energy of the scene",
                coordinate.name,
                now / then
            )
        })
        .next()
}

/// Pivots of the mass matrix without exchange of rows, each the inertia of its coordinate where those before it move freely.
fn pivots(model: &dyn Model, x: &[f64]) -> Vec<f64> {
    let n = model.declaration().coordinates.len();
    let mut mass = vec![0.0; n * n];
    model.mass_matrix(x, &mut mass);
    for k in 0..n {
        for row in k + 1..n {
            let factor = mass[row * n + k] / mass[k * n + k];
            for column in k..n {
                mass[row * n + column] -= factor * mass[k * n + column];
            }
        }
    }
    (0..n).map(|k| mass[k * n + k]).collect()
}

/// What of the model has a value at the input `x` that is infinite or not a number.
pub(in crate::simulation) fn not_finite_at(model: &dyn Model, x: &[f64]) -> Option<String> {
    let declaration = model.declaration();
    let n = declaration.coordinates.len();
    let mut acceleration = vec![0.0; n];
    model.free_acceleration(x, &mut acceleration);
    let pairs = declaration.coordinates.iter().zip(&acceleration);
    for (k, (coordinate, value)) in pairs.enumerate() {
        if !value.is_finite() {
            return Some(match declaration.state(k) {
                None => format!("the acceleration of `{}`", coordinate.name),
                Some(state) => format!("the rate of `{}`", state.name),
            });
        }
    }
    let mut point = vec![0.0; contact_point::length(n)];
    let mut contacts = declaration.contacts.iter().enumerate();
    contacts.find_map(|(i, contact)| {
        model.contact(i, x, &mut point);
        let gap = model.gap(i, x);
        if gap.is_finite() && point.iter().all(|value| value.is_finite()) {
            return None;
        }
        let what = match (contact.dry, gap.is_finite()) {
            (true, _) => "friction",
            (false, true) => "gradient of the gap",
            (false, false) => "gap",
        };
        Some(format!("the {what} of `{}`", contact.name))
    })
}

fn finite(what: &str, value: f64) -> Result<(), InputError> {
    if value.is_finite() {
        Ok(())
    } else {
        Err(refusal::not_finite(what, value))
    }
}

fn length(what: &str, found: usize, expected: usize) -> Result<(), InputError> {
    if found == expected {
        Ok(())
    } else {
        Err(refusal::wrong_length(what, found, expected))
    }
}

/// Whether a row from `first` on depends on a velocity.
fn reads_velocities(model: &dyn Model, pattern: &SparsityPattern, first: usize) -> bool {
    let n = model.declaration().coordinates.len();
    let mut entries = pattern.entries.iter();
    entries.any(|&(row, column)| row as usize >= first && (n..2 * n).contains(&(column as usize)))
}

/// Refuses friction of a contact that brakes more in sliding than at rest, or that does not brake at the start `x`.
fn check_coefficients(model: &dyn Model, contact: usize, x: &[f64]) -> Result<(), InputError> {
    let name = model.declaration().contacts[contact].name;
    let (rest, sliding) = (model.friction(contact), model.kinetic_friction(contact));
    if !(0.0..=rest).contains(&sliding) {
        return Err(refusal::out_of_range(
            format!("coefficient of friction of `{name}` in sliding (E10)"),
            sliding,
            "",
            format!("in 0..={rest}, at most that at rest"),
        ));
    }
    let share = friction_share(model, contact, x);
    if !(0.0..f64::INFINITY).contains(&share) {
        return Err(refusal::out_of_range(
            format!("coefficient of friction of `{name}` at the start (E10)"),
            share,
            "",
            "at least 0",
        ));
    }
    Ok(())
}

/// Cholesky test of the mass matrix; on failure the eigenvector of the smallest eigenvalue in words.
fn check_mass(model: &dyn Model, x: &[f64]) -> Result<(), InputError> {
    let declaration = model.declaration();
    let n = declaration.coordinates.len();
    let mut m = vec![0.0; n * n];
    model.mass_matrix(x, &mut m);
    let m = nalgebra::DMatrix::from_row_slice(n, n, &m);
    // States of first order have inertias of 1 of their own.
    let mechanical = declaration.mechanical();
    if mechanical == 0 {
        return Ok(());
    }
    let m = m.view((0, 0), (mechanical, mechanical)).into_owned();
    if m.iter().any(|value| !value.is_finite()) {
        return Err(refusal::not_finite("mass matrix at the start", f64::NAN));
    }
    let eigen = m.symmetric_eigen();
    let smallest = eigen.eigenvalues.imin();
    if eigen.eigenvalues[smallest] > 1e-14 * eigen.eigenvalues.max().abs() {
        return Ok(());
    }
    let direction = eigen.eigenvectors.column(smallest);
    let largest = direction.amax();
    let words: Vec<String> = declaration
        .coordinates
        .iter()
        .zip(direction.iter())
        .filter(|(_, weight)| weight.abs() > 1e-6 * largest)
        .map(|(coordinate, weight)| format!("{weight:+.3} {}", coordinate.name))
        .collect();
    Err(InputError::new(format!(
        "mass matrix is not positive definite at the start (E06): {} carries no positive inertia; check the masses in \
         the Lagrangian",
        words.join(" ")
    )))
}
