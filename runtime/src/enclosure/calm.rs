//! Parts of a piece in each of which nothing is hidden.

/// Parts this narrow are not halved.
const NARROWEST: f64 = 1e-9;

/// Parts of a step, as shares, that its stages tell apart.
pub(super) const WIDE: f64 = 0.125;

/// Whether something is confined to less of a piece than the stages of a step tell, as its calm parts say.
pub(crate) fn hide(parts: &[[f64; 2]]) -> bool {
    parts.iter().any(|part| part[1] - part[0] < WIDE)
}

/// Parts of the piece from 0 to 1, increasing, each of which is calm or too narrow to be halved; none if there are more than `most`.
pub(crate) fn calm_parts(
    most: usize,
    mut is_calm: impl FnMut([f64; 2]) -> bool,
) -> Option<Vec<[f64; 2]>> {
    let mut parts = Vec::new();
    let mut open = vec![[0.0, 1.0]];
    while let Some([from, to]) = open.pop() {
        if to - from <= NARROWEST || is_calm([from, to]) {
            parts.push([from, to]);
        } else if parts.len() + open.len() + 2 > most {
            return None;
        } else {
            let middle = 0.5 * (from + to);
            open.push([middle, to]);
            open.push([from, middle]);
        }
    }
    Some(parts)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_are_narrow_where_something_is_confined_and_wide_elsewhere() {
        // Calm where it is farther from a place than it is wide.
        let place = 0.371;
        let calm = |[a, b]: [f64; 2]| (0.5 * (a + b) - place).abs() > b - a || b - a < 1e-4;
        let parts = calm_parts(1024, calm).unwrap_or_default();
        assert!(parts.len() < 64, "{}", parts.len());
        assert!(parts.windows(2).all(|pair| pair[0][1] == pair[1][0]));
        let there = parts
            .iter()
            .find(|part| part[0] <= place && place < part[1]);
        assert!(there.is_some_and(|part| part[1] - part[0] < 1e-4));
        assert_eq!(calm_parts(1024, |_| false), None);
        assert_eq!(calm_parts(1024, |_| true), Some(vec![[0.0, 1.0]]));
    }
}
