//! Shapes that several scenes share: grounds under a point, bodies on a floor.

use super::scene::{HandWritten, Number, Scene};
use super::scenes::GRAVITY;

/// Ground under a point mass in the plane `(y, z)`.
#[derive(Debug, Clone, Copy)]
pub enum Ground {
    /// Straight through `(0, height)`, falling with `y` at an angle; the gap is `scale` times the distance.
    Plane { angle: f64, height: f64, scale: f64 },
    /// `z = curvature y^2 / 2`.
    Bowl { curvature: f64 },
    /// `z = height cos(number y)`.
    Waves { height: f64, number: f64 },
}

impl Ground {
    pub fn gap<D: Number>(&self, q: &[D; 2]) -> D {
        match *self {
            Self::Plane {
                angle,
                height,
                scale,
            } => (q[0] * angle.sin() + (q[1] - height) * angle.cos()) * scale,
            Self::Bowl { curvature } => q[1] - q[0] * q[0] * (0.5 * curvature),
            Self::Waves { height, number } => q[1] - (q[0] * number).cos() * height,
        }
    }

    /// Height of the surface above `y`.
    pub fn height(&self, y: f64) -> f64 {
        match *self {
            Self::Plane { angle, height, .. } => height - y * angle.tan(),
            Self::Bowl { curvature } => 0.5 * curvature * y * y,
            Self::Waves { height, number } => height * f64::cos(number * y),
        }
    }

    /// Tangent with the length of the gap's gradient, so that both are measured alike.
    pub fn tangent<D: Number>(&self, q: &[D; 2]) -> [D; 2] {
        match *self {
            Self::Plane { angle, scale, .. } => {
                [D::from(angle.cos() * scale), D::from(-angle.sin() * scale)]
            }
            Self::Bowl { curvature } => [D::from(1.0), q[0] * curvature],
            Self::Waves { height, number } => {
                [D::from(1.0), (q[0] * number).sin() * (-height * number)]
            }
        }
    }
}

pub const FLAT: Ground = Ground::Plane {
    angle: 0.0,
    height: 0.0,
    scale: 1.0,
};

/// A rigid body `(y, z, phi)` that touches the floor with points of its own: two tips of a bar, or the rim of
/// a disc.
#[derive(Debug, Clone)]
pub struct Body {
    /// Radius of gyration over unit mass.
    pub gyration: f64,
    /// Points fixed to the body, or the lowest point of the rim.
    pub shape: Shape,
    pub friction: f64,
    pub restitution: f64,
}

#[derive(Debug, Clone, Copy)]
pub enum Shape {
    Tips { front: f64, rear: f64 },
    Rod { half_length: f64 },
    Disc { radius: f64 },
}

impl Body {
    pub fn model(self) -> HandWritten<Self, 3, 0> {
        HandWritten::new(self)
    }

    fn arm(&self, contact: usize) -> f64 {
        match self.shape {
            Shape::Tips { front, rear } => [front, -rear][contact],
            Shape::Rod { half_length } => half_length,
            Shape::Disc { .. } => 0.0,
        }
    }
}

impl Scene<3, 0> for Body {
    fn coordinates(&self) -> [&'static str; 3] {
        ["y", "z", "phi"]
    }
    fn contacts(&self) -> &'static [&'static str] {
        match self.shape {
            Shape::Tips { .. } => &["front", "rear"],
            Shape::Rod { .. } => &["tip"],
            Shape::Disc { .. } => &["rim"],
        }
    }
    fn mass<D: Number>(&self, _q: &[D; 3]) -> [[D; 3]; 3] {
        let (one, o) = (D::from(1.0), D::from(0.0));
        let inertia = D::from(self.gyration * self.gyration);
        [[one, o, o], [o, one, o], [o, o, inertia]]
    }
    fn force<D: Number>(&self, _q: &[D; 3], _v: &[D; 3], _u: &[D; 0]) -> [D; 3] {
        [D::from(0.0), D::from(-GRAVITY), D::from(0.0)]
    }
    fn potential(&self, q: &[f64; 3]) -> f64 {
        GRAVITY * q[1]
    }
    fn gap<D: Number>(&self, contact: usize, q: &[D; 3]) -> D {
        match self.shape {
            Shape::Disc { radius } => q[1] - radius,
            _ => q[1] + q[2].sin() * self.arm(contact),
        }
    }
    fn restitution(&self, _contact: usize) -> f64 {
        self.restitution
    }
    fn friction(&self, _contact: usize) -> f64 {
        self.friction
    }
    fn sliding<D: Number>(&self, contact: usize, q: &[D; 3], v: &[D; 3]) -> Option<D> {
        let sliding = match self.shape {
            Shape::Disc { radius } => v[0] + v[2] * radius,
            _ => v[0] - q[2].sin() * v[2] * self.arm(contact),
        };
        (self.friction > 0.0).then_some(sliding)
    }
}
