//! Where parts of a picture touch each other and the ground.

/// Places that are apart by less than this share of their own size are the same.
const ROUNDING: f64 = 1e-9;

/// The outline of a part or of ground, in the plane of the picture.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct Outline {
    /// Its corners; the middle of a round one.
    pub(super) corners: Vec<[f64; 2]>,
    /// Whether the last corner is joined to the first.
    pub(super) closed: bool,
    /// Radius of a round one; 0 of all others.
    pub(super) radius: f64,
}

/// A place where two outlines are close to each other.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Touch {
    /// The place.
    pub(super) at: [f64; 2],
    /// Direction across both, of length 1; zero where neither is a line there.
    pub(super) normal: [f64; 2],
    /// How far they are apart.
    pub(super) distance: f64,
}

impl Outline {
    /// Its sides, from corner to corner.
    fn sides(&self) -> impl Iterator<Item = [[f64; 2]; 2]> {
        let pairs = self.corners.windows(2).map(|pair| [pair[0], pair[1]]);
        let last = self.corners.last().copied();
        let first = self.corners.first().copied();
        let closing = last.zip(first).filter(|_| self.closed);
        pairs.chain(closing.map(|(last, first)| [last, first]))
    }

    /// The point of the outline that is nearest to a place.
    fn nearest(&self, place: [f64; 2]) -> Option<[f64; 2]> {
        let corner = self.corners.first().copied();
        let sides = self.sides().map(|side| foot(place, side));
        sides
            .chain(corner)
            .min_by(|a, b| apart(place, *a).total_cmp(&apart(place, *b)))
    }

    /// Where a corner of either is nearest to the other: a place for each corner of `self`, and the closest of those of `other`.
    pub(super) fn touches(&self, other: &Self) -> Vec<Touch> {
        let own = self
            .corners
            .iter()
            .filter_map(|&corner| self.touch(corner, other));
        let theirs = other.corners.iter();
        let theirs = theirs.filter_map(|&corner| other.touch(corner, self));
        let closest = theirs.min_by(|a, b| a.distance.total_cmp(&b.distance));
        own.chain(closest).collect()
    }

    /// Where the part around one of its corners (round: around its middle) meets another outline.
    fn touch(&self, corner: [f64; 2], other: &Self) -> Option<Touch> {
        let nearest = other.nearest(corner)?;
        let length = apart(corner, nearest);
        let (own, others) = (self.radius, other.radius);
        let apart = length > ROUNDING * (own + others + corner[0].hypot(corner[1]));
        let across = match apart {
            true => [
                (nearest[0] - corner[0]) / length,
                (nearest[1] - corner[1]) / length,
            ],
            false => other.across(nearest),
        };
        let from = |middle: [f64; 2], along: f64| {
            [middle[0] + along * across[0], middle[1] + along * across[1]]
        };
        // One round part may be inside the other one.
        let inside = own > 0.0 && others > 0.0 && length < own.max(others);
        let (at, distance) = match (inside, own > others) {
            // The middle is on the line: on which side it touches is not seen.
            _ if !apart => (corner, own + others),
            (true, true) => (from(corner, own), (length + others - own).abs()),
            (true, false) => (from(nearest, -others), (length + own - others).abs()),
            (false, _) if own > 0.0 => (from(corner, own), (length - own - others).abs()),
            (false, _) if others > 0.0 => (from(nearest, -others), (length - others).abs()),
            (false, _) => (corner, length),
        };
        Some(Touch {
            at,
            normal: across,
            distance,
        })
    }

    /// Across the side that is nearest to a place; zero where there is none.
    fn across(&self, place: [f64; 2]) -> [f64; 2] {
        let distance = |side: &[[f64; 2]; 2]| apart(place, foot(place, *side));
        let side = self
            .sides()
            .min_by(|a, b| distance(a).total_cmp(&distance(b)));
        let [a, b] = side.unwrap_or_default();
        match apart(a, b) {
            length if length > 0.0 => [(a[1] - b[1]) / length, (b[0] - a[0]) / length],
            _ => [0.0; 2],
        }
    }
}

fn apart(a: [f64; 2], b: [f64; 2]) -> f64 {
    (a[0] - b[0]).hypot(a[1] - b[1])
}

/// The point of a side that is nearest to a place.
fn foot(place: [f64; 2], [a, b]: [[f64; 2]; 2]) -> [f64; 2] {
    let along = [b[0] - a[0], b[1] - a[1]];
    let square = along[0] * along[0] + along[1] * along[1];
    if square == 0.0 {
        return a;
    }
    let share = ((place[0] - a[0]) * along[0] + (place[1] - a[1]) * along[1]) / square;
    let share = share.clamp(0.0, 1.0);
    [a[0] + share * along[0], a[1] + share * along[1]]
}

#[cfg(test)]
mod tests {
    use super::{Outline, Touch};

    fn outline(corners: &[[f64; 2]], closed: bool, radius: f64) -> Outline {
        Outline {
            corners: corners.to_vec(),
            closed,
            radius,
        }
    }

    fn closest(one: &Outline, other: &Outline) -> Touch {
        let touches = one.touches(other).into_iter();
        touches
            .min_by(|a, b| a.distance.total_cmp(&b.distance))
            .unwrap()
    }

    #[test]
    fn disc_on_a_slope_touches_it_at_the_foot_of_its_middle() {
        // The line through (0, 0) and (4, 3), and a disc whose middle is 0.5 from (2, 1.5) along (-3, 4)/5.
        let slope = outline(&[[0.0, 0.0], [4.0, 3.0]], false, 0.0);
        let disc = outline(&[[2.0 - 0.3, 1.5 + 0.4]], false, 0.5);
        let touch = closest(&disc, &slope);
        assert!((touch.at[0] - 2.0).abs() < 1e-12 && (touch.at[1] - 1.5).abs() < 1e-12);
        assert!((touch.normal[0] - 0.6).abs() < 1e-12 && (touch.normal[1] + 0.8).abs() < 1e-12);
        assert!(touch.distance < 1e-12);
    }

    #[test]
    fn round_parts_touch_beside_and_within_each_other() {
        let large = outline(&[[0.0, 0.0]], false, 3.0);
        for (middle, at) in [([4.0, 0.0], [3.0, 0.0]), ([0.0, 2.0], [0.0, 3.0])] {
            let small = outline(&[middle], false, 1.0);
            for touch in [closest(&small, &large), closest(&large, &small)] {
                assert_eq!((touch.at, touch.distance), (at, 0.0), "{touch:?}");
            }
        }
    }

    #[test]
    fn corner_of_either_of_two_boxes_may_be_the_one_that_touches() {
        let square = outline(&[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]], true, 0.0);
        let tip = outline(&[[1.1, 0.4], [2.0, 0.0], [2.0, 1.0]], true, 0.0);
        for touch in [closest(&square, &tip), closest(&tip, &square)] {
            assert_eq!(touch.at, [1.1, 0.4]);
            assert!((touch.distance - 0.1).abs() < 1e-12);
        }
        // A corner right on a side: across the side.
        let tip = outline(&[[1.0, 0.4]], false, 0.0);
        assert_eq!(closest(&tip, &square).normal[1], 0.0);
    }
}
