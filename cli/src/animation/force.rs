//! Where in the plane a contact acts on what is drawn, and how.
//!
//! Bodies and lines of a picture are rigid parts. A contact whose gap is a length acts by a force `F` at the place `p` where two parts
//! touch, or where one touches the ground: `(dp/dq)' F = Q`, with `p` as a point of the one as seen from the other, and the
//! generalized force `Q = n lambda_n + b lambda_t` that the scene declares. Of the places that can carry `Q` the force is drawn at the
//! closest one, across the lines that touch there if that is enough. A contact whose gap is an angle acts by a torque `T` on a part that
//! turns, `(da/dq)' T = Q`.

use hangtime::model::{Model, contact_point, tangent_point};
use serde::Serialize;

use super::touch::{Outline, Touch};
use crate::drawing::{Drawing, GroundLine, Placed, ranges};
use crate::sampling::State;

/// Step of the central differences of a place, relative to the size of the coordinate.
const STEP: f64 = 1e-6;
/// A place carries a generalized force that it has within this share: far above roundings of the differences.
const CARRIED: f64 = 1e-4;
/// Parts that are apart by less than this share of the picture touch: less is not seen.
const TOUCHING: f64 = 0.01;
/// Where the motions of a place by all coordinates are along one line within this share, only that direction is known.
const ONE_DIRECTION: f64 = 1e-6;

/// What one contact does in the plane.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub(crate) struct Arrow {
    /// The part that it acts on: bodies, then lines.
    pub(super) on: usize,
    /// Where it acts.
    pub(super) at: [f64; 2],
    /// Horizontal and vertical component of a force; zero of a torque.
    pub(super) force: [f64; 2],
    /// Torque, counterclockwise; zero of a force.
    pub(super) torque: f64,
}

impl Arrow {
    pub(super) fn magnitude(&self) -> f64 {
        self.force[0].hypot(self.force[1])
    }
}

/// A place where a force may act: on a part, and against another one if there is one.
struct Place {
    on: usize,
    against: Option<usize>,
    touch: Touch,
}

/// The parts of a picture at a state, and right beside it.
struct Parts<'a> {
    drawing: &'a Drawing<'a>,
    placed: Placed,
    /// Steps of the coordinates, with everything a step behind and ahead.
    beside: Vec<(f64, [Placed; 2])>,
    outlines: Vec<Outline>,
    /// How far everything reaches.
    extent: f64,
}

/// What every contact does; `None` where it does nothing, or nothing that is drawn could feel it.
pub(super) fn arrows(
    drawing: &Drawing<'_>,
    ground: &[GroundLine],
    model: &dyn Model,
    state: &State,
) -> Vec<Option<Arrow>> {
    let loads: Vec<[Vec<f64>; 2]> = (0..state.contact_force.len())
        .map(|contact| generalized_force(model, contact, state))
        .collect();
    if loads.as_flattened().iter().flatten().all(|q| *q == 0.0) {
        return vec![None; loads.len()];
    }
    let parts = Parts::new(drawing, state);
    let places = parts.places(ground);
    let turns = |contact: usize| is_angle(model, contact);
    let loads = loads.iter().enumerate().map(|(contact, load)| {
        if load.iter().flatten().all(|q| *q == 0.0) {
            return None;
        }
        let torque = turns(contact).then(|| parts.torque(load)).flatten();
        let at_a_place = || {
            let mut places = places.iter();
            let found = places.find_map(|place| Some((place, parts.force(place, load)?)));
            found.map(|(place, force)| Arrow {
                on: place.on,
                at: place.touch.at,
                force,
                torque: 0.0,
            })
        };
        torque.or_else(at_a_place).or_else(|| parts.along(load))
    });
    let finite = |arrow: &Arrow| {
        let numbers = arrow.force.iter().chain(&arrow.at).chain([&arrow.torque]);
        numbers.copied().all(f64::is_finite)
    };
    loads.map(|arrow| arrow.filter(finite)).collect()
}

/// Whether the gap of a contact is an angle, in a scene with units.
fn is_angle(model: &dyn Model, contact: usize) -> bool {
    let declaration = model.declaration();
    let unit = declaration.contacts[contact].unit;
    let measured = declaration.coordinates.iter().any(|c| !c.unit.is_empty());
    measured && hangtime_units::convert(1.0, unit, "").is_ok()
}

