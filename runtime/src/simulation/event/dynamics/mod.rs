//! The constrained dynamics of one contact mode: accelerations, contact forces, switching functions, speed of
//! numerical time, projection onto the surfaces in contact.
//!
//! `rows` are the equations for the contact forces, `switching` the values of the switching functions, `motion` the
//! derivative of the state and the projection.

mod laws;
mod memory;
pub(in crate::simulation) mod motion;
pub(in crate::simulation) mod rows;
mod scales;
mod switch;
pub(in crate::simulation) mod switching;

use crate::linalg::products::dot;
use crate::yardstick;
pub(in crate::simulation) use laws::Laws;
use memory::Equations;
pub(in crate::simulation) use memory::{Mode, SwitchingFunctions};
pub(in crate::simulation) use switch::Switch;

use std::ops::{Deref, DerefMut};

use crate::contact::{ContactState, Direction, Extent, Line, View, stuck};
use crate::enclosure::Bounds;
use crate::joints::Joints;
use crate::model::rounding::{rounding_error, rounding_error_at_start};
use crate::model::{
    ControlPiece, Model, contact_point, friction_share, pair_size, surfaces, switching_terms,
    tangent_point,
};
use crate::simulation::near::Near;
use crate::simulation::{
    ContactMode, ControlSignal, Counts, Doubts, ProblemSize, Residuals, Seconds, Simulation,
    SimulationStatus, Trajectory,
};
use scales::{ContactScale, Instant};

/// Speed below which an explicit method does not follow the direction of a slide, as a multiple of that for finite elements: the slower
/// a slide, the stiffer.
const EXPLICIT: f64 = 10.0;

/// Number of switching functions from which on gaps are left out where nobody looks at them. Chosen: fewer take no time.
const MANY: usize = 16;

/// Dynamics of a model with a set of active contacts `I`, of which `J` stick:
///
/// ```text
/// v' = a + sum_I d_i r_i + e_i s_i              s_i = -+ mu r_i where contact i slips, 0 without friction
/// n_i' v' + curvature = 0  for i in I,          b_i' v' + curvature = 0  for i in J
/// ```
///
/// a linear system for the normal contact accelerations `r_i`, `i` in `I`, and the tangential ones `s_i`, `i`
/// in `J`.
///
/// The state is `y = (q, v, numerical time)`.
pub(in crate::simulation) struct Dynamics<'a> {
    view: View<'a>,
    /// Input vector of the model, `(q, v, u[, t])`.
    x: Vec<f64>,
    /// Mass matrix, row-major.
    mass: Vec<f64>,
    /// Number of contacts.
    pub(in crate::simulation) contacts: usize,
    pub(in crate::simulation) laws: Laws,
    pub(in crate::simulation) mode: Mode,
    pub(in crate::simulation) switching: SwitchingFunctions,
    /// Controls that hold now.
    pub(in crate::simulation) u: Vec<f64>,
    /// The controls over time, until they jump or change their slope.
    piece: ControlPiece,
    /// Evaluations so far.
    pub(in crate::simulation) evaluations: usize,
    /// Sign of the determinant of the equations for the contact accelerations at the last evaluation. While it
    /// stays, none of them has passed through infinity.
    pub(in crate::simulation) orientation: f64,
    equations: Equations,
    /// How far and how fast the motion has been.
    extent: Extent,
    /// What counts as zero at each contact.
    scales: Vec<ContactScale>,
    /// Which contacts may close.
    near: Near,
    auxiliary_acceleration: f64,
    explicit_time: bool,
    /// Joints, if there are any.
    joints: Option<Joints<'a>>,
}

impl<'a> Deref for Dynamics<'a> {
    type Target = View<'a>;

    fn deref(&self) -> &View<'a> {
        &self.view
    }
}

impl DerefMut for Dynamics<'_> {
    fn deref_mut(&mut self) -> &mut Self::Target {
        &mut self.view
    }
}

