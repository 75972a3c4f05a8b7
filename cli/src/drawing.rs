//! How a scene is drawn: as it declares, or as one body where its coordinates are a place.

use hangtime::model::{ContactDeclaration, Model, Picture, Shape};
use serde::Serialize;

use crate::contour::zero_lines;
use crate::sampling::State;
use crate::table::headed;

/// Free space around what is shown, as a share of its larger extent.
const MARGIN: f64 = 0.08;
/// Points of a curve.
const POINTS: usize = 200;
/// Corners of the outline of a disc.
const ROUND: usize = 48;

/// What is drawn of a model with its parameters.
pub(crate) struct Drawing<'a> {
    model: &'a dyn Model,
    shapes: Vec<Shape>,
    /// Whether the model declares a picture.
    declared: bool,
    ground: Option<[usize; 2]>,
    /// Unit of all lengths.
    pub(crate) unit: &'static str,
    /// Labels of the axes, with the unit.
    pub(crate) axes: [String; 2],
    /// The bodies.
    pub(crate) bodies: Vec<Body>,
    /// Whether each line is a spring; the others are links.
    pub(crate) springs: Vec<bool>,
}

/// A body that is drawn.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Body {
    /// Its name.
    pub(crate) name: &'static str,
    /// Its corners where place and angle are zero; none for a point.
    pub(crate) outline: Vec<[f64; 2]>,
    /// Whether it looks the same from all sides.
    pub(crate) round: bool,
}

/// Where everything is at one instant.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct Placed {
    /// Place of each body.
    pub(crate) places: Vec<[f64; 2]>,
    /// Angle of each body, counterclockwise.
    pub(crate) angles: Vec<f64>,
    /// Both ends of each line.
    pub(crate) ends: Vec<[[f64; 2]; 2]>,
}

/// A line of ground.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(crate) struct GroundLine {
    /// Name of the curve or of the surface.
    pub(crate) name: &'static str,
    /// Its points, as (horizontal, vertical).
    pub(crate) points: Vec<[f64; 2]>,
}

impl Body {
    /// How far its outline is from its place at most; 0 for a point.
    pub(crate) fn reach(&self) -> f64 {
        let corners = self.outline.iter().map(|[a, b]| a.hypot(*b));
        corners.fold(0.0, f64::max)
    }
}

impl Placed {
    /// A point of body `index` that is at `point` where place and angle are zero.
    pub(crate) fn point(&self, index: usize, [a, b]: [f64; 2]) -> [f64; 2] {
        let (sine, cosine) = self.angles[index].sin_cos();
        let [y, z] = self.places[index];
        [y + a * cosine - b * sine, z + a * sine + b * cosine]
    }

    /// The outline of body `index`.
    pub(crate) fn outline(&self, index: usize, body: &Body) -> Vec<[f64; 2]> {
        let corners = body.outline.iter();
        corners.map(|&corner| self.point(index, corner)).collect()
    }

    /// Everything that has to be in sight.
    pub(crate) fn extent(&self, bodies: &[Body]) -> Vec<[f64; 2]> {
        let mut points = self.places.clone();
        for (index, body) in bodies.iter().enumerate() {
            points.extend(self.outline(index, body));
        }
        points.extend(self.ends.iter().flatten());
        points
    }
}

impl<'a> Drawing<'a> {
    /// How a model is drawn, if it is. One without a picture is one body called `name`, if its first two coordinates
    /// are called like a horizontal position and a height and have the same unit.
    pub(crate) fn of(model: &'a dyn Model, name: &'static str) -> Option<Self> {
        let declared = model.picture();
        let picture = declared.or_else(|| one_body(model))?;
        let shapes = match declared {
            Some(picture) => picture.shapes.to_vec(),
            None => vec![Shape::Point(name)],
        };
        let axes = <[&str; 2]>::from(picture.axes).map(|axis| match picture.unit {
            "" => headed(axis, "1"),
            unit => headed(axis, unit),
        });
        let springs = shapes.iter().filter_map(|shape| match shape {
            Shape::Link => Some(false),
            Shape::Spring => Some(true),
            _ => None,
        });
        let mut drawing = Self {
            model,
            springs: springs.collect(),
            shapes,
            declared: declared.is_some(),
            ground: picture.ground.map(<[usize; 2]>::from),
            unit: picture.unit,
            axes,
            bodies: Vec::new(),
        };
        drawing.bodies = drawing.outlines();
        Some(drawing)
    }

