//! The contact mode: which contacts carry a force, and which of them stick.
//!
//! Contacts that touch (`g_i = 0`, `v_n,i = 0`) take accelerations from the linear complementarity problem
//! `0 <= r _|_ w >= 0` with the normal accelerations `w = phi + D r`, `phi_i = n_i' a + curvature_i`,
//! `D_ij = n_i' d_j`. With friction a contact that slides acts along `d -+ mu e`, and one that does not
//! follows Coulomb's law with the sliding acceleration. Where both sides of a condition vanish the same
//! problem one derivative higher decides.

use super::active_contact::{ActiveContact, Tangential, find};
use super::contacts::{Contacts, Line, ModeError, dot, norm};
use super::coulomb::{self, Cone};
use super::sharing::Share;

/// Relative size below which an acceleration or a jerk counts as zero when the mode is chosen.
const BIACTIVE: f64 = 1e-8;

/// A condition whose two sides both vanish in accelerations.
#[derive(Debug, Clone, Copy)]
enum Undecided {
    /// Neither force nor normal acceleration; slides in the given sense, or is at rest tangentially.
    Normal { contact: usize, sense: Option<f64> },
    /// Friction on the edge of its cone, without sliding acceleration: about to slip in the given sense.
    Edge { contact: usize, sense: f64 },
}

