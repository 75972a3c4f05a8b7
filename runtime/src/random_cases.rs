//! Random cases of unit tests, the same in every run.

use proptest::prelude::ProptestConfig;
use proptest::test_runner::RngSeed;

/// As many cases as usual.
pub(crate) fn same_in_every_run() -> ProptestConfig {
    ProptestConfig {
        rng_seed: RngSeed::Fixed(20_261_122),
        failure_persistence: None,
        ..ProptestConfig::default()
    }
}
