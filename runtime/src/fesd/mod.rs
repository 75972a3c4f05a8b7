//! Finite elements with switch detection (FESD).
//!
//! A finite element is one Runge-Kutta step whose length is an unknown, so that switches of the contact
//! mode fall on element boundaries and the scheme keeps its order. Source: Nurkanovic, Sperl, Albrecht,
//! Diehl, Finite Elements with Switch Detection for direct optimal control of nonsmooth systems,
//! Numerische Mathematik 2024.
//!
//! - [`finite_element`]: one element in a fixed contact mode, a smooth square system.
//! - [`contacts`]: gaps, velocities and forces at a point; [`contact_mode`]: which contacts are active and
//!   which of them stick, by the laws of [`contact`](crate::contact).

mod constraints;
pub(crate) mod contact_mode;
pub(crate) mod contact_size;
pub(crate) mod contacts;
pub(crate) mod finite_element;
mod redundancy;
