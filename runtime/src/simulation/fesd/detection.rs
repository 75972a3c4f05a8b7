//! Detection of the first switching function that falls below zero inside a solved element, by bounds along its dense output.
//!
//! The switching functions are those of the time-freezing system: an open contact closes when its gap
//! falls through zero, or, after a release, when `max(g, v_n)` falls below zero (the region `g < 0 < v_n`
//! still carries the free dynamics); an active one opens when its force does. A sticking contact slips when
//! its friction reaches the bound `mu r`, and one that slides stops when its sliding velocity vanishes.

use super::present::Present;
use super::stop::Stop;
use super::switch::{self, Function, Switch, SwitchKind};
use crate::enclosure::{
    Along, Interpolated, Sample, Suspect, earliest_fall, positive_before, root,
};
use crate::fesd::contact_size::ContactSize;
use crate::fesd::contacts::{Contacts, ModeError};
use crate::fesd::finite_element::{ElementError, FiniteElement, MotionSize};
use crate::model::Model;
use crate::rk::ButcherTableau;
use crate::yardstick;
use std::collections::BTreeSet;

/// Share of the way in an element below which a penetration after a release may be its local error.
const DEEP: f64 = 1e-3;
/// Halvings of an element on the way back to where a function that starts at zero has grown.
const HALVINGS: i32 = 30;
/// How often the range of the values of a function of forces at the stages its least value may be for it to be looked at in between. Chosen.
const VARIES: f64 = 2.0;
/// Places at which the gaps of active contacts are looked at. Chosen: more than there are stages.
const PLACES: usize = 8;

/// What is known of the element that was solved last.
pub(super) struct Detector<'a> {
    /// Explicit functions on the dense output.
    pub(super) along: Along<'a>,
    /// Functions that were looked at by some of their values.
    pub(super) interpolated: BTreeSet<Interpolated>,
    /// Largest gap of an active contact between the stages, as a share of what the motion has made of it; 0 where nobody
    /// asks for it.
    pub(super) drift: f64,
}

impl<'a> Detector<'a> {
    pub(super) fn new(model: &'a dyn Model, tableau: &ButcherTableau) -> Self {
        Self {
            along: Along::new(model, tableau.stages() + 1),
            interpolated: BTreeSet::new(),
            drift: 0.0,
        }
    }

    /// Takes up the dense output of an element from the present state on.
    fn enclose(&mut self, element: &mut Solved<'_, '_>, now: (&[f64], f64)) {
        let (x, time) = now;
        let n = element.contacts.n;
        let length = element.element.length;
        self.along.begin(time, length, &element.contacts.pieces);
        for end in [0, 1] {
            let controls = self.along.controls_at(end);
            controls.copy_from_slice(&x[2 * n..][..controls.len()]);
        }
        self.along
            .follow(|theta, out| out.copy_from_slice(&element.input(theta)[..2 * n]));
    }

