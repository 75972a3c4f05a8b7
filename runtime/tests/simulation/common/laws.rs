//! Scenes whose contacts bounce and rub.

use super::scene::{HandWritten, Number, Scene};
use super::scenes::GRAVITY;

fn diagonal<D: Number, const N: usize>(entries: [f64; N]) -> [[D; N]; N] {
    std::array::from_fn(|row| {
        std::array::from_fn(|column| D::from(if row == column { entries[row] } else { 0.0 }))
    })
}

/// A point mass on the side of `scale ((z - height(y)) cos slope + y sin slope) = 0` where gravity does not
/// pull it: a plane that falls by `slope` for growing `y`, or waves.
#[derive(Debug, Clone)]
pub struct Ground {
    pub mass: f64,
    /// Angle by which the ground falls [rad].
    pub slope: f64,
    /// Height of the plane at `y = 0`.
    pub offset: f64,
    /// Height and wave number of a cosine on the plane.
    pub waves: (f64, f64),
    /// Length of the gradient of the gap, on a plane.
    pub scale: f64,
    pub restitution: f64,
    pub friction: f64,
}

impl Default for Ground {
    fn default() -> Self {
        Self {
            mass: 1.0,
            slope: 0.0,
            offset: 0.0,
            waves: (0.0, 1.0),
            scale: 1.0,
            restitution: 0.0,
            friction: 0.0,
        }
    }
}

impl Ground {
    pub fn model(self) -> HandWritten<Self, 2, 1> {
        HandWritten::new(self)
    }
}

impl Scene<2, 1> for Ground {
    fn coordinates(&self) -> [&'static str; 2] {
        ["y", "z"]
    }

    fn contacts(&self) -> &'static [&'static str] {
        &["ground"]
    }

    fn mass<D: Number>(&self, _q: &[D; 2]) -> [[D; 2]; 2] {
        diagonal([self.mass; 2])
    }

    /// The control pushes along `y`.
    fn force<D: Number>(&self, _q: &[D; 2], _v: &[D; 2], u: &[D; 1]) -> [D; 2] {
        [u[0], D::from(-self.mass * GRAVITY)]
    }

    fn potential(&self, q: &[f64; 2]) -> f64 {
        self.mass * GRAVITY * q[1]
    }

    fn gap<D: Number>(&self, _contact: usize, q: &[D; 2]) -> D {
        let (sin, cos) = self.slope.sin_cos();
        let height = (q[0] * self.waves.1).cos() * self.waves.0 + self.offset;
        ((q[1] - height) * cos + q[0] * sin) * self.scale
    }

    fn restitution(&self, _contact: usize) -> f64 {
        self.restitution
    }

    fn friction(&self, _contact: usize) -> f64 {
        self.friction
    }

    /// Along the ground; where there are waves, along the plane below them.
    fn sliding<D: Number>(&self, _contact: usize, _q: &[D; 2], v: &[D; 2]) -> Option<D> {
        let (sin, cos) = self.slope.sin_cos();
        Some((v[0] * cos - v[1] * sin) * self.scale)
    }
}

/// A point mass in a square room of unit side.
#[derive(Debug, Clone)]
pub struct Room {
    pub gravity: f64,
    pub restitution: f64,
    pub friction: f64,
}

impl Room {
    pub fn model(self) -> HandWritten<Self, 2, 0> {
        HandWritten::new(self)
    }
}

impl Scene<2, 0> for Room {
    fn coordinates(&self) -> [&'static str; 2] {
        ["y", "z"]
    }

    fn contacts(&self) -> &'static [&'static str] {
        &["floor", "left", "right", "ceiling"]
    }

    fn mass<D: Number>(&self, _q: &[D; 2]) -> [[D; 2]; 2] {
        diagonal([2.0; 2])
    }

    fn force<D: Number>(&self, _q: &[D; 2], _v: &[D; 2], _u: &[D; 0]) -> [D; 2] {
        [D::from(0.0), D::from(-2.0 * self.gravity)]
    }

    fn potential(&self, q: &[f64; 2]) -> f64 {
        2.0 * self.gravity * q[1]
    }

    fn gap<D: Number>(&self, contact: usize, q: &[D; 2]) -> D {
        match contact {
            0 => q[1],
            1 => q[0],
            2 => -q[0] + 1.0,
            _ => -q[1] + 1.0,
        }
    }

    fn restitution(&self, _contact: usize) -> f64 {
        self.restitution
    }

    fn friction(&self, _contact: usize) -> f64 {
        self.friction
    }

    fn sliding<D: Number>(&self, contact: usize, _q: &[D; 2], v: &[D; 2]) -> Option<D> {
        Some(if contact == 0 || contact == 3 {
            v[0]
        } else {
            v[1]
        })
    }
}

/// A round body `(y, z, angle)` of unit mass on ground that falls by `slope`; the angle grows such that the
/// lowest point moves with `v_y + radius angle'`.
#[derive(Debug, Clone)]
pub struct Disc {
    pub radius: f64,
    /// Moment of inertia over mass and radius squared.
    pub shape: f64,
    pub slope: f64,
    pub restitution: f64,
    pub friction: f64,
}

