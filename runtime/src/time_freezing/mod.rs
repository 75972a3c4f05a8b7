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
//! that sum has a law of its own. The step form, in which a program chooses the regions (`dcs`), has the fields below.
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

pub(crate) mod clock;
mod system;

pub(crate) use system::TimeFreezingSystem;