    /// The first violation in the solved `element` that begins at the present state, if any; gaps of contacts are measured by the `motion`
    /// where errors are controlled.
    pub(super) fn first_violation(
        &mut self,
        (element, tableau): (&FiniteElement<'a>, &ButcherTableau),
        now: &mut Present<'a>,
        motion: Option<&MotionSize>,
    ) -> Result<Option<Switch>, Stop> {
        let of_coordinates = motion.map_or(0.0, |motion| element.position_rounding(motion));
        let starts = starts(now, of_coordinates, element.length);
        let mut solved = Solved {
            element,
            tableau,
            weights: vec![0.0; tableau.stages()],
            x: now.x.clone(),
            contacts: &mut now.contacts,
            forces: Vec::new(),
            failed: None,
        };
        self.enclose(&mut solved, (&now.x, now.state.time));
        if !now.near.holds(|k| self.along.input(k)) {
            // What is far might come near unseen.
            return Err(Stop::Unresolved);
        }
        self.drift = motion.map_or(0.0, |motion| solved.drift(motion));
        let mut first: Option<Switch> = None;
        // What begins at zero is asked how it goes on up to where another function falls: behind, the element tells nothing.
        for begins_at_zero in [false, true] {
            let until = first.map_or(1.0, |first| first.theta);
            let mut suspects = vec![None; starts.len()];
            for (start, suspect) in starts.iter().zip(&mut suspects) {
                if start.begins_at_zero != begins_at_zero {
                    continue;
                }
                let watched = start.function.watched(solved.contacts, element.active());
                if !watched.is_explicit(&self.along) {
                    self.interpolated.insert(start.function.named());
                }
                match solved.from(start, until)? {
                    From::Nowhere => {}
                    From::Switch(switch) => first = earlier(first, switch),
                    From::Sample(from) => {
                        *suspect = Some(Suspect {
                            watched,
                            from,
                            end: solved.sample(start.function, until),
                            zero: start.zeros[0].max(-2.0 * from.value),
                            rounding: 0.0,
                        });
                    }
                }
            }
            let value = |k: usize, theta: f64| solved.value(starts[k].function, theta);
            let fall = earliest_fall(&mut self.along, &suspects, value);
            if let Some(error) = solved.failed {
                return Err(beyond(&error));
            }
            if let Some(fall) = fall.map_err(|_| Stop::Unresolved)? {
                let function = starts[fall.function].function;
                let ends = (fall.left, fall.right);
                let switch = Switch::between(function, ends, fall.root, element.length);
                first = earlier(first, switch);
            }
        }
        Ok(first)
    }
}

/// The earlier one of two switches.
fn earlier(first: Option<Switch>, other: Switch) -> Option<Switch> {
    first
        .filter(|first| first.theta <= other.theta)
        .or(Some(other))
}

/// A solved element, along whose dense output switching functions are evaluated.
struct Solved<'s, 'a> {
    element: &'s FiniteElement<'a>,
    tableau: &'s ButcherTableau,
    contacts: &'s mut Contacts<'a>,
    weights: Vec<f64>,
    x: Vec<f64>,
    /// Forces at places.
    forces: Vec<(f64, Vec<f64>)>,
    /// Why a function has no value at a place.
    failed: Option<ModeError>,
}

/// A switching function at the start of an element.
struct Start {
    function: Function,
    value: f64,
    size: ContactSize,
    /// Its rounding error, and the values that another switch explains.
    zeros: [f64; 2],
    /// Whether it may grow more slowly than the local error of the element at first.
    begins_at_zero: bool,
    /// Normal velocity of the contact.
    velocity: f64,
    /// Whether forces accelerate the contact in the sense of its slip.
    in_sense: bool,
}

/// Where a function may fall from on.
enum From {
    Nowhere,
    Sample(Sample),
    /// It is known to fall.
    Switch(Switch),
}

/// The switching functions of the mode at the present state, where rounding of coordinates leaves this error in those that are gaps.
fn starts(now: &mut Present<'_>, of_coordinates: f64, length: f64) -> Vec<Start> {
    let functions = Function::of_mode(now);
    let contacts = functions.iter().map(|function| function.contact);
    now.contacts.evaluate_contacts(&now.x, contacts);
    let start = |function: Function| {
        let i = function.contact;
        let own = now.size(i);
        // What an idle piece lacks to acting is the difference of two gaps, whose terms may cancel.
        let size = own.as_difference_from(now.size(now.contacts.pieces.acting(i)));
        let steepness: f64 = now.contacts.normal(i).iter().map(|n| n.abs()).sum();
        let in_sense = function.kind == SwitchKind::Stopping && {
            let sense = function.sense(&now.active);
            sense * now.contacts.sliding_acceleration(i, &now.acceleration)
                > -yardstick::ROUNDING * now.contacts.tangential_scale(i)
        };
        let value = function.at_present(now);
        // Where its terms have vanished, those that the accelerations of the element add to it are left.
        let own = f64::EPSILON * now.contacts.phi_scale(i) * length * length;
        let size = size.with_error(steepness * of_coordinates + own);
        let zeros = function.zeros(&now.contacts, size);
        Start {
            function,
            value,
            size,
            zeros,
            begins_at_zero: match function.kind {
                SwitchKind::Entry => value <= zeros[1],
                SwitchKind::Stopping => value <= zeros[0],
                _ => false,
            },
            velocity: now.velocities[i],
            in_sense,
        }
    };
    functions.into_iter().map(start).collect()
}

impl Solved<'_, '_> {
    /// The input vector at a place.
    fn input(&mut self, theta: f64) -> &[f64] {
        self.tableau.dense_weights(theta, &mut self.weights);
        self.element.interpolate(theta, &self.weights, &mut self.x);
        &self.x
    }

