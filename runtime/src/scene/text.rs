//! A scene whose functions are evaluated without a compiler.

use super::data::Structure;
use super::declared::{Declared, Derived, Scene};
use super::program::{Program, TooLarge};
use super::run;
use super::tapes::Tapes;
use crate::model::{Explicit, Tape};
use hangtime_dsl::description::Description;
use std::sync::Arc;

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
    experiment: Option<usize>,
}

/// What copies share.
#[derive(Debug)]
pub(super) struct Shared {
    pub(super) declared: Declared,
    kernels: Vec<Program>,
    tapes: Tapes,
    warnings: String,
}

impl TextScene {
    /// The scene of a description, which was derived from `text` with `warnings`, a report.
    ///
    /// # Errors
    /// A kernel is too large.
    pub fn new(description: Description, text: &str, warnings: String) -> Result<Self, TooLarge> {
        let tapes = Tapes::of(&description);
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
            declared: Declared::of_text(structure, text),
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
}

impl Scene for TextScene {
    fn structure(&self) -> &'static Structure {
        self.shared.declared.structure
    }

    fn declared(&self) -> &Declared {
        &self.shared.declared
    }

    fn number(&self, index: usize) -> f64 {
        self.numbers.get(index).copied().unwrap_or(f64::NAN)
    }

    fn set_number(&mut self, index: usize, value: f64) {
        if let Some(number) = self.numbers.get_mut(index) {
            *number = value;
            self.fold();
        }
    }

    #[inline]
    fn evaluate(&self, kernel: usize, x: &[f64], y: &[f64], out: &mut [f64]) {
        let kernel = &self.shared.kernels[kernel];
        let folded = &self.folded[kernel.folded.clone()];
        run::lend(|registers| kernel.run(folded, x, y, out, registers));
    }

    fn tape(&self, function: Explicit) -> Option<Tape<'_>> {
        self.shared.tapes.get(function)
    }

    fn experiment(&self) -> Option<usize> {
        self.experiment
    }

    fn shared(&self) -> Option<Derived> {
        let shared: Derived = Arc::<Shared>::clone(&self.shared);
        Some(shared)
    }
}
