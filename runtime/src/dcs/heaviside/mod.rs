//! The lean Heaviside step form: one step function a contact.
//!
//! With `m_i = max(g_i, v_n,i)` and `alpha_i = H(m_i)` (1 free, 0 jump, between in sustained contact):
//!
//! ```text
//! (q, v, t)' = theta f_free + sum_i beta_i f_aux,i   theta = prod alpha_i,  beta_i = 1 - alpha_i
//! G_i' = theta v_n,i                              G_i = g_i(q) at the start
//! p_i - w_i + G_i - v_n,i = 0                     0 <= p_i _|_ w_i >= 0      (m_i = G_i + p_i)
//! G_i + p_i - lp_i + ln_i = 0                     0 <= ln_i _|_ alpha_i >= 0,  0 <= lp_i _|_ beta_i >= 0
//! ```
//!
//! The *lifted gap* `G_i` is a state of its own, so that it is linear in the states whatever the surface is.
//! The gap itself would be an invariant of contact that a Runge-Kutta scheme keeps on flat ground only:
//! with `v_n = 0` at the stages, `g` leaves zero there by the error of the scheme, with either sign, and
//! contact has one condition more than unknowns. `G` stays exactly zero, and differs from `g` by the error
//! that the scheme makes in all states.
//!
//! Products of more than two step functions are lifted, `P_k = P_{k-1} alpha_k`, so that every equation is
//! bilinear in them. Two contacts that jump at the same time receive impulses at the same rate until each
//! has stopped; this is Moreau's law where the contacts do not push each other apart (`D_12 <= 0`).
//!
//! A contact with *friction* splits its weight `beta_i` by the sign of the sliding velocity:
//!
//! ```text
//! f_aux,i = (0, a_bar (beta_i d_i + (b-_i - b+_i) mu_i e_i), 0)    b+_i + b-_i = beta_i
//! v_t,i = c+_i - c-_i      0 <= c+_i _|_ c-_i >= 0     0 <= b+_i _|_ c-_i >= 0,  0 <= b-_i _|_ c+_i >= 0
//! ```
//!
//! The split is linear, and in flight, where `b+ = b- = 0`, the sliding velocity may change its sign without
//! a switch: a step function of `v_t` times `beta` would have neither property. A contact with *restitution*
//! has the step function of `m_i = G_i` and splits its weight by the sign of the normal velocity, into a fall
//! at the rate `a_bar` and a rise at `e^2 a_bar`, which press and rub with `f_i + e_i^2 r_i` instead of `beta_i`:
//!
//! ```text
//! G_i' = (theta + beta_i) v_n,i     f_i + r_i = beta_i    v_n,i = p_i - w_i
//! 0 <= f_i _|_ p_i >= 0,  0 <= r_i _|_ w_i >= 0
//! ```
//!
//! A piece of an *outer edge* acts where its gap is the largest of the pieces `j`; its margin is `max(m_i, G_j - G_i)`:
//!
//! ```text
//! a_ij - b_ij + m_i + sum_k<j a_ik - (G_j - G_i) = 0    0 <= a_ij _|_ b_ij >= 0    (m_i + sum_j a_ij instead of m_i)
//! ```
//!
//! Over an element, `a_ij` counts like `lp_i` against `beta_i`. Without it, a contact could be kept at `G_j = G_i` inside the
//! ground, which a stage can reach at once. Where two gaps are negative, as beside and below the corner of a table, only the larger one pushes; where another
//! piece comes to be the larger one while the contact lasts, the body passes the edge and is free. A piece that *bounces* dips into the
//! ground during a jump, by more than the other pieces may be away. So its *dip* `D_i` is a state of its own, which is not compared with other pieces:
//!
//! ```text
//! G_i' = theta v_n,i    D_i' = beta_i v_n,i    m_i = G_i    (D_i + m_i + sum_j a_ij instead of m_i)
//! ```
//!
//! The *local vector* of a stage is `xi = (q, v, t, G, D, u, z)`, with `z = (alpha, beta, lp, ln, p, w)` of each
//! contact, `(b+, b-, c+, c-)` of each with friction, `(f, r)` of each with restitution, `(a, b)` of each pair
//! of pieces and then the lifted products `P_2..P_nc`. The *local rows* are the right-hand side `F = (q', v', t', G', D')` and then the
//! algebraic equations: three a contact, two a friction, one a restitution, one a pair of pieces
//! and one a lifted product.

mod derivatives;
mod layout;
mod system;

pub(crate) use derivatives::{gap_gradient, gap_hessian, hessian, jacobian};
pub(crate) use layout::{ALPHA, Group, P, W};
pub(crate) use system::HeavisideSystem;
