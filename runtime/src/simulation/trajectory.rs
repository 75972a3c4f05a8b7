//! States over time, as a simulation records them.

use std::sync::OnceLock;

use super::recorder::{Impulses, Instant, Recorder};
use crate::model::{Model, VariableDeclaration};

/// States over time; entry `k` of every field belongs to the same instant.
///
/// ```
/// use hangtime::prelude::*;
///
/// # hangtime::model! {
/// #     /// A ball above a floor.
/// #     pub Ball {
/// #         parameters { m: kg = 1, g: m/s^2 = 9.81, height: m = 1 }
/// #         coordinates { z: m }
/// #         lagrangian m/2*dot(z)^2 - m*g*z
/// #         surface floor: z >= 0
/// #         impact floor: inelastic
/// #         start { z: height }
/// #         horizon 1 [s]
/// #     }
/// # }
/// let ball = Ball::default();
/// let Trajectory { time, q, .. } = simulate(&ball).run()?.trajectory;
/// assert_eq!((time[0], q[0][0]), (0.0, 1.0));
/// # Ok::<(), InputError>(())
/// ```
#[derive(Debug, Clone, Default)]
pub struct Trajectory {
    /// Physical time \[s\], not decreasing (equal across an impact).
    pub time: Vec<f64>,
    /// Numerical time of the time-freezing system \[s\]: grows faster in contact, and alone during a jump.
    pub numerical_time: Vec<f64>,
    /// Coordinates, one vector an instant.
    pub q: Vec<Vec<f64>>,
    /// Velocities, one vector an instant.
    pub v: Vec<Vec<f64>>,
    /// Controls, one vector an instant.
    pub u: Vec<Vec<f64>>,
    /// Contact forces `lambda` [N for a gap in metres], one vector an instant, 0 for open contacts; of dry friction its bound.
    /// Each acts as `lambda` times the gradient of the gap: it is the normal force where the gap is a distance.
    pub contact_force: Vec<Vec<f64>>,
    /// Tangential contact forces, one vector an instant, 0 for contacts that carry none; no vector at
    /// all if no contact declares friction.
    pub friction_force: Vec<Vec<f64>>,
    /// All of these by quantity instead of instant, gathered when first asked for.
    columns: OnceLock<Vec<Vec<f64>>>,
    /// What is recorded along it, and the columns of that.
    pub(super) recorder: Option<Recorder>,
    /// Impulses of its impacts, if the method knows them.
    pub(super) impulses: Option<Impulses>,
    outputs: OnceLock<Vec<Vec<f64>>>,
}

impl Trajectory {
    /// Keeps the first `instants` instants.
    pub(crate) fn truncate(&mut self, instants: usize) {
        self.columns.take();
        self.outputs.take();
        self.time.truncate(instants);
        self.numerical_time.truncate(instants);
        self.q.truncate(instants);
        self.v.truncate(instants);
        self.u.truncate(instants);
        self.contact_force.truncate(instants);
        self.friction_force.truncate(instants);
    }

    /// Leaves out the coordinates that `scene` does not have, the last ones; what is recorded is that of the scene.
    pub(super) fn leave_held_out(&mut self, scene: &dyn Model) {
        self.columns.take();
        self.outputs.take();
        let declaration = scene.declaration();
        let (n, m) = (declaration.coordinates.len(), declaration.controls.len());
        self.u.iter_mut().for_each(|u| u.truncate(m));
        for states in [&mut self.q, &mut self.v] {
            states.iter_mut().for_each(|state| state.truncate(n));
        }
        self.recorder = Recorder::of(scene);
    }

    /// Leaves out both sides of every second jump.
    pub(super) fn thin_jumps(&mut self) {
        let last = self.time.len().saturating_sub(1);
        let (mut jumps, mut keeps) = (0_usize, vec![true; self.time.len()]);
        let mut first = 0;
        while first <= last && !keeps.is_empty() {
            let now = self.time[first];
            let together = self.time[first..].iter().take_while(|t| **t == now).count();
            if together > 1 {
                jumps += 1;
                let ends = first == 0 || first + together > last;
                let leaves = jumps.is_multiple_of(2) && !ends;
                keeps[first..first + together].fill(!leaves);
            }
            first += together.max(1);
        }
        self.select(&keeps);
    }

    /// Keeps one of `stride` instants from entry `first + skip` on, what stands before entry `first`, the last one, and
    /// both sides of every jump.
    pub(super) fn thin(&mut self, first: usize, skip: usize, stride: usize) {
        let last = self.time.len().saturating_sub(1);
        let jumps = |k: usize| {
            (k > 0 && self.time[k - 1] == self.time[k])
                || (k < last && self.time[k + 1] == self.time[k])
        };
        let keeps: Vec<bool> = (0..self.time.len())
            .map(|k| {
                let regular = k >= first + skip && (k - first - skip).is_multiple_of(stride);
                k < first || k == last || regular || jumps(k)
            })
            .collect();
        self.select(&keeps);
    }