    /// The value of a function at a place; infinite where it has none. A gap may have a pole, on whose sides its sign tells where it is.
    fn value(&mut self, function: Function, theta: f64) -> f64 {
        let active = self.element.active();
        let found = if function.is_of_forces() {
            self.forces_at(theta)
                .map(|forces| function.of_forces(self.contacts, active, &forces))
        } else {
            self.input(theta);
            function.value(self.contacts, active, &self.x)
        };
        match found {
            Ok(value) if value.is_finite() || !function.is_of_forces() && !value.is_nan() => {
                return value;
            }
            Ok(_) => self.failed.get_or_insert(ModeError::NotFinite),
            Err(error) => self.failed.get_or_insert(error),
        };
        f64::INFINITY
    }

    /// A place with the value there.
    fn sample(&mut self, function: Function, at: f64) -> Sample {
        let value = self.value(function, at);
        Sample { at, value }
    }

    /// Forces of the active contacts at a place.
    fn forces_at(&mut self, theta: f64) -> Result<Vec<f64>, ModeError> {
        if let Some((_, forces)) = self.forces.iter().find(|(place, _)| *place == theta) {
            return Ok(forces.clone());
        }
        self.input(theta);
        let forces = switch::forces(self.contacts, self.element.active(), &self.x)?;
        self.forces.push((theta, forces.clone()));
        Ok(forces)
    }

    /// The largest gap of an active contact, as a share of what the `motion` has made of it. They vanish at the stages; what is left of
    /// them in between tells of ground that varies faster than the stages see, which their error estimate does not know.
    fn drift(&mut self, motion: &MotionSize) -> f64 {
        let (element, n) = (self.element, self.contacts.n);
        let mut drift = 0.0_f64;
        let of_coordinates = element.position_rounding(motion);
        let places = (1..=PLACES).map(|k| k as f64 / PLACES as f64);
        for theta in places.filter(|_| !element.active().is_empty()) {
            self.input(theta);
            let held = element.active().iter().map(|held| held.contact);
            self.contacts.evaluate_contacts(&self.x, held.clone());
            for i in held {
                let normal = self.contacts.normal(i);
                let steepness: f64 = normal.iter().map(|n| n.abs()).sum();
                let size = self.contacts.size(i, element.stage_time(0));
                let rounding = size.touching_gap() + steepness * of_coordinates;
                let gap = self.contacts.gap(i).abs() - rounding;
                if gap > 0.0 {
                    let (q, v) = self.x[..2 * n].split_at(n);
                    drift = drift.max(gap / motion.along(normal, (q, v), element.length));
                }
            }
        }
        drift
    }

