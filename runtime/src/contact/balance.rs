//! Forces of contacts that touch, as the law finds them, and what they say of the state of each contact.

use super::contact_mode::Direction;
use super::law::{self, Solutions};
use super::line::Line;
use super::mode_error::ModeError;
use super::shares::{self, Shares};
use super::state::ContactState;
use super::touching::Touching;
use super::view::View;
use crate::linalg::products::{dot, largest};
use crate::model::pair_size;
use crate::yardstick;

/// Two solutions are one if their changes of the velocity agree to this relative accuracy.
const SAME: f64 = 1e-8;

/// A force among those of a balance.
struct Carrier {
    /// The line whose motion it holds.
    line: usize,
    /// Lines on which a unit of it acts, and how much.
    acts: Vec<(usize, f64)>,
}

/// What accelerations say of a contact.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Decision {
    /// Its state.
    Is(ContactState),
    /// Friction on the edge of its cone, without sliding acceleration: it sticks, or is about to slip as said.
    Edge(ContactState),
    /// Neither force nor normal acceleration: it is open, or closed.
    Touches,
}

/// What is known of a contact besides: a switching function of the mode before that vanishes now, whatever rounding error has left of
/// it.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Vanished {
    /// Its normal force does.
    pub(crate) force: bool,
    /// Friction has come to the edge of its cone, against sliding in this direction.
    pub(crate) reserve: Option<Direction>,
}

/// Forces of contacts that touch, and what their lines do under them: `w = q + K f`.
#[derive(Debug, Clone)]
pub(crate) struct Balance {
    pub(crate) touching: Touching,
    pub(crate) forces: Vec<f64>,
    pub(crate) motions: Vec<f64>,
}

impl Balance {
    /// A solution of the law for lines that move by `offsets`. All are asked for only where friction may push a contact into the
    /// ground: elsewhere they give one motion, but for [switches](Touching::parting).
    ///
    /// # Errors
    /// Where none is found, or several with different motions.
    pub(crate) fn first(
        touching: Touching,
        view: &View<'_>,
        offsets: &[f64],
    ) -> Result<Self, ModeError> {
        let matrix = view.couplings(&touching.lines);
        let forces = law::first(&touching.problem(&matrix, offsets))?;
        let balance = Self::with(touching, &matrix, offsets, forces);
        match balance.touching.jams(view) {
            Some((contact, _)) if balance.is_one_of_several(view, offsets) => {
                Err(ModeError::Several(contact))
            }
            _ => Ok(balance),
        }
    }

    /// Whether the lines that move by `offsets` have several motions. Where sliding has a lower coefficient of its own, what may rest does.
    pub(crate) fn is_one_of_several(&self, view: &View<'_>, offsets: &[f64]) -> bool {
        let all = || Self::all(self.touching.clone(), view, offsets);
        !self.touching.breaks()
            && all().is_some_and(|(found, others)| found.has_others(view, offsets, &others))
    }

    /// Whether one of the solutions changes the velocity by something else than this one does.
    pub(crate) fn has_others(
        &self,
        view: &View<'_>,
        offsets: &[f64],
        solutions: &Solutions,
    ) -> bool {
        let change = |forces: &[f64]| {
            let mut change = vec![0.0; view.n];
            self.push(view, forces, &mut change);
            change
        };
        let reference = change(&self.forces);
        let tolerance = SAME * largest(&reference).max(largest(offsets));
        let differs = |other: Vec<f64>| {
            let other = change(&other);
            let mut pairs = other.iter().zip(&reference);
            pairs.any(|(a, b)| (a - b).abs() > tolerance)
        };
        solutions.others(&self.forces).any(differs)
    }

    /// The balance with all solutions that are found; `None` without any.
    pub(crate) fn all(
        touching: Touching,
        view: &View<'_>,
        offsets: &[f64],
    ) -> Option<(Self, Solutions)> {
        let matrix = view.couplings(&touching.lines);
        let contacts = touching.contacts.iter();
        let inertia: Vec<f64> = contacts.map(|&i| view.force(i, 1.0)).collect();
        let solutions = law::all(&touching.problem(&matrix, offsets), &inertia)?;
        let mut first = solutions.first();
        for force in &mut first[..touching.contacts.len()] {
            *force = force.max(0.0);
        }
        Some((Self::with(touching, &matrix, offsets, first), solutions))
    }

    fn with(touching: Touching, matrix: &[f64], offsets: &[f64], forces: Vec<f64>) -> Self {
        let rows = matrix
            .chunks_exact(touching.lines.len().max(1))
            .zip(offsets);
        let motions = rows.map(|(row, q)| q + dot(row, &forces)).collect();
        Self {
            touching,
            forces,
            motions,
        }
    }

