//! The command line of hangtime.

fn main() {}