    /// Keeps the instants that are marked.
    fn select(&mut self, keeps: &[bool]) {
        fn select<T>(rows: &mut Vec<T>, keeps: &[bool]) {
            let mut keeps = keeps.iter();
            rows.retain(|_| keeps.next().is_none_or(|&keep| keep));
        }
        self.columns.take();
        self.outputs.take();
        select(&mut self.time, keeps);
        select(&mut self.numerical_time, keeps);
        select(&mut self.q, keeps);
        select(&mut self.v, keeps);
        select(&mut self.u, keeps);
        select(&mut self.contact_force, keeps);
        select(&mut self.friction_force, keeps);
    }

    /// Appends one instant.
    pub fn push(
        &mut self,
        time: f64,
        numerical_time: f64,
        q: &[f64],
        v: &[f64],
        u: &[f64],
        force: &[f64],
    ) {
        self.columns.take();
        self.outputs.take();
        self.time.push(time);
        self.numerical_time.push(numerical_time);
        self.q.push(q.to_vec());
        self.v.push(v.to_vec());
        self.u.push(u.to_vec());
        self.contact_force.push(force.to_vec());
    }

    /// Names of what is recorded along it.
    pub(super) fn recorded(&self) -> &'static [VariableDeclaration] {
        self.recorder.as_ref().map_or(&[], Recorder::declared)
    }

    /// Impulses of all impacts until instant `k`: of the contacts along their normals and then along their sliding
    /// velocities, `2 n_c` numbers \[N s for a gap in metres\]; not numbers where the method does not tell impacts from
    /// lasting forces, as [`Moreau`](crate::baselines::Moreau) and [`Smooth`](crate::baselines::Smooth).
    #[must_use]
    pub fn impulses(&self, k: usize) -> Vec<f64> {
        let contacts = self.contact_force.get(k).map_or(0, Vec::len);
        match &self.impulses {
            None => vec![f64::NAN; 2 * contacts],
            Some(impulses) => {
                let sums = impulses.at(k).map(<[f64]>::to_vec);
                sums.unwrap_or_else(|| vec![0.0; 2 * contacts])
            }
        }
    }

    /// Whether an output depends on impulses, which the method does not know.
    pub(super) fn misses_impulses(&self) -> bool {
        let recorder = self.recorder.as_ref();
        self.impulses.is_none()
            && !self.time.is_empty()
            && recorder.is_some_and(|recorder| {
                recorder.misses_impulses(self.instant(0, &self.impulses(0)))
            })
    }

    /// What is recorded at an instant.
    pub(super) fn outputs_at(&self, k: usize) -> Vec<f64> {
        let recorder = self.recorder.as_ref();
        recorder.map_or_else(Vec::new, |recorder| {
            recorder.values(self.instant(k, &self.impulses(k)))
        })
    }

    /// Instant `k`, with the [`impulses`](Self::impulses) until it.
    pub(crate) fn instant<'t>(&'t self, k: usize, impulses: &'t [f64]) -> Instant<'t> {
        let friction = self.friction_force.get(k);
        Instant {
            time: self.time[k],
            q: &self.q[k],
            v: &self.v[k],
            u: &self.u[k],
            contact_force: &self.contact_force[k],
            friction_force: friction.map_or(&[], Vec::as_slice),
            impulses,
        }
    }

    /// All values of an output.
    pub(super) fn output(&self, index: usize) -> Option<&[f64]> {
        let columns = self.outputs.get_or_init(|| {
            let mut columns = vec![Vec::with_capacity(self.time.len()); self.recorded().len()];
            for k in 0..self.time.len() {
                for (column, value) in columns.iter_mut().zip(self.outputs_at(k)) {
                    column.push(value);
                }
            }
            columns
        });
        columns.get(index).map(Vec::as_slice)
    }

    /// Component `index` of all rows `(q, v, u, contact_force, impulses, friction_force)`; no friction forces stand there
    /// where no contact declares friction.
    pub(super) fn column(&self, index: usize) -> Option<&[f64]> {
        let columns = self.columns.get_or_init(|| {
            let impulses: Vec<Vec<f64>> = (0..self.time.len()).map(|k| self.impulses(k)).collect();
            let parts = [
                &self.q,
                &self.v,
                &self.u,
                &self.contact_force,
                &impulses,
                &self.friction_force,
            ];
            let widths = parts.map(|rows| rows.first().map_or(0, Vec::len));
            let columns = parts.iter().zip(widths).flat_map(|(rows, width)| {
                (0..width).map(|k| {
                    let value = |row: &Vec<f64>| row.get(k).copied().unwrap_or(f64::NAN);
                    rows.iter().map(value).collect::<Vec<f64>>()
                })
            });
            columns.collect()
        });
        columns.get(index).map(Vec::as_slice)
    }
}
