//! Where a walk along a motion is, and what is known of the motion there.

use super::cost::Cost;
use super::mode::{Acceleration, input};
use super::quantities::Quantities;
use super::step::{At, STAGES, Step, Steps};
use crate::linalg::products::largest;
use crate::model::{ControlPiece, Model, contact_point, tangent_point};
use crate::simulation::{ContactMode, Direction, InitialValueProblem, Simulation};
use crate::yardstick;

/// Share of the sizes of its terms that a vanishing force or sliding velocity may have.
pub(super) const VANISHED: f64 = 1e-5;

/// A place of a motion.
pub(super) struct Place<'w> {
    pub(super) run: &'w Simulation,
    pub(super) problem: &'w InitialValueProblem,
    pub(super) acceleration: Acceleration<'w>,
    /// The objective, if its derivatives are known.
    pub(super) cost: Option<Cost<'w>>,
    pub(super) steps: Steps,
    pub(super) modes: Vec<ContactMode>,
    /// Largest normal velocity, and gap, of each contact in the whole motion.
    pub(super) closing_speeds: Vec<f64>,
    pub(super) gap_sizes: Vec<f64>,
    /// Largest coordinate and velocity of the motion; of velocities those at least that are more than rounding of the coordinates.
    pub(super) sizes: [f64; 2],
}

impl<'w> Place<'w> {
    /// The start of a motion; none without coordinates.
    pub(super) fn at_start(
        model: &'w dyn Model,
        (problem, run): (&'w InitialValueProblem, &'w Simulation),
        quantities: &Quantities,
    ) -> Option<Self> {
        let (layout, derivatives) = (quantities.layout(model), &quantities.derivatives);
        let size = |rows: &[Vec<f64>]| rows.iter().map(|row| largest(row)).fold(0.0, f64::max);
        let trajectory = &run.trajectory;
        let [gap_sizes, closing_speeds] = sides(model, run);
        let place = size(&trajectory.q).max(f64::MIN_POSITIVE);
        Some(Self {
            acceleration: Acceleration::new(model, (derivatives.clone(), layout)),
            cost: Cost::of(model, derivatives, layout),
            steps: Steps::of(STAGES)?,
            modes: run.initial_modes.clone(),
            closing_speeds,
            gap_sizes,
            sizes: [
                place,
                size(&trajectory.v).max(yardstick::NOTHING * place / problem.horizon),
            ],
            run,
            problem,
        })
        .filter(|_| !problem.q.is_empty())
    }

    /// The time of an instant.
    pub(super) fn time(&self, k: usize) -> f64 {
        self.run.trajectory.time[k]
    }

