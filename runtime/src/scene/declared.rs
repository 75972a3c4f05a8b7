//! What a scene is to the one model of all.

use super::data::Structure;
use crate::model::{Explicit, Tape};
use std::any::Any;
use std::borrow::Cow;
use std::sync::{Arc, Mutex};

/// A scene whose functions are kernels: what [`model!`](crate::model!) implements.
pub trait Scene: Clone + Send + Sync + 'static {
    /// What it declares, and of which kernels it consists. Of a compiled scene it is a constant, so that kernels are called by their names.
    fn structure(&self) -> &'static Structure;

    /// The declaration with the text that it follows from.
    fn declared(&self) -> &Declared;

    /// A number that kernels read besides their inputs: a parameter, in its unit, and behind those for each equation of a joint
    /// whether it is held, 1 or 0. Not a number where there is none.
    fn number(&self, index: usize) -> f64;

    /// Sets one of the [numbers](Self::number).
    fn set_number(&mut self, index: usize, value: f64);

    /// Evaluates a kernel at an input vector `x`, with multipliers or unknowns `y`.
    fn evaluate(&self, kernel: usize, x: &[f64], y: &[f64], out: &mut [f64]);

    /// The operations of an explicit function; `None` where they are not known.
    fn tape(&self, _function: Explicit) -> Option<Tape<'_>> {
        None
    }

    /// The experiment whose start it has, if it is in one.
    fn experiment(&self) -> Option<usize> {
        None
    }

    /// What its copies share, if it was read from a text.
    fn shared(&self) -> Option<Derived> {
        None
    }
}

/// What was derived from a text and is shared.
pub type Derived = Arc<dyn Any + Send + Sync>;

/// A scene as it was declared.
#[derive(Debug)]
pub struct Declared {
    pub(super) structure: &'static Structure,
    pub(super) text: Cow<'static, str>,
    /// Derived once more, in all ways that were asked for, and by which parameters (indices).
    known: Mutex<Vec<(Again, Vec<usize>, Derived)>>,
}

/// What parameters are in a scene that is derived once more.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Again {
    /// What they were.
    Same,
    /// Functions have derivatives by them.
    Differentiated,
    /// They are coordinates without motion.
    Held,
}

impl Declared {
    /// What follows from a text.
    #[must_use]
    pub const fn new(structure: &'static Structure, text: &'static str) -> Self {
        Self {
            structure,
            text: Cow::Borrowed(text),
            known: Mutex::new(Vec::new()),
        }
    }

    pub(super) fn of_text(structure: Structure, text: &str) -> Self {
        Self {
            structure: Box::leak(Box::new(structure)),
            text: Cow::Owned(text.to_owned()),
            known: Mutex::default(),
        }
    }

    /// What was derived so, if it was.
    pub(super) fn find(&self, again: Again, parameters: &[usize]) -> Option<Derived> {
        let known = self.known.lock().ok()?;
        let mut known = known.iter();
        let (_, _, shared) = known.find(|(kind, of, _)| *kind == again && of == parameters)?;
        Some(Arc::clone(shared))
    }

    pub(super) fn keep(&self, again: Again, parameters: &[usize], derived: Derived) {
        if let Ok(mut known) = self.known.lock() {
            known.push((again, parameters.to_vec(), derived));
        }
    }
}