    /// Values of every shape, one after the other.
    fn values(&self, x: &[f64], along: f64) -> Vec<f64> {
        let count = self.shapes.iter().map(Shape::values).sum();
        let mut values = vec![0.0; count];
        if self.declared {
            self.model.picture_values(x, along, &mut values);
        } else {
            values[..2].copy_from_slice(&x[..2]);
        }
        values
    }

    /// Each shape with its values.
    fn split<'v>(&self, values: &'v [f64]) -> impl Iterator<Item = (Shape, &'v [f64])> {
        let mut rest = values;
        self.shapes.iter().map(move |shape| {
            let (own, behind) = rest.split_at(shape.values());
            rest = behind;
            (*shape, own)
        })
    }

    /// An input at which only parameters count.
    fn nowhere(&self) -> Vec<f64> {
        let declaration = self.model.declaration();
        vec![0.0; 2 * declaration.coordinates.len() + declaration.controls.len() + 1]
    }

    fn outlines(&self) -> Vec<Body> {
        let values = self.values(&self.nowhere(), 0.0);
        let mut bodies = Vec::new();
        for (shape, own) in self.split(&values) {
            let (name, round, outline) = match shape {
                Shape::Point(name) => (name, true, Vec::new()),
                Shape::Circle(name) => (name, true, disc(own[3])),
                Shape::Rectangle(name) => {
                    let [a, b] = [own[3] / 2.0, own[4] / 2.0];
                    (name, false, vec![[-a, -b], [a, -b], [a, b], [-a, b]])
                }
                Shape::Polygon(name, _) => (name, false, pairs(&own[3..])),
                Shape::Link | Shape::Spring | Shape::Curve(_) | Shape::Arc(_) => continue,
            };
            bodies.push(Body {
                name,
                outline,
                round,
            });
        }
        bodies
    }

    /// Where everything is in a state.
    pub(crate) fn at(&self, state: &State) -> Placed {
        self.placed(&state.q, &state.v, &state.u, state.time)
    }

    /// Where everything is at coordinates, velocities, controls (zero, if none are given) and a time.
    pub(crate) fn placed(&self, q: &[f64], v: &[f64], u: &[f64], time: f64) -> Placed {
        let mut x = self.nowhere();
        let given = [q, v, u].into_iter().flatten();
        for (input, value) in x.iter_mut().zip(given) {
            *input = *value;
        }
        if let Some(last) = x.last_mut() {
            *last = time;
        }
        let values = self.values(&x, 0.0);
        let mut placed = Placed::default();
        for (shape, own) in self.split(&values) {
            match shape {
                Shape::Point(_) | Shape::Circle(_) | Shape::Rectangle(_) | Shape::Polygon(..) => {
                    placed.places.push([own[0], own[1]]);
                    placed.angles.push(own[2]);
                }
                Shape::Link | Shape::Spring => {
                    placed.ends.push([[own[0], own[1]], [own[2], own[3]]]);
                }
                Shape::Curve(_) | Shape::Arc(_) => {}
            }
        }
        placed
    }

    /// The ground that is in sight: declared curves, and surfaces that are places of the body.
    pub(crate) fn ground(&self, [across, up]: [[f64; 2]; 2]) -> Vec<GroundLine> {
        let mut lines = Vec::new();
        let nowhere = self.nowhere();
        let values = self.values(&nowhere, 0.0);
        let mut first = 0;
        for (shape, own) in self.split(&values) {
            let (name, [from, to], place) = match shape {
                Shape::Curve(name) => (name, across, first),
                Shape::Arc(name) => (name, [own[0], own[1]], first + 2),
                _ => {
                    first += shape.values();
                    continue;
                }
            };
            first += shape.values();
            let points = (0..=POINTS).map(|i| {
                let along = from + (to - from) * (i as f64 / POINTS as f64);
                let values = self.values(&nowhere, along);
                [values[place], values[place + 1]]
            });
            lines.extend(pieces(name, points));
        }
        if let Some(axes) = self.ground {
            lines.extend(self.surfaces(axes, [across, up]));
        }
        lines
    }

    /// Where the gaps vanish that depend on these two coordinates only.
    fn surfaces(&self, axes: [usize; 2], [across, up]: [[f64; 2]; 2]) -> Vec<GroundLine> {
        let declaration = self.model.declaration();
        let contacts = declaration.contacts;
        let seen = |contact: &ContactDeclaration| {
            let mut gap = contact.jacobian.entries.iter().filter(|entry| entry.0 == 0);
            !contact.dry && gap.all(|entry| axes.contains(&(entry.1 as usize)))
        };
        // The pieces of a surface are contacts of their own; what is seen is where all of them let pass.
        let surface = |contact: &ContactDeclaration| contact.name.split('.').next();
        let mut lines = Vec::new();
        for (first, contact) in contacts.iter().enumerate() {
            let name = surface(contact).unwrap_or(contact.name);
            let of_it = (first..contacts.len()).filter(|&i| surface(&contacts[i]) == Some(name));
            let pieces: Vec<usize> = of_it.collect();
            let known = contacts[..first]
                .iter()
                .any(|other| surface(other) == Some(name));
            if known || !pieces.iter().all(|&i| seen(&contacts[i])) {
                continue;
            }
            let gap = |place: [f64; 2]| {
                let mut x = vec![0.0; declaration.inputs()];
                for (axis, value) in axes.into_iter().zip(place) {
                    x[axis] = value;
                }
                let largest = |&i: &usize| {
                    let others = contacts[i].alternatives.iter();
                    let gaps = others.map(|&other| self.model.gap(other, &x));
                    gaps.fold(self.model.gap(i, &x), f64::max)
                };
                pieces.iter().map(largest).fold(f64::INFINITY, f64::min)
            };
            let found = zero_lines(across, up, gap).into_iter();
            lines.extend(found.map(|points| GroundLine { name, points }));
        }
        lines
    }
}