impl Disc {
    pub fn model(self) -> HandWritten<Self, 3, 0> {
        HandWritten::new(self)
    }
}

impl Scene<3, 0> for Disc {
    fn coordinates(&self) -> [&'static str; 3] {
        ["y", "z", "angle"]
    }

    fn contacts(&self) -> &'static [&'static str] {
        &["ground"]
    }

    fn mass<D: Number>(&self, _q: &[D; 3]) -> [[D; 3]; 3] {
        diagonal([1.0, 1.0, self.shape * self.radius * self.radius])
    }

    fn force<D: Number>(&self, _q: &[D; 3], _v: &[D; 3], _u: &[D; 0]) -> [D; 3] {
        [D::from(0.0), D::from(-GRAVITY), D::from(0.0)]
    }

    fn potential(&self, q: &[f64; 3]) -> f64 {
        GRAVITY * q[1]
    }

    fn gap<D: Number>(&self, _contact: usize, q: &[D; 3]) -> D {
        let (sin, cos) = self.slope.sin_cos();
        q[1] * cos + q[0] * sin - self.radius
    }

    fn restitution(&self, _contact: usize) -> f64 {
        self.restitution
    }

    fn friction(&self, _contact: usize) -> f64 {
        self.friction
    }

    fn sliding<D: Number>(&self, _contact: usize, _q: &[D; 3], v: &[D; 3]) -> Option<D> {
        let (sin, cos) = self.slope.sin_cos();
        Some(v[0] * cos - v[1] * sin + v[2] * self.radius)
    }
}

/// A slender rod `(y, z, angle)` of unit mass and length 2 whose lower tip is at
/// `(y - cos angle, z - sin angle)`: `D_nn = 1 + 3 cos^2`, `D_nt = -3 sin cos`, `D_tt = 1 + 3 sin^2`.
#[derive(Debug, Clone)]
pub struct Rod {
    pub restitution: f64,
    pub friction: f64,
}

impl Rod {
    pub fn model(self) -> HandWritten<Self, 3, 0> {
        HandWritten::new(self)
    }
}

impl Scene<3, 0> for Rod {
    fn coordinates(&self) -> [&'static str; 3] {
        ["y", "z", "angle"]
    }

    fn contacts(&self) -> &'static [&'static str] {
        &["tip"]
    }

    fn mass<D: Number>(&self, _q: &[D; 3]) -> [[D; 3]; 3] {
        diagonal([1.0, 1.0, 1.0 / 3.0])
    }

    fn force<D: Number>(&self, _q: &[D; 3], _v: &[D; 3], _u: &[D; 0]) -> [D; 3] {
        [D::from(0.0), D::from(-GRAVITY), D::from(0.0)]
    }

    fn potential(&self, q: &[f64; 3]) -> f64 {
        GRAVITY * q[1]
    }

    fn gap<D: Number>(&self, _contact: usize, q: &[D; 3]) -> D {
        q[1] - q[2].sin()
    }

    fn restitution(&self, _contact: usize) -> f64 {
        self.restitution
    }

    fn friction(&self, _contact: usize) -> f64 {
        self.friction
    }

    fn sliding<D: Number>(&self, _contact: usize, q: &[D; 3], v: &[D; 3]) -> Option<D> {
        Some(v[0] + q[2].sin() * v[2])
    }
}

/// A table `(y, z, angle)` of unit mass, its centre `height` above two feet at `y - 1` and `y + 1`, on a belt
/// that moves with the speed `belt`, held by a spring of stiffness `stiffness` at the centre's height.
#[derive(Debug, Clone)]
pub struct Table {
    pub height: f64,
    pub stiffness: f64,
    pub belt: f64,
    pub restitution: f64,
    pub friction: f64,
}

impl Table {
    pub fn model(self) -> HandWritten<Self, 3, 0> {
        HandWritten::new(self)
    }
}

impl Scene<3, 0> for Table {
    fn coordinates(&self) -> [&'static str; 3] {
        ["y", "z", "angle"]
    }

    fn contacts(&self) -> &'static [&'static str] {
        &["rear foot", "front foot"]
    }

    fn mass<D: Number>(&self, _q: &[D; 3]) -> [[D; 3]; 3] {
        diagonal([1.0, 1.0, 0.5])
    }

    fn force<D: Number>(&self, q: &[D; 3], _v: &[D; 3], _u: &[D; 0]) -> [D; 3] {
        [q[0] * -self.stiffness, D::from(-GRAVITY), D::from(0.0)]
    }

    fn potential(&self, q: &[f64; 3]) -> f64 {
        GRAVITY * q[1] + 0.5 * self.stiffness * q[0] * q[0]
    }

    fn gap<D: Number>(&self, contact: usize, q: &[D; 3]) -> D {
        let side = if contact == 0 { -1.0 } else { 1.0 };
        q[1] + q[2].sin() * side - q[2].cos() * self.height
    }

    fn restitution(&self, _contact: usize) -> f64 {
        self.restitution
    }

    fn friction(&self, _contact: usize) -> f64 {
        self.friction
    }

    /// Velocity of the foot at `(y + side cos + height sin, z + side sin - height cos)` along the belt.
    fn sliding<D: Number>(&self, contact: usize, q: &[D; 3], v: &[D; 3]) -> Option<D> {
        let side = if contact == 0 { -1.0 } else { 1.0 };
        let (sin, cos) = q[2].sin_cos();
        Some(v[0] + (-sin * side + cos * self.height) * v[2] - self.belt)
    }
}

