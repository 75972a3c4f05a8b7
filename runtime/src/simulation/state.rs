//! States of a simulation by name and time.

use std::fmt;
use std::ops::Index;

use super::quantity::{Quantity, number, per_second};
use super::recorder::{Instant, Recorder};
use crate::model::{Declaration, VariableDeclaration};

/// State of a simulation at one instant, see [`Simulation::at`](super::Simulation::at).
///
/// Values are read by name: a coordinate `"z"`, its velocity `"dot(z)"`, a state of first order `"a"`, a control `"u"`, the normal and the tangential
/// force of a contact `"force(floor)"` and `"friction_force(floor)"` (or `"friction(floor)"`), the impulses of all its
/// impacts so far `"impulse(floor)"` and `"friction_impulse(floor)"`, `"time"`, and what the scene declares in `outputs`.
/// Impulses are not numbers where the method does not tell impacts from lasting forces.
///
/// ```
/// use hangtime::prelude::*;
///
/// # hangtime::model! {
/// #     /// A ball above a floor.
/// #     pub Ball {
/// #         parameters { m: kg = 1, g: m/s^2 = 9.81 }
/// #         coordinates { z: m }
/// #         lagrangian m/2*dot(z)^2 - m*g*z
/// #         surface floor: z >= 0
/// #         impact floor: inelastic
/// #         outputs { energy: J = m/2*dot(z)^2 + m*g*z }
/// #         start { z: 1 [m] }
/// #         horizon 1 [s]
/// #     }
/// # }
/// let ball = Ball::default();
/// let state = simulate(&ball).run()?.at(0.3)?;
/// assert!((state["energy"] - 9.81).abs() < 1e-9);
/// assert!((state["z"] - (1.0 - 9.81 / 2.0 * 0.09)).abs() < 1e-9);
/// assert!((state["dot(z)"] + 9.81 * 0.3).abs() < 1e-9);
/// assert_eq!(state["force(floor)"], 0.0);
/// # Ok::<(), InputError>(())
/// ```
#[derive(Debug, Clone)]
pub struct State {
    /// Physical time \[s\].
    pub time: f64,
    /// Coordinates, in order of declaration.
    pub q: Vec<f64>,
    /// Velocities.
    pub v: Vec<f64>,
    /// Controls.
    pub u: Vec<f64>,
    /// Contact forces, 0 for open contacts: the normal forces where gaps are distances.
    pub contact_force: Vec<f64>,
    /// Tangential contact forces; empty if no contact declares friction.
    pub friction_force: Vec<f64>,
    /// What the scene declares in `outputs`, in order of declaration.
    pub outputs: Vec<f64>,
    /// Impulses of all impacts so far, normal and then tangential.
    pub(super) impulses: Vec<f64>,
    pub(super) declaration: &'static Declaration,
    pub(super) recorder: Option<Recorder>,
}

impl State {
    /// The value of that name, if there is one.
    #[must_use]
    pub fn get(&self, name: &str) -> Option<f64> {
        let values = |vector: &[f64], index| vector.get(index).copied();
        match Quantity::named(self.declaration, self.recorded(), name)? {
            Quantity::Time => Some(self.time),
            Quantity::Coordinate(k) => values(&self.q, k),
            Quantity::Velocity(k) => values(&self.v, k),
            Quantity::Control(k) => values(&self.u, k),
            Quantity::Force(i) => values(&self.contact_force, i),
            Quantity::Friction(i) => values(&self.friction_force, i),
            Quantity::Impulse(i) => values(&self.impulses, i),
            Quantity::FrictionImpulse(i) => values(&self.impulses, self.contact_force.len() + i),
            Quantity::Output(i) => values(&self.outputs, i),
        }
    }