/// A scene of one body whose first two coordinates are its place.
fn one_body(model: &dyn Model) -> Option<Picture> {
    let [across, up, ..] = model.declaration().coordinates else {
        return None;
    };
    let drawn = matches!((across.name, up.name), ("x", "y" | "z") | ("y", "z"));
    (drawn && across.unit == up.unit).then_some(Picture {
        unit: across.unit,
        axes: (across.name, up.name),
        ground: Some((0, 1)),
        shapes: &[],
    })
}

/// The smallest and the largest value on each axis.
pub(crate) fn ranges(points: &[[f64; 2]]) -> [[f64; 2]; 2] {
    [0, 1].map(|axis| {
        let values = points.iter().map(|point| point[axis]);
        values.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], x| {
            [low.min(x), high.max(x)]
        })
    })
}

/// What is seen, from left to right and from bottom to top: all these points, and a margin around them.
pub(crate) fn frame<'p>(points: impl Iterator<Item = &'p [f64; 2]>) -> [[f64; 2]; 2] {
    let finite = points.filter(|point| point.iter().all(|x| x.is_finite()));
    let ranges = ranges(&finite.copied().collect::<Vec<_>>());
    let extents = ranges.iter().map(|[low, high]| high - low);
    let extent = extents.fold(0.0, f64::max);
    // Nothing moved, or nothing is known: a frame that can be drawn all the same.
    let margin = match extent.is_finite() && extent > 0.0 {
        true => MARGIN * extent,
        false => 1.0,
    };
    ranges.map(|[low, high]| match low <= high {
        true => [low - margin, high + margin],
        false => [-margin, margin],
    })
}

fn disc(radius: f64) -> Vec<[f64; 2]> {
    let corner = |i: usize| {
        let (sine, cosine) = (std::f64::consts::TAU * i as f64 / ROUND as f64).sin_cos();
        [radius * cosine, radius * sine]
    };
    (0..ROUND).map(corner).collect()
}

fn pairs(values: &[f64]) -> Vec<[f64; 2]> {
    values
        .chunks_exact(2)
        .map(|pair| [pair[0], pair[1]])
        .collect()
}

/// The parts of a line that are numbers.
fn pieces(name: &'static str, points: impl Iterator<Item = [f64; 2]>) -> Vec<GroundLine> {
    let points: Vec<[f64; 2]> = points.collect();
    let parts = points.split(|[a, b]| !(a.is_finite() && b.is_finite()));
    let lines = parts.filter(|part| part.len() > 1).map(|part| GroundLine {
        name,
        points: part.to_vec(),
    });
    lines.collect()
}

