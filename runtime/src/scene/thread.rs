//! Where texts are read: their expressions and places are remembered by the thread.

use std::io;
#[cfg(not(target_family = "wasm"))]
use std::{panic, thread};

/// Stack for a derivation, whose recursion is bounded.
#[cfg(not(target_family = "wasm"))]
const STACK: usize = 64 << 20;

/// Does work on a text on a thread of its own, whose stack is known, and whose memory of expressions and places ends
/// with it; it gets the name of the scene.
///
/// # Errors
/// There is no thread for it.
#[cfg(not(target_family = "wasm"))]
pub fn on_a_thread<T: Send>(name: &str, work: impl FnOnce(&str) -> T + Send) -> io::Result<T> {
    let done = thread::scope(|scope| {
        let worker = thread::Builder::new().stack_size(STACK);
        let worker = worker.spawn_scoped(scope, || work(name));
        worker.map(|worker| worker.join())
    });
    match done? {
        Ok(value) => Ok(value),
        Err(panic) => panic::resume_unwind(panic),
    }
}

/// Does work on a text where there are no threads: on the stack of the host, whose memory of places is given back.
///
/// # Errors
/// None.
#[cfg(target_family = "wasm")]
pub fn on_a_thread<T: Send>(name: &str, work: impl FnOnce(&str) -> T + Send) -> io::Result<T> {
    let done = work(name);
    hangtime_dsl::forget_places();
    Ok(done)
}
