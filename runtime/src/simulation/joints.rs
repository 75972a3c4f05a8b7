//! Joints of a motion: its start, which they complete, and what is checked and measured after it.
//!
//! The start of a scene with joints is a guess. Newton's method in the metric of the mass matrix moves its positions onto
//! `g = 0`, with steps that are shortened until each correction is smaller than the one before it (Deuflhard's natural monotonicity
//! test), and its velocities onto `w = 0`. Rows that follow from others there are found by rank and not held; they stay
//! fulfilled where they follow from the others everywhere, and so the same rank is asked for at places nearby.

use super::{
    Diagnosis, InitialValueProblem, InputError, Simulation, SimulationStatus, number, singular,
    struck_at_start,
};
use crate::joints::{JointError, Joints};
use crate::model::{Function, JointsDeclaration, Model, Pieces, contact_point, joint_rows};
use crate::refusal;
use crate::run::resets;
use crate::yardstick;

/// Newton steps of the start.
const STEPS: usize = 100;
/// Shortest share of a Newton step.
const SHORTEST: f64 = 1e-4;
/// Share of the size of the coordinates by which a place is nearby.
const NEARBY: f64 = 1e-2;

/// A problem whose start fulfils the joints of its scene, and what is to be said of that.
pub(crate) struct Closed<'a> {
    model: &'a dyn Model,
    /// Of a scene with rows that are not held.
    reduced: Option<Box<dyn Model>>,
    /// Of a scene with joints.
    problem: Option<InitialValueProblem>,
    given: &'a InitialValueProblem,
    notes: Vec<String>,
}

impl<'a> Closed<'a> {
    /// Completes the start of a problem; the problem itself where there are no joints.
    ///
    /// # Errors
    /// [`InputError`] if the problem is refused, or its start cannot be completed.
    pub(crate) fn of(
        model: &'a dyn Model,
        given: &'a InitialValueProblem,
    ) -> Result<Self, InputError> {
        let mut closed = Self {
            model,
            reduced: None,
            problem: None,
            given,
            notes: Vec::new(),
        };
        if let Some(declared) = model.declaration().joints {
            given.check_numbers(model)?;
            closed.complete(&declared)?;
        }
        let (model, problem) = closed.scene();
        problem.check(model)?;
        if model.declaration().joints.is_some() {
            check_surfaces(model, problem)?;
        }
        let conditions = resets::true_at_start(model, &problem.input(model));
        closed.notes.extend(conditions);
        Ok(closed)
    }

    /// The scene, with the rows that are held, and the problem.
    pub(crate) fn scene(&self) -> (&dyn Model, &InitialValueProblem) {
        let model = self.reduced.as_deref().unwrap_or(self.model);
        (model, self.problem.as_ref().unwrap_or(self.given))
    }

    fn complete(&mut self, declared: &JointsDeclaration) -> Result<(), InputError> {
        let model = self.model;
        let n = self.given.q.len();
        let given = self.given.input(model);
        let mut start = Start {
            model,
            declared,
            x: given.clone(),
        };
        let held = start.close()?;
        start.check_rank(&held)?;
        let rows = joint_rows(model);
        if held.len() < rows {
            let mut reduced = model.boxed();
            for row in 0..rows {
                reduced.hold_joint_row(row, held.contains(&row));
            }
            self.reduced = Some(reduced);
            self.notes.push(redundant(declared, &held));
        }
        let x = start.x;
        self.notes
            .extend(moved(model, &given[..2 * n], &x[..2 * n]));
        self.problem = Some(InitialValueProblem {
            q: x[..n].to_vec(),
            v: x[n..2 * n].to_vec(),
            ..self.given.clone()
        });
        Ok(())
    }

    /// What the start was moved by, and which rows follow from others, in words.
    pub(crate) fn notes(&self) -> &[String] {
        &self.notes
    }

    /// Measures how well the joints hold along a `run` of a method that locates impacts, and says what is to be said of its start.
    pub(crate) fn finish(self, run: &mut Simulation) {
        self.end(run, true);
    }

    /// Measures how well the joints hold along a `run` of a method that does not locate impacts.
    pub(crate) fn finish_without_events(self, run: &mut Simulation) {
        self.end(run, false);
    }

