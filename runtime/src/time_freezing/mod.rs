//! Time-freezing: a system with state jumps becomes a Filippov system without.
//!
//! The state is extended by the physical time, `y = (q, v, t)`, and everything evolves in *numerical time*
//! `tau`. A contact may be violated, and there an auxiliary field performs the jump while the clock rests:
//!
//! ```text
//! f_free  = (v, a(q, v, u, t), 1)        where max(g_i, v_n,i) > 0 for all contacts
//! f_aux,i = (0, a_bar d_i(q), 0)         where max(g_i, v_n,i) < 0
//! ```
//!
//! Positions are frozen during a jump, so its end is exact for any gap function and mass matrix: `v_n`
//! rises at the rate `a_bar` to zero. Sustained contact is a sliding mode on `max(g, v_n) = 0`. Source:
//! Nurkanovic, Albrecht, Brogliato, Diehl, Automatica 158 (2023) 111295. One switching function a contact,
//! the maximum of gap and normal velocity, replaces the published two; it makes the step functions unique
//! in contact.
//!
//! A simulation follows the system from region to region (`fesd::finite_element`): free flow, where numerical and physical
//! time are the same; sustained contact, in which the clock is slowed down ([`clock::speed`]); jumps, whose field is
//! constant. Of a jump the impact law gives the impulses `p_i` and `s_i`, and the field is
//!
//! ```text
//! y' = (0, a_bar sum_i (p_i d_i + s_i e_i) / max_k p_k, 0)
//! ```
//!
//! It ends after `max_k p_k / a_bar` where the law says. For one contact that slides in one sense this is
//! `f_aux`; one that begins to stick within its jump ends at the same velocity. It is another field than the sum of the
//! `f_aux,i` where contacts push each other apart (`n_i' d_j > 0`) or where sliding turns round within the jump: there
//! that sum has a law of its own. The step form, in which a program chooses the regions, has the fields below.
//!
//! *Friction* adds the auxiliary force that its bound allows, against the sliding velocity, so that impulses
//! and sustained forces both follow Coulomb's law:
//!
//! ```text
//! f_aux,i = (0, a_bar (d_i -+ mu_i e_i), 0)          where v_t,i > 0, v_t,i < 0
//! ```
//!
//! Sticking is a sliding mode on `v_t = 0`. *Restitution* lets the gap fall and rise again during the jump,
//! with the coordinates still frozen: a lifted gap `G` moves in their place,
//!
//! ```text
//! f_aux,i = (0, a_bar d_i, 0),      G_i' = v_n,i     where G_i < 0, v_n,i < 0
//! f_aux,i = (0, e_i^2 a_bar d_i, 0), G_i' = v_n,i    where G_i < 0, v_n,i > 0
//! ```
//!
//! It comes to rest at the depth `v_n-^2 / (2 a_bar)` and returns with `v_n+^2 = 2 e^2 a_bar` times that
//! depth: `v_n+ = -e v_n-`, for any mass matrix, ground and scale of the gap, as only `G` and `v_n` matter
//! and `n' d = 1`. The published auxiliary dynamics (Nurkanovic, Sartor, Albrecht, Diehl, L-CSS 2021) are those of a
//! damped spring instead, which a Runge-Kutta scheme resolves to its error only; velocities linear and gaps
//! quadratic in time are exact for any scheme with two stages.
//!
//! # The step form
//! One step function a contact.
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
//! of pieces and then the lifted products `P_2..P_nc`.
//!
//! # Rows
//! On a grid of control intervals the step form is a mathematical program with complementarity constraints: FESD with FE-FE cross
//! complementarity, stated in rows of [`program`](crate::program).
//!
//! Interval `k` of `N` has the numerical length `s_k` and ends at the physical time `(k+1) T / N`. On its
//! finite element `e` with start `y_e` and length `h_e s_k`:
//!
//! ```text
//! Y_m = y_e + h_e s_k sum_j a_mj F(Y_j, u_k, z_j)      0 = algebraic rows (Y_m, z_m)
//! y_{e+1} = y_e + h_e s_k sum_j b_j F(Y_j, u_k, z_j)   (Y of the last stage for a stiffly accurate scheme)
//! 0 <= sum_m alpha_m  _|_  ln_0 + sum_m ln_m >= 0
//! 0 <= sum_m beta_m   _|_  lp_0 + sum_m lp_m >= 0      (cross complementarity, a contact)
//! 0 <= p_m _|_ w_m >= 0                                (a stage and contact)
//! 0 <= c+_m _|_ c-_m >= 0                              (a stage and friction)
//! sum_e h_e = 1,  t at the end of interval k = t_0 + (k+1) T / N
//! ```
//!
//! and the same sums for the weights by which friction and restitution split a jump (see the step form). The
//! multipliers with index 0 are those at the end of the element before; they put switches on element
//! boundaries. Schemes without a stage at the end carry `lp, ln, p, w` there as boundary variables. The
//! objective contains `3e-4 sum_e (h_e / h_0 - 1)^2`, the mean step equilibration: lengths that no switch
//! determines stay equal. Sources: Nurkanovic et al., Numerische Mathematik 2024; Nurkanovic, Pozharskiy,
//! Frey, Diehl, Nonlinear Analysis: Hybrid Systems 54 (2024).
//!
//! All of it is products of unknowns and of functions of the model, so that [`program`](crate::program) knows the derivatives. The
//! start and the controls are variables that a program has before, given or free; where coordinates are free there, `G_i = g_i(q)` is a
//! row. Parameters that are unknowns are coordinates without motion, whose variable all stages share, and coefficients of laws factors of
//! the rows that they stand in. Joints stand in the place of as many rows of collocation, as in all programs.
//!
//! A switch of what acts is a friction whose normal force is given: its sign is the difference of the weights against both
//! directions.
//!
//! A condition that sets velocities, `when c >= 0 { x = r }`, is no jump that takes numerical time, as what it sets may be any function of
//! the state before. It is a switch that nothing acts by, whose share `S_e` of an element is 1 where `c > 0` and 0 where `c < 0`; it comes
//! true between two elements, and what it sets is where the second one starts:
//!
//! ```text
//! S_e (1 - S_e) = 0     a_e (1 - a_e) = 0     S_e - S_{e-1} <= a_e     a_e S_{e-1} = 0     a_e c(y_e) = 0
//! y_e + a_e (r(y_e) - y_e)  instead of y_e at the start of element e
//! ```
//!
//! It may be false again right after, as where a heater is switched on that warms. All of these are pairs.
//! The multipliers at the end of the element before count for it as for all others, so that no switch and no contact may read what is set.
//!
//! While a contact of a known motion is closed, the lifted gap and the normal velocity vanish at every stage. Where the
//! normal turns, or the surface moves, coordinates drift off the surface all the same, by the error of the scheme, and a goal that
//! lies on it may have no motion. Each stage `m` of such a contact has an unknown `mu_m` more, and each end without a stage, and a row:
//!
//! ```text
//! q_m = q_e + h_e s_k sum_j a_mj F(Y_j, u_k, z_j) + d mu_m        G_m = g(q_m)
//! ```
//!
//! with the contact direction `d` of the guess at the first stage of the element. As the matrix of the scheme is regular, this is the
//! stabilised system of index 2 (Gear, Gupta, Leimkuhler 1985), `q' = v + d mu`.

pub(crate) mod clock;
pub(crate) mod conditions;
pub(crate) mod field;
mod guess;
mod known;
pub(crate) mod laid_out;
mod layout;
pub(crate) mod modes;
mod names;
mod rows;
pub(crate) mod step_form;
pub(crate) mod task;
#[cfg(test)]
mod test_scenes;
#[cfg(test)]
mod tests;
pub(crate) mod transcription;