    /// The name of a contact.
    pub(super) fn name_of(&self, contact: usize) -> &'static str {
        self.acceleration.model.declaration().contacts[contact].name
    }

    /// Whether a contact with a surface is closed at present.
    pub(super) fn is_closed(&self, contact: usize) -> bool {
        let declared = &self.acceleration.model.declaration().contacts[contact];
        let mode = self.modes.get(contact);
        !declared.dry && mode.is_some_and(|mode| *mode != ContactMode::Open)
    }

    pub(super) fn undetermined(&self, k: usize) -> String {
        format!(
            "at t = {} s the contact forces are not determined, so that neither are their derivatives",
            self.run.trajectory.time[k]
        )
    }

    /// The input vector at an instant.
    pub(super) fn input(&self, k: usize) -> Vec<f64> {
        let trajectory = &self.run.trajectory;
        let (q, v, u) = (&trajectory.q[k], &trajectory.v[k], &trajectory.u[k]);
        input(self.acceleration.model, (q, v, u), trajectory.time[k])
    }

    /// The controls around an instant.
    pub(super) fn controls(&self, time: f64) -> ControlPiece {
        let count = self.acceleration.model.declaration().controls.len();
        let mut piece = ControlPiece::default();
        self.problem.controls.take_piece(time, count, &mut piece);
        piece
    }

    /// Enters the present mode at an instant.
    pub(super) fn enter(&mut self, k: usize) -> Result<(), String> {
        let x = self.input(k);
        if self.enter_at(&x) {
            Ok(())
        } else {
            Err(self.undetermined(k))
        }
    }

    /// Enters the present mode at an input vector; `false` if the forces are not determined there.
    pub(super) fn enter_at(&mut self, x: &[f64]) -> bool {
        self.acceleration.set_mode(&self.modes);
        self.acceleration.keep_independent(x);
        self.acceleration.evaluate(x)
    }

    /// Evaluates the motion at an instant in the mode that was entered.
    pub(super) fn evaluate(&mut self, k: usize) -> Result<(), String> {
        let x = self.input(k);
        if self.acceleration.evaluate(&x) {
            Ok(())
        } else {
            Err(self.undetermined(k))
        }
    }

    /// Rates of everything along the motion at `x`, where the acceleration is evaluated, under controls with these rates.
    pub(super) fn rates(&self, x: &[f64], control_rates: &[f64]) -> Vec<f64> {
        let (layout, n) = (self.acceleration.layout, self.acceleration.n);
        let mut rates = vec![0.0; layout.rows()];
        rates[..n].copy_from_slice(&x[n..2 * n]);
        rates[n..2 * n].copy_from_slice(&self.acceleration.value);
        rates[2 * n..][..control_rates.len()].copy_from_slice(control_rates);
        rates[layout.time()] = 1.0;
        rates[layout.cost()] = self.cost.as_ref().map_or(0.0, |cost| cost.rate(x));
        rates
    }

    /// The step that ends at instant `k`.
    pub(super) fn step_to<'s>(&self, k: usize, controls: &'s ControlPiece) -> Step<'s>
    where
        'w: 's,
    {
        let trajectory = &self.run.trajectory;
        let at = |k: usize| At {
            time: trajectory.time[k],
            q: &trajectory.q[k],
            v: &trajectory.v[k],
        };
        Step {
            from: at(k - 1),
            to: at(k),
            controls,
        }
    }

    /// Whether the velocities of two input vectors differ by more than a share of the largest one of the motion.
    pub(super) fn velocities_differ(&self, one: &[f64], other: &[f64], share: f64) -> bool {
        let mut velocities = self.acceleration.n..2 * self.acceleration.n;
        velocities.any(|i| (one[i] - other[i]).abs() > share * self.sizes[1])
    }

    /// Size of the terms of a function with these derivatives by the input vector `x` at a time.
    pub(super) fn terms(&self, by: &[f64], (x, time): (&[f64], f64)) -> f64 {
        let n = self.acceleration.n;
        let of = |i: usize| match i {
            i if i < n => self.sizes[0],
            i if i < 2 * n => self.sizes[1],
            i => x[i].abs().max(time),
        };
        (0..x.len()).map(|i| by[i].abs() * of(i)).sum()
    }

    /// Whether the function of a condition vanishes at `x`, or is positive.
    pub(super) fn holds(&mut self, condition: usize, (x, time): (&[f64], f64)) -> bool {
        self.acceleration.load_contact(condition, x);
        let component = tangent_point::SLIDING_VELOCITY;
        let (against, by) = self.acceleration.tangent(condition, component);
        against <= VANISHED * self.terms(by, (x, time))
    }

    /// Whether accelerations at `x` are others on the other side of a switch or of friction. They are evaluated on this side afterwards.
    pub(super) fn jumps(&mut self, contact: usize, x: &[f64]) -> bool {
        let other = match self.modes.get(contact) {
            Some(ContactMode::Slip(side)) => ContactMode::Slip(Direction::of(-side.sign())),
            _ => return false,
        };
        let own = self.acceleration.value.clone();
        let size = largest(&own).max(largest(self.acceleration.free_acceleration()));
        let mut modes = self.modes.clone();
        modes[contact] = other;
        self.acceleration.set_mode(&modes);
        self.acceleration.keep_independent(x);
        let known = self.acceleration.evaluate_values(x);
        let pairs = own.iter().zip(&self.acceleration.value);
        let most = pairs.fold(0.0_f64, |most, (a, b)| most.max((a - b).abs()));
        self.enter_at(x);
        known && most > yardstick::NOTHING * size
    }
}

/// Largest gap and normal velocity of each contact in a motion.
fn sides(model: &dyn Model, run: &Simulation) -> [Vec<f64>; 2] {
    let declaration = model.declaration();
    let contacts = declaration.contacts.len();
    let mut point = vec![0.0; contact_point::length(declaration.coordinates.len())];
    let mut most = [vec![0.0_f64; contacts], vec![0.0_f64; contacts]];
    let trajectory = &run.trajectory;
    for k in 0..trajectory.time.len() {
        let (q, v, u) = (&trajectory.q[k], &trajectory.v[k], &trajectory.u[k]);
        let x = input(model, (q, v, u), trajectory.time[k]);
        for contact in 0..contacts {
            model.contact(contact, &x, &mut point);
            let sides = [contact_point::GAP, contact_point::NORMAL_VELOCITY];
            for (most, side) in most.iter_mut().zip(sides) {
                most[contact] = most[contact].max(point[side].abs());
            }
        }
    }
    most
}
