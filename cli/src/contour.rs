//! The lines along which a function of the plane vanishes, by marching squares.

use std::collections::HashMap;

/// Squares along the longer side of what is looked at.
const SQUARES: f64 = 200.0;
/// Least squares along a side.
const LEAST: usize = 8;
/// Halvings of the side of a square, down to the rounding error of what is drawn.
const HALVINGS: usize = 40;

/// An edge of the grid: its lower left point, and whether it is vertical.
type Edge = (usize, usize, bool);

/// The lines in `[left, right] x [bottom, top]` on which `f(a, b) = 0` changes its sign, each as its points in order.
///
/// Every point is a root on an edge of a grid, to rounding error; features smaller than a square of the grid may be
/// missed. Where `f` is not finite there is no line.
pub(crate) fn zero_lines(
    [left, right]: [f64; 2],
    [bottom, top]: [f64; 2],
    f: impl Fn([f64; 2]) -> f64,
) -> Vec<Vec<[f64; 2]>> {
    let (width, height) = (right - left, top - bottom);
    let longest = width.max(height);
    if !(longest.is_finite() && width > 0.0 && height > 0.0) {
        return Vec::new();
    }
    let count = |length: f64| ((SQUARES * length / longest).ceil() as usize).max(LEAST);
    let (columns, rows) = (count(width), count(height));
    let place = |i: usize, j: usize| {
        [
            left + width * (i as f64 / columns as f64),
            bottom + height * (j as f64 / rows as f64),
        ]
    };
    let values: Vec<Vec<f64>> = (0..=columns)
        .map(|i| (0..=rows).map(|j| f(place(i, j))).collect())
        .collect();
    let mut joined: HashMap<Edge, Vec<Edge>> = HashMap::new();
    let mut order = Vec::new();
    for i in 0..columns {
        for j in 0..rows {
            let corners = [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)];
            if corners.iter().any(|&(i, j)| !values[i][j].is_finite()) {
                continue;
            }
            let edges = [
                (i, j, false),
                (i + 1, j, true),
                (i, j + 1, false),
                (i, j, true),
            ];
            let crossed = edges.into_iter().filter(|&(i, j, up)| {
                let (k, l) = if up { (i, j + 1) } else { (i + 1, j) };
                (values[i][j] >= 0.0) != (values[k][l] >= 0.0)
            });
            let crossed: Vec<Edge> = crossed.collect();
            // Four where two lines come close: neighbours along the rim belong together.
            for pair in crossed.chunks_exact(2) {
                joined.entry(pair[0]).or_default().push(pair[1]);
                joined.entry(pair[1]).or_default().push(pair[0]);
                order.extend_from_slice(pair);
            }
        }
    }
    let root = |(i, j, up): Edge| {
        let end = if up { place(i, j + 1) } else { place(i + 1, j) };
        root(place(i, j), end, &f)
    };
    chains(joined, &order)
        .into_iter()
        .map(|chain| chain.into_iter().map(root).collect())
        .collect()
}

/// The root of `f` between two points where it has different signs.
fn root(mut from: [f64; 2], mut to: [f64; 2], f: impl Fn([f64; 2]) -> f64) -> [f64; 2] {
    let is_positive = f(from) >= 0.0;
    let middle = |a: [f64; 2], b: [f64; 2]| [0, 1].map(|axis| a[axis] + (b[axis] - a[axis]) / 2.0);
    for _ in 0..HALVINGS {
        let between = middle(from, to);
        if (f(between) >= 0.0) == is_positive {
            from = between;
        } else {
            to = between;
        }
    }
    middle(from, to)
}

/// Edges in the order in which they follow each other: open lines first, then closed ones.
fn chains(mut joined: HashMap<Edge, Vec<Edge>>, order: &[Edge]) -> Vec<Vec<Edge>> {
    let mut chains = Vec::new();
    for closed in [false, true] {
        for &start in order {
            let neighbours = joined.get(&start).map_or(0, Vec::len);
            if neighbours == 0 || (!closed && neighbours > 1) {
                continue;
            }
            let mut chain = vec![start];
            let mut here = start;
            while let Some(next) = joined.get_mut(&here).and_then(Vec::pop) {
                if let Some(back) = joined.get_mut(&next)
                    && let Some(index) = back.iter().position(|edge| *edge == here)
                {
                    back.swap_remove(index);
                }
                chain.push(next);
                here = next;
            }
            chains.push(chain);
        }
    }
    chains
}

#[cfg(test)]
mod tests {
    use super::zero_lines;

    #[test]
    fn circle_is_one_closed_line_of_roots() {
        let lines = zero_lines([-2.0, 2.0], [-2.0, 1.5], |[a, b]| a * a + b * b - 1.0);
        assert_eq!(lines.len(), 1);
        assert_eq!(lines[0].first(), lines[0].last());
        let length: f64 = lines[0]
            .windows(2)
            .map(|pair| (pair[0][0] - pair[1][0]).hypot(pair[0][1] - pair[1][1]))
            .sum();
        for [a, b] in &lines[0] {
            assert!((a.hypot(*b) - 1.0).abs() < 1e-10);
        }
        // Chords of 1/50 fall short of their arcs by a part of 1/60000.
        assert!((length - std::f64::consts::TAU).abs() < 1e-3, "{length}");
    }

    #[test]
    fn lines_begin_and_end_at_the_frame_or_where_the_function_ends() {
        let lines = zero_lines([0.0, 4.0], [-1.0, 3.0], |[a, b]| b - a / 2.0);
        assert_eq!(lines.len(), 1);
        let mut ends = [lines[0][0], *lines[0].last().unwrap()];
        ends.sort_by(|a, b| a[0].total_cmp(&b[0]));
        assert!(
            ends[0][0].abs() < 1e-10 && (ends[1][0] - 4.0).abs() < 1e-10,
            "{ends:?}"
        );
        let walls = zero_lines([-1.0, 3.0], [0.0, 1.0], |[a, _]| a * (2.0 - a));
        let places: Vec<f64> = walls.iter().map(|wall| wall[0][0].round()).collect();
        assert_eq!(places, [0.0, 2.0]);
        let rooted = zero_lines([-1.0, 1.0], [-1.0, 1.0], |[a, b]| b - a.sqrt());
        assert_eq!(rooted.len(), 1);
        assert!(rooted[0].iter().all(|[a, _]| *a >= 0.0));
        assert!(zero_lines([0.0, f64::INFINITY], [0.0, 1.0], |[a, _]| a).is_empty());
        assert!(zero_lines([0.0, 0.0], [0.0, 1.0], |[a, _]| a).is_empty());
    }
}
