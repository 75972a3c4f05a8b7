//! The elements of the phases and jumps of a known motion.

use super::task::Span;

/// A guess of one element.
pub(super) struct Placed {
    /// Its length over that of its interval.
    pub(super) width: f64,
    /// `(q, v, t, G, D)` and the shares of the groups in each block.
    pub(super) points: Vec<Vec<f64>>,
}

/// Numbers of elements of these spans, `count` together where that is enough: a jump is one element, the others are divided evenly,
/// the longest ones most often.
pub(super) fn parts(spans: &[Span], count: usize) -> Vec<usize> {
    let mut parts = vec![1; spans.len()];
    for _ in spans.len()..count {
        let part = |&i: &usize| (!spans[i].jumps, spans[i].length / parts[i] as f64);
        let compare = |a: &usize, b: &usize| {
            let (a, b) = (part(a), part(b));
            a.0.cmp(&b.0).then(a.1.total_cmp(&b.1))
        };
        if let Some(longest) = (0..spans.len()).max_by(compare) {
            parts[longest] += 1;
        }
    }
    parts
}

/// The span of each element of all intervals, which have `count` elements each.
pub(crate) fn spans_of_elements(intervals: &[Vec<Span>], count: usize) -> Vec<&Span> {
    let repeated = intervals.iter().flat_map(|spans| {
        let parts = spans.iter().zip(parts(spans, count));
        parts.flat_map(|(span, count)| std::iter::repeat_n(span, count))
    });
    repeated.collect()
}

/// Which elements of an interval are as long as the one before: those of the same span. Nothing else decides their lengths, and an
/// objective would move them to where its error of integration is largest.
pub(super) fn alike(spans: &[Span], count: usize) -> Vec<bool> {
    let parts = parts(spans, count).into_iter();
    parts
        .flat_map(|count| (0..count).map(|part| part > 0))
        .collect()
}

/// Which of these contacts, along which coordinates would drift, are closed in each element of an interval, where the clock runs.
pub(super) fn closed(spans: &[Span], count: usize, contacts: &[usize]) -> Vec<Vec<usize>> {
    let of_span = |(span, parts): (&Span, usize)| {
        let closed = |i: &&usize| !span.jumps && span.weights[**i] == [true, true];
        let closed: Vec<usize> = contacts.iter().filter(closed).copied().collect();
        std::iter::repeat_n(closed, parts)
    };
    let parts = parts(spans, count);
    spans.iter().zip(parts).flat_map(of_span).collect()
}

/// Length in numerical time and elements of an interval with these spans.
pub(super) fn laid_out(spans: &[Span], count: usize, places: &[f64]) -> (f64, Vec<Placed>) {
    let length: f64 = spans.iter().map(|span| span.length).sum();
    let elements = spans
        .iter()
        .zip(parts(spans, count))
        .flat_map(|(span, parts)| {
            (0..parts).map(move |part| Placed {
                width: span.length / length / parts as f64,
                points: places
                    .iter()
                    .map(|place| at(span, (part as f64 + place) / parts as f64))
                    .collect(),
            })
        });
    (length, elements.collect())
}

/// The point at a share of a span.
fn at(span: &Span, share: f64) -> Vec<f64> {
    let place = share * (span.points.len() - 1) as f64;
    let first = (place as usize).min(span.points.len() - 2);
    let fraction = place - first as f64;
    let pair = span.points[first].iter().zip(&span.points[first + 1]);
    pair.map(|(a, b)| a + fraction * (b - a)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A span whose only number runs from one value to another.
    fn span(length: f64, jumps: bool, [from, to]: [f64; 2]) -> Span {
        Span {
            length,
            jumps,
            weights: Vec::new(),
            sets: Vec::new(),
            points: vec![vec![from], vec![to]],
        }
    }

    #[test]
    fn phases_are_divided_evenly_and_jumps_not_at_all() {
        let spans = [
            span(0.3, false, [0.0, 3.0]),
            span(0.5, true, [3.0, 3.0]),
            span(0.6, false, [3.0, 9.0]),
        ];
        assert_eq!(parts(&spans, 5), [1, 1, 3]);
        assert_eq!(parts(&spans, 2), [1, 1, 1]);
        let (length, placed) = laid_out(&spans, 5, &[0.5, 1.0]);
        assert!((length - 1.4).abs() < 1e-15);
        let widths: f64 = placed.iter().map(|element| element.width).sum();
        assert!((widths - 1.0).abs() < 1e-15);
        // The second third of the last phase, at its middle and its end.
        let points: Vec<f64> = placed[3].points.iter().map(|point| point[0]).collect();
        assert!((points[0] - 6.0).abs() < 1e-14 && (points[1] - 7.0).abs() < 1e-14);
    }
}
