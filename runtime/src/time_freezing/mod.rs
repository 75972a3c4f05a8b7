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

pub(crate) mod clock;
mod system;

pub(crate) use system::TimeFreezingSystem;
