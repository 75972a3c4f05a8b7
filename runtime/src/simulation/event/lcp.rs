//! Small linear complementarity problems, solved exactly by enumeration:
//! `w = q + M z`, `0 <= z _|_ w >= 0`.

use super::small_system;

/// Largest order: `2^12` subsets take some milliseconds, and no scene closes more contacts at once.
pub(in crate::simulation) const LARGEST: usize = 12;

/// Components below this times the largest of `q` count as zero: the subsets are solved to some `1e-15`.
const ZERO: f64 = 1e-12;

/// A solution of the problem.
#[derive(Debug, Clone, PartialEq)]
pub(in crate::simulation) struct LcpSolution {
    /// `z`, not negative.
    pub(in crate::simulation) z: Vec<f64>,
    /// `w = q + M z`, not negative up to rounding, zero where `z` is in the basis.
    pub(in crate::simulation) w: Vec<f64>,
}

/// All basic solutions of the problem, fewest positive components first; `matrix` is row-major of order
/// `q.len()`, at most [`LARGEST`]. Empty if there is none.
pub(in crate::simulation) fn solutions(matrix: &[f64], q: &[f64]) -> Vec<LcpSolution> {
    let m = q.len();
    let zero = ZERO * q.iter().fold(0.0_f64, |s, q| s.max(q.abs()));
    let mut subsets: Vec<usize> = (0..1 << m).collect();
    subsets.sort_by_key(|subset| subset.count_ones());
    subsets
        .into_iter()
        .filter_map(|subset| basic(matrix, q, subset, zero))
        .collect()
}

/// The solution whose positive components are those of the bit set `subset`, if it is one.
fn basic(matrix: &[f64], q: &[f64], subset: usize, zero: f64) -> Option<LcpSolution> {
    let m = q.len();
    let basis: Vec<usize> = (0..m).filter(|i| subset >> i & 1 == 1).collect();
    let mut square: Vec<f64> = basis
        .iter()
        .flat_map(|&i| basis.iter().map(move |&j| matrix[i * m + j]))
        .collect();
    let mut right: Vec<f64> = basis.iter().map(|&i| -q[i]).collect();
    if !small_system::solve(&mut square, &mut right) {
        return None;
    }
    let mut z = vec![0.0; m];
    for (&i, value) in basis.iter().zip(right) {
        if value < -zero || value.is_nan() {
            return None;
        }
        z[i] = value.max(0.0);
    }
    let mut w = vec![0.0; m];
    for i in (0..m).filter(|i| !basis.contains(i)) {
        w[i] = q[i] + (0..m).map(|j| matrix[i * m + j] * z[j]).sum::<f64>();
        if w[i] < -zero || w[i].is_nan() {
            return None;
        }
    }
    Some(LcpSolution { z, w })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn coupled_contacts_of_both_signs_take_the_impulses_of_the_law() {
        // D_12 < 0: the second needs more impulse because the first pushes it in.
        let found = solutions(&[1.0, -0.5, -0.5, 1.0], &[-1.0, -1.0]);
        assert_eq!(found.len(), 1);
        assert_eq!(found[0].z, [2.0, 2.0]);
        // D_12 > 0 and unequal speeds: the stronger impact lifts the other contact.
        let found = solutions(&[1.0, 0.5, 0.5, 1.0], &[-1.0, -0.25]);
        assert_eq!(found.len(), 1);
        assert_eq!(found[0].z, [1.0, 0.0]);
        assert_eq!(found[0].w, [0.0, 0.25]);
    }

    #[test]
    fn dependent_normals_give_the_same_velocities_in_every_solution() {
        let found = solutions(&[1.0, 1.0, 1.0, 1.0], &[-1.0, -1.0]);
        assert_eq!(found.len(), 2);
        assert!(found.iter().all(|solution| solution.w == [0.0, 0.0]));
    }

    #[test]
    fn problem_without_solution_gives_none() {
        assert!(solutions(&[-1.0], &[-1.0]).is_empty());
        assert!(solutions(&[1.0], &[f64::NAN]).is_empty());
        assert_eq!(solutions(&[-1.0], &[1.0]).len(), 2);
    }

    #[test]
    fn no_contact_gives_the_empty_solution() {
        assert_eq!(solutions(&[], &[]).len(), 1);
    }
}
