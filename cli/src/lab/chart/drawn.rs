//! What the charts have in common.

use crate::page::Section;

/// What one kind of chart comes to.
#[derive(Default)]
pub(super) struct Chart {
    /// For the standard output stream.
    pub(super) text: String,
    /// On the page; `None` if nothing could be measured.
    pub(super) section: Option<Section>,
    pub(super) files: Vec<(String, String)>,
    pub(super) diagnoses: Vec<String>,
    /// Its line in the overview.
    pub(super) overview: Option<Vec<String>>,
}
