//! How a motion is drawn.

/// What is drawn of a motion in a plane.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Picture {
    /// Unit of all lengths, as written; empty in a scene without units.
    pub unit: &'static str,
    /// Names of the axes, the horizontal one first.
    pub axes: (&'static str, &'static str),
    /// Indices of the coordinates that are the place of a point, if surfaces that depend on nothing else are to be
    /// drawn as places of that point.
    pub ground: Option<(usize, usize)>,
    /// The shapes in order of declaration.
    pub shapes: &'static [Shape],
}

impl Picture {
    /// Length of what `Model::picture_values` writes.
    #[must_use]
    pub fn values(&self) -> usize {
        self.shapes.iter().map(Shape::values).sum()
    }
}

/// One shape of a [`Picture`], with the values that `Model::picture_values` gives of
/// it. Lengths are in the unit of the picture, angles in radians, counterclockwise.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Shape {
    /// A body without extent, by its name: place `(a, b)` and angle.
    Point(&'static str),
    /// A disc: place, angle and radius.
    Circle(&'static str),
    /// A rectangle around its place: place, angle, width and height.
    Rectangle(&'static str),
    /// A polygon: place, angle, and as many corners as given here, where place and angle are zero.
    Polygon(&'static str, usize),
    /// A link: the places of both ends.
    Link,
    /// A spring: the places of both ends.
    Spring,
    /// A curve over all that is shown: the place at a number along it, the horizontal position as the axis shows it.
    Curve(&'static str),
    /// A curve over a range: first and last number along it, and the place at a number between them.
    Arc(&'static str),
}

impl Shape {
    /// Number of its values.
    #[must_use]
    pub const fn values(&self) -> usize {
        match self {
            Self::Point(_) => 3,
            Self::Circle(_) | Self::Link | Self::Spring | Self::Arc(_) => 4,
            Self::Rectangle(_) => 5,
            Self::Polygon(_, corners) => 3 + 2 * *corners,
            Self::Curve(_) => 2,
        }
    }
}