    fn end(&self, run: &mut Simulation, locates: bool) {
        let (model, problem) = self.scene();
        let struck = struck_at_start::notes(model, problem, run, locates);
        run.notes.extend(struck);
        run.notes.extend_from_slice(&self.notes);
        let Some(declared) = model.declaration().joints else {
            return;
        };
        let left = drift(model, &declared, run);
        if let (true, Some(status)) = (run.status.is_solved(), left) {
            run.status = status;
        }
        pass_singular(model, &declared, run);
    }
}

/// Refuses a surface whose gap the joints hold: no force changes it.
fn check_surfaces(model: &dyn Model, problem: &InitialValueProblem) -> Result<(), InputError> {
    let n = problem.q.len();
    let x = problem.input(model);
    let mut point = vec![0.0; contact_point::length(n)];
    let mut mass = vec![0.0; n * n];
    model.mass_matrix(&x, &mut mass);
    let pieces = Pieces::at(model, &x);
    let size = x[..n].iter().fold(1.0, |size: f64, q| size.max(q.abs()));
    for (i, contact) in model.declaration().contacts.iter().enumerate() {
        model.contact(i, &x, &mut point);
        // Nothing acts on a surface that is open, nor on a piece in whose place another one acts.
        if contact.dry || pieces.is_idle(i) || point[contact_point::GAP] > yardstick::NOTHING * size
        {
            continue;
        }
        let normal = &point[contact_point::NORMAL..][..n];
        // At most what each coordinate would give by itself, times their number.
        let alone = (0..n).map(|k| normal[k] * normal[k] / mass[k * n + k]);
        let most: f64 = alone.sum();
        if point[contact_point::INVERSE_INERTIA] > yardstick::ROUNDING * most {
            continue;
        }
        return Err(InputError::new(format!(
            "joints hold the gap of surface `{}` at the start (E25), so that no force on it moves anything; leave the surface or \
             a joint out, or start elsewhere",
            contact.name
        )));
    }
    Ok(())
}

/// What to do where a method does not hold joints.
pub(crate) const LOCATED: &str =
    "simulate by finite elements, from event to event or by fixed steps, which hold joints";

/// Refuses a scene with joints, for methods that do not hold them.
pub(crate) fn refuse(model: &dyn Model, what: &str, remedy: &str) -> Result<(), InputError> {
    match model.declaration().joints.map(|joints| joints.list) {
        Some([first, ..]) => Err(refusal::unsupported(
            format!("joint `{}` by {what}", first.name),
            remedy,
        )),
        _ => Ok(()),
    }
}

/// The start while it is completed.
struct Start<'a> {
    model: &'a dyn Model,
    declared: &'a JointsDeclaration,
    /// Input vector.
    x: Vec<f64>,
}

impl<'m> Start<'m> {
    /// Moves the start onto the joints; the rows that are to be held.
    fn close(&mut self) -> Result<Vec<usize>, InputError> {
        let n = self.model.declaration().coordinates.len();
        for _ in 0..STEPS {
            let mut joints = self.held()?;
            let (error, largest) = self.farthest(&joints, true);
            if error.is_none() {
                break;
            }
            let step = correction(&mut joints, &self.x, n).map_err(|_| self.open())?;
            let size = norm(self.model, &self.x, &step);
            let mut share = 1.0;
            let moved = loop {
                let mut moved = self.x.clone();
                for (q, step) in moved.iter_mut().zip(&step) {
                    *q -= share * step;
                }
                joints.evaluate(&moved);
                let next = correction_along(&mut joints, &self.x, &moved, n);
                let size_next = next.map(|step| norm(self.model, &self.x, &step));
                if size_next.is_ok_and(|next| next <= (1.0 - share / 4.0) * size) {
                    break moved;
                }
                share /= 2.0;
                if share < SHORTEST {
                    // Rounding is all that is left, or nothing gets there.
                    if largest <= yardstick::NOTHING {
                        break self.x.clone();
                    }
                    return Err(self.open());
                }
            };
            let stays = moved == self.x;
            self.x = moved;
            if stays {
                break;
            }
        }
        let mut joints = self.held()?;
        if self.farthest(&joints, true).1 > yardstick::NOTHING {
            return Err(self.open());
        }
        let mut x = self.x.clone();
        joints.project_velocities(&mut x).map_err(|_| self.open())?;
        self.x = x;
        joints.evaluate(&self.x);
        if self.farthest(&joints, false).1 > yardstick::NOTHING {
            return Err(self.open_velocities(&joints));
        }
        Ok(joints.held().to_vec())
    }

