//! Where a walk along a motion is: what is known of the motion, the derivatives so far, and what has none there.

use super::acceleration::{Acceleration, Hold, input};
use super::arc::{Arc, At, Step, stage_input};
use super::cause::{VANISHED, terms};
use super::front::Front;
use super::matrix::largest;
use super::wanted::Wanted;
use crate::model::{ControlPiece, Model, Switching, contact_point, tangent_point};
use crate::simulation::{ContactMode, InitialValueProblem, Simulation};

/// Share of its terms that the derivative of what a contact holds may have.
pub(super) const HELD: f64 = 1e-6;
/// The same after a step, which has the error of the motion.
pub(super) const DRIFT: f64 = 1e-3;
/// Share of the largest derivative that rounding may leave of one.
pub(super) const ROUNDING: f64 = 1e-9;
/// Share of the largest gap that counts as none where a contact passes its surface.
const TOUCHED: f64 = 1e-9;
/// Halvings of a step in search of the least gap: its value changes with their square.
const BISECTIONS: usize = 30;

/// A place of a motion.
// Many fields: what is known of the motion, and where in it the walk is.
pub(super) struct Place<'w> {
    pub(super) run: &'w Simulation,
    pub(super) problem: &'w InitialValueProblem,
    /// The quantities that are asked for; the derivatives may be those along one direction of them.
    pub(super) asked: &'w Wanted,
    pub(super) front: Front<'w>,
    pub(super) acceleration: Acceleration<'w>,
    pub(super) arc: Arc,
    pub(super) modes: Vec<ContactMode>,
    pub(super) closing_speeds: Vec<f64>,
    pub(super) gap_sizes: Vec<f64>,
    /// Gap and normal velocity of each contact at each instant.
    open_sides: Vec<Vec<[f64; 2]>>,
    /// Largest coordinate and velocity of the motion.
    pub(super) sizes: [f64; 2],
}

