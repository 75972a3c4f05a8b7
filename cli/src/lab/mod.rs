//! The laboratory: what compares methods with each other, with other programs and with what was published. Nothing else needs it.

pub(crate) mod chart;
pub(crate) mod reproduce;