    /// Where the fall of a function is looked for before a place.
    fn from(&mut self, start: &Start, until: f64) -> Result<From, Stop> {
        let Start {
            function, value, ..
        } = *start;
        let rounding = start.zeros[0];
        if !start.begins_at_zero {
            let waits = function.is_of_forces() && !self.may_vanish(function, (value, rounding));
            return Ok(match waits {
                true => From::Nowhere,
                false => From::Sample(Sample { at: 0.0, value }),
            });
        }
        if function.kind == SwitchKind::Entry {
            return self.released(start, until);
        }
        let end = self.sample(function, until);
        let falls = end.value < -rounding;
        match self.rise((function, until), if falls { 0.0 } else { rounding }) {
            (Some(sample), _) => Ok(From::Sample(sample)),
            _ if !falls || until < 1.0 => Ok(From::Nowhere),
            // The element is too long to show the slip that the forces demand.
            _ if start.in_sense => Err(Stop::Unresolved),
            // It starts where the slip ends.
            _ => {
                let ends = (Sample { at: 0.0, value }, end);
                let length = self.element.length;
                Ok(From::Switch(Switch::between(function, ends, 0.0, length)))
            }
        }
    }

    /// Where the fall of the gap of a contact is looked for before a place that touches at the start of the element.
    ///
    /// Flights lower than the rounding error end in contact.
    fn released(&mut self, start: &Start, until: f64) -> Result<From, Stop> {
        let (function, size) = (start.function, start.size);
        let depth = DEEP * self.element.length * size.speed();
        let bounced = start.velocity > size.velocity_rounding();
        // Thrown off, and deeper than the local error explains: it has fallen back in a flight that is too low for an element of
        // that length.
        let from_above = bounced && start.value >= -size.touching_gap();
        let end = self.value(function, until);
        let falls = end < -size.gap_rounding();
        let told = if bounced || end < -depth {
            0.5 * size.gap_rounding()
        } else {
            size.touching_gap()
        };
        match self.rise((function, until), told) {
            (Some(_), least) if from_above && least < -depth => return Err(Stop::Unresolved),
            (Some(sample), _) => return Ok(From::Sample(sample)),
            _ if !falls || until < 1.0 => return Ok(From::Nowhere),
            _ => {}
        }
        self.input(1.0);
        let i = function.contact;
        self.contacts.evaluate_contacts(&self.x, [i]);
        if self.contacts.normal_velocity(i) >= -size.velocity_rounding() {
            return if from_above && end < -depth {
                Err(Stop::Unresolved)
            } else {
                Ok(From::Nowhere)
            };
        }
        let function = Function {
            kind: SwitchKind::Reentry,
            contact: i,
        };
        let length = self.element.length;
        let [from, right] = [0.0, 1.0].map(|at| self.sample(function, at));
        let mut value = |theta| self.value(function, theta);
        let left = positive_before(&mut value, from, from, right, 0.0);
        let theta = root(&mut value, left, right);
        let switch = Switch::between(function, (left, right), theta, length);
        Ok(From::Switch(switch))
    }

    /// The first of some places, ever farther from the start until another one, at which a function is larger than `told`, and the least
    /// value before.
    fn rise(&mut self, (function, until): (Function, f64), told: f64) -> (Option<Sample>, f64) {
        let mut least = f64::INFINITY;
        for halvings in (0..=HALVINGS).rev() {
            let sample = self.sample(function, until * 0.5_f64.powi(halvings));
            if sample.value > told {
                return (Some(sample), least);
            }
            least = least.min(sample.value);
        }
        (None, least)
    }

    /// Whether the values of a function of forces at the stages leave room for a zero between them.
    fn may_vanish(&mut self, function: Function, (start, zero): (f64, f64)) -> bool {
        let end = self.value(function, 1.0);
        let (element, contacts) = (self.element, &*self.contacts);
        let at = |m| {
            let forces = element.stage_constraint_forces(m);
            function.of_forces(contacts, element.active(), forces)
        };
        let stages = (0..self.tableau.stages()).map(at);
        let ends = [start.min(end), start.max(end)];
        let [low, high] = stages.fold(ends, |[low, high], value| [low.min(value), high.max(value)]);
        low + zero <= VARIES * (high - low)
    }
}

/// Between its stages an element may leave the domain of the model, or of the mode; a shorter one will not.
fn beyond(error: &ModeError) -> Stop {
    Stop::Element(match error {
        ModeError::NotFinite => ElementError::NotFinite,
        _ => ElementError::Singular,
    })
}
