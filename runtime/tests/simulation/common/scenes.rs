//! The scenes.

use super::scene::{HandWritten, Number, Scene};
use super::shapes::{Body, FLAT, Ground, Shape};

/// Acceleration of gravity in every scene [m/s^2].
pub const GRAVITY: f64 = 9.81;

/// A point mass in the plane `(y, z)`.
macro_rules! point_mass {
    ($mass:expr) => {
        fn coordinates(&self) -> [&'static str; 2] {
            ["y", "z"]
        }

        fn mass<D: Number>(&self, _q: &[D; 2]) -> [[D; 2]; 2] {
            let (m, zero) = (D::from($mass), D::from(0.0));
            [[m, zero], [zero, m]]
        }

        fn force<D: Number>(&self, _q: &[D; 2], _v: &[D; 2], _u: &[D; 0]) -> [D; 2] {
            [D::from(0.0), D::from($mass) * -GRAVITY]
        }

        fn potential(&self, q: &[f64; 2]) -> f64 {
            $mass * GRAVITY * q[1]
        }
    };
}

/// A point mass on some ground, without friction.
#[derive(Debug, Clone)]
pub struct OnGround {
    pub mass: f64,
    pub ground: Ground,
}

impl Scene<2, 0> for OnGround {
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

    fn force<D: Number>(&self, _q: &[D; 2], _v: &[D; 2], _u: &[D; 0]) -> [D; 2] {
        [D::from(0.0), D::from(self.mass) * -GRAVITY]
    }

    fn potential(&self, q: &[f64; 2]) -> f64 {
        self.mass * GRAVITY * q[1]
    }

    fn gap<D: Number>(&self, _contact: usize, q: &[D; 2]) -> D {
        self.ground.gap(q)
    }
}

/// A point mass above flat ground.
pub fn ball() -> HandWritten<OnGround, 2, 0> {
    HandWritten::new(OnGround {
        mass: 0.5,
        ground: FLAT,
    })
}

/// A point mass on wavy ground `z = height cos(number y)`.
pub fn waves(height: f64, number: f64) -> HandWritten<OnGround, 2, 0> {
    HandWritten::new(OnGround {
        mass: 1.0,
        ground: Ground::Waves { height, number },
    })
}

/// The ski jump: a point mass on the table and the slope.
#[derive(Debug, Clone)]
pub struct SkiJump;

/// Height of the table.
pub fn table<D: Number>(y: D) -> D {
    (((y * -0.0001524 - 0.002149) * y + 0.4162) * y - 9.154) * y + 99.15
}

impl Scene<2, 0> for SkiJump {
    point_mass!(80.0);

    fn contacts(&self) -> &'static [&'static str] {
        &["table", "slope"]
    }

    fn gap<D: Number>(&self, contact: usize, q: &[D; 2]) -> D {
        if contact == 0 {
            q[1] - table(q[0])
        } else {
            q[1] + q[0] * 0.5 - 45.0
        }
    }
}

pub fn ski_jump() -> HandWritten<SkiJump, 2, 0> {
    HandWritten::new(SkiJump)
}

/// A point mass on the unit disc; the gap is in square metres.
#[derive(Debug, Clone)]
pub struct Disc;

impl Scene<2, 0> for Disc {
    point_mass!(3.0);

    fn contacts(&self) -> &'static [&'static str] {
        &["disc"]
    }

    fn gap<D: Number>(&self, _contact: usize, q: &[D; 2]) -> D {
        q[0] * q[0] + q[1] * q[1] - 1.0
    }
}

pub fn disc() -> HandWritten<Disc, 2, 0> {
    HandWritten::new(Disc)
}

/// A block that slides on the floor towards a wall at `y = 1`, and the floor a second time.
#[derive(Debug, Clone)]
pub struct Corner {
    /// Names of the surfaces; a third one repeats the floor.
    pub surfaces: &'static [&'static str],
}

impl Scene<2, 0> for Corner {
    point_mass!(2.0);