impl<'a> Parts<'a> {
    fn new(drawing: &'a Drawing<'a>, state: &State) -> Self {
        let placed = drawing.at(state);
        let mut q = state.q.clone();
        let beside = (0..q.len()).map(|i| {
            let (at, step) = (q[i], STEP * q[i].abs().max(1.0));
            let both = [-step, step].map(|step| {
                q[i] = at + step;
                drawing.placed(&q, &state.v, &state.u, state.time)
            });
            q[i] = at;
            (step, both)
        });
        let beside = beside.collect();
        let bodies = drawing.bodies.iter().enumerate();
        let bodies = bodies.map(|(index, body)| {
            let corners = placed.outline(index, body);
            let round = body.round || corners.is_empty();
            Outline {
                corners: if round {
                    vec![placed.places[index]]
                } else {
                    corners
                },
                closed: true,
                radius: if round { body.reach() } else { 0.0 },
            }
        });
        let lines = placed.ends.iter().zip(&drawing.springs);
        let lines = lines.map(|(ends, spring)| Outline {
            corners: if *spring { Vec::new() } else { ends.to_vec() },
            closed: false,
            radius: 0.0,
        });
        let outlines = bodies.chain(lines).collect();
        let [[left, right], [bottom, top]] = ranges(&placed.extent(&drawing.bodies));
        Self {
            drawing,
            placed,
            beside,
            outlines,
            extent: (right - left).hypot(top - bottom),
        }
    }

    /// How large a part is.
    fn reach(&self, part: usize) -> f64 {
        match self.drawing.bodies.get(part) {
            Some(body) => body.reach(),
            None => {
                let [a, b] = self.placed.ends[part - self.drawing.bodies.len()];
                (a[0] - b[0]).hypot(a[1] - b[1]) / 2.0
            }
        }
    }

    /// Every place where a force may act, the likeliest first: where parts touch the ground and each other, then where nothing touches.
    fn places(&self, ground: &[GroundLine]) -> Vec<Place> {
        let ground = ground.iter().map(|line| Outline {
            corners: line.points.clone(),
            closed: false,
            radius: 0.0,
        });
        let ground: Vec<Outline> = ground.collect();
        let mut places = Vec::new();
        for (on, outline) in self.outlines.iter().enumerate() {
            let touches = ground.iter().flat_map(|line| outline.touches(line));
            let corners = outline.corners.iter().map(|&at| Touch {
                at,
                normal: [0.0; 2],
                distance: f64::INFINITY,
            });
            places.extend(touches.chain(corners).map(|touch| Place {
                on,
                against: None,
                touch,
            }));
            for (other, second) in self.outlines.iter().enumerate().skip(on + 1) {
                // The force is shown on the smaller one.
                let (on, against) = match self.reach(other) < self.reach(on) {
                    true => (other, on),
                    false => (on, other),
                };
                places.extend(outline.touches(second).into_iter().map(|touch| Place {
                    on,
                    against: Some(against),
                    touch,
                }));
            }
        }
        let rank = |place: &Place| {
            let apart = place.touch.distance > TOUCHING * self.extent;
            (apart, place.against.is_some())
        };
        places.sort_by(|a, b| {
            let nearer = a.touch.distance.total_cmp(&b.touch.distance);
            rank(a).cmp(&rank(b)).then(nearer)
        });
        places
    }

    /// Place and angle of a part.
    fn pose(&self, placed: &Placed, part: usize) -> ([f64; 2], f64) {
        match part.checked_sub(self.drawing.bodies.len()) {
            None => (placed.places[part], placed.angles[part]),
            Some(line) => {
                let [a, b] = placed.ends[line];
                (a, (b[1] - a[1]).atan2(b[0] - a[0]))
            }
        }
    }