impl<'a> Dynamics<'a> {
    pub(in crate::simulation) fn new(model: &'a dyn Model, auxiliary_acceleration: f64) -> Self {
        let declaration = model.declaration();
        let n = declaration.coordinates.len();
        let contacts = declaration.contacts.len();
        let laws = Laws::of(model);
        let functions = contacts + 2 * laws.frictional.len();
        let rows = contacts + 2 * laws.frictional.len();
        Self {
            view: View::new(model),
            x: vec![0.0; declaration.inputs()],
            mass: vec![0.0; n * n],
            contacts,
            mode: Mode {
                states: vec![ContactState::Open; contacts],
                active: Vec::with_capacity(contacts),
                sticking: Vec::with_capacity(laws.frictional.len()),
            },
            laws,
            switching: SwitchingFunctions::new(functions),
            u: vec![0.0; declaration.controls.len()],
            piece: ControlPiece::default(),
            evaluations: 0,
            orientation: 1.0,
            equations: Equations::new(contacts, rows),
            extent: Extent::default(),
            scales: vec![ContactScale::default(); contacts],
            near: Near::new(model, surfaces(model)),
            auxiliary_acceleration,
            explicit_time: declaration.explicit_time,
            joints: Joints::of(model),
        }
    }

    /// Whether the scene has joints.
    pub(in crate::simulation) fn has_joints(&self) -> bool {
        self.joints.is_some()
    }

    /// A result without events and trajectory.
    pub(in crate::simulation) fn empty_result(&self) -> Simulation {
        Simulation {
            declaration: self.model.declaration(),
            status: SimulationStatus::Solved,
            initial_modes: Vec::new(),
            events: Vec::new(),
            trajectory: Trajectory::default(),
            error_estimate: None,
            residuals: Residuals::default(),
            size: ProblemSize {
                variables: 2 * self.n,
                equalities: 2 * self.n,
                complementarities: self.contacts,
                ..ProblemSize::default()
            },
            counts: Counts::default(),
            seconds: Seconds::default(),
            interpolated: None,
            notes: Vec::new(),
            doubts: Doubts::default(),
        }
    }

    /// Takes up the piece of the controls that holds right after `t`.
    pub(in crate::simulation) fn set_controls(&mut self, signal: &ControlSignal, t: f64) {
        signal.take_piece(t, self.u.len(), &mut self.piece);
        self.write_controls(t);
    }

    /// Evaluates the controls at `t`.
    pub(in crate::simulation) fn write_controls(&mut self, t: f64) {
        self.piece.write(t, &mut self.u);
        let n = self.n;
        self.x[2 * n..2 * n + self.u.len()].copy_from_slice(&self.u);
    }

    /// Lets the next piece of an edge act if it has come to be the largest: nothing else happens there. What has vanished is left otherwise.
    pub(in crate::simulation) fn pass_edge(&mut self, vanished: Option<Switch>) -> Option<Switch> {
        match vanished {
            Some(Switch::Gap(piece)) if self.pieces.is_idle(piece) => {
                let model = self.model;
                self.pieces.let_act(model, piece);
                None
            }
            other => other,
        }
    }

    /// Writes state and controls at `t` into the input vector that the model's kernels read.
    pub(in crate::simulation) fn load(&mut self, t: f64, y: &[f64]) {
        let n = self.n;
        self.x[..2 * n].copy_from_slice(&y[..2 * n]);
        if self.piece.varies() {
            self.write_controls(t);
        }
        if self.explicit_time
            && let Some(last) = self.x.last_mut()
        {
            *last = t;
        }
    }

    /// Input vector of the model at the state loaded.
    pub(in crate::simulation) fn input(&self) -> &[f64] {
        &self.x
    }

    /// Evaluates one contact at the state loaded.
    pub(in crate::simulation) fn evaluate_contact(&mut self, contact: usize) {
        self.view.evaluate_normal(contact, &self.x);
    }

    /// Evaluates the tangential side of one contact with friction at the state loaded.
    pub(in crate::simulation) fn evaluate_tangent(&mut self, contact: usize) {
        self.view.evaluate_tangent(contact, &self.x);
    }

    /// Below this speed a contact does not slide.
    pub(in crate::simulation) fn zero_speed(&self, contact: usize) -> f64 {
        let zero = self.zero_sliding_velocity(contact);
        let space = self.space(contact);
        space.map_or(zero, |space| zero.max(space.frames()[contact].soft))
    }

    /// Size of the tangential acceleration that a contact provides at the last evaluation.
    pub(in crate::simulation) fn friction_size(&self, contact: usize) -> f64 {
        pair_size((self.equations.s[contact], self.equations.across[contact]))
    }

