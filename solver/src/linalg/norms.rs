//! Norms of long vectors, in lanes that do not wait for each other.

/// Largest absolute entry; not a number if there is one.
pub(crate) fn norm_inf(x: &[f64]) -> f64 {
    let (fours, others) = x.as_chunks::<4>();
    let mut lanes = [0.0_f64; 4];
    // zero for finite entries, and not a number from the first that is not
    let mut faults = [0.0_f64; 4];
    for four in fours {
        for ((lane, fault), a) in lanes.iter_mut().zip(&mut faults).zip(four) {
            if a.abs() > *lane {
                *lane = a.abs();
            }
            *fault += a * 0.0;
        }
    }
    let mut norm: f64 = 0.0;
    let mut fault: f64 = faults.iter().sum();
    for a in lanes.iter().chain(others) {
        norm = norm.max(a.abs());
        fault += a * 0.0;
    }
    if fault == 0.0 {
        norm
    } else if x.iter().any(|a| a.is_nan()) {
        f64::NAN
    } else {
        f64::INFINITY
    }
}

/// Sum of absolute entries.
pub(crate) fn norm_one(x: &[f64]) -> f64 {
    let (fours, others) = x.as_chunks::<4>();
    let mut lanes = [0.0_f64; 4];
    for four in fours {
        for (lane, a) in lanes.iter_mut().zip(four) {
            *lane += a.abs();
        }
    }
    lanes.iter().chain(others).map(|a| a.abs()).sum()
}

/// Whether all entries are finite.
pub(crate) fn is_finite(x: &[f64]) -> bool {
    let (fours, others) = x.as_chunks::<4>();
    let mut faults = [0.0_f64; 4];
    for four in fours {
        for (fault, a) in faults.iter_mut().zip(four) {
            *fault += a * 0.0;
        }
    }
    faults.iter().sum::<f64>() == 0.0 && others.iter().all(|a| a.is_finite())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn norm_inf_sees_every_lane_and_every_fault() {
        let mut x = vec![1.0; 11];
        for k in 0..x.len() {
            x[k] = -3.0;
            assert_eq!(norm_inf(&x), 3.0);
            x[k] = f64::NEG_INFINITY;
            assert_eq!(norm_inf(&x), f64::INFINITY);
            assert!(!is_finite(&x));
            x[k] = f64::NAN;
            assert!(norm_inf(&x).is_nan());
            assert!(!is_finite(&x));
            x[k] = 1.0;
            assert!(is_finite(&x));
        }
        assert_eq!(norm_inf(&[]), 0.0);
    }

    #[test]
    fn norm_one_adds_every_lane() {
        let x: Vec<f64> = (0..11)
            .map(|k| if k % 2 == 0 { 1.0 } else { -2.0 })
            .collect();
        assert_eq!(norm_one(&x), 16.0);
        assert!(norm_one(&[1.0, f64::NAN, 0.0, 0.0]).is_nan());
    }
}