/// Points of a spring between two ends, with coils as wide as `width`.
pub(crate) fn zigzag([from, to]: [[f64; 2]; 2], width: f64) -> Vec<[f64; 2]> {
    /// Where coils turn, on one side and then on the other.
    const TURNS: usize = 12;
    let [a, b] = [to[0] - from[0], to[1] - from[1]];
    let length = a.hypot(b);
    if !(length.is_finite() && length > 0.0) {
        return vec![from, to];
    }
    let across = [-b / length * width, a / length * width];
    let mut points = vec![from];
    points.extend((0..TURNS).map(|turn| {
        let share = (turn as f64 + 1.5) / (TURNS as f64 + 2.0);
        let side = if turn % 2 == 0 { 0.5 } else { -0.5 };
        [
            from[0] + share * a + side * across[0],
            from[1] + share * b + side * across[1],
        ]
    }));
    points.push(to);
    points
}

#[cfg(test)]
mod tests {
    use hangtime_scene_files::of_text;

    use super::{Body, Drawing, GroundLine, Placed, zigzag};

    const BALL: &str = "parameters { r: m = 2 } coordinates { x: m, z: m } lagrangian 1[kg]/2*|dot((x, z))|^2 \
        surface floor: z >= x/2 impact floor: inelastic surface wall: x <= 3[m] impact wall: inelastic \
        surface disc: x^2 + z^2 >= r^2 impact disc: inelastic start { x: 2, z: 3 }";

    fn close(a: [f64; 2], b: [f64; 2]) -> bool {
        (a[0] - b[0]).hypot(a[1] - b[1]) < 1e-9
    }

    #[test]
    fn scene_of_one_body_is_drawn_without_a_picture() {
        let ball = of_text("ball.hang", BALL).unwrap();
        let drawing = Drawing::of(&ball, "ball").unwrap();
        assert_eq!(
            (drawing.axes.join(" "), drawing.unit),
            ("x [m] z [m]".to_owned(), "m")
        );
        assert_eq!(
            drawing.placed(&[0.5, 0.7], &[], &[], 0.0).places,
            [[0.5, 0.7]]
        );
        let lines = drawing.ground([[-4.0, 4.0], [-4.0, 4.0]]);
        let named = |name: &str| -> Vec<&GroundLine> {
            lines.iter().filter(|line| line.name == name).collect()
        };
        let [floor, wall, disc] = [named("floor"), named("wall"), named("disc")];
        assert_eq!([floor.len(), wall.len(), disc.len()], [1; 3]);
        assert!(
            floor[0]
                .points
                .iter()
                .all(|[x, z]| (z - x / 2.0).abs() < 1e-9)
        );
        assert!(wall[0].points.iter().all(|[x, _]| (x - 3.0).abs() < 1e-9));
        assert!(
            disc[0]
                .points
                .iter()
                .all(|[x, z]| (x.hypot(*z) - 2.0).abs() < 1e-9)
        );
        let carts = BALL
            .replace("x", "a")
            .replace("z", "b")
            .replace("mab", "max");
        let two = of_text("carts.hang", &carts).unwrap();
        assert!(Drawing::of(&two, "carts").is_none());
    }

    #[test]
    fn surfaces_that_are_no_places_of_a_point_are_not_drawn() {
        // In turn: the surface needs an angle, the time; the body is larger than a point; the ground is drawn.
        for (surface, picture) in [
            ("z >= 0.1[m]*cos(a)", "point ball at (y, z)"),
            ("z >= 0.1[m]*sin(t*1[1/s])", "point ball at (y, z)"),
            ("z >= 0.1[m]", "circle ball at (y, z) radius 0.1[m]"),
            ("z >= 0.1[m]", "point ball at (y + 1[m], z)"),
        ] {
            let text = format!(
                "coordinates {{ y: m, z: m, a: rad }} \
                 lagrangian 1[kg]/2*|dot((y, z))|^2 + 1[kg m^2]/2*dot(a)^2 \
                 surface floor: {surface} impact floor: inelastic start {{ z: 1 }} picture {{ {picture} }}"
            );
            let scene = of_text("scene.hang", &text).unwrap();
            let drawing = Drawing::of(&scene, "scene").unwrap();
            assert_eq!(
                drawing.ground([[-2.0, 2.0], [-2.0, 2.0]]),
                [],
                "{surface} {picture}"
            );
            let drawn = text.replace(
                "picture {",
                "picture { curve floor: (w, 0) over w in 0[m]..=1[m],",
            );
            let scene = of_text("scene.hang", &drawn).unwrap();
            let lines = Drawing::of(&scene, "scene").unwrap();
            let lines = lines.ground([[-2.0, 2.0], [-2.0, 2.0]]);
            assert_eq!(lines.len(), 1);
            assert_eq!(
                (lines[0].points[0], lines[0].points[200]),
                ([0.0, 0.0], [1.0, 0.0])
            );
        }
    }