impl<'w> Place<'w> {
    /// The start of a motion; none without coordinates.
    pub(super) fn at_start(
        model: &'w dyn Model,
        problem: &'w InitialValueProblem,
        run: &'w Simulation,
        wanted: &'w Wanted,
    ) -> Option<Self> {
        let contacts = model.declaration().contacts.len();
        let size = |rows: &[Vec<f64>]| rows.iter().map(|row| largest(row)).fold(0.0, f64::max);
        let trajectory = &run.trajectory;
        let open_sides = sides(model, run);
        let most = |side: usize| -> Vec<f64> {
            let contact = |i: usize| {
                open_sides
                    .iter()
                    .map(move |row: &Vec<[f64; 2]>| row[i][side].abs())
            };
            (0..contacts)
                .map(|i| contact(i).fold(0.0, f64::max))
                .collect()
        };
        Some(Self {
            acceleration: Acceleration::new(model, wanted),
            arc: Arc::new()?,
            modes: run.initial_modes.clone(),
            front: Front::at_start(model, problem, wanted),
            gap_sizes: most(0),
            closing_speeds: most(1),
            open_sides,
            sizes: [
                size(&trajectory.q).max(f64::MIN_POSITIVE),
                size(&trajectory.v),
            ],
            asked: wanted,
            run,
            problem,
        })
        .filter(|_| !problem.q.is_empty())
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
        self.acceleration.set_mode(&self.modes);
        self.acceleration.keep_independent(&x);
        self.evaluate(k)
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

    /// Derivatives of the horizon.
    pub(super) fn horizon_moves(&self) -> Vec<f64> {
        self.front
            .wanted
            .of_horizon(self.acceleration.model, self.problem)
    }

    /// Whether the velocities of two input vectors differ by more than a share of the largest one of the motion.
    pub(super) fn velocities_differ(&self, one: &[f64], other: &[f64], share: f64) -> bool {
        let mut velocities = self.acceleration.n..2 * self.acceleration.n;
        velocities.any(|i| (one[i] - other[i]).abs() > share * self.sizes[1])
    }

    /// Whether the function of a condition vanishes at `x`, or is positive.
    pub(super) fn holds(&mut self, condition: usize, (x, time): (&[f64], f64)) -> bool {
        self.acceleration.load_contact(condition, x);
        let (against, by) = self
            .acceleration
            .tangent(condition, tangent_point::SLIDING_VELOCITY);
        against <= VANISHED * terms(self.sizes, self.acceleration.n, by, (x, time))
    }

    /// No open contact touches its surface within the step that was solved last and opens again: a neighbouring motion
    /// would strike it.
    pub(super) fn check_touches(&mut self, step: Step<'_>, k: usize) -> Result<(), String> {
        let declared = self.acceleration.model.declaration().contacts;
        for (contact, declared) in declared.iter().enumerate() {
            let open = self.modes.get(contact) == Some(&ContactMode::Open);
            let sides = &self.open_sides;
            let ([gap, speed], [next_gap, next]) = (sides[k][contact], sides[k + 1][contact]);
            let least = ROUNDING * self.closing_speeds[contact];
            if !open || !declared.alternatives.is_empty() || speed >= -least || next < -least {
                continue;
            }
            // The gap falls no faster than it ever does.
            let fall = (step.to.time - step.from.time) * self.closing_speeds[contact];
            let lowest = gap.min(next_gap) - fall;
            let touched = TOUCHED * self.gap_sizes[contact];
            if lowest > touched {
                continue;
            }
            let (time, gap) = self.least_gap(step, contact);
            if gap.abs() <= touched {
                return Err(format!(
                    "at t = {time} s `{}` only grazes: it touches and is not struck, but is so for other parameters",
                    declared.name
                ));
            }
        }
        Ok(())
    }

    /// Where the gap of a contact that closes at the start of a step and opens at its end is the least, and that.
    pub(super) fn least_gap(&mut self, step: Step<'_>, contact: usize) -> (f64, f64) {
        let model = self.acceleration.model;
        let mut point = vec![0.0; contact_point::length(self.acceleration.n)];
        let (mut low, mut high) = (0.0, 1.0);
        let mut found = (step.from.time, f64::INFINITY);
        for _ in 0..BISECTIONS {
            let theta = 0.5 * (low + high);
            let (q, v) = self.arc.within(step, theta);
            let time = step.from.time + theta * (step.to.time - step.from.time);
            let x = stage_input(&self.acceleration, (&q, &v), time, step.controls);
            model.contact(contact, &x, &mut point);
            found = (time, point[contact_point::GAP]);
            if point[contact_point::NORMAL_VELOCITY] < 0.0 {
                low = theta;
            } else {
                high = theta;
            }
        }
        found
    }

    /// Contacts that are struck at the start are so for all neighbouring starts.
    pub(super) fn check_start(&mut self, struck: &[usize]) -> Result<(), String> {
        let x = self.input(0);
        for &contact in struck {
            self.acceleration.load_contact(contact, &x);
            self.check_zero(contact, contact_point::GAP, (0, HELD))?;
        }
        Ok(())
    }

    /// No contact slides from rest at the start, and nothing switches there, for these values only: the other side acts first then.
    pub(super) fn check_sides(&self, k: usize) -> Result<(), String> {
        let declared = self.acceleration.model.declaration().contacts;
        for (contact, mode) in self.modes.iter().enumerate() {
            let passes = declared[contact].switch.is_some_and(Switching::passes);
            if passes || !matches!(mode, ContactMode::Slip(_)) {
                continue;
            }
            let (value, by) = self
                .acceleration
                .tangent(contact, tangent_point::SLIDING_VELOCITY);
            let size = match declared[contact].switch {
                Some(_) => {
                    let (x, time) = (self.input(k), self.run.trajectory.time[k]);
                    terms(self.sizes, self.acceleration.n, by, (&x, time))
                }
                None => self.sizes[1] * largest(by),
            };
            if value.abs() <= ROUNDING * size {
                self.check_row(contact, by, (k, HELD))?;
            }
        }
        Ok(())
    }

    /// What contacts hold does not change with what the motion is differentiated by.
    pub(super) fn check_holds(&self, k: usize, share: f64) -> Result<(), String> {
        let times = &self.run.trajectory.time;
        if times[k] <= times[0] {
            self.check_sides(k)?;
        }
        for &hold in &self.acceleration.holds {
            match hold {
                Hold::Normal { contact, .. } => {
                    self.check_laws(contact, k)?;
                    self.check_zero(contact, contact_point::GAP, (k, share))?;
                    self.check_zero(contact, contact_point::NORMAL_VELOCITY, (k, share))?;
                }
                Hold::Tangent { contact } => {
                    let (_, by) = self
                        .acceleration
                        .tangent(contact, tangent_point::SLIDING_VELOCITY);
                    self.check_row(contact, by, (k, share))?;
                }
            }
        }
        Ok(())
    }

    /// No coefficient of a law stands at its limit of 0 and is moved from there: what follows differs on both sides.
    pub(super) fn check_laws(&self, contact: usize, k: usize) -> Result<(), String> {
        let model = self.acceleration.model;
        let declared = &model.declaration().contacts[contact];
        let (mu, friction_by) = self.acceleration.friction(contact);
        let wanted = self.asked;
        let mut restitution_by = vec![0.0; wanted.parameters];
        wanted.derivatives.restitution(contact, &mut restitution_by);
        let e = model.restitution(contact);
        for column in 0..wanted.count() {
            let Some(parameter) = wanted.parameter(column) else {
                continue;
            };
            let laws = [
                ("restitution", e, restitution_by[parameter]),
                ("friction", mu, friction_by[parameter]),
            ];
            for (law, value, by) in laws {
                if value == 0.0 && by != 0.0 {
                    return Err(format!(
                        "at t = {} s `{}` has a coefficient of {law} of 0, below which there is nothing: by `{}` there is a \
                         derivative to one side only",
                        self.run.trajectory.time[k], declared.name, wanted.names[column]
                    ));
                }
            }
        }
        Ok(())
    }

    pub(super) fn check_zero(
        &self,
        contact: usize,
        component: usize,
        at: (usize, f64),
    ) -> Result<(), String> {
        self.check_row(contact, self.acceleration.point(contact, component).1, at)
    }

    pub(super) fn check_row(
        &self,
        contact: usize,
        by: &[f64],
        (k, share): (usize, f64),
    ) -> Result<(), String> {
        let (state, wanted) = (&self.front.state, self.front.wanted);
        let most = largest(&state.values) * largest(by);
        for column in 0..wanted.count() {
            let change = wanted.along(by, state, column);
            let terms = (0..state.values.len() / state.columns)
                .map(|i| (by[i] * state.row(i)[column]).abs());
            let own = wanted.own(by, column).abs();
            let size = terms.sum::<f64>() + own;
            if change.abs() > (share * size).max(ROUNDING * most) {
                let declared = &self.acceleration.model.declaration().contacts[contact];
                let name = declared.name;
                let [state, other] = match self.modes.get(contact) {
                    Some(ContactMode::Slip(_)) if declared.dry => {
                        ["at its edge", "changes its side"]
                    }
                    _ => ["closed, or struck,", "opens it or presses it in"],
                };
                return Err(format!(
                    "at t = {} s `{name}` is {state} for these values only: another `{}` {other}",
                    self.run.trajectory.time[k], wanted.names[column]
                ));
            }
        }
        Ok(())
    }
}

/// Gap and normal velocity of each contact at each instant of a motion.
fn sides(model: &dyn Model, run: &Simulation) -> Vec<Vec<[f64; 2]>> {
    let declaration = model.declaration();
    let mut point = vec![0.0; contact_point::length(declaration.coordinates.len())];
    let trajectory = &run.trajectory;
    let instants = 0..trajectory.time.len();
    let mut of = |k: usize| {
        let (q, v, u) = (&trajectory.q[k], &trajectory.v[k], &trajectory.u[k]);
        let x = input(model, (q, v, u), trajectory.time[k]);
        let contacts = 0..declaration.contacts.len();
        let sides = contacts.map(|contact| {
            model.contact(contact, &x, &mut point);
            [contact_point::GAP, contact_point::NORMAL_VELOCITY].map(|side| point[side])
        });
        sides.collect()
    };
    instants.map(&mut of).collect()
}
