//! Numerical time of the time-freezing system.
//!
//! Physical time `t` is a state of the time-freezing system and advances at the rate `theta_free` of
//! the numerical time `tau`. With step functions `gamma_i` of the contacts and auxiliary dynamics
//! `v' = a_bar d_i`, sustained contact needs `a_bar gamma_i = theta_free r_i` with
//! `theta_free = prod (1 - gamma_i)`. Source: Nurkanovic, Albrecht, Brogliato, Diehl, Automatica 158
//! (2023) 111295; several contacts in the lean product form.

/// `d tau / d t = 1 / theta_free` for normal contact accelerations `r` of the active contacts.
///
/// One contact: `1 + r / a_bar`. Several: `theta` solves `theta = prod (1 - (r_i / a_bar) theta)`, whose
/// right-hand side falls from 1; Newton's method from the root's upper bound converges monotonically.
pub(crate) fn rate(r: &[f64], auxiliary_acceleration: f64) -> f64 {
    match r {
        [] => 1.0,
        [single] => 1.0 + single.max(0.0) / auxiliary_acceleration,
        several => {
            let ratio = |r: f64| r.max(0.0) / auxiliary_acceleration;
            let mut theta = several
                .iter()
                .fold(1.0_f64, |bound, &r| bound.min(1.0 / (1.0 + ratio(r))));
            for _ in 0..50 {
                let product: f64 = several.iter().map(|&r| 1.0 - ratio(r) * theta).product();
                let slope: f64 = several
                    .iter()
                    .map(|&r| ratio(r) / (1.0 - ratio(r) * theta))
                    .sum::<f64>()
                    * product;
                let step = (theta - product) / (1.0 + slope);
                theta -= step;
                if step.abs() <= 1e-16 {
                    break;
                }
            }
            1.0 / theta
        }
    }
}

/// Least ratio `r / a_bar` of all contacts together at which the speed of the clock is smooth: contacts do not pull,
/// but an element that is tried beyond the end of a contact has forces that do.
const LEAST_RATIO: f64 = -0.2;

/// Speed of the clock `theta_free = d t / d tau` for normal contact accelerations `r`, and its derivatives with
/// respect to them in `slopes`:
///
/// ```text
/// theta = P,  P = prod_k (1 - rho_k theta),  rho_k = r_k / a_bar
/// d theta / d r_i = -(theta / a_bar) c_i / (1 + sum_k rho_k c_k),  c_k = P / (1 - rho_k theta)
/// ```
pub(crate) fn speed(r: &[f64], auxiliary_acceleration: f64, slopes: &mut [f64]) -> f64 {
    let least = LEAST_RATIO / r.len().max(1) as f64;
    let ratio = |r: f64| (r / auxiliary_acceleration).max(least);
    // One contact knows its root; that of several lies below those of each.
    let mut theta = r
        .iter()
        .fold(f64::INFINITY, |bound, &r| bound.min(1.0 / (1.0 + ratio(r))));
    if r.is_empty() {
        theta = 1.0;
    }
    for _ in 0..50 {
        if r.len() < 2 {
            break;
        }
        let (product, decrease) = product(r.iter().map(|&r| ratio(r)), theta);
        let step = (theta - product) / (1.0 + decrease);
        theta -= step;
        if step.abs() <= 1e-16 {
            break;
        }
    }
    let (product, decrease) = product(r.iter().map(|&r| ratio(r)), theta);
    for (slope, &r) in slopes.iter_mut().zip(r) {
        let others = product / (1.0 - ratio(r) * theta);
        let kept = f64::from(r / auxiliary_acceleration > least);
        *slope = -kept * theta / auxiliary_acceleration * others / (1.0 + decrease);
    }
    theta
}

/// `prod (1 - rho theta)` and minus its derivative with respect to `theta`.
fn product(ratios: impl Iterator<Item = f64>, theta: f64) -> (f64, f64) {
    ratios.fold((1.0, 0.0), |(product, decrease), ratio| {
        let factor = 1.0 - ratio * theta;
        (product * factor, decrease * factor + product * ratio)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_contact_slows_the_clock_by_the_filippov_weight() {
        // rho = a_bar / (a_bar + r): half speed at r = a_bar.
        assert_eq!(rate(&[10.0], 10.0), 2.0);
        assert_eq!(rate(&[], 10.0), 1.0);
    }

    #[test]
    fn speed_is_the_inverse_rate_and_its_slopes_are_its_derivatives() {
        let a_bar = 10.0;
        let cases: [&[f64]; 4] = [&[], &[4.0], &[3.0, 5.0, 0.5], &[-0.3, 2.0]];
        for r in cases {
            let mut slopes = vec![0.0; r.len()];
            let theta = speed(r, a_bar, &mut slopes);
            if r.iter().all(|r| *r >= 0.0) {
                assert!((theta * rate(r, a_bar) - 1.0).abs() < 1e-15);
            }
            for (i, slope) in slopes.iter().enumerate() {
                let moved = |step: f64| {
                    let mut r = r.to_vec();
                    r[i] += step;
                    speed(&r, a_bar, &mut vec![0.0; r.len()])
                };
                let difference = (moved(1e-4) - moved(-1e-4)) / 2e-4;
                assert!((slope - difference).abs() < 1e-9, "{r:?} {i}");
            }
        }
    }

    #[test]
    fn several_contacts_satisfy_the_product_equation() {
        let (r, a_bar) = ([3.0, 5.0, 0.5], 10.0);
        let theta = 1.0 / rate(&r, a_bar);
        let product: f64 = r.iter().map(|r| 1.0 - r / a_bar * theta).product();
        assert!((theta - product).abs() < 1e-15);
        assert!(theta > 0.0 && theta < 1.0);
    }
}
