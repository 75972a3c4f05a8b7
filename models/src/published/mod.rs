//! The published results that the scenes reproduce: the plotted data, what they mean, and the values that are known
//! better.

pub(crate) mod pump_track;
mod read;
pub(crate) mod ski_jump;