    /// Evaluates one contact, and its tangential side if it has friction, at the state loaded.
    pub(in crate::simulation) fn evaluate_sides(&mut self, contact: usize) {
        self.view.evaluate_sides(contact, &self.x);
    }

    /// The sliding contact with the smallest [`gain`](Self::gain), and that.
    pub(in crate::simulation) fn smallest_gain(&self) -> Option<(usize, f64)> {
        self.mode
            .active
            .iter()
            .filter(|&&i| self.mode.states[i].slips())
            .map(|&i| {
                (
                    i,
                    self.gain(i, self.mode.states[i].force_ratio(self.frictions(i))),
                )
            })
            .min_by(|(_, a), (_, b)| a.total_cmp(b))
    }

    /// State of a contact in the present mode.
    pub(in crate::simulation) fn state(&self, contact: usize) -> ContactState {
        self.mode.states[contact]
    }

    /// States of all contacts.
    pub(in crate::simulation) fn mode(&self) -> &[ContactState] {
        &self.mode.states
    }

    /// The present mode of each contact, as results tell it.
    pub(in crate::simulation) fn contact_modes(&self) -> Vec<ContactMode> {
        self.mode.states.iter().map(|&state| state.into()).collect()
    }

    /// Changes the contact mode.
    pub(in crate::simulation) fn set_mode(&mut self, mode: &[ContactState]) {
        self.mode.states.copy_from_slice(mode);
        self.mode.active.clear();
        self.mode.sticking.clear();
        for (i, &state) in mode.iter().enumerate() {
            if !state.is_open() {
                self.mode.active.push(i);
            }
            self.mode.sticking.extend(stuck(i, state));
        }
    }

    /// Gap at the state loaded.
    pub(in crate::simulation) fn gap(&self, contact: usize) -> f64 {
        self.pieces.gap(self.model, contact, &self.x)
    }

    /// Lets the pieces of surfaces with edges act that do so at the state loaded.
    pub(in crate::simulation) fn choose_pieces(&mut self) {
        let model = self.model;
        self.view.pieces.choose(model, &self.x);
    }

    /// Evaluates the acceleration without contact at the state loaded.
    pub(in crate::simulation) fn evaluate_free_acceleration(&mut self) {
        self.evaluations += 1;
        self.view.evaluate_free_acceleration(&self.x);
    }

    /// Normal acceleration of contact `i` without contact forces, `n' a + curvature`, and the sum of
    /// the absolute values of its terms.
    pub(in crate::simulation) fn free_normal_acceleration(&self, contact: usize) -> (f64, f64) {
        let curvature = self.point(contact)[contact_point::CURVATURE];
        along(self.normal(contact), self.free_acceleration(), curvature)
    }

    /// Rate of the sliding velocity of contact `i` without contact forces, `b' a + curvature`, and the sum of
    /// the absolute values of its terms.
    pub(in crate::simulation) fn free_sliding_acceleration(&self, contact: usize) -> (f64, f64) {
        let curvature = self.tangent_point(contact)[tangent_point::CURVATURE];
        along(
            self.tangent(contact),
            self.view.free_acceleration(),
            curvature,
        )
    }

    /// Normal acceleration and rate of the sliding velocity with the accelerations `a`; the latter is 0
    /// without friction.
    pub(in crate::simulation) fn contact_accelerations(
        &self,
        contact: usize,
        a: &[f64],
    ) -> (f64, f64) {
        let normal = self.point(contact)[contact_point::CURVATURE] + dot(self.normal(contact), a);
        if !self.has_friction(contact) {
            return (normal, 0.0);
        }
        let curvature = self.tangent_point(contact)[tangent_point::CURVATURE];
        (normal, curvature + dot(self.tangent(contact), a))
    }

    /// Sizes of the terms of the normal acceleration with contact forces of any contact as last
    /// evaluated: `|curvature| + sum_k |n_k| (|a_k| + sum_j |d_jk r_j| + |e_jk s_j|)`, or the floor if that is
    /// larger.
    pub(in crate::simulation) fn normal_acceleration_scale(&self, contact: usize) -> f64 {
        let curvature = self.point(contact)[contact_point::CURVATURE];
        self.acceleration_scale(self.normal(contact), curvature)
            .max(self.switching.force_floor[contact])
    }