impl Contacts<'_> {
    /// The contact mode at `x` and `time`: writes the contacts that carry a force to `active`. Of the contacts
    /// that are `close`, those touch whose normal velocity is zero for their size; those of them slide whose
    /// sliding velocity is not.
    ///
    /// `active` holds the previous mode on entry; it decides where accelerations and jerks both vanish.
    /// What [`evaluate`](Self::evaluate) stored is overwritten.
    pub(crate) fn select(
        &mut self,
        x: &[f64],
        close: &[usize],
        time: f64,
        active: &mut Vec<ActiveContact>,
    ) -> Result<(), ModeError> {
        self.evaluate(x, close.iter().copied());
        let touching: Vec<usize> = close
            .iter()
            .copied()
            .filter(|&i| self.normal_velocity(i).abs() <= self.resting_velocity(i, time))
            .collect();
        if touching.is_empty() {
            active.clear();
            return Ok(());
        }
        let at_rest = |i: usize| self.sliding_velocity(i).abs() <= self.size(i, time).at_rest();
        let (lines, cones) = self.coulomb_lines(&touching, at_rest);
        let free: Vec<f64> = lines
            .iter()
            .map(|&line| self.free_line_acceleration(line))
            .collect();
        let matrix = self.couplings(&lines);
        let mut forces = vec![0.0; lines.len()];
        coulomb::solve(&matrix, &free, &cones, &mut forces)?;
        let total = |line: usize| {
            free[line]
                + dot(
                    &matrix[line * lines.len()..(line + 1) * lines.len()],
                    &forces,
                )
        };
        let (mut strict, mut undecided, mut shares) = (Vec::new(), Vec::new(), Vec::new());
        for (k, &contact) in touching.iter().enumerate() {
            let zero = BIACTIVE * self.phi_scale(contact);
            let cone = cones.iter().position(|cone| cone.normal == k);
            let tangent = cone.map(|cone| touching.len() + cone);
            if forces[k] > zero {
                let tangential = match tangent {
                    None => self.sliding_state(contact),
                    Some(tangent) => {
                        let friction = forces[tangent];
                        let zero = BIACTIVE * self.tangential_scale(contact);
                        let margin = self.friction(contact) * forces[k] - friction.abs();
                        let margin = if margin > zero { margin } else { 0.0 };
                        shares.push(Share {
                            contact,
                            friction,
                            margin,
                        });
                        let slip = total(tangent);
                        if margin == 0.0 && slip.abs() <= zero {
                            let sense = -friction.signum();
                            undecided.push(Undecided::Edge { contact, sense });
                            Tangential::slip(sense)
                        } else if margin > 0.0 {
                            Tangential::Sticking
                        } else {
                            Tangential::slip(slip)
                        }
                    }
                };
                strict.push(ActiveContact {
                    contact,
                    tangential,
                });
            } else if total(k) <= zero {
                let sense = match tangent {
                    None => Some(self.sliding_state(contact).sense()),
                    Some(tangent) => {
                        let slip = total(tangent);
                        let moves = slip.abs() > BIACTIVE * self.tangential_scale(contact);
                        moves.then_some(slip.signum())
                    }
                };
                undecided.push(Undecided::Normal { contact, sense });
            }
        }
        self.share_friction(&mut strict, &shares)?;
        self.drop_held(&mut strict, &mut undecided)?;
        if !undecided.is_empty() {
            self.select_by_jerk(x, active, &mut strict, &undecided)?;
            self.share_friction(&mut strict, &shares)?;
        }
        strict.sort_unstable_by_key(|held| held.contact);
        active.clone_from(&strict);
        Ok(())
    }

    /// Conditions on velocities that the strictly active contacts hold need no decision: a contact on the edge
    /// of its cone stays there, one without a force needs none.
    fn drop_held(
        &self,
        active: &mut [ActiveContact],
        undecided: &mut Vec<Undecided>,
    ) -> Result<(), ModeError> {
        for k in (0..undecided.len()).rev() {
            let line = match undecided[k] {
                Undecided::Edge { contact, sense } => Line::Tangent { contact, sense },
                Undecided::Normal { contact, .. } => Line::Normal {
                    contact,
                    slope: 0.0,
                },
            };
            if self.is_independent(active, line)? {
                continue;
            }
            if let Undecided::Edge { contact, sense } = undecided.remove(k) {
                for held in active.iter_mut().filter(|held| held.contact == contact) {
                    held.tangential = Tangential::bound(sense);
                }
            }
        }
        Ok(())
    }

    /// State of a contact that slides or has no friction.
    fn sliding_state(&self, contact: usize) -> Tangential {
        if self.friction(contact) > 0.0 {
            Tangential::slip(self.sliding_velocity(contact))
        } else {
            Tangential::Idle
        }
    }

    /// Decides conditions whose two sides both vanish by their derivatives along the motion with the
    /// strictly active contacts, in which those on the edge of their cone slip; where those vanish too, the
    /// previous mode stays.
    fn select_by_jerk(
        &mut self,
        x: &[f64],
        previous: &[ActiveContact],
        strict: &mut Vec<ActiveContact>,
        undecided: &[Undecided],
    ) -> Result<(), ModeError> {
        let (lines, cones) = self.undecided_lines(undecided);
        let mut held = Vec::new();
        self.lines(strict, &mut held);
        let mut forces = vec![0.0; held.len()];
        self.contact_forces(strict, &mut forces)?;
        let mut motion = vec![0.0; self.n];
        self.constrained_acceleration(strict, &forces, &mut motion);
        let matrix = self.reduced_couplings(&held, &lines)?;
        let scales: Vec<f64> = lines.iter().map(|&line| self.scale(line)).collect();
        let (step, time_scale) = self.difference_step(x, &motion);
        // Far from the origin the step is longer and leaves fewer digits.
        let biactive = BIACTIVE.max(4.0 * (step / time_scale).powi(2));
        let mut jerk = vec![0.0; lines.len()];
        let mut behind = vec![0.0; lines.len()];
        self.separation(x, &motion, step, strict, &held, &lines, &mut jerk)?;
        self.separation(x, &motion, -step, strict, &held, &lines, &mut behind)?;
        for (ahead, behind) in jerk.iter_mut().zip(&behind) {
            *ahead = (*ahead - behind) / (2.0 * step);
        }
        let mut rates = vec![0.0; lines.len()];
        coulomb::solve(&matrix, &jerk, &cones, &mut rates)?;
        let size = lines.len();
        for (k, &condition) in undecided.iter().enumerate() {
            let zero = |line: usize| biactive * scales[line] / time_scale;
            let total =
                |line: usize| jerk[line] + dot(&matrix[line * size..(line + 1) * size], &rates);
            match condition {
                Undecided::Edge { contact, sense } => {
                    let slips = Tangential::slip(sense);
                    let slip = rates[k] <= zero(k)
                        && (total(k) > zero(k) || find(previous, contact) == Some(slips));
                    for held in strict.iter_mut().filter(|held| held.contact == contact) {
                        held.tangential = if slip { slips } else { Tangential::Sticking };
                    }
                }
                Undecided::Normal { contact, sense } => {
                    let before = find(previous, contact);
                    if !(rates[k] > zero(k) || total(k) <= zero(k) && before.is_some()) {
                        continue;
                    }
                    let cone = cones.iter().position(|cone| cone.normal == k);
                    let tangential = match cone.map(|cone| undecided.len() + cone) {
                        None if self.friction(contact) > 0.0 => {
                            Tangential::slip(sense.unwrap_or(0.0))
                        }
                        None => Tangential::Idle,
                        Some(tangent) => {
                            let margin = self.friction(contact) * rates[k] - rates[tangent].abs();
                            let slip = total(tangent);
                            if margin > zero(tangent) {
                                Tangential::Sticking
                            } else if slip.abs() > zero(tangent) {
                                Tangential::slip(slip)
                            } else {
                                before.unwrap_or(Tangential::Sticking)
                            }
                        }
                    };
                    strict.push(ActiveContact {
                        contact,
                        tangential,
                    });
                }
            }
        }
        Ok(())
    }

    /// Step of a central difference along the motion with the acceleration `motion`, and the motion's own time
    /// scale: truncation and rounding errors are both near 1e-10 for a step of 1e-5 of it.
    fn difference_step(&self, x: &[f64], motion: &[f64]) -> (f64, f64) {
        let speed = norm(&x[self.n..2 * self.n]) + f64::MIN_POSITIVE;
        let rounding = f64::EPSILON * norm(&x[..self.n]);
        let own = speed / (norm(motion) + f64::MIN_POSITIVE);
        // From rest the velocity says nothing.
        let shortest = if speed * own > 1e8 * rounding {
            0.0
        } else {
            1e-3
        };
        let time_scale = own.clamp(shortest, 1.0);
        let share = (rounding / (speed * time_scale)).cbrt().clamp(1e-5, 1e-2);
        (share * time_scale, time_scale)
    }

    /// One line for each undecided condition, in its order, then the tangents of the cones.
    fn undecided_lines(&self, undecided: &[Undecided]) -> (Vec<Line>, Vec<Cone>) {
        let (mut lines, mut tangents, mut cones) = (Vec::new(), Vec::new(), Vec::new());
        for (normal, &condition) in undecided.iter().enumerate() {
            lines.push(match condition {
                Undecided::Edge { contact, sense } => Line::Tangent { contact, sense },
                Undecided::Normal { contact, sense } => {
                    let friction = self.friction(contact);
                    if friction > 0.0 && sense.is_none() {
                        tangents.push(Line::Tangent {
                            contact,
                            sense: 1.0,
                        });
                        cones.push(Cone { normal, friction });
                    }
                    Line::Normal {
                        contact,
                        slope: -friction * sense.unwrap_or(0.0),
                    }
                }
            });
        }
        lines.extend(tangents);
        (lines, cones)
    }

    /// Accelerations of `lines` a time `step` along the motion, with the `active` contacts, whose lines are
    /// `held`, carrying their forces.
    #[expect(
        clippy::too_many_arguments,
        reason = "a place on the motion and what is held there"
    )]
    fn separation(
        &mut self,
        x: &[f64],
        motion: &[f64],
        step: f64,
        active: &[ActiveContact],
        held: &[Line],
        lines: &[Line],
        w: &mut [f64],
    ) -> Result<(), ModeError> {
        let n = self.n;
        let mut shifted = std::mem::take(&mut self.shifted);
        shifted.copy_from_slice(x);
        for k in 0..n {
            shifted[k] += step * x[n + k] + 0.5 * step * step * motion[k];
            shifted[n + k] += step * motion[k];
        }
        for (control, slope) in shifted[2 * n..].iter_mut().zip(&self.control_slopes) {
            *control += step * slope;
        }
        if self.model.declaration().explicit_time
            && let Some(time) = shifted.last_mut()
        {
            *time += step;
        }
        let contacts = held.iter().chain(lines).map(|line| line.contact());
        self.evaluate(&shifted, contacts);
        self.shifted = shifted;
        let mut forces = vec![0.0; held.len()];
        self.contact_forces(active, &mut forces)?;
        for (value, &line) in w.iter_mut().zip(lines) {
            *value = self.free_line_acceleration(line)
                + held
                    .iter()
                    .zip(&forces)
                    .map(|(&h, force)| self.coupling(line, h) * force)
                    .sum::<f64>();
        }
        Ok(())
    }
}
