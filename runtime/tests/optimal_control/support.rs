//! What the tests share.

use hangtime::ocp::Settings;

/// The settings of a search from one start, where a test is about what comes after the exploration.
pub(crate) fn one_start() -> Settings {
    let mut settings = Settings::default();
    settings.starts = Some(1);
    settings
}