    /// Derivatives by each coordinate of the point of a part that is at a place, and of its angle.
    fn motion(&self, part: usize, at: [f64; 2]) -> Vec<[f64; 3]> {
        let (place, angle) = self.pose(&self.placed, part);
        let seen = turned([at[0] - place[0], at[1] - place[1]], -angle);
        let column = |(step, both): &(f64, [Placed; 2])| {
            let [behind, ahead] = both.each_ref().map(|placed| {
                let (place, angle) = self.pose(placed, part);
                let arm = turned(seen, angle);
                ([place[0] + arm[0], place[1] + arm[1]], angle)
            });
            // An angle may be written a whole turn away.
            let turn = (ahead.1 - behind.1 + std::f64::consts::PI)
                .rem_euclid(std::f64::consts::TAU)
                - std::f64::consts::PI;
            let change = [ahead.0[0] - behind.0[0], ahead.0[1] - behind.0[1], turn];
            change.map(|change| change / (2.0 * step))
        };
        self.beside.iter().map(column).collect()
    }

    /// The force at a place that has this generalized force, normal and tangential, if one has.
    fn force(&self, place: &Place, [normal, tangential]: &[Vec<f64>; 2]) -> Option<[f64; 2]> {
        let own = self.motion(place.on, place.touch.at);
        let other = place
            .against
            .map(|other| self.motion(other, place.touch.at));
        let moves: Vec<[f64; 2]> = match other {
            None => own.iter().map(|&[y, z, _]| [y, z]).collect(),
            Some(other) => own
                .iter()
                .zip(&other)
                .map(|(a, b)| [a[0] - b[0], a[1] - b[1]])
                .collect(),
        };
        let across = place.touch.normal;
        let along = [-across[1], across[0]];
        let one = |direction: [f64; 2], load: &[f64]| {
            let rates = moves
                .iter()
                .map(|m| m[0] * direction[0] + m[1] * direction[1]);
            carried(&rates.collect::<Vec<_>>(), load)
        };
        if let (Some(n), Some(t)) = (one(across, normal), one(along, tangential)) {
            return Some([n * across[0] + t * along[0], n * across[1] + t * along[1]]);
        }
        let load: Vec<f64> = normal.iter().zip(tangential).map(|(n, t)| n + t).collect();
        both(&moves, &load)
    }

    /// The force on a part that moves freely, where no place is drawn that could carry it: its line follows from its moment, and it begins
    /// where that passes the corner that it is closest to.
    fn along(&self, [normal, tangential]: &[Vec<f64>; 2]) -> Option<Arrow> {
        let load: Vec<f64> = normal.iter().zip(tangential).map(|(n, t)| n + t).collect();
        (0..self.outlines.len()).find_map(|on| {
            let (place, _) = self.pose(&self.placed, on);
            let motion = self.motion(on, place);
            // What of each column is no turn of the part.
            let square: f64 = motion.iter().map(|[.., turn]| turn * turn).sum();
            let share = |column: &dyn Fn(usize) -> f64| -> f64 {
                let products = motion.iter().enumerate();
                products.map(|(k, m)| m[2] * column(k)).sum::<f64>() / square
            };
            let [y, z] = [0, 1].map(|axis| share(&|k| motion[k][axis]));
            let of_load = share(&|k| load[k]);
            let moves = motion.iter().map(|m| [m[0] - y * m[2], m[1] - z * m[2]]);
            let moves: Vec<[f64; 2]> = moves.collect();
            let rest = load.iter().zip(&motion).map(|(q, m)| q - of_load * m[2]);
            let is_free = square > 0.0 && gram(&moves).is_some();
            let rest: Vec<f64> = rest.collect();
            let force = is_free.then(|| both(&moves, &rest)).flatten()?;
            let size = force[0].hypot(force[1]);
            let (u, v) = (force[0] / size, force[1] / size);
            let arm = (of_load - y * force[0] - z * force[1]) / size;
            let seen = |corner: &[f64; 2]| {
                let (y, z) = (corner[0] - place[0], corner[1] - place[1]);
                ((y * v - z * u - arm).abs(), y * u + z * v)
            };
            let corners = self.outlines[on].corners.iter().map(seen);
            // Of corners as close as each other the one where it enters.
            let far = |(beside, along): &(f64, f64)| beside + CARRIED * along;
            let (_, along) = corners.min_by(|a, b| far(a).total_cmp(&far(b)))?;
            (size > 0.0).then_some(Arrow {
                on,
                at: [
                    place[0] + arm * v + along * u,
                    place[1] - arm * u + along * v,
                ],
                force,
                torque: 0.0,
            })
        })
    }