/// A mass `m = 1` on a belt that moves with the speed `belt`, held by a spring.
#[derive(Debug, Clone)]
pub struct Belt {
    pub stiffness: f64,
    pub belt: f64,
    pub friction: f64,
}

impl Belt {
    pub fn model(self) -> HandWritten<Self, 2, 0> {
        HandWritten::new(self)
    }
}

impl Scene<2, 0> for Belt {
    fn coordinates(&self) -> [&'static str; 2] {
        ["y", "z"]
    }

    fn contacts(&self) -> &'static [&'static str] {
        &["belt"]
    }

    fn mass<D: Number>(&self, _q: &[D; 2]) -> [[D; 2]; 2] {
        diagonal([1.0; 2])
    }

    fn force<D: Number>(&self, q: &[D; 2], _v: &[D; 2], _u: &[D; 0]) -> [D; 2] {
        [q[0] * -self.stiffness, D::from(-GRAVITY)]
    }

    fn potential(&self, q: &[f64; 2]) -> f64 {
        GRAVITY * q[1] + 0.5 * self.stiffness * q[0] * q[0]
    }

    fn gap<D: Number>(&self, _contact: usize, q: &[D; 2]) -> D {
        q[1]
    }

    fn friction(&self, _contact: usize) -> f64 {
        self.friction
    }

    fn sliding<D: Number>(&self, _contact: usize, _q: &[D; 2], v: &[D; 2]) -> Option<D> {
        Some(v[0] - self.belt)
    }
}

/// A point mass of 1 kg in a round bowl of unit radius.
#[derive(Debug, Clone)]
pub struct Bowl {
    pub friction: f64,
}

impl Bowl {
    pub fn model(self) -> HandWritten<Self, 2, 0> {
        HandWritten::new(self)
    }
}

impl Scene<2, 0> for Bowl {
    fn coordinates(&self) -> [&'static str; 2] {
        ["y", "z"]
    }

    fn contacts(&self) -> &'static [&'static str] {
        &["bowl"]
    }

    fn mass<D: Number>(&self, _q: &[D; 2]) -> [[D; 2]; 2] {
        diagonal([1.0; 2])
    }

    fn force<D: Number>(&self, _q: &[D; 2], _v: &[D; 2], _u: &[D; 0]) -> [D; 2] {
        [D::from(0.0), D::from(-GRAVITY)]
    }

    fn potential(&self, q: &[f64; 2]) -> f64 {
        GRAVITY * q[1]
    }

    fn gap<D: Number>(&self, _contact: usize, q: &[D; 2]) -> D {
        -(q[0] * q[0] + q[1] * q[1]).sqrt() + 1.0
    }

    fn friction(&self, _contact: usize) -> f64 {
        self.friction
    }

    fn sliding<D: Number>(&self, _contact: usize, q: &[D; 2], v: &[D; 2]) -> Option<D> {
        Some((q[0] * v[1] - q[1] * v[0]) / (q[0] * q[0] + q[1] * q[1]).sqrt())
    }
}

/// A carriage `y` of unit mass, pressed onto its rail by its weight, that drags a brake by a crank: the brake's
/// velocity is `y' cos y`, zero at the dead points of the crank.
#[derive(Debug, Clone)]
pub struct CrankBrake {
    pub friction: f64,
}

impl CrankBrake {
    pub fn model(self) -> HandWritten<Self, 2, 0> {
        HandWritten::new(self)
    }
}

impl Scene<2, 0> for CrankBrake {
    fn coordinates(&self) -> [&'static str; 2] {
        ["y", "z"]
    }

    fn contacts(&self) -> &'static [&'static str] {
        &["brake"]
    }

    fn mass<D: Number>(&self, _q: &[D; 2]) -> [[D; 2]; 2] {
        diagonal([1.0; 2])
    }

    fn force<D: Number>(&self, _q: &[D; 2], _v: &[D; 2], _u: &[D; 0]) -> [D; 2] {
        [D::from(0.0), D::from(-GRAVITY)]
    }

    fn potential(&self, q: &[f64; 2]) -> f64 {
        GRAVITY * q[1]
    }

    fn gap<D: Number>(&self, _contact: usize, q: &[D; 2]) -> D {
        q[1]
    }

    fn friction(&self, _contact: usize) -> f64 {
        self.friction
    }

    fn sliding<D: Number>(&self, _contact: usize, q: &[D; 2], v: &[D; 2]) -> Option<D> {
        Some(q[0].cos() * v[0])
    }
}
