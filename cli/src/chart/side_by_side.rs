//! Independent pieces of a chart, as many at a time as the machine has cores.

use std::num::NonZero;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};
use std::thread;

use crate::bounds::Bounds;
use crate::failure::BadInput;
use crate::progress::Progress;

/// How many pieces are worked on at a time.
pub(super) fn workers() -> usize {
    thread::available_parallelism().map_or(1, NonZero::get)
}

/// What `each` makes of the pieces, in their order, under a bar with a title that says what is done; without the last
/// ones where a bound is reached.
pub(super) fn side_by_side<T: Sync, R: Send>(
    title: &str,
    pieces: &[T],
    bounds: &Bounds,
    says: impl Fn(&T) -> String + Sync,
    each: impl Fn(&T) -> Result<R, BadInput> + Sync,
) -> Result<Vec<R>, BadInput> {
    let progress = Mutex::new(Progress::new(title, pieces.len() as f64));
    let next = AtomicUsize::new(0);
    let worker = || {
        let mut own = Vec::new();
        loop {
            let index = next.fetch_add(1, Ordering::Relaxed);
            let Some(piece) = pieces.get(index).filter(|_| bounds.asked().is_none()) else {
                return own;
            };
            let show = |reached: usize| {
                let mut progress = progress.lock().unwrap_or_else(PoisonError::into_inner);
                progress.say(&says(piece));
                progress.reach(reached as f64);
            };
            show(index);
            own.push((index, each(piece)));
            show(index + 1);
        }
    };
    let mut done: Vec<(usize, Result<R, BadInput>)> = thread::scope(|scope| {
        let workers: Vec<_> = (0..workers()).map(|_| scope.spawn(worker)).collect();
        let ended = workers.into_iter().map(|worker| worker.join());
        ended
            .flat_map(|own| own.unwrap_or_else(|panic| std::panic::resume_unwind(panic)))
            .collect()
    });
    done.sort_by_key(|(index, _)| *index);
    done.into_iter().map(|(_, result)| result).collect()
}