    /// The torque that has this generalized force: on the first part that turns so, or turns so as seen from another one.
    fn torque(&self, [normal, tangential]: &[Vec<f64>; 2]) -> Option<Arrow> {
        let load: Vec<f64> = normal.iter().zip(tangential).map(|(n, t)| n + t).collect();
        let turns = |part: usize| -> Vec<f64> {
            let motion = self.motion(part, self.pose(&self.placed, part).0);
            motion.into_iter().map(|[.., turn]| turn).collect()
        };
        let parts = 0..self.outlines.len();
        let turns: Vec<Vec<f64>> = parts.clone().map(turns).collect();
        let alone = parts
            .clone()
            .find_map(|on| Some((on, carried(&turns[on], &load)?)));
        let pairs = || {
            let mut pairs = parts
                .clone()
                .flat_map(|on| parts.clone().map(move |other| (on, other)));
            pairs.find_map(|(on, other)| {
                let relative = turns[on].iter().zip(&turns[other]);
                let relative: Vec<f64> = relative.map(|(a, b)| a - b).collect();
                Some((on, carried(&relative, &load)?))
            })
        };
        alone.or_else(pairs).map(|(on, torque)| Arrow {
            on,
            at: self.pose(&self.placed, on).0,
            force: [0.0; 2],
            torque,
        })
    }
}

fn turned([y, z]: [f64; 2], angle: f64) -> [f64; 2] {
    let (sine, cosine) = angle.sin_cos();
    [y * cosine - z * sine, y * sine + z * cosine]
}

/// Whether what is left of a generalized force is nothing.
fn is_carried(left: impl Iterator<Item = f64>, load: &[f64]) -> bool {
    let size = |squares: f64| squares.sqrt();
    size(left.map(|x| x * x).sum()) <= CARRIED * size(load.iter().map(|x| x * x).sum())
}

/// The factor by which `rates` are a generalized force, if they are one; 0 of none.
fn carried(rates: &[f64], load: &[f64]) -> Option<f64> {
    let square: f64 = rates.iter().map(|r| r * r).sum();
    let product: f64 = rates.iter().zip(load).map(|(r, q)| r * q).sum();
    let factor = if square > 0.0 { product / square } else { 0.0 };
    let left = rates.iter().zip(load).map(|(r, q)| q - factor * r);
    is_carried(left, load).then_some(factor)
}

/// The entries of `J J'` of a place that moves in more than one direction.
fn gram(moves: &[[f64; 2]]) -> Option<[f64; 3]> {
    let sum = |i: usize, j: usize| -> f64 { moves.iter().map(|m| m[i] * m[j]).sum() };
    let [a, b, c] = [sum(0, 0), sum(0, 1), sum(1, 1)];
    (a * c - b * b > ONE_DIRECTION * (a + c) * (a + c)).then_some([a, b, c])
}

/// The force whose work along the motions of a place is that of a generalized force, if there is one: `J' F = Q`. A place that moves along
/// one line alone has one along that line.
fn both(moves: &[[f64; 2]], load: &[f64]) -> Option<[f64; 2]> {
    let product = |axis: usize| -> f64 { moves.iter().zip(load).map(|(m, q)| m[axis] * q).sum() };
    let [y, z] = [product(0), product(1)];
    let trace: f64 = moves.iter().flatten().map(|m| m * m).sum();
    let force = match gram(moves) {
        Some([a, b, c]) => {
            let determinant = a * c - b * b;
            [(c * y - b * z) / determinant, (a * z - b * y) / determinant]
        }
        // `J J'` has this one eigenvalue.
        None if trace > 0.0 => [y / trace, z / trace],
        None => [0.0; 2],
    };
    let left = moves.iter().zip(load);
    let left = left.map(|(m, q)| q - m[0] * force[0] - m[1] * force[1]);
    is_carried(left, load).then_some(force)
}

