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

/// Numerical time of an impact with normal velocity increments `impulses`: the auxiliary dynamics
/// raise each contact's normal velocity at the rate `a_bar` until the last one is done.
pub(crate) fn jump(impulses: &[f64], auxiliary_acceleration: f64) -> f64 {
    impulses.iter().fold(0.0_f64, |longest, &p| longest.max(p)) / auxiliary_acceleration
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
    fn several_contacts_satisfy_the_product_equation() {
        let (r, a_bar) = ([3.0, 5.0, 0.5], 10.0);
        let theta = 1.0 / rate(&r, a_bar);
        let product: f64 = r.iter().map(|r| 1.0 - r / a_bar * theta).product();
        assert!((theta - product).abs() < 1e-15);
        assert!(theta > 0.0 && theta < 1.0);
    }
}
