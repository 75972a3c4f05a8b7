//! What ends a long run before its time: Ctrl-C, and the limits on time and memory.
//!
//! A run that is to end is asked first: it returns the best result so far. One that does not answer within a grace
//! period is ended by the program, which then has no result but still says why, with the exit status of a result that
//! did not converge.

use std::fs;
use std::process;
use std::sync::atomic::{AtomicBool, AtomicU8, Ordering};
use std::sync::{Arc, OnceLock};
use std::thread;
use std::time::{Duration, Instant};

use cpu_time::ProcessTime;
use hangtime::nlp::Interrupt;

use crate::arguments::LimitArguments;
use crate::ending::Stop;
use crate::report::{NOT_CONVERGED, complain};

/// Exit status of a program that a second Ctrl-C ended, as shells report it.
const ENDED: i32 = 130;
/// How often the limits are looked at.
const INTERVAL: Duration = Duration::from_millis(10);
/// A run that was asked to end has this much more of its limit until it is ended: time [s] and shares.
const GRACE: Duration = Duration::from_secs(2);
const GRACE_SHARE: f64 = 0.2;
/// Of what the system allows the process, this share is used: the system ends a process without a word.
const SYSTEM_SHARE: f64 = 0.75;
/// Bytes of a gigabyte and of a kilobyte, as the system counts them.
const GIGABYTE: f64 = 1e9;
const KILOBYTE: f64 = 1024.0;

/// Whether Ctrl-C was pressed; it ends every run of the program.
static INTERRUPTED: AtomicBool = AtomicBool::new(false);
/// Whether the system asked to terminate (SIGTERM), as job schedulers do at the end of a run's time.
static TERMINATED: OnceLock<Arc<AtomicBool>> = OnceLock::new();

/// The bounds of one run; they end when this is dropped.
#[derive(Debug)]
pub(crate) struct Bounds {
    /// The first limit that was reached, as a number; 0 for none.
    reached: Arc<AtomicU8>,
    /// Set once the run is to end, for what looks within a step.
    asked: Arc<AtomicBool>,
    over: Arc<AtomicBool>,
}

impl Bounds {
    /// Watches the run `name` from now on.
    pub(crate) fn watch(name: &'static str, limits: &LimitArguments) -> Self {
        listen();
        let reached = Arc::new(AtomicU8::new(0));
        let [asked, over] = [(); 2].map(|()| Arc::new(AtomicBool::new(false)));
        let watcher = Watcher {
            name,
            limits: limits.clone(),
            system: SystemLimits::read(),
            start: Instant::now(),
            reached: Arc::clone(&reached),
            asked: Arc::clone(&asked),
            over: Arc::clone(&over),
        };
        // A system without threads to spare lets the run go on unwatched.
        let _ = thread::Builder::new()
            .name("bounds".to_owned())
            .spawn(move || watcher.run());
        Self {
            reached,
            asked,
            over,
        }
    }

    /// The request to end for a solver, which looks for it within a step too.
    pub(crate) fn interrupt(&self) -> Interrupt {
        Interrupt::by(Arc::clone(&self.asked))
    }

    /// Why the run is to end, if it is.
    pub(crate) fn asked(&self) -> Option<Stop> {
        asked_from_outside().or_else(|| Stop::of(self.reached.load(Ordering::Relaxed)))
    }
}

/// The signal that asked every run of the program to end, if one did.
pub(crate) fn asked_from_outside() -> Option<Stop> {
    if INTERRUPTED.load(Ordering::Relaxed) {
        return Some(Stop::Interrupt);
    }
    let asked = TERMINATED.get()?.load(Ordering::Relaxed);
    asked.then_some(Stop::Terminate)
}

impl Drop for Bounds {
    fn drop(&mut self) {
        self.over.store(true, Ordering::Relaxed);
    }
}

/// The first Ctrl-C asks the run to end, the second one ends the program.
pub(crate) fn listen() {
    static LISTENING: OnceLock<()> = OnceLock::new();
    LISTENING.get_or_init(|| {
        // Where the system refuses a handler, Ctrl-C ends the program as it does everywhere else.
        let _ = ctrlc::set_handler(|| {
            if INTERRUPTED.swap(true, Ordering::Relaxed) {
                process::exit(ENDED);
            }
        });
        listen_for_termination();
    });
}

/// The first SIGTERM asks the run to end, the second one ends the program.
fn listen_for_termination() {
    #[cfg(unix)]
    {
        use signal_hook::consts::SIGTERM;
        use signal_hook::flag::{register, register_conditional_shutdown};
        let asked = TERMINATED.get_or_init(Arc::default);
        // In this order the second signal finds what the first one left.
        let _ = register_conditional_shutdown(SIGTERM, ENDED, Arc::clone(asked))
            .and_then(|_| register(SIGTERM, Arc::clone(asked)));
    }
}

