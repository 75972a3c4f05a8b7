//! Limits and observer of a whole solve, and its totals.

use crate::clock::Instant;
use crate::seconds::Seconds;

use super::Settings;
use crate::nlp::{self, InputError, IterationInfo, Observer};
use crate::until::Until;

/// What an interior point run is for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Purpose {
    /// The relaxed problem.
    Relaxed,
    /// The smooth program that remains when sides are fixed.
    Crossover,
}

/// Every interior point run of a solve goes through here: the caller's observer sees its iterations, and the limits
/// are those of the whole solve.
pub(crate) struct Watch<'o> {
    observer: &'o mut Observer<'o>,
    start: Instant,
    maximum_seconds: f64,
    interrupt: nlp::Interrupt,
    maximum_iterations: usize,
    /// The limit of the whole solve, of which `maximum_iterations` may be a part.
    all_iterations: usize,
    /// Iterations of relaxed runs and crossovers.
    pub(crate) iterations: usize,
    pub(crate) crossover_iterations: usize,
    pub(crate) certificate_iterations: usize,
    pub(crate) factorizations: usize,
    pub(crate) cpu: Seconds,
    /// Why the whole solve has to end, once it has to.
    pub(crate) stop: Option<nlp::Status>,
}

impl<'o> Watch<'o> {
    pub(crate) fn new(settings: &Settings, observer: &'o mut Observer<'o>) -> Self {
        Self {
            observer,
            start: Instant::now(),
            maximum_seconds: settings.interior_point.maximum_seconds,
            interrupt: settings.interior_point.interrupt.clone(),
            maximum_iterations: settings.maximum_iterations,
            all_iterations: settings.maximum_iterations,
            iterations: 0,
            crossover_iterations: 0,
            certificate_iterations: 0,
            factorizations: 0,
            cpu: Seconds::default(),
            stop: None,
        }
    }

    /// Changes the limit of iterations; whether there are some left for another run.
    pub(crate) fn limit(&mut self, most: usize) -> bool {
        self.maximum_iterations = most;
        if self.stop == Some(nlp::Status::IterationLimit) && self.iterations_left() > 0 {
            self.stop = None;
        }
        self.stop.is_none()
    }

    /// Some work with the limit of the whole solve: an exact point is worth its certificate, whatever part its path may take.
    pub(crate) fn with_all<T>(&mut self, work: impl FnOnce(&mut Self) -> T) -> T {
        let part = self.maximum_iterations;
        self.limit(self.all_iterations);
        let result = work(self);
        self.maximum_iterations = part;
        if self.stop.is_none() && self.iterations_left() == 0 {
            self.stop = Some(nlp::Status::IterationLimit);
        }
        result
    }

    /// Iterations of all runs and certificates so far.
    pub(crate) fn used(&self) -> usize {
        self.iterations + self.certificate_iterations
    }

    /// Until when the factorizations of a linear program may work.
    pub(crate) fn until(&self) -> Until {
        let left = self.maximum_seconds - self.start.elapsed().as_secs_f64();
        Until::new(&self.interrupt, left)
    }

    fn iterations_left(&self) -> usize {
        self.maximum_iterations.saturating_sub(self.used())
    }

    /// A run within what is left of the limits. `call` starts it with the settings and the observer it is given;
    /// `own` sees each iteration too and may end this run alone.
    pub(crate) fn run(
        &mut self,
        purpose: Purpose,
        settings: &nlp::Settings,
        own: &mut dyn FnMut(&IterationInfo) -> bool,
        call: impl FnOnce(&nlp::Settings, &mut Observer<'_>) -> Result<nlp::Solution, InputError>,
    ) -> Result<nlp::Solution, InputError> {
        let left = self.iterations_left();
        let seconds = self.maximum_seconds - self.start.elapsed().as_secs_f64();
        let settings = nlp::Settings {
            maximum_iterations: settings.maximum_iterations.min(left),
            maximum_seconds: seconds.max(f64::MIN_POSITIVE),
            ..settings.clone()
        };
        let mut interrupted = self.stop == Some(nlp::Status::Interrupted);
        let mut observer = |info: &IterationInfo| {
            interrupted |= !(self.observer)(info);
            !interrupted && own(info)
        };
        let solution = call(&settings, &mut observer)?;
        self.factorizations += solution.counts.factorizations;
        self.cpu += solution.cpu;
        let iterations = solution.counts.iterations;
        match purpose {
            Purpose::Relaxed => self.iterations += iterations,
            Purpose::Crossover => {
                self.iterations += iterations;
                self.crossover_iterations += iterations;
            }
        }
        if interrupted || self.interrupt.is_asked() {
            self.stop = Some(nlp::Status::Interrupted);
        } else if solution.status == nlp::Status::TimeLimit {
            self.stop = Some(nlp::Status::TimeLimit);
        } else if solution.status == nlp::Status::IterationLimit && iterations >= left {
            self.stop = Some(nlp::Status::IterationLimit);
        }
        Ok(solution)
    }

    /// Counts an iteration of a linear program of the certificate; `false` if the solve has to end.
    pub(crate) fn certificate_iteration(&mut self, info: &IterationInfo) -> bool {
        if self.stop.is_none() && self.iterations_left() == 0 {
            self.stop = Some(nlp::Status::IterationLimit);
        }
        if self.stop.is_some() {
            return false;
        }
        self.certificate_iterations += 1;
        self.factorizations += 1;
        if !(self.observer)(info) || self.interrupt.is_asked() {
            self.stop = Some(nlp::Status::Interrupted);
        } else if self.start.elapsed().as_secs_f64() >= self.maximum_seconds {
            self.stop = Some(nlp::Status::TimeLimit);
        }
        self.stop.is_none()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn with_all_goes_beyond_a_part_and_leaves_it_used_up() {
        let settings = Settings {
            maximum_iterations: 5,
            ..Settings::default()
        };
        let mut observer = |_: &IterationInfo| true;
        let mut watch = Watch::new(&settings, &mut observer);
        let info = IterationInfo::default();
        watch.limit(2);
        while watch.certificate_iteration(&info) {}
        assert_eq!(watch.certificate_iterations, 2);
        assert_eq!(watch.stop, Some(nlp::Status::IterationLimit));
        // the certificate of an exact point that the part led to
        let goes_on = watch.with_all(|watch| watch.certificate_iteration(&info));
        assert!(goes_on);
        assert_eq!(watch.certificate_iterations, 3);
        assert_eq!(watch.stop, Some(nlp::Status::IterationLimit));
        // the rest belongs to the next path
        assert!(watch.limit(5));
        while watch.certificate_iteration(&info) {}
        assert_eq!(watch.certificate_iterations, 5);
        assert!(!watch.limit(5));
    }
}