    fn contacts(&self) -> &'static [&'static str] {
        self.surfaces
    }

    fn gap<D: Number>(&self, contact: usize, q: &[D; 2]) -> D {
        match contact {
            0 => q[1],
            1 => -q[0] + 1.0,
            _ => q[1] * 3.0,
        }
    }
}

pub fn corner() -> HandWritten<Corner, 2, 0> {
    HandWritten::new(Corner {
        surfaces: &["floor", "wall"],
    })
}

pub fn corner_with_double_floor() -> HandWritten<Corner, 2, 0> {
    HandWritten::new(Corner {
        surfaces: &["floor", "wall", "floor again"],
    })
}

/// A pendulum of unit mass and length, `angle` from the vertical, beside a wall at `angle = wall`.
#[derive(Debug, Clone)]
pub struct Pendulum {
    pub wall: f64,
}

impl Scene<1, 0> for Pendulum {
    fn coordinates(&self) -> [&'static str; 1] {
        ["angle"]
    }

    fn contacts(&self) -> &'static [&'static str] {
        &["wall"]
    }

    fn mass<D: Number>(&self, _q: &[D; 1]) -> [[D; 1]; 1] {
        [[D::from(1.0)]]
    }

    fn force<D: Number>(&self, q: &[D; 1], _v: &[D; 1], _u: &[D; 0]) -> [D; 1] {
        [q[0].sin() * -GRAVITY]
    }

    fn potential(&self, q: &[f64; 1]) -> f64 {
        -GRAVITY * q[0].cos()
    }

    fn gap<D: Number>(&self, _contact: usize, q: &[D; 1]) -> D {
        -q[0].sin() + self.wall.sin()
    }
}

pub fn pendulum(wall: f64) -> HandWritten<Pendulum, 1, 0> {
    HandWritten::new(Pendulum { wall })
}

/// A bar of unit mass with tips at distances `front` and `rear` from its centre and the radius of gyration
/// `radius`, without friction: on flat ground, `D_12 = (1 - front rear / radius^2) / m` when it is level.
pub fn bar(front: f64, rear: f64, radius: f64) -> HandWritten<Body, 3, 0> {
    Body {
        gyration: radius,
        shape: Shape::Tips { front, rear },
        friction: 0.0,
        restitution: 0.0,
    }
    .model()
}

/// A mass at `z` above the ground that a control `u` pulls up, and a second one on a spring above it.
#[derive(Debug, Clone)]
pub struct Hopper;

/// Stiffness of the hopper's spring [N/m].
pub const STIFFNESS: f64 = 400.0;

impl Scene<2, 1> for Hopper {
    fn coordinates(&self) -> [&'static str; 2] {
        ["foot", "body"]
    }

    fn contacts(&self) -> &'static [&'static str] {
        &["ground"]
    }

    fn mass<D: Number>(&self, _q: &[D; 2]) -> [[D; 2]; 2] {
        [[D::from(1.0), D::from(0.0)], [D::from(0.0), D::from(2.0)]]
    }

    fn force<D: Number>(&self, q: &[D; 2], _v: &[D; 2], u: &[D; 1]) -> [D; 2] {
        let spring = (q[1] - q[0] - 0.5) * STIFFNESS;
        [spring - GRAVITY, -spring - 2.0 * GRAVITY + u[0]]
    }

    fn potential(&self, q: &[f64; 2]) -> f64 {
        let stretch = q[1] - q[0] - 0.5;
        GRAVITY * (q[0] + 2.0 * q[1]) + 0.5 * STIFFNESS * stretch * stretch
    }

    fn gap<D: Number>(&self, _contact: usize, q: &[D; 2]) -> D {
        q[0]
    }
}

pub fn hopper() -> HandWritten<Hopper, 2, 1> {
    HandWritten::new(Hopper)
}

/// A point mass on the track `z = 0.2 (1 - cos 2y)` in the coordinates (y, height above the track),
/// with the impulse direction `(-h', 1)`, which is not `M^-1 grad g`.
#[derive(Debug, Clone)]
pub struct Track;