    /// Sizes of the terms of the rate of the sliding velocity of a contact, or the floor if that is larger.
    pub(in crate::simulation) fn sliding_acceleration_scale(&self, contact: usize) -> f64 {
        let curvature = self.tangent_point(contact)[tangent_point::CURVATURE];
        self.acceleration_scale(self.tangent(contact), curvature)
            .max(self.switching.force_floor[contact])
    }

    fn acceleration_scale(&self, covector: &[f64], curvature: f64) -> f64 {
        let components = covector.iter().enumerate();
        components.filter(|(_, component)| **component != 0.0).fold(
            curvature.abs(),
            |sum, (k, component)| {
                let forces: f64 = self
                    .mode
                    .active
                    .iter()
                    .map(|&j| {
                        let normal = (self.direction(j)[k] * self.equations.r[j]).abs();
                        if self.equations.s[j] == 0.0 {
                            return normal;
                        }
                        normal + (self.friction_direction(j)[k] * self.equations.s[j]).abs()
                    })
                    .sum();
                sum + component.abs() * (self.view.free_acceleration()[k].abs() + forces)
            },
        )
    }

    /// Takes note of the sizes of the functions of all contacts at a state, by which is measured what counts as zero there.
    /// `moment` is a time over which the motion is smooth, such as a step size.
    pub(in crate::simulation) fn observe(&mut self, t: f64, y: &[f64], moment: f64) {
        self.load(t, y);
        self.view.evaluate_free_acceleration(&self.x);
        self.stay_near();
        let n = self.n;
        let a = self.view.free_acceleration();
        self.extent.include(&y[..n], &y[n..2 * n], a);
        for slot in 0..self.near.contacts().len() {
            let i = self.near.contacts()[slot];
            self.evaluate_sides(i);
            let (view, rubs) = (&self.view, self.view.has_friction(i));
            let friction = rubs.then(|| (view.tangent_point(i), view.friction(i)));
            let instant = Instant::new(&y[..2 * n], view.free_acceleration(), moment);
            let time = if self.explicit_time { t } else { 0.0 };
            self.scales[i].observe(view.point(i), friction, instant.at(time), &self.extent);
            let terms = switching_terms(self.model, i, &self.x);
            self.scales[i].observe_switch(terms);
            if self.is_in_space(i) {
                let speed = pair_size(self.sliding(i));
                let scale = &mut self.scales[i];
                scale.observe_switch(speed);
                let zero = scale.zero_sliding_velocity();
                let soft = EXPLICIT * scale.sliding_velocity;
                self.view.measure_sliding(i, soft, zero);
                if self.mode.states[i].slips() {
                    self.align(i, None);
                }
            }
        }
    }

    /// Contacts that may close, increasing; the others are far at the state loaded.
    pub(in crate::simulation) fn near(&self) -> &[usize] {
        self.near.contacts()
    }

    /// Time on which gaps depend, if they do.
    fn time(&self) -> Option<f64> {
        self.x.last().copied().filter(|_| self.explicit_time)
    }

    /// Finds out anew which contacts may close, if the state loaded is elsewhere than was expected.
    pub(in crate::simulation) fn stay_near(&mut self) {
        if self.near.is_left(&self.x, self.view.n, self.time()) {
            self.look_around();
        }
    }

    /// Looks around for a step of length `h` from a state, if it may leave where nothing can close.
    pub(in crate::simulation) fn prepare_step(&mut self, t: f64, y: &[f64], h: f64) {
        self.near.expect_step(h);
        self.load(t, y);
        let a = self.view.free_acceleration();
        if self.near.is_left_within(&self.x, a, self.explicit_time) {
            self.look_around();
        }
    }

    /// Finds out which contacts may close within the next steps from the state loaded.
    fn look_around(&mut self) {
        let (view, switching) = (&mut self.view, &mut self.switching);
        let model = view.model;
        let mut place = |contact: usize, value: f64| {
            switching.values[contact] = value;
            switching.lowest[contact] = value;
            switching.highest[contact] = value;
        };
        let mut bounds = Bounds::new(model);
        let least_gap =
            |contact: usize, low: &[f64], high: &[f64]| bounds.least_gap(contact, low, high);
        let now = (&self.x[..], view.free_acceleration());
        let near = &mut self.near;
        let news = near.look(least_gap, now, self.explicit_time, &mut place);
        let pieces = &mut view.pieces;
        pieces.choose_among(model, &self.x, news.iter().copied());
        for contact in news {
            place(contact, pieces.gap(model, contact, &self.x));
        }
    }