    #[test]
    fn bodies_are_placed_by_point_and_angle_in_the_unit_of_the_coordinates() {
        let text = "parameters { l: mm = 40 } coordinates { y: cm, z: cm, a: deg } \
            lagrangian 1[kg]/2*|dot((y, z))|^2 + 1[kg m^2]/2*dot(a)^2 \
            picture { \
                rectangle plank at (y, z) size (l, 20[mm]) angle a, \
                circle wheel at (y + l, z) radius l/2 angle 2*a, \
                polygon tip at (0, 0) corners ((0, 0), (l, 0), (0, l)), \
                link plank to wheel, spring (0, 0) to (0, 1[cm]), \
                curve track: (w, 2*w) over w, \
                curve arc: (l*cos(s), l*sin(s)) over s in 0..=pi/2 \
            }";
        let scene = of_text("scene.hang", text).unwrap();
        let drawing = Drawing::of(&scene, "scene").unwrap();
        assert_eq!(
            (drawing.axes.join(" "), drawing.unit),
            ("y [cm] z [cm]".to_owned(), "cm")
        );
        assert_eq!(drawing.springs, [false, true]);
        let Body {
            name,
            outline,
            round,
        } = &drawing.bodies[0];
        assert_eq!((*name, *round), ("plank", false));
        let corners = [[-2.0, -1.0], [2.0, -1.0], [2.0, 1.0], [-2.0, 1.0]];
        assert!(outline.iter().zip(corners).all(|(a, b)| close(*a, b)));
        assert!((drawing.bodies[1].reach() - 2.0).abs() < 1e-12);
        assert!((drawing.bodies[2].reach() - 4.0).abs() < 1e-12);
        let placed = drawing.placed(&[10.0, 5.0, 90.0], &[], &[], 0.0);
        assert!(close(placed.places[1], [14.0, 5.0]));
        assert!(close(placed.point(0, [2.0, 1.0]), [9.0, 7.0]));
        assert!((placed.angles[1] - std::f64::consts::PI).abs() < 1e-12);
        assert!(close(placed.ends[0][0], [10.0, 5.0]) && close(placed.ends[0][1], [14.0, 5.0]));
        assert!(close(placed.ends[1][1], [0.0, 1.0]));
        let lines = drawing.ground([[-3.0, 3.0], [-1.0, 1.0]]);
        assert!(close(lines[0].points[0], [-3.0, -6.0]) && close(lines[0].points[200], [3.0, 6.0]));
        assert!(close(lines[1].points[0], [4.0, 0.0]) && close(lines[1].points[200], [0.0, 4.0]));
    }

    #[test]
    fn spring_begins_and_ends_where_it_is_fixed_and_winds_around_the_line_between() {
        let ends = [[1.0, 1.0], [4.0, 5.0]];
        let points = zigzag(ends, 0.2);
        assert_eq!((points[0], *points.last().unwrap()), (ends[0], ends[1]));
        // Distances from the line through both ends, whose direction is (3, 4)/5.
        let beside = points
            .iter()
            .map(|[a, b]| (4.0 * (a - 1.0) - 3.0 * (b - 1.0)) / 5.0);
        let turns: Vec<f64> = beside.skip(1).take(points.len() - 2).collect();
        assert!(
            turns.iter().all(|x| (x.abs() - 0.1).abs() < 1e-12),
            "{turns:?}"
        );
        assert!(turns.windows(2).all(|pair| pair[0] * pair[1] < 0.0));
        assert_eq!(zigzag([ends[0]; 2], 0.2), [ends[0]; 2]);
        assert_eq!(Placed::default().extent(&[]), [[0.0; 2]; 0]);
    }
}
