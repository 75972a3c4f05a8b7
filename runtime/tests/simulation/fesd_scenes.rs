//! Scenes with friction and restitution.

#![allow(
    dead_code,
    unused_imports,
    missing_docs,
    unreachable_pub,
    reason = "shared by several test programs, each of which uses a part"
)]

use crate::common::scene::{HandWritten, Number, Scene};
pub use crate::common::shapes::{Body, FLAT, Ground, Shape};

use crate::common::scenes::GRAVITY;

/// A point mass on some ground, held by a spring to the origin, pushed along `y` by the control.
#[derive(Debug, Clone)]
pub struct Point {
    pub mass: f64,
    pub ground: Ground,
    pub friction: f64,
    pub restitution: f64,
    pub stiffness: f64,
}

impl Point {
    pub fn on(ground: Ground, friction: f64, restitution: f64) -> Self {
        Self {
            mass: 1.0,
            ground,
            friction,
            restitution,
            stiffness: 0.0,
        }
    }

    pub fn model(self) -> HandWritten<Self, 2, 1> {
        HandWritten::new(self)
    }
}

impl Scene<2, 1> for Point {
    fn coordinates(&self) -> [&'static str; 2] {
        ["y", "z"]
    }
    fn contacts(&self) -> &'static [&'static str] {
        &["ground"]
    }
    fn mass<D: Number>(&self, _q: &[D; 2]) -> [[D; 2]; 2] {
        let (m, zero) = (D::from(self.mass), D::from(0.0));
        [[m, zero], [zero, m]]
    }
    fn force<D: Number>(&self, q: &[D; 2], _v: &[D; 2], u: &[D; 1]) -> [D; 2] {
        [u[0] - q[0] * self.stiffness, D::from(-GRAVITY * self.mass)]
    }
    fn potential(&self, q: &[f64; 2]) -> f64 {
        self.mass * GRAVITY * q[1] + 0.5 * self.stiffness * q[0] * q[0]
    }
    fn gap<D: Number>(&self, _contact: usize, q: &[D; 2]) -> D {
        self.ground.gap(q)
    }
    fn restitution(&self, _contact: usize) -> f64 {
        self.restitution
    }
    fn friction(&self, _contact: usize) -> f64 {
        self.friction
    }
    fn sliding<D: Number>(&self, _contact: usize, q: &[D; 2], v: &[D; 2]) -> Option<D> {
        let tangent = self.ground.tangent(q);
        Some(tangent[0] * v[0] + tangent[1] * v[1])
    }
}

/// A unit mass `y` on the floor, pulled by a hardening spring whose other end `p` moves freely.
#[derive(Debug, Clone)]
pub struct Pulled {
    pub friction: f64,
    pub stiffness: f64,
    pub hardening: f64,
}

impl Scene<3, 0> for Pulled {
    fn coordinates(&self) -> [&'static str; 3] {
        ["y", "z", "p"]
    }
    fn contacts(&self) -> &'static [&'static str] {
        &["floor"]
    }
    fn mass<D: Number>(&self, _q: &[D; 3]) -> [[D; 3]; 3] {
        let (one, o) = (D::from(1.0), D::from(0.0));
        [[one, o, o], [o, one, o], [o, o, one]]
    }
    fn force<D: Number>(&self, q: &[D; 3], _v: &[D; 3], _u: &[D; 0]) -> [D; 3] {
        let stretch = q[2] - q[0];
        let pull = stretch * self.stiffness + stretch * stretch * stretch * self.hardening;
        [pull, D::from(-GRAVITY), D::from(0.0)]
    }
    fn potential(&self, q: &[f64; 3]) -> f64 {
        GRAVITY * q[1]
    }
    fn gap<D: Number>(&self, _contact: usize, q: &[D; 3]) -> D {
        q[1]
    }
    fn friction(&self, _contact: usize) -> f64 {
        self.friction
    }
    fn sliding<D: Number>(&self, _contact: usize, _q: &[D; 3], v: &[D; 3]) -> Option<D> {
        Some(v[0])
    }
}

/// A crate `(y, z, angle)` of unit mass between floor, left wall and right wall, all with friction: each of
/// the four corners against each of the three surfaces.
#[derive(Debug, Clone)]
pub struct RoughCrate {
    pub half_width: f64,
    pub half_height: f64,
    pub half_room: f64,
    pub friction: f64,
}