    /// Expects a motion that is smooth over a `moment`, where no step tells yet.
    pub(in crate::simulation) fn expect_moment(&mut self, moment: f64) {
        for scale in &mut self.scales {
            scale.expect_moment(moment);
        }
    }

    /// Measures the rounding errors of all gaps around a state, which may be that `at_start`.
    pub(in crate::simulation) fn observe_rounding(
        &mut self,
        t: f64,
        y: &[f64],
        moment: f64,
        at_start: bool,
    ) {
        self.observe(t, y, moment);
        let n = self.n;
        for &i in self.near.contacts() {
            let (pieces, model) = (&self.view.pieces, self.view.model);
            let a = self.view.free_acceleration();
            let x = &mut self.x;
            x[..2 * n].copy_from_slice(&y[..2 * n]);
            let error = if at_start {
                rounding_error_at_start(x, a, moment, |x| pieces.gap(model, i, x))
            } else {
                rounding_error(|share| {
                    let instant = Instant::new(&y[..2 * n], a, moment);
                    for (k, x) in x[..n].iter_mut().enumerate() {
                        *x = instant.moved(k, share);
                    }
                    pieces.gap(model, i, x)
                })
            };
            self.scales[i].observe_rounding(error);
        }
        self.load(t, y);
    }

    /// Mass matrix at a state, row-major.
    pub(in crate::simulation) fn mass(&mut self, t: f64, y: &[f64]) -> &[f64] {
        self.load(t, y);
        self.view.model.mass_matrix(&self.x, &mut self.mass);
        &self.mass
    }

    /// Whether a contact belongs to the present mode.
    pub(in crate::simulation) fn is_active(&self, contact: usize) -> bool {
        self.mode.active.contains(&contact)
    }

    /// Normal contact forces at the last evaluation, `lambda_i = r_i / D_i`, 0 for open contacts.
    pub(in crate::simulation) fn forces(&self, out: &mut [f64]) {
        self.divide_by_inertia(&self.equations.r, out);
    }

    /// Tangential contact forces at the last evaluation, `s_i / D_i`, 0 for open contacts.
    pub(in crate::simulation) fn friction_forces(&self, out: &mut [f64]) {
        self.divide_by_inertia(&self.equations.s, out);
        for &i in self.mode.active.iter().filter(|&&i| self.is_in_space(i)) {
            // In space it has a size, and a direction that the velocities tell.
            out[i] = self.friction_size(i) / self.point(i)[contact_point::INVERSE_INERTIA];
        }
        for (i, force) in out.iter_mut().enumerate() {
            *force *= friction_share(self.model, i, &self.x);
        }
    }

    fn divide_by_inertia(&self, accelerations: &[f64], out: &mut [f64]) {
        out.fill(0.0);
        for &i in &self.mode.active {
            out[i] = accelerations[i] / self.point(i)[contact_point::INVERSE_INERTIA];
        }
    }

    /// Normal contact acceleration of an active contact at the last evaluation.
    pub(in crate::simulation) fn normal_force(&self, contact: usize) -> f64 {
        self.equations.r[contact]
    }

    /// What a contact that sticks at the last evaluation has left before it slips, `mu r - |s|`.
    pub(in crate::simulation) fn friction_reserve(&self, contact: usize) -> f64 {
        self.friction(contact) * self.equations.r[contact] - self.friction_size(contact)
    }