/// Height of the track.
pub fn track<D: Number>(y: D) -> D {
    ((y * 2.0).cos() - 1.0) * -0.2
}

impl Scene<2, 0> for Track {
    fn coordinates(&self) -> [&'static str; 2] {
        ["y", "s"]
    }

    fn contacts(&self) -> &'static [&'static str] {
        &["track"]
    }

    fn mass<D: Number>(&self, q: &[D; 2]) -> [[D; 2]; 2] {
        let slope = (q[0] * 2.0).sin() * 0.4;
        let one = D::from(1.0);
        [[slope * slope + 1.0, slope], [slope, one]]
    }

    fn force<D: Number>(&self, q: &[D; 2], v: &[D; 2], _u: &[D; 0]) -> [D; 2] {
        let slope = (q[0] * 2.0).sin() * 0.4;
        let weight = -((q[0] * 2.0).cos() * 0.8 * v[0] * v[0] + GRAVITY);
        [slope * weight, weight]
    }

    fn potential(&self, q: &[f64; 2]) -> f64 {
        GRAVITY * (track(q[0]) + q[1])
    }

    fn gap<D: Number>(&self, _contact: usize, q: &[D; 2]) -> D {
        q[1]
    }

    fn direction<D: Number>(&self, _contact: usize, q: &[D; 2]) -> Option<[D; 2]> {
        Some([(q[0] * 2.0).sin() * -0.4, D::from(1.0)])
    }
}

pub fn track_scene() -> HandWritten<Track, 2, 0> {
    HandWritten::new(Track)
}

/// A point mass on which a force `sqrt(1 - y)` acts: not a number beyond `y = 1`.
#[derive(Debug, Clone)]
pub struct Edge;

impl Scene<1, 0> for Edge {
    fn coordinates(&self) -> [&'static str; 1] {
        ["y"]
    }

    fn contacts(&self) -> &'static [&'static str] {
        &[]
    }

    fn mass<D: Number>(&self, _q: &[D; 1]) -> [[D; 1]; 1] {
        [[D::from(1.0)]]
    }

    fn force<D: Number>(&self, q: &[D; 1], _v: &[D; 1], _u: &[D; 0]) -> [D; 1] {
        [(-q[0] + 1.0).sqrt()]
    }

    fn potential(&self, _q: &[f64; 1]) -> f64 {
        0.0
    }

    fn gap<D: Number>(&self, _contact: usize, q: &[D; 1]) -> D {
        q[0]
    }
}

pub fn edge() -> HandWritten<Edge, 1, 0> {
    HandWritten::new(Edge)
}

/// A ball of unit mass at height `z` that a control pulls up.
#[derive(Debug, Clone)]
pub struct LiftedBall;

impl Scene<1, 1> for LiftedBall {
    fn coordinates(&self) -> [&'static str; 1] {
        ["z"]
    }

    fn contacts(&self) -> &'static [&'static str] {
        &["ground"]
    }

    fn mass<D: Number>(&self, _q: &[D; 1]) -> [[D; 1]; 1] {
        [[D::from(1.0)]]
    }

    fn force<D: Number>(&self, _q: &[D; 1], _v: &[D; 1], u: &[D; 1]) -> [D; 1] {
        [u[0] - GRAVITY]
    }

    fn potential(&self, q: &[f64; 1]) -> f64 {
        GRAVITY * q[0]
    }

    fn gap<D: Number>(&self, _contact: usize, q: &[D; 1]) -> D {
        q[0]
    }
}

pub fn lifted_ball() -> HandWritten<LiftedBall, 1, 1> {
    HandWritten::new(LiftedBall)
}

/// A block of unit mass on the floor that a constant force presses against the wall at `y = 1`.
#[derive(Debug, Clone)]
pub struct PressedCorner {
    pub press: f64,
}

impl Scene<2, 0> for PressedCorner {
    fn coordinates(&self) -> [&'static str; 2] {
        ["y", "z"]
    }

