//! Joints, and the inertia of a system whose joints hold.
//!
//! A joint is rows `w = G(q, t) v - b(q, t) = 0`, of positions `g(q, t) = 0` whose rate is `w`. Where they hold,
//!
//! ```text
//! K (a, mu) = (r, c),   K = [ M  G' ]   c = -dw/dt without accelerations      force of the joints lambda = -mu
//!                           [ G  0  ]
//! ```
//!
//! gives the acceleration, and the upper left block of the inverse of `K` is what the inverse mass matrix is to everything
//! that acts on the bodies: contacts push a mechanism as it can move. `K` is factorized with the masses first, which are
//! positive definite, so that no pivot vanishes before joints depend on each other.
//!
//! A row that follows from others is not *held*: its equation becomes `-mu = 0`.

use super::held::{along_motion, moving};
use super::simplify;
use crate::graph::{self, Sym, Variable};
use crate::scene::CheckedScene;

/// One equation.
pub(super) struct Row {
    /// `dw/dv`.
    gradient: Vec<Sym>,
    /// `w`.
    pub(super) rate: Sym,
    /// `dw/dt` without accelerations.
    curvature: Sym,
    /// 1 if it is held.
    held: Sym,
}

/// All rows of a scene.
pub(super) fn rows(scene: &CheckedScene) -> Vec<Row> {
    let n = scene.coordinates.len();
    // What is held has no part in any rate.
    let along = along_motion(moving(scene));
    let velocities = Variable::velocities(n);
    let joints = scene.joints.iter();
    let rows = joints.flat_map(|joint| joint.rows.iter().map(|&row| (row, joint.holonomic)));
    rows.zip(0_u16..)
        .map(|((row, holonomic), index)| {
            let rate = if holonomic {
                graph::directional(&[row], along)[0]
            } else {
                row
            };
            let rate = simplify(rate);
            let gradient = graph::gradient(rate, &velocities);
            Row {
                gradient: gradient.into_iter().map(simplify).collect(),
                rate,
                curvature: simplify(graph::directional(&[rate], along)[0]),
                held: Sym::variable(Variable::JointHeld(index)),
            }
        })
        .collect()
}

impl Row {
    /// What is on its right-hand side.
    pub(super) fn right(&self) -> Sym {
        -(self.held * self.curvature)
    }

    /// Whether it moves something that is not locked.
    fn moves(&self, held: &[usize]) -> bool {
        let entries = self.gradient.iter().enumerate();
        let mut free = entries.filter(|(i, _)| !held.contains(i));
        free.any(|(_, entry)| !entry.is_structural_zero())
    }

    /// Its entry for coordinate `i` where the coordinates `locked` do not move.
    pub(super) fn entry(&self, i: usize, locked: &[usize]) -> Sym {
        if locked.contains(&i) {
            Sym::ZERO
        } else {
            self.held * self.gradient[i]
        }
    }

    /// Its entry for its own force: 0 if it is held.
    pub(super) fn own(&self, locked: &[usize]) -> Sym {
        if self.moves(locked) {
            self.held - Sym::ONE
        } else {
            -Sym::ONE
        }
    }
}
