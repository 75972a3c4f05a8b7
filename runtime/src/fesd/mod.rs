//! Finite elements with switch detection (FESD).
//!
//! A finite element is one Runge-Kutta step whose length is an unknown, so that switches of the contact
//! mode fall on element boundaries and the scheme keeps its order. Source: Nurkanovic, Sperl, Albrecht,
//! Diehl, Finite Elements with Switch Detection for direct optimal control of nonsmooth systems,
//! Numerische Mathematik 2024.
//!
//! - [`finite_element`]: one element in a fixed contact mode, a smooth square system.
//! - [`contact_mode`]: which contacts are active, and the velocity jump of an impact.

pub(crate) mod contact_mode;
pub(crate) mod finite_element;
pub(crate) mod transcription;