    /// The joints with the rows that are independent here, evaluated.
    fn held(&self) -> Result<Joints<'m>, InputError> {
        let all = (0..self.declared.rows()).collect();
        let mut joints = Joints::with_rows(self.model, all);
        let rows = joints.independent_rows(&self.x).map_err(|_| self.open())?;
        let mut joints = Joints::with_rows(self.model, rows);
        joints.evaluate(&self.x);
        Ok(joints)
    }

    /// The row that is farthest from holding, unless all do up to rounding error, and its value as a share of its terms: of
    /// positions, or of velocities.
    fn farthest(&self, joints: &Joints<'_>, positions: bool) -> (Option<usize>, f64) {
        let rows = self.declared.rows();
        let values = joints.values();
        let values = if positions {
            &values[..rows]
        } else {
            &values[rows..]
        };
        let terms = terms(self.model, &self.x, positions);
        let mut farthest = (None, 0.0);
        for (row, (value, terms)) in values.iter().zip(&terms).enumerate() {
            let share = value.abs() / terms.max(f64::MIN_POSITIVE);
            // NaN is the farthest.
            let beyond = !(share <= 4.0 * f64::EPSILON || share <= farthest.1);
            if beyond && *value != 0.0 {
                farthest = (
                    Some(row),
                    if share.is_nan() { f64::INFINITY } else { share },
                );
            }
        }
        farthest
    }

    /// A start that cannot be closed.
    fn open(&self) -> InputError {
        let all = (0..self.declared.rows()).collect();
        let mut joints = Joints::with_rows(self.model, all);
        joints.evaluate(&self.x);
        let rows = self.declared.rows();
        let worst = (0..rows).max_by(|&a, &b| {
            let size = |row: usize| joints.values()[row].abs();
            size(a).total_cmp(&size(b))
        });
        let named = worst.and_then(|row| self.declared.equations().nth(row));
        let (name, unit) = named.map_or((String::new(), ""), |(joint, own)| {
            (joint.equation(own), joint.unit)
        });
        let value = worst.map_or(f64::NAN, |row| joints.values()[row]);
        let shown = format!("{} {unit}", number(value));
        InputError::new(format!(
            "the start cannot be completed (E25): joint {name} is off by {} where Newton's method ends; start nearer to a \
             position in which all joints hold, and check that lengths allow one",
            shown.trim_end()
        ))
    }

    /// Velocities that contradict each other.
    fn open_velocities(&self, joints: &Joints<'_>) -> InputError {
        let row = self.farthest(joints, false).0.unwrap_or_default();
        let named = self.declared.equations().nth(row);
        let (name, unit) = named.map_or((String::new(), ""), |(joint, own)| {
            (joint.equation(own), joint.unit)
        });
        let value = joints.values()[self.declared.rows() + row];
        InputError::new(format!(
            "no velocities fulfil all joints at the start (E25): the velocity of joint {name} is off by {} {unit}/s by what the \
             others give; leave one of them out",
            number(value)
        ))
    }

    /// Whether as many rows are independent nearby, in positions that the joints allow.
    fn check_rank(&self, held: &[usize]) -> Result<(), InputError> {
        let n = self.model.declaration().coordinates.len();
        let rows = self.declared.rows();
        if held.len() == rows {
            return Ok(());
        }
        let scale = self.x[..n].iter().fold(0.0_f64, |s, q| s.max(q.abs()));
        // Where all are zero nothing tells how large the mechanism is: the unit of the scene.
        let scale = if scale > 0.0 { scale } else { 1.0 };
        for sense in [1.0, -1.0] {
            let mut nearby = self.x.clone();
            for (k, q) in nearby[..n].iter_mut().enumerate() {
                // Any direction, of no meaning to a scene.
                let angle = 1.0 + 2.4 * k as f64;
                *q += sense * NEARBY * scale * angle.sin();
            }
            let mut joints = Joints::with_rows(self.model, held.to_vec());
            if joints.project_positions(&mut nearby, 0.0).is_err() {
                continue;
            }
            let mut all = Joints::with_rows(self.model, (0..rows).collect());
            let found = all.independent_rows(&nearby);
            if found.is_ok_and(|found| found.len() > held.len()) {
                return Err(InputError::new(format!(
                    "the start is a singular configuration (E25): joint {} follows from the others there and nowhere near, so that \
                     the motion is not unique; start beside it",
                    outside(self.declared, held)
                )));
            }
        }
        Ok(())
    }
}