    /// The motion by the forces that are the farthest from leaving the laws of all contacts that hold, where these share their load in more
    /// ways than one: what each does next is told by what all of them together can carry.
    pub(crate) fn spread(mut self, view: &View<'_>) -> Self {
        if !self.touching.in_space {
            return self;
        }
        let carriers = self.carriers(view);
        if carriers.len() < 2 {
            return self;
        }
        let matrix = view.couplings(&self.touching.lines);
        let order = self.touching.lines.len();
        let entry = |row: usize, carrier: &Carrier| -> f64 {
            let terms = carrier.acts.iter();
            terms
                .map(|&(line, weight)| weight * matrix[row * order + line])
                .sum()
        };
        let couplings = carriers
            .iter()
            .flat_map(|row| carriers.iter().map(|column| entry(row.line, column)));
        let couplings: Vec<f64> = couplings.collect();
        let right = couplings.chunks_exact(carriers.len().max(1)).map(|row| {
            let terms = row.iter().zip(&carriers);
            terms
                .map(|(k, carrier)| k * self.forces[carrier.line])
                .sum()
        });
        let right: Vec<f64> = right.collect();
        let lines: Vec<Line> = carriers
            .iter()
            .map(|held| self.touching.lines[held.line])
            .collect();
        let push = |place: usize, value: f64, to: &mut [f64]| {
            for &(line, weight) in &carriers[place].acts {
                view.push(self.touching.lines[line], value * weight, to);
            }
        };
        let shares = Shares::along(view, &lines, push, (&couplings, &right));
        let Some(shares) = shares.ok().filter(Shares::are_many) else {
            return self;
        };
        let rooms = shares::rooms(view, &lines);
        let found = shares.inside(&rooms);
        if shares.decide && !shares::obey(&rooms, &found) {
            return self;
        }
        for (carrier, force) in carriers.iter().zip(found) {
            for &(line, weight) in &carrier.acts {
                self.forces[line] = weight * force;
            }
        }
        self
    }

    /// What holds the contacts that do not leave: their normals, with the friction of those that slide, and the tangents of those that do not.
    fn carriers(&self, view: &View<'_>) -> Vec<Carrier> {
        let sizes = self.forces.iter().chain(&self.motions);
        let zero = yardstick::NOTHING * sizes.fold(0.0_f64, |most, size| most.max(size.abs()));
        let alone = |line: usize| Carrier {
            line,
            acts: vec![(line, 1.0)],
        };
        let mut carriers = Vec::new();
        for (k, &contact) in self.touching.contacts.iter().enumerate() {
            if self.motions[k].abs() > zero {
                continue;
            }
            let mut normal = alone(k);
            if let Some(tangent) = self.touching.tangent(k) {
                let slip = self.touching.both(tangent, &self.motions);
                let across = self.touching.across(tangent);
                let lines = [(Some(tangent), slip.0), (across, slip.1)];
                let lines = lines
                    .into_iter()
                    .filter_map(|(line, slip)| Some((line?, slip)));
                let size = pair_size(slip);
                if size > zero {
                    let ratio = -view.kinetic(contact) / size;
                    normal
                        .acts
                        .extend(lines.map(|(line, slip)| (line, ratio * slip)));
                } else {
                    carriers.extend(lines.map(|(line, _)| alone(line)));
                }
            }
            carriers.push(normal);
        }
        carriers
    }

    /// Adds these forces, or others on the same lines, to an acceleration, or impulses to a velocity.
    pub(crate) fn push(&self, view: &View<'_>, forces: &[f64], to: &mut [f64]) {
        for (&line, &force) in self.touching.lines.iter().zip(forces) {
            view.push(line, force, to);
        }
    }

    /// Forces of the normals, one a contact.
    pub(crate) fn normals(&self) -> &[f64] {
        &self.forces[..self.touching.contacts.len()]
    }

    /// Tangential forces of the `k`-th contact; the second is 0 in the plane.
    pub(crate) fn friction(&self, k: usize) -> (f64, f64) {
        match (self.touching.tangent(k), self.touching.lines[k]) {
            (Some(tangent), _) => self.touching.both(tangent, &self.forces),
            (None, Line::Normal { slope, .. }) => (slope * self.forces[k], 0.0),
            (None, _) => (0.0, 0.0),
        }
    }

    /// Tangential motions of the `k`-th contact, where its friction has a cone.
    pub(crate) fn slip(&self, k: usize) -> Option<(f64, f64)> {
        let tangent = self.touching.tangent(k)?;
        Some(self.touching.both(tangent, &self.motions))
    }

    /// What accelerations say of the `k`-th contact; below `zeros`, a normal and a tangential acceleration, they are none.
    pub(crate) fn decide(
        &self,
        view: &View<'_>,
        k: usize,
        zeros: (f64, f64),
        vanished: Vanished,
    ) -> Decision {
        if self.forces[k] > zeros.0 && !vanished.force {
            self.pressed(view, k, zeros.1, vanished.reserve)
        } else if self.motions[k] > zeros.0 && !vanished.force {
            Decision::Is(ContactState::Open)
        } else {
            Decision::Touches
        }
    }

