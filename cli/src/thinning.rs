//! Long trajectories, thinned for files and figures.

/// The indices of at most `most` instants of a trajectory: all of them if there are no more; otherwise every second,
/// third, ... one, with the last one and, as long as these leave room, both sides of every jump, where two instants
/// have the same time.
pub(crate) fn kept(times: &[f64], most: usize) -> Vec<usize> {
    let count = times.len();
    if count <= most {
        return (0..count).collect();
    }
    if most == 1 {
        return vec![count - 1];
    }
    let mut jumps: Vec<usize> = (1..count)
        .filter(|&k| times[k] == times[k - 1])
        .flat_map(|k| [k - 1, k])
        .collect();
    jumps.dedup();
    if 2 * jumps.len() > most {
        jumps.clear();
    }
    // One for the last instant.
    let room = most.saturating_sub(jumps.len() + 1).max(1);
    let mut kept: Vec<usize> = (0..count).step_by(count.div_ceil(room)).collect();
    kept.extend(jumps);
    kept.push(count - 1);
    kept.sort_unstable();
    kept.dedup();
    kept
}

/// What the notes of a result say about a trajectory of `count` instants of which `kept` are written.
pub(crate) fn note(count: usize, kept: usize) -> Option<String> {
    (kept < count).then(|| {
        format!(
            "{kept} of the {count} instants of the trajectory are written; --rows sets how many"
        )
    })
}

#[cfg(test)]
mod tests {
    use super::kept;

    #[test]
    fn short_trajectory_is_kept_whole() {
        assert_eq!(kept(&[0.0, 1.0, 2.0], 3), [0, 1, 2]);
        assert!(kept(&[], 1).is_empty());
        assert_eq!(kept(&[0.0, 1.0, 2.0], 1), [2]);
    }

    #[test]
    fn long_trajectory_keeps_ends_and_jumps_within_the_bound() {
        let mut times: Vec<f64> = (0..1000).map(f64::from).collect();
        times[501] = 500.0;
        for most in [10, 37, 500, 999] {
            let kept = kept(&times, most);
            assert!(kept.len() <= most, "{most}: {}", kept.len());
            assert!(kept.is_sorted_by(|a, b| a < b));
            for index in [0, 500, 501, 999] {
                assert!(kept.contains(&index), "{most}: {index}");
            }
        }
    }

    #[test]
    fn trajectory_of_nothing_but_jumps_is_thinned_all_the_same() {
        let times: Vec<f64> = (0..1000).map(|k| f64::from(k / 2)).collect();
        let kept = kept(&times, 20);
        assert!(kept.len() <= 20 && kept.contains(&999), "{kept:?}");
    }
}
