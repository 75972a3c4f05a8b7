//! The phase that finds the digits: collocation of high order with a given contact sequence.
//!
//! A phase is a part of a control interval between two switches. On each of its Radau IIA elements (one, unless the
//! grid is refined), of length `h`, with the closed contacts `A`:
//!
//! ```text
//! sum_j C_mj Q_j = h V_m + sum_A d_i eta_i      g_i(Q_m) = 0,  v_n,i(Q_m, V_m) = 0,  r_i >= 0     i in A
//! sum_j C_mj V_j = h a_m + sum_A d_i r_i        g_i(Q_m) >= 0                                 i not in A
//! ```
//!
//! (stabilised index 2: Gear, Leimkuhler, Gupta 1985; order `2 s - 1` in `q` and `v`). The unknowns `r_i` are
//! normal accelerations times `h`, so that the system stays regular for short phases. Between phases:
//! an opening inside an interval happens where the force vanishes, `r_i = 0`; one at a jump of the
//! controls where `r_i >= 0` before and the normal acceleration is `>= 0` after it, and one at a node of linear
//! controls, which do not jump, where `r_i = 0` before it; a closing or a touch where `g_i = 0`, possibly at the very
//! end, followed by the impact map `v+ = v + sum_B d_i p_i`, `v_n,i(v+) = -e_i v_n,i(v)` for all contacts `B` closed
//! there. A touch leaves its contact open; without a bounce the normal acceleration is `>= 0` after it, unless the motion
//! passes an edge right there.
//! Contacts with friction are the subject of [`friction_rows`].
//!
//! The gap of an edge is the largest of those of its pieces. The sequence says which piece `k` acts: only its gap has a row,
//! `g_k >= 0`, as a maximum is not negative where one of its pieces is not. Where it is closed, `g_i <= 0` for the others. The motion
//! passes the edge where `g_i = g_k`; a contact that ends there opens where `g_i = 0`, whatever its force. A passage at a jump of the
//! controls, where the motion may be far from the edge, asks for `g_i >= 0` and `g_k >= 0` instead.
//!
//! A coordinate whose acceleration depends on nothing but the controls is a parabola on each interval,
//! so bounds hold at all times if and only if its control points meet conditions (`interval_bounds`): it is a nonnegative combination of the
//! Bernstein polynomials and of a square (Lukacs). Under linear controls it is a cubic, with conditions alike. Other bounds hold at the stages,
//! and between them where a [`Cut`](layout::Cut) says so.
//!
//! The same program with intervals of free lengths tells when the switches of a sequence have to happen
//! ([`Lengths`](discretization::Lengths)); its motion is none on the grid asked for.
//!
//! [`transcribe`] goes through the intervals; the other files add the rows of one kind each to the state of the
//! construction, [`builder`]. A solved program is read by [`program`] and checked [`between_stages`]. The layer uses
//! [`program`](super::program) and [`motion`](super::motion).

pub(in crate::ocp) mod between_stages;
pub(in crate::ocp) mod bounds;
mod builder;
mod cut_rows;
pub(in crate::ocp) mod dense_motion;
pub(in crate::ocp) mod discretization;
mod friction_cuts;
pub(in crate::ocp) mod friction_rows;
mod impact_map;
mod interval;
mod interval_bounds;
pub(in crate::ocp) mod layout;
pub(in crate::ocp) mod limits;
mod phase;
pub(in crate::ocp) mod program;
pub(in crate::ocp) mod provided;
mod stage_inputs;
mod start_conditions;
#[cfg(test)]
mod test_scene;
pub(in crate::ocp) mod transcribe;
mod turns;
