//! The clocks by which runs are timed: those of the system, or of the host where the system has none.

#[cfg(target_family = "wasm")]
pub use host::{HostTime as Instant, HostTime as ThreadTime, set_clock};
#[cfg(not(target_family = "wasm"))]
pub use {cpu_time::ThreadTime, std::time::Instant};

/// Without an operating system the host gives the time, one for wall-clock and processor.
#[cfg(target_family = "wasm")]
mod host {
    use std::io;
    use std::sync::OnceLock;
    use std::time::Duration;

    static CLOCK: OnceLock<fn() -> f64> = OnceLock::new();

    /// Runs are timed by this clock, in seconds from any instant; the first one that is set counts. Without a clock
    /// every run takes zero seconds, so that limits on time are never reached. Only where the system has no clock.
    pub fn set_clock(seconds: fn() -> f64) {
        let _ = CLOCK.set(seconds);
    }

    /// An instant on the clock of the host \[s\].
    #[derive(Debug, Clone, Copy)]
    pub struct HostTime(f64);

    impl HostTime {
        pub fn now() -> Self {
            Self::try_now().unwrap_or(Self(0.0))
        }

        pub fn elapsed(&self) -> Duration {
            Duration::try_from_secs_f64(Self::now().0 - self.0).unwrap_or_default()
        }

        pub fn try_now() -> io::Result<Self> {
            let seconds = CLOCK.get().ok_or(io::ErrorKind::Unsupported)?;
            Ok(Self(seconds()))
        }

        pub fn try_elapsed(&self) -> io::Result<Duration> {
            Ok(self.elapsed())
        }
    }
}
