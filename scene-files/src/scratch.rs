//! Memory of a thread for the evaluation of programs, so that no call allocates.

use crate::run::Registers;
use crate::system::Solution;
use std::cell::Cell;

/// Registers, and vectors and matrices for linear systems.
#[derive(Debug)]
pub(crate) struct Scratch {
    pub(crate) registers: Box<Registers>,
    /// Values of a kernel on their way elsewhere.
    pub(crate) values: Vec<f64>,
    /// Values of a second kernel.
    pub(crate) others: Vec<f64>,
    pub(crate) solution: Solution,
}

thread_local! {
    static SCRATCH: Cell<Option<Box<Scratch>>> = const { Cell::new(None) };
}

impl Scratch {
    fn new() -> Option<Box<Self>> {
        // Made on the heap: half a megabyte may be more than the stack has left.
        let registers = vec![0.0; 1 << 16].into_boxed_slice().try_into().ok()?;
        Some(Box::new(Self {
            registers,
            values: Vec::new(),
            others: Vec::new(),
            solution: Solution::default(),
        }))
    }

    /// Lends the memory of this thread. Inlined: what `work` captures would go through memory, where the processor waits for
    /// what was just written in parts and is read as a whole, longer than a short kernel takes.
    #[inline(always)]
    pub(crate) fn lend<T>(work: impl FnOnce(&mut Self) -> T) -> Option<T> {
        let mut scratch = SCRATCH.take().or_else(Self::new)?;
        let result = work(&mut scratch);
        SCRATCH.set(Some(scratch));
        Some(result)
    }
}