    /// The state at a time between two of different times, see [`Simulation::at`](super::Simulation::at).
    pub(super) fn between(from: &Self, to: &Self, time: f64) -> Self {
        let h = to.time - from.time;
        let s = (time - from.time) / h;
        let linear = |from: &[f64], to: &[f64]| -> Vec<f64> {
            let ends = from.iter().zip(to);
            ends.map(|(from, to)| from + s * (to - from)).collect()
        };
        let (mut q, mut v) = (linear(&from.q, &to.q), linear(&from.v, &to.v));
        for k in 0..q.len() {
            let (q_0, q_1, v_0, v_1) = (from.q[k], to.q[k], from.v[k], to.v[k]);
            let mean = (q_1 - q_0) / h;
            q[k] += h * s * (1.0 - s) * ((1.0 - s) * (v_0 - mean) - s * (v_1 - mean));
            // On the shortest steps the difference of the positions holds nothing but rounding.
            let excess = mean - 0.5 * (v_0 + v_1);
            if excess.abs() * h > 4.0 * f64::EPSILON * q_0.abs().max(q_1.abs()) {
                v[k] += 6.0 * s * (1.0 - s) * excess;
            }
        }
        let mut state = Self {
            time,
            q,
            v,
            u: linear(&from.u, &to.u),
            contact_force: linear(&from.contact_force, &to.contact_force),
            friction_force: linear(&from.friction_force, &to.friction_force),
            outputs: Vec::new(),
            impulses: from.impulses.clone(),
            declaration: from.declaration,
            recorder: from.recorder.clone(),
        };
        if let Some(recorder) = &state.recorder {
            state.outputs = recorder.values(Instant {
                time,
                q: &state.q,
                v: &state.v,
                u: &state.u,
                contact_force: &state.contact_force,
                friction_force: &state.friction_force,
                impulses: &state.impulses,
            });
        }
        state
    }

    /// Names of the outputs.
    fn recorded(&self) -> &'static [VariableDeclaration] {
        self.recorder.as_ref().map_or(&[], Recorder::declared)
    }
}

impl Index<&str> for State {
    type Output = f64;

    /// The value of that name.
    ///
    /// # Panics
    /// If the scene knows no such name; [`State::get`] asks.
    fn index(&self, name: &str) -> &f64 {
        let value = match Quantity::named(self.declaration, self.recorded(), name) {
            None => None,
            Some(Quantity::Time) => Some(&self.time),
            Some(Quantity::Coordinate(k)) => self.q.get(k),
            Some(Quantity::Velocity(k)) => self.v.get(k),
            Some(Quantity::Control(k)) => self.u.get(k),
            Some(Quantity::Force(i)) => self.contact_force.get(i),
            Some(Quantity::Friction(i)) => self.friction_force.get(i),
            Some(Quantity::Impulse(i)) => self.impulses.get(i),
            Some(Quantity::FrictionImpulse(i)) => self.impulses.get(self.contact_force.len() + i),
            Some(Quantity::Output(i)) => self.outputs.get(i),
        };
        value.unwrap_or_else(|| {
            panic!(
                "{}",
                Quantity::unknown(self.declaration, self.recorded(), name)
            )
        })
    }
}

impl fmt::Display for State {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "t = {} s:", number(self.time))?;
        let mechanical = self.declaration.mechanical();
        let coordinates = &self.declaration.coordinates[..mechanical];
        for (k, known) in coordinates.iter().enumerate() {
            let comma = if k == 0 { "" } else { "," };
            write!(
                f,
                "{comma} {} = {} {}",
                known.name,
                number(self.q[k]),
                known.unit
            )?;
        }
        for (k, known) in coordinates.iter().enumerate() {
            let unit = per_second(known.unit);
            write!(f, ", dot({}) = {} {unit}", known.name, number(self.v[k]))?;
        }
        let states = self.declaration.states.iter();
        for (known, value) in states.zip(&self.v[mechanical..]) {
            write!(f, ", {} = {} {}", known.name, number(*value), known.unit)?;
        }
        for (known, value) in self.declaration.controls.iter().zip(&self.u) {
            write!(f, ", {} = {} {}", known.name, number(*value), known.unit)?;
        }
        Ok(())
    }
}