    fn contacts(&self) -> &'static [&'static str] {
        &["floor", "wall"]
    }

    fn mass<D: Number>(&self, _q: &[D; 2]) -> [[D; 2]; 2] {
        let (one, zero) = (D::from(1.0), D::from(0.0));
        [[one, zero], [zero, one]]
    }

    fn force<D: Number>(&self, _q: &[D; 2], _v: &[D; 2], _u: &[D; 0]) -> [D; 2] {
        [D::from(self.press), D::from(-GRAVITY)]
    }

    fn potential(&self, q: &[f64; 2]) -> f64 {
        GRAVITY * q[1] - self.press * q[0]
    }

    fn gap<D: Number>(&self, contact: usize, q: &[D; 2]) -> D {
        if contact == 0 { q[1] } else { -q[0] + 1.0 }
    }
}

pub fn pressed_corner(press: f64) -> HandWritten<PressedCorner, 2, 0> {
    HandWritten::new(PressedCorner { press })
}

/// A rectangular crate `(y, z, angle)` of unit mass between floor, left wall and right wall: each of the
/// four corners against each of the three surfaces, twelve contacts.
#[derive(Debug, Clone)]
pub struct Crate {
    pub half_width: f64,
    pub half_height: f64,
    pub half_room: f64,
}

impl Scene<3, 0> for Crate {
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
        let (one, zero) = (D::from(1.0), D::from(0.0));
        let inertia = D::from((self.half_width.powi(2) + self.half_height.powi(2)) / 3.0);
        [[one, zero, zero], [zero, one, zero], [zero, zero, inertia]]
    }

    fn force<D: Number>(&self, _q: &[D; 3], _v: &[D; 3], _u: &[D; 0]) -> [D; 3] {
        [D::from(0.0), D::from(-GRAVITY), D::from(0.0)]
    }

    fn potential(&self, q: &[f64; 3]) -> f64 {
        GRAVITY * q[1]
    }

    fn gap<D: Number>(&self, contact: usize, q: &[D; 3]) -> D {
        let across = if contact & 1 == 0 {
            self.half_width
        } else {
            -self.half_width
        };
        let up = if contact & 2 == 0 {
            self.half_height
        } else {
            -self.half_height
        };
        let (sin, cos) = q[2].sin_cos();
        match contact / 4 {
            0 => q[1] + sin * across + cos * up,
            1 => q[0] + cos * across - sin * up + self.half_room,
            _ => -(q[0] + cos * across - sin * up) + self.half_room,
        }
    }
}

pub fn crate_in_room(
    half_width: f64,
    half_height: f64,
    half_room: f64,
) -> HandWritten<Crate, 3, 0> {
    HandWritten::new(Crate {
        half_width,
        half_height,
        half_room,
    })
}

/// A block in a corner whose contact directions push it into the other surface: `D = [1, -2; -2, 1]`.
#[derive(Debug, Clone)]
pub struct JammingCorner;

impl Scene<2, 0> for JammingCorner {
    point_mass!(1.0);

    fn contacts(&self) -> &'static [&'static str] {
        &["floor", "wall"]
    }

    fn gap<D: Number>(&self, contact: usize, q: &[D; 2]) -> D {
        if contact == 0 { q[1] } else { q[0] }
    }

    fn direction<D: Number>(&self, contact: usize, _q: &[D; 2]) -> Option<[D; 2]> {
        let (one, two) = (D::from(1.0), D::from(-2.0));
        Some(if contact == 0 { [two, one] } else { [one, two] })
    }
}

pub fn jamming_corner() -> HandWritten<JammingCorner, 2, 0> {
    HandWritten::new(JammingCorner)
}

/// A block above a floor that is declared thirteen times.
pub fn thirteen_floors() -> HandWritten<Corner, 2, 0> {
    HandWritten::new(Corner {
        surfaces: &[
            "floor", "wall", "3", "4", "5", "6", "7", "8", "9", "10", "11", "12", "13", "14",
        ],
    })
}