/// `n lambda_n` and `b lambda_t`; nothing of a switch, which is no force.
fn generalized_force(model: &dyn Model, contact: usize, state: &State) -> [Vec<f64>; 2] {
    let (declaration, n) = (model.declaration(), state.q.len());
    let declared = &declaration.contacts[contact];
    let mut generalized = [vec![0.0; n], vec![0.0; n]];
    if declared.switch.is_some() {
        return generalized;
    }
    let mut x: Vec<f64> = Vec::with_capacity(declaration.inputs());
    x.extend(state.q.iter().chain(&state.v).chain(&state.u));
    if declaration.explicit_time {
        x.push(state.time);
    }
    let mut point = vec![0.0; contact_point::length(n)];
    model.contact(contact, &x, &mut point);
    let normal = &point[contact_point::NORMAL..contact_point::NORMAL + n];
    let force = state.contact_force[contact];
    let scaled = |direction: &[f64], by: f64| direction.iter().map(|d| d * by).collect();
    generalized[0] = scaled(normal, force);
    if let Some(&friction) = state.friction_force.get(contact)
        && declared.friction.is_some()
    {
        let mut point = vec![0.0; tangent_point::length(n)];
        model.tangent(contact, &x, &mut point);
        let tangent = &point[tangent_point::TANGENT..tangent_point::TANGENT + n];
        generalized[1] = scaled(tangent, friction);
    }
    generalized
}

#[cfg(test)]
mod tests {
    use hangtime_scene_files::of_text;

    use super::{Arrow, arrows};
    use crate::drawing::Drawing;
    use crate::sampling::State;
    use hangtime::model::Model as _;

    /// What a contact with this force does in a scene that is drawn.
    fn arrow(text: &str, q: &[f64], force: f64, contact: usize) -> Arrow {
        let scene = of_text("scene.hang", text).unwrap();
        let declaration = scene.declaration();
        let mut contact_force = vec![0.0; declaration.contacts.len()];
        contact_force[contact] = force;
        let state = State {
            time: 0.0,
            q: q.to_vec(),
            v: vec![0.0; q.len()],
            u: vec![0.0; declaration.controls.len()],
            contact_force,
            friction_force: Vec::new(),
            impulses: Vec::new(),
            outputs: Vec::new(),
        };
        let drawing = Drawing::of(&scene, "scene").unwrap();
        let ground = drawing.ground([[-3.0, 3.0], [-3.0, 3.0]]);
        let all = arrows(&drawing, &ground, &scene, &state);
        assert!(
            all.iter()
                .enumerate()
                .all(|(k, arrow)| arrow.is_some() == (k == contact)),
            "{all:?}"
        );
        all[contact].unwrap()
    }

    fn assert_close(found: [f64; 2], right: [f64; 2]) {
        // Central differences with a step of 1e-6 lose about 1e-10 of a slope.
        let apart = (found[0] - right[0]).hypot(found[1] - right[1]);
        assert!(apart < 1e-6 * (1.0 + right[0].hypot(right[1])), "{found:?}");
    }

    #[test]
    fn force_on_a_mass_on_a_track_is_the_normal_of_the_track() {
        // The gap is the height above the track h: the force is `lambda (-h', 1)` on the mass.
        let text = "fn h(y) = 0.2[m] - 0.2[m]*cos(2*y/1[m]) coordinates { y: m, s: m } \
            lagrangian 1[kg]/2*|dot((y, h(y) + s))|^2 surface track: s >= 0 impact track: inelastic \
            picture { point mass at (y, h(y) + s), curve track: (w, h(w)) over w }";
        let arrow = arrow(text, &[0.7, 0.0], 200.0, 0);
        let slope = 0.4 * 1.4_f64.sin();
        assert_eq!(arrow.on, 0);
        assert_close(arrow.force, [-200.0 * slope, 200.0]);
    }

    #[test]
    fn ladder_that_is_a_line_is_pushed_at_the_end_that_touches() {
        let text = "parameters { l: m = 2 } coordinates { x: m, z: m, phi: rad } \
            let foot = (x + l/2*cos(phi), z - l/2*sin(phi)) let top = (x - l/2*cos(phi), z + l/2*sin(phi)) \
            lagrangian 3[kg]/2*|dot((x, z))|^2 + 1[kg m^2]/2*dot(phi)^2 - 30[N]*z \
            surface floor: foot.z >= 0 surface wall: top.x >= 0 impact floor, wall: inelastic \
            picture { link foot to top, curve ground: (w, 0) over w in 0..=3 [m] } start { x: 1, z: 1 }";
        let phi = 0.6_f64;
        let q = [phi.cos(), phi.sin(), phi];
        let floor = arrow(text, &q, 17.0, 0);
        assert_close(floor.at, [2.0 * phi.cos(), 0.0]);
        assert_close(floor.force, [0.0, 17.0]);
        // The wall is not drawn.
        let wall = arrow(text, &q, 5.0, 1);
        assert_close(wall.at, [0.0, 2.0 * phi.sin()]);
        assert_close(wall.force, [5.0, 0.0]);
    }

