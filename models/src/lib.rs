//! The shipped scenes.
