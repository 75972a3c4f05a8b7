//! A problem as it was stated, term by term.

use super::Target;
use super::group::Group;

/// Variables, rows and terms in the order in which they were given.
#[derive(Default)]
pub(super) struct Statement {
    pub(super) variable_bounds: Vec<(f64, f64)>,
    pub(super) start: Vec<f64>,
    pub(super) row_bounds: Vec<(f64, f64)>,
    pub(super) linear: Vec<(Target, f64, usize)>,
    pub(super) constants: Vec<(Target, f64)>,
    pub(super) variable_names: Vec<Option<String>>,
    pub(super) row_names: Vec<Option<String>>,
    pub(super) groups: Vec<Box<dyn Group>>,
}