    /// What a switching function is in the present mode.
    pub(in crate::simulation) fn switch(&self, function: usize) -> Switch {
        if function < self.contacts {
            return if self.mode.states[function].is_open() {
                Switch::Gap(function)
            } else {
                Switch::NormalForce(function)
            };
        }
        let index = function - self.contacts;
        let contact = self.laws.frictional[index / 2];
        match (self.mode.states[contact], index % 2) {
            (ContactState::StickInSpace, 1) => Switch::Constant(contact),
            (ContactState::Stick | ContactState::StickInSpace, 0) => {
                Switch::FrictionLimit(contact, Direction::Forward)
            }
            (ContactState::Stick, _) => Switch::FrictionLimit(contact, Direction::Backward),
            (ContactState::Slip(direction), 0) => Switch::SlidingVelocity(contact, direction),
            (ContactState::Held(_), 0) => Switch::HeldVelocity(contact),
            _ => Switch::Constant(contact),
        }
    }

    /// Number of switching functions.
    pub(in crate::simulation) fn functions(&self) -> usize {
        self.switching.values.len()
    }

    /// Size of forces to which those of a contact are compared.
    pub(in crate::simulation) fn force_floor(&self, contact: usize) -> f64 {
        self.switching.force_floor[contact]
    }

    /// Leaves the gaps of open contacts out of evaluations, or takes them up again: the motion does not depend on them. Of few functions all
    /// are evaluated.
    pub(in crate::simulation) fn leave_gaps(&mut self, idle: bool) {
        self.switching.gaps_are_idle = idle && self.functions() >= MANY;
    }

    /// Makes `values` the first sample of a step.
    pub(in crate::simulation) fn sample_from(&mut self, values: &[f64]) {
        self.switching.sample_from(values);
    }

    /// Below this gap a contact is closed.
    pub(in crate::simulation) fn closed_gap(&self, contact: usize) -> f64 {
        // What an idle piece lacks to acting is the difference of two gaps, whose terms may cancel.
        let acting = self.pieces.acting(contact);
        let [own, other] = [contact, acting].map(|i| self.scales[i].closed_gap());
        own.max(other)
    }

    /// Rounding error of a gap.
    pub(super) fn gap_rounding(&self, contact: usize) -> f64 {
        self.scales[contact].rounding
    }

    /// By how much the way of the motion has changed a gap.
    pub(in crate::simulation) fn gap_range(&self, contact: usize) -> f64 {
        self.scales[contact].range
    }

    /// Flights lower than this are none.
    pub(in crate::simulation) fn lowest_flight(&self, contact: usize) -> f64 {
        self.scales[contact].lowest_flight()
    }

    /// Below this normal velocity a contact is at rest.
    pub(in crate::simulation) fn zero_normal_velocity(&self, contact: usize) -> f64 {
        self.scales[contact].zero_normal_velocity()
    }

    /// Below this a normal velocity is rounding of a motion that may be elsewhere, as of balls in a row: of what its energy could make of it.
    pub(in crate::simulation) fn zero_of_energy(&self, contact: usize) -> f64 {
        let view = &self.view;
        let response = view.coupling(Line::normal(contact), Line::normal(contact));
        yardstick::ROUNDING * (2.0 * view.kinetic_energy(self.input()) * response).sqrt()
    }

    /// Sizes of the gap, the normal and the sliding velocity of a contact that is held: at least of what forces like the present ones
    /// could make of them in the longest moment.
    pub(in crate::simulation) fn held_sizes(&self, contact: usize) -> [f64; 3] {
        let (scale, moment) = (&self.scales[contact], self.scales[contact].longest);
        let speed = moment * self.switching.force_floor[contact];
        [
            scale.range.max(moment * speed),
            scale.normal_velocity.max(speed),
            scale.sliding_velocity.max(speed),
        ]
    }

    /// Below these normal and sliding velocities contacts are at rest.
    pub(in crate::simulation) fn zero_velocities(&self) -> Vec<(f64, f64)> {
        let scales = self.scales.iter();
        scales
            .map(|known| (known.zero_normal_velocity(), known.zero_sliding_velocity()))
            .collect()
    }

    /// Below this sliding velocity a contact does not slide.
    pub(in crate::simulation) fn zero_sliding_velocity(&self, contact: usize) -> f64 {
        self.scales[contact].zero_sliding_velocity()
    }
}

/// `covector' a + curvature`, and the sum of the absolute values of its terms.
fn along(covector: &[f64], a: &[f64], curvature: f64) -> (f64, f64) {
    covector
        .iter()
        .zip(a)
        .fold((curvature, curvature.abs()), |(sum, scale), (n, a)| {
            (sum + n * a, scale + (n * a).abs())
        })
}
