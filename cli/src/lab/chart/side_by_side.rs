//! Independent pieces of a chart, as many at a time as the machine has cores. Each has a thread of its own, since those of a
//! pool take up other pieces while they wait within one, whose clock then runs on.

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
    let progress = Mutex::new((Progress::new(title, pieces.len() as f64), 0.0));
    let next = AtomicUsize::new(0);
    let worker = || {
        let mut own = Vec::new();
        loop {
            let index = next.fetch_add(1, Ordering::Relaxed);
            let Some(piece) = pieces.get(index).filter(|_| bounds.asked().is_none()) else {
                return own;
            };
            let shown = || progress.lock().unwrap_or_else(PoisonError::into_inner);
            shown().0.say(&says(piece));
            own.push((index, each(piece)));
            let (progress, done) = &mut *shown();
            *done += 1.0;
            progress.reach(*done);
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

#[cfg(test)]
mod tests {
    use super::side_by_side;
    use crate::arguments::LimitArguments;
    use crate::bounds::Bounds;
    use crate::failure::BadInput;

    #[test]
    fn pieces_come_back_in_their_order_and_the_first_failure_is_told() {
        let bounds = Bounds::watch("test", &LimitArguments::default());
        let pieces: Vec<u64> = (0..50).collect();
        let squares = |fails: u64| {
            let each = |&piece: &u64| {
                // Later pieces are done before earlier ones.
                std::thread::sleep(std::time::Duration::from_micros(50 * (50 - piece)));
                if piece >= fails {
                    return Err(BadInput::new(format!("piece {piece}")));
                }
                Ok(piece * piece)
            };
            side_by_side("test", &pieces, &bounds, u64::to_string, each)
        };
        let expected: Vec<u64> = pieces.iter().map(|piece| piece * piece).collect();
        assert_eq!(squares(50).unwrap(), expected);
        assert_eq!(squares(7).unwrap_err().to_string(), "piece 7");
    }
}