/// What looks at the limits beside a run.
struct Watcher {
    name: &'static str,
    limits: LimitArguments,
    system: SystemLimits,
    start: Instant,
    reached: Arc<AtomicU8>,
    asked: Arc<AtomicBool>,
    over: Arc<AtomicBool>,
}

impl Watcher {
    fn run(self) {
        while !self.over.load(Ordering::Relaxed) {
            if asked_from_outside().is_some() {
                self.asked.store(true, Ordering::Relaxed);
            }
            for (used, limit, grace, stop) in self.budgets() {
                if used > limit {
                    let (none, this) = (0, stop as u8);
                    let _ = self.reached.compare_exchange(
                        none,
                        this,
                        Ordering::Relaxed,
                        Ordering::Relaxed,
                    );
                    self.asked.store(true, Ordering::Relaxed);
                }
                if used > limit + grace && !self.over.load(Ordering::Relaxed) {
                    complain(&format!(
                        "{}: {}: {}; the step under way did not end in time, so there is no result",
                        self.name,
                        stop.name(),
                        stop.diagnosis(&self.limits)
                    ));
                    process::exit(i32::from(NOT_CONVERGED));
                }
            }
            thread::sleep(INTERVAL);
        }
    }

    /// What is limited: used, limit, grace.
    fn budgets(&self) -> Vec<(f64, f64, f64, Stop)> {
        let mut budgets = Vec::with_capacity(4);
        if let Some(limit) = self.limits.time_limit {
            let grace = GRACE.as_secs_f64() + GRACE_SHARE * limit;
            budgets.push((self.start.elapsed().as_secs_f64(), limit, grace, Stop::Time));
        }
        if let (Some(limit), Ok(used)) = (self.system.cpu_seconds, ProcessTime::try_now()) {
            let limit = SYSTEM_SHARE * limit;
            budgets.push((
                used.as_duration().as_secs_f64(),
                limit,
                GRACE_SHARE * limit,
                Stop::SystemTime,
            ));
        }
        let memory = Memory::read();
        if let Some(used) = memory.resident {
            let limit = GIGABYTE * self.limits.memory_limit;
            budgets.push((used, limit, GRACE_SHARE * limit, Stop::Memory));
        }
        if let (Some(limit), Some(used)) = (self.system.address_space, memory.reserved) {
            let limit = SYSTEM_SHARE * limit;
            budgets.push((used, limit, GRACE_SHARE * limit, Stop::Memory));
        }
        budgets
    }
}

/// What the system allows this process (`ulimit`), where it tells.
#[derive(Debug, Clone, Copy, Default)]
struct SystemLimits {
    /// CPU time [s].
    cpu_seconds: Option<f64>,
    /// Address space [bytes].
    address_space: Option<f64>,
}

impl SystemLimits {
    fn read() -> Self {
        fs::read_to_string("/proc/self/limits")
            .map_or_else(|_| Self::default(), |text| Self::of(&text))
    }

    /// From lines such as `Max cpu time    60    unlimited    seconds`; the first number is in force.
    fn of(text: &str) -> Self {
        let of = |name: &str| {
            let line = text.lines().find_map(|line| line.strip_prefix(name))?;
            line.split_whitespace().next()?.parse().ok()
        };
        Self {
            cpu_seconds: of("Max cpu time"),
            address_space: of("Max address space"),
        }
    }
}

/// What the process takes, where the system tells [bytes].
#[derive(Debug, Clone, Copy, Default)]
struct Memory {
    /// In memory.
    resident: Option<f64>,
    /// Address space.
    reserved: Option<f64>,
}

impl Memory {
    fn read() -> Self {
        fs::read_to_string("/proc/self/status")
            .map_or_else(|_| Self::default(), |text| Self::of(&text))
    }

    /// From lines such as `VmRSS:    1234 kB`.
    fn of(text: &str) -> Self {
        let of = |name: &str| {
            let line = text.lines().find_map(|line| line.strip_prefix(name))?;
            let kilobytes: f64 = line.split_whitespace().next()?.parse().ok()?;
            Some(KILOBYTE * kilobytes)
        };
        Self {
            resident: of("VmRSS:"),
            reserved: of("VmSize:"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{Memory, SystemLimits};

    #[test]
    fn limits_of_the_system_are_the_numbers_in_force() {
        let limits = SystemLimits::of(
            "Limit                     Soft Limit           Hard Limit           Units\n\
             Max cpu time              70                   90                   seconds\n\
             Max address space         unlimited            unlimited            bytes\n",
        );
        assert_eq!(limits.cpu_seconds, Some(70.0));
        assert_eq!(limits.address_space, None);
    }

    #[test]
    fn memory_is_read_in_bytes() {
        let memory = Memory::of("Name:\tx\nVmSize:\t     300 kB\nVmRSS:\t      20 kB\n");
        assert_eq!(memory.resident, Some(20.0 * 1024.0));
        assert_eq!(memory.reserved, Some(300.0 * 1024.0));
        assert_eq!(Memory::of("").resident, None);
    }
}
