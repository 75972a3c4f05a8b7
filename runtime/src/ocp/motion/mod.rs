//! What a motion is: states over time with controls, contact modes, contact sequences, and what the goals ask of it.
//!
//! Pure data and functions of the model; nothing here knows a program or a solver.

pub(in crate::ocp) mod candidate;
pub(in crate::ocp) mod control_grid;
pub(in crate::ocp) mod edit_sequence;
pub(in crate::ocp) mod final_times;
pub(in crate::ocp) mod mode;
pub(in crate::ocp) mod model_input;
pub(in crate::ocp) mod passages;
pub(in crate::ocp) mod read_sequence;
pub(in crate::ocp) mod sequence;
pub(in crate::ocp) mod targets;
pub(in crate::ocp) mod trajectory;