impl RoughCrate {
    pub fn model(self) -> HandWritten<Self, 3, 0> {
        HandWritten::new(self)
    }

    /// Corner of a contact in the frame of the crate.
    fn corner(&self, contact: usize) -> (f64, f64) {
        let sign = |bit: usize| if contact & bit == 0 { 1.0 } else { -1.0 };
        (sign(1) * self.half_width, sign(2) * self.half_height)
    }
}

impl Scene<3, 0> for RoughCrate {
    fn coordinates(&self) -> [&'static str; 3] {
        ["y", "z", "angle"]
    }
    fn contacts(&self) -> &'static [&'static str] {
        &[
            "floor 1", "floor 2", "floor 3", "floor 4", "left 1", "left 2", "left 3", "left 4",
            "right 1", "right 2", "right 3", "right 4",
        ]
    }
    fn mass<D: Number>(&self, _q: &[D; 3]) -> [[D; 3]; 3] {
        let (one, o) = (D::from(1.0), D::from(0.0));
        let inertia = D::from((self.half_width.powi(2) + self.half_height.powi(2)) / 3.0);
        [[one, o, o], [o, one, o], [o, o, inertia]]
    }
    fn force<D: Number>(&self, _q: &[D; 3], _v: &[D; 3], _u: &[D; 0]) -> [D; 3] {
        [D::from(0.0), D::from(-GRAVITY), D::from(0.0)]
    }
    fn potential(&self, q: &[f64; 3]) -> f64 {
        GRAVITY * q[1]
    }
    fn gap<D: Number>(&self, contact: usize, q: &[D; 3]) -> D {
        let (across, up) = self.corner(contact);
        let (sin, cos) = q[2].sin_cos();
        let (y, z) = (
            q[0] + cos * across - sin * up,
            q[1] + sin * across + cos * up,
        );
        match contact / 4 {
            0 => z,
            1 => y + self.half_room,
            _ => -y + self.half_room,
        }
    }
    fn friction(&self, _contact: usize) -> f64 {
        self.friction
    }
    fn sliding<D: Number>(&self, contact: usize, q: &[D; 3], v: &[D; 3]) -> Option<D> {
        let (across, up) = self.corner(contact);
        let (sin, cos) = q[2].sin_cos();
        Some(if contact < 4 {
            v[0] - v[2] * (sin * across + cos * up)
        } else {
            v[1] + v[2] * (cos * across - sin * up)
        })
    }
}

/// A unit mass between the surfaces `z + y >= 0` and `z - 2 y >= 0`.
#[derive(Debug, Clone)]
pub struct Wedge {
    pub friction: f64,
    pub restitution: f64,
}

impl Scene<2, 0> for Wedge {
    fn coordinates(&self) -> [&'static str; 2] {
        ["y", "z"]
    }
    fn contacts(&self) -> &'static [&'static str] {
        &["left", "right"]
    }
    fn mass<D: Number>(&self, _q: &[D; 2]) -> [[D; 2]; 2] {
        let (one, o) = (D::from(1.0), D::from(0.0));
        [[one, o], [o, one]]
    }
    fn force<D: Number>(&self, _q: &[D; 2], _v: &[D; 2], _u: &[D; 0]) -> [D; 2] {
        [D::from(0.0), D::from(-GRAVITY)]
    }
    fn potential(&self, q: &[f64; 2]) -> f64 {
        GRAVITY * q[1]
    }
    fn gap<D: Number>(&self, contact: usize, q: &[D; 2]) -> D {
        if contact == 0 {
            q[1] + q[0]
        } else {
            q[1] - q[0] * 2.0
        }
    }
    fn restitution(&self, _contact: usize) -> f64 {
        self.restitution
    }
    fn friction(&self, _contact: usize) -> f64 {
        self.friction
    }
    fn sliding<D: Number>(&self, contact: usize, _q: &[D; 2], v: &[D; 2]) -> Option<D> {
        Some(if contact == 0 {
            v[0] - v[1]
        } else {
            v[0] + v[1] * 2.0
        })
    }
}