    /// What the `k`-th contact does along its tangent, which carries a force.
    pub(crate) fn pressed(
        &self,
        view: &View<'_>,
        k: usize,
        zero: f64,
        reserve: Option<Direction>,
    ) -> Decision {
        let contact = self.touching.contacts[k];
        let Some(slip) = self.slip(k) else {
            return Decision::Is(sliding(view, contact));
        };
        // Where sliding has a lower coefficient of its own, a force that is no longer held jumps.
        let breaks = view.kinetic(contact) < view.friction(contact);
        let slips = pair_size(slip) > zero;
        if self.margin(view, k) > zero && reserve.is_none() && !(breaks && slips) {
            return Decision::Is(ContactState::sticking(view.is_in_space(contact)));
        }
        let to = match reserve {
            _ if view.is_in_space(contact) => Direction::Forward,
            Some(direction) if !slips => direction,
            _ => Direction::of(self.heading(k, zero).0),
        };
        let state = ContactState::Slip(to);
        if slips || breaks {
            Decision::Is(state)
        } else {
            Decision::Edge(state)
        }
    }

    /// What the friction of the `k`-th contact has left before it slips, `mu r - |s|`.
    pub(crate) fn margin(&self, view: &View<'_>, k: usize) -> f64 {
        view.friction(self.touching.contacts[k]) * self.forces[k] - pair_size(self.friction(k))
    }

    /// Where the `k`-th contact slides to that begins to: along its acceleration, or against its friction where that is none.
    pub(crate) fn heading(&self, k: usize, zero: f64) -> (f64, f64) {
        let friction = self.friction(k);
        let slip = self.slip(k).filter(|&slip| pair_size(slip) > zero);
        slip.unwrap_or((-friction.0, -friction.1))
    }
}

/// State of a contact that slides or has no friction.
pub(crate) fn sliding(view: &View<'_>, contact: usize) -> ContactState {
    if view.has_friction(contact) {
        ContactState::slip(view.side(contact))
    } else {
        ContactState::Frictionless
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    crate::model! {
        /// A block at rest on an incline.
        Block {
            parameters { m: kg = 1.7, g: m/s^2 = 9.81, a = 0.4, mu = 0.6 }
            coordinates { x: m, z: m }
            lagrangian m/2*|dot((x, z))|^2 - m*g*(z*cos(a) - x*sin(a))
            surface ground: z >= 0
            impact ground: inelastic, friction mu, sliding dot(x)
            start { z: 0 [m] }
        }
    }

    /// The balance of accelerations at rest, and what it says.
    fn decided(mu: f64) -> (Balance, Decision) {
        let block = Block {
            mu,
            ..Block::default()
        };
        let x = [0.3, 0.0, 0.0, 0.0];
        let mut view = View::new(&block);
        view.evaluate_free_acceleration(&x);
        view.evaluate_sides(0, &x);
        let touching = Touching::new(&view, &[0], |_| true);
        let lines = touching.lines.iter();
        let offsets: Vec<f64> = lines
            .map(|&line| view.free_line_acceleration(line))
            .collect();
        let balance = Balance::first(touching, &view, &offsets).expect("solvable");
        let decision = balance.decide(&view, 0, (1e-8, 1e-8), Vanished::default());
        (balance, decision)
    }

    #[test]
    fn block_on_an_incline_sticks_below_the_angle_of_friction_and_slips_beyond_it() {
        let (normal, along) = (9.81 * 0.4_f64.cos(), 9.81 * 0.4_f64.sin());
        let slides = ContactState::Slip(Direction::Forward);
        // A few rounding errors of numbers up to 10.
        let near = |a: f64, b: f64| (a - b).abs() < 1e-14;
        let (balance, decision) = decided(0.6);
        assert_eq!(decision, Decision::Is(ContactState::Stick));
        assert!(near(balance.forces[0], normal) && near(balance.friction(0).0, -along));
        let (balance, decision) = decided(0.3);
        assert_eq!(decision, Decision::Is(slides));
        assert!(near(balance.friction(0).0, -0.3 * normal));
        let slip = balance.slip(0).map(|slip| slip.0);
        assert!(slip.is_some_and(|slip| near(slip, along - 0.3 * normal)));
        assert_eq!(decided(0.4_f64.tan()).1, Decision::Edge(slides));
    }

    #[test]
    fn force_that_vanishes_leaves_the_contact_undecided() {
        let (mut balance, _) = decided(0.6);
        balance.forces = vec![0.0; 2];
        balance.motions = vec![0.0; 2];
        let block = Block::default();
        let view = View::new(&block);
        let decide =
            |balance: &Balance| balance.decide(&view, 0, (1e-8, 1e-8), Vanished::default());
        assert_eq!(decide(&balance), Decision::Touches);
        balance.motions[0] = 1e-3;
        assert_eq!(decide(&balance), Decision::Is(ContactState::Open));
    }
}