    /// Two flaps on hinges at (0, 0) and (1, 0), turned clockwise from upright.
    const FLAPS: &str = "parameters { h: m = 2, w: m = 0.5, d: m = 1 } coordinates { p: rad, q: rad } \
        fn turned(a, y, z) = (y*cos(a) + z*sin(a), z*cos(a) - y*sin(a)) \
        let tip = turned(p, 0, h) let seen = turned(-q, tip.y - d, tip.z) \
        lagrangian 1[kg m^2]/2*(dot(p)^2 + dot(q)^2) \
        surface hit: seen.y <= -w surface first: p >= 0 surface second: q >= 0 \
        impact hit, first, second: inelastic \
        picture { polygon one at (0, 0) angle -p corners ((0, 0), (0, h), (-w, h), (-w, 0)), \
            polygon two at (d, 0) angle -q corners ((0, 0), (0, h), (-w, h), (-w, 0)) }";

    #[test]
    fn torque_is_drawn_on_the_part_whose_angle_is_bounded() {
        for (contact, at) in [(1, [0.0, 0.0]), (2, [1.0, 0.0])] {
            let arrow = arrow(FLAPS, &[0.1, 0.05], 3.0, contact);
            assert_eq!((arrow.on, arrow.at), (contact - 1, at));
            assert_eq!(arrow.force, [0.0; 2]);
            // The gap is the clockwise angle.
            assert!((arrow.torque + 3.0).abs() < 1e-6, "{arrow:?}");
        }
    }

    #[test]
    fn force_between_two_bodies_acts_at_the_corner_that_touches_across_the_face() {
        // The tip of one is on the face of two where h sin p = d - w cos q + ..; here q = 0: sin p = (d - w)/h.
        let p = 0.25_f64.asin();
        let arrow = arrow(FLAPS, &[p, 0.0], 8.0, 0);
        assert_close(arrow.at, [0.5, 2.0 * p.cos()]);
        // The face is upright: it pushes the tip back.
        assert_eq!(arrow.on, 0);
        assert_close(arrow.force, [-8.0, 0.0]);
    }

    #[test]
    fn force_beside_all_corners_of_a_free_body_is_on_its_line() {
        // The floor is struck by a point inside of the board, 0.3 m from its middle.
        let text = "coordinates { y: m, z: m, a: rad } let tip = (y + 0.3[m]*cos(a), z + 0.3[m]*sin(a)) \
            lagrangian 1[kg]/2*|dot((y, z))|^2 + 1[kg m^2]/2*dot(a)^2 \
            surface floor: tip.z >= 0 impact floor: inelastic start { z: 1 } \
            picture { rectangle board at (y, z) size (1[m], 0.2[m]) angle a }";
        let arrow = arrow(text, &[0.5, 0.0, 0.0], 7.0, 0);
        assert_close(arrow.force, [0.0, 7.0]);
        // Below: it enters the board there.
        assert_close(arrow.at, [0.8, -0.1]);
    }

    #[test]
    fn pin_with_clearance_is_pushed_along_the_line_between_both_ends() {
        // The gap r^2 - |a - b|^2 has the gradient -2 (a - b): a force of 2 lambda |a - b|.
        let text = "parameters { r: m = 0.1 } coordinates { y: m, z: m } \
            lagrangian 1[kg]/2*|dot((y, z))|^2 surface pin: r^2 >= |(y, z)|^2 impact pin: inelastic \
            picture { link (0, 0) to (1[m], 0), link (y, z) to (y - 1[m], z) }";
        let arrow = arrow(text, &[0.06, 0.08], 50.0, 0);
        let size = arrow.force[0].hypot(arrow.force[1]);
        assert!((size - 2.0 * 50.0 * 0.1).abs() < 1e-6, "{arrow:?}");
        assert!((arrow.force[0] * 0.08 - arrow.force[1] * 0.06).abs() < 1e-6);
    }
}
