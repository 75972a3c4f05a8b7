//! A scene whose functions are evaluated without a compiler.

use super::data::Structure;
use super::program::{Program, TooLarge};
use super::run;
use super::solved::View;
use super::tape::{Explicit, Tape};
use hangtime_dsl::description::{Description, Kernel};
use std::borrow::Cow;
use std::collections::HashMap;
use std::sync::{Arc, Mutex};

/// A scene as it was declared.
#[derive(Debug)]
pub struct Declared {
    pub(super) structure: &'static Structure,
    pub(super) text: Cow<'static, str>,
    /// In all ways that were asked for.
    known: Mutex<Vec<Derived>>,
}

/// What was derived once more, how, and by which parameters (indices).
type Derived = (Again, Vec<usize>, Arc<Shared>);

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

    /// What was derived so, if it was.
    pub(super) fn find(&self, again: Again, parameters: &[usize]) -> Option<Arc<Shared>> {
        let known = self.known.lock().ok()?;
        let mut known = known.iter();
        let (_, _, shared) = known.find(|(kind, of, _)| *kind == again && of == parameters)?;
        Some(Arc::clone(shared))
    }

    pub(super) fn keep(&self, again: Again, parameters: &[usize], derived: &Arc<Shared>) {
        if let Ok(mut known) = self.known.lock() {
            known.push((again, parameters.to_vec(), Arc::clone(derived)));
        }
    }
}

/// A scene from a text: a model like those that the compiler makes, with the same operations in the same order.
///
/// Copies share everything but the values of the parameters. Evaluation allocates nothing after the first one of a thread.
#[derive(Debug, Clone)]
pub struct TextScene {
    pub(super) shared: Arc<Shared>,
    /// Parameters, and behind them which equations of joints are held.
    pub(super) numbers: Vec<f64>,
    /// What depends on these only, of all programs.
    folded: Vec<f64>,
    /// The experiment whose start it has, if it is in one.
    pub(super) experiment: Option<usize>,
}

/// What copies of a scene from a text share.
#[derive(Debug)]
pub struct Shared {
    pub(super) declared: Declared,
    kernels: Vec<Program>,
    tapes: HashMap<Explicit, Kernel>,
    warnings: String,
}

impl TextScene {
    /// The scene of a description, which was derived from `text` with `warnings`, a report.
    ///
    /// # Errors
    /// A kernel is too large.
    pub fn new(description: Description, text: &str, warnings: String) -> Result<Self, TooLarge> {
        let tapes = description.explicit_functions().into_iter().collect();
        let mut kernels: Vec<Program> = Vec::with_capacity(description.kernels.len());
        let mut folded = 0;
        for kernel in &description.kernels {
            let program = match kernel.like {
                Some(like) => kernels[like].like(kernel),
                None => Program::new(kernel, folded)?,
            };
            folded = folded.max(program.folded.end);
            kernels.push(program);
        }
        let structure = description.structure;
        let parameters = structure.declaration.parameters.iter();
        let rows = structure.joint_rows();
        let numbers = parameters.map(|known| known.default);
        let numbers = numbers.chain(std::iter::repeat_n(1.0, rows)).collect();
        let shared = Shared {
            declared: Declared {
                structure: Box::leak(Box::new(structure)),
                text: Cow::Owned(text.to_owned()),
                known: Mutex::default(),
            },
            kernels,
            tapes,
            warnings,
        };
        Ok(Self::at(Arc::new(shared), numbers, None))
    }

    /// A scene with these numbers.
    pub(super) fn at(shared: Arc<Shared>, numbers: Vec<f64>, experiment: Option<usize>) -> Self {
        let mut scene = Self {
            shared,
            numbers,
            folded: Vec::new(),
            experiment,
        };
        scene.fold();
        scene
    }

    /// The scene in an experiment.
    pub(super) fn in_start_of(self, experiment: usize) -> Self {
        Self {
            experiment: Some(experiment),
            ..self
        }
    }

    /// What is accepted in its text, but most likely not meant, as a report that shows the lines; empty if there is
    /// nothing.
    #[must_use]
    pub fn warnings(&self) -> &str {
        &self.shared.warnings
    }

    /// The text that it was read from.
    #[must_use]
    pub fn source(&self) -> &str {
        &self.shared.declared.text
    }

    /// Computes what depends on parameters only.
    fn fold(&mut self) {
        self.folded.clear();
        for kernel in &self.shared.kernels {
            // Those of kernels that are like an earlier one stand there.
            if kernel.folded.start == self.folded.len() {
                self.folded.extend(kernel.fold(&self.numbers));
            }
        }
    }

    pub(super) fn number(&self, index: usize) -> f64 {
        self.numbers.get(index).copied().unwrap_or(f64::NAN)
    }

    pub(super) fn set_number(&mut self, index: usize, value: f64) {
        if let Some(number) = self.numbers.get_mut(index) {
            *number = value;
            self.fold();
        }
    }

    #[inline]
    pub(super) fn kernel(&self, kernel: usize, x: &[f64], y: &[f64], out: &mut [f64]) {
        let kernel = &self.shared.kernels[kernel];
        let folded = &self.folded[kernel.folded.clone()];
        run::lend(|registers| kernel.run(folded, x, y, out, registers));
    }

    pub(super) fn tape(&self, function: Explicit) -> Option<Tape<'_>> {
        let stored = self.shared.tapes.get(&function)?;
        Some(Tape {
            operations: &stored.operations,
            outputs: &stored.outputs,
        })
    }

    /// Does what needs all kernels.
    pub(super) fn view<T>(&self, work: impl FnOnce(View<'_>) -> T) -> T {
        work(View {
            structure: self.shared.declared.structure,
            evaluate: &|kernel, x, y, out| self.kernel(kernel, x, y, out),
        })
    }
}