/// Newton's correction of the positions at `x`, where the rows have been evaluated.
fn correction(joints: &mut Joints<'_>, x: &[f64], n: usize) -> Result<Vec<f64>, JointError> {
    joints.direct(x)?;
    Ok(along(joints, n))
}

/// Newton's correction of the positions at `x` along the directions at `from`.
fn correction_along(
    joints: &mut Joints<'_>,
    from: &[f64],
    x: &[f64],
    n: usize,
) -> Result<Vec<f64>, JointError> {
    let mut values = vec![0.0; joints.values().len()];
    values.copy_from_slice(joints.values());
    joints.evaluate(from);
    joints.direct(from)?;
    joints.evaluate(x);
    Ok(along(joints, n))
}

fn along(joints: &Joints<'_>, n: usize) -> Vec<f64> {
    let mut step = vec![0.0; n];
    for place in joints.positions() {
        let value = joints.position(place);
        let direction = &joints.directions()[place * n..(place + 1) * n];
        for (step, d) in step.iter_mut().zip(direction) {
            *step += value * d;
        }
    }
    step
}

/// Size in the metric of the mass matrix at `x`.
fn norm(model: &dyn Model, x: &[f64], step: &[f64]) -> f64 {
    let n = step.len();
    let mut mass = vec![0.0; n * n];
    model.mass_matrix(x, &mut mass);
    let rows = mass.chunks_exact(n.max(1)).zip(step);
    let square: f64 = rows
        .map(|(row, own)| own * row.iter().zip(step).map(|(m, s)| m * s).sum::<f64>())
        .sum();
    square.max(0.0).sqrt()
}

/// Size of the terms of each row, `sum |dw/dv| |q|` of positions and `sum |dw/dv| |v|` of velocities, with what all coordinates make
/// of it at least.
fn terms(model: &dyn Model, x: &[f64], positions: bool) -> Vec<f64> {
    let n = model.declaration().coordinates.len();
    let rows = joint_rows(model);
    let mut joints = Joints::with_rows(model, (0..rows).collect());
    joints.evaluate(x);
    let state = if positions { &x[..n] } else { &x[n..2 * n] };
    let largest = state.iter().fold(0.0_f64, |s, q| s.max(q.abs()));
    let gradients = joints.gradients().chunks_exact(n.max(1));
    gradients
        .map(|gradient| {
            let sum = gradient.iter().zip(state).map(|(g, q)| (g * q).abs());
            let steepest = gradient.iter().fold(0.0_f64, |s, g| s.max(g.abs()));
            sum.sum::<f64>().max(steepest * largest)
        })
        .collect()
}

/// Names of the rows that are not held.
fn outside(declared: &JointsDeclaration, held: &[usize]) -> String {
    let names: Vec<String> = declared
        .equations()
        .enumerate()
        .filter(|(row, _)| !held.contains(row))
        .map(|(_, (joint, own))| joint.equation(own))
        .collect();
    names.join(", ")
}

fn redundant(declared: &JointsDeclaration, held: &[usize]) -> String {
    format!(
        "joint {} is redundant and follows from the others: the motion is the same without, and of the forces that joints share the smallest are given",
        outside(declared, held)
    )
}

/// By how much a start was moved, if by more than rounding.
fn moved(model: &dyn Model, from: &[f64], to: &[f64]) -> Option<String> {
    let coordinates = model.declaration().coordinates;
    let n = coordinates.len();
    let largest = |values: &[f64]| values.iter().fold(0.0_f64, |s, x| s.max(x.abs()));
    let sizes = [largest(&to[..n]), largest(&to[n..])];
    let mut words = Vec::new();
    for (i, (from, to)) in from.iter().zip(to).enumerate() {
        let velocity = i >= n;
        if (to - from).abs() <= yardstick::NOTHING * sizes[usize::from(velocity)] {
            continue;
        }
        let coordinate = &coordinates[i % n];
        let (name, unit) = match velocity {
            false => (coordinate.name.to_owned(), coordinate.unit.to_owned()),
            true => (
                format!("dot({})", coordinate.name),
                super::per_second(coordinate.unit),
            ),
        };
        let shown = format!("{name} from {} to {} {unit}", number(*from), number(*to));
        words.push(shown.trim_end().to_owned());
    }
    if words.is_empty() {
        return None;
    }
    Some(format!(
        "the start was completed, so that all joints hold: {}{}",
        words.join(", "),
        off(model, from, to)
    ))
}

/// How far the joints are from holding at a start `from` that was moved, where that is more than rounding of what their terms are there and
/// at its end `to`.
fn off(model: &dyn Model, from: &[f64], to: &[f64]) -> String {
    let declaration = model.declaration();
    let Some(declared) = declaration.joints else {
        return String::new();
    };
    let rows = declared.rows();
    let at = |state: &[f64]| {
        let mut x = state.to_vec();
        x.resize(declaration.inputs(), 0.0);
        x
    };
    let (from, to) = (at(from), at(to));
    let mut values = vec![0.0; 2 * rows];
    model.values(Function::Joints, &from, &mut values);
    let mut words = Vec::new();
    for (row, (joint, own)) in declared.equations().enumerate() {
        for (positions, value) in [(true, values[row]), (false, values[rows + row])] {
            let size = |x: &[f64]| terms(model, x, positions)[row];
            if value.abs() <= yardstick::NOTHING * size(&from).max(size(&to)) {
                continue;
            }
            let (what, unit) = match positions {
                true => ("", joint.unit.to_owned()),
                false => ("the velocity of ", super::per_second(joint.unit)),
            };
            let shown = format!("{} {unit}", number(value));
            let equation = joint.equation(own);
            words.push(format!("{} in {what}{equation}", shown.trim_end()));
        }
    }
    match words.is_empty() {
        true => String::new(),
        false => format!("; as given they were off by {}", words.join(", ")),
    }
}

/// Adds how far rows are from holding along a run to its residuals; a status where a row that was not held does not follow from the
/// others any longer.
fn drift(
    model: &dyn Model,
    declared: &JointsDeclaration,
    run: &mut Simulation,
) -> Option<SimulationStatus> {
    let rows = declared.rows();
    let mut values = vec![0.0; 2 * rows];
    let mut x = vec![0.0; model.declaration().inputs()];
    let mut left = None;
    for k in 0..run.trajectory.time.len() {
        input(model, run, k, &mut x);
        model.values(Function::Joints, &x, &mut values);
        let largest = values.iter().fold(0.0_f64, |s, value| s.max(value.abs()));
        if largest.is_finite() {
            run.residuals.primal = run.residuals.primal.max(largest);
        }
        let free = (0..rows).filter(|&row| !model.joint_row_held(row));
        let far = |row: &usize| {
            let size = terms(model, &x, true)[*row];
            values[*row].abs() > yardstick::PROMISE * size
        };
        if left.is_none()
            && let Some(row) = free.clone().find(far)
        {
            let (joint, own) = declared.equations().nth(row)?;
            left = Some(SimulationStatus::StepFailed(Diagnosis {
                time: run.trajectory.time[k],
                step: 0,
                contact: None,
                message: format!(
                    "joint {} followed from the others at the start and does not any longer: the start is a singular \
                     configuration; start beside it",
                    joint.equation(own)
                ),
            }));
        }
    }
    left
}

/// Ends a run before the first singular configuration on its way.
fn pass_singular(model: &dyn Model, declared: &JointsDeclaration, run: &mut Simulation) {
    let inputs = model.declaration().inputs();
    let found = singular::first(model, run, |k| {
        let mut x = vec![0.0; inputs];
        input(model, run, k, &mut x);
        x
    });
    let Some((time, row)) = found else {
        return;
    };
    let name = declared
        .equations()
        .nth(row)
        .map_or_else(String::new, |(joint, own)| joint.equation(own));
    let kept = run.trajectory.time.partition_point(|&t| t < time);
    run.trajectory.truncate(kept);
    run.events.retain(|event| event.time < time);
    run.error_estimate = None;
    run.status = SimulationStatus::StepFailed(Diagnosis {
        time,
        step: 0,
        contact: None,
        message: format!(
            "the joints pass a singular configuration, in which {name} follows from the others, so that the motion may go on in \
             more than one way; end it before, or change lengths or the start so that it is not passed"
        ),
    });
}

/// The input vector at an instant of a trajectory.
fn input(model: &dyn Model, run: &Simulation, k: usize, x: &mut [f64]) {
    let trajectory = &run.trajectory;
    let (q, v, u) = (&trajectory.q[k], &trajectory.v[k], &trajectory.u[k]);
    let (n, m) = (q.len(), u.len());
    x[..n].copy_from_slice(q);
    x[n..2 * n].copy_from_slice(v);
    x[2 * n..2 * n + m].copy_from_slice(u);
    if model.declaration().explicit_time {
        x[2 * n + m] = trajectory.time[k];
    }
}
