//! A kernel as a program: what depends on parameters only is computed when those are set; the rest is grouped into runs of
//! equal steps, so that the processor decides once a run, and not once an operation, what to do.

use super::run::{Registers, Run};
use super::steps::steps;
use hangtime_dsl::description::{Kernel, Operation, Source};
use std::ops::Range;
use std::sync::Arc;

/// A kernel as runs of equal steps on registers.
#[derive(Debug)]
pub(super) struct Program {
    code: Arc<Code>,
    /// Where the folded values stand among those of all programs of a scene.
    pub(super) folded: Range<usize>,
    /// Components of the input vector, and their registers.
    inputs: Vec<(u32, u16)>,
    /// Components of the second vector, and their registers.
    weights: Vec<(u32, u16)>,
    /// Registers of the outputs.
    outputs: Vec<u16>,
}

/// What programs have in common that differ in the components that they read and in the order of their outputs.
#[derive(Debug)]
struct Code {
    /// What depends on parameters only.
    folding: Folding,
    runs: Vec<Run>,
    /// Registers of operations, by their positions in the kernel.
    registers: Vec<u16>,
}

/// Operations on parameters and constants.
#[derive(Debug)]
struct Folding {
    /// Operands are positions in this list.
    operations: Vec<Operation>,
    /// Positions of the values that the rest of the program reads; they fill the first registers.
    kept: Vec<u32>,
}

/// A kernel has too many values to be evaluated without a compiler.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TooLarge;

impl Program {
    /// The program of a kernel, whose folded values stand behind `before` others.
    pub(super) fn new(kernel: &Kernel, before: usize) -> Result<Self, TooLarge> {
        let operations = &kernel.operations;
        let mut constant = vec![false; operations.len()];
        for (at, &operation) in operations.iter().enumerate() {
            constant[at] = match operation {
                Operation::Given(Source::Input(_) | Source::Weight(_)) => false,
                known => known.operands().all(|part| constant[part as usize]),
            };
        }
        let steps = steps(operations, &kernel.outputs, &constant);
        let mut uses = vec![0_usize; operations.len()];
        for &part in steps.iter().flat_map(|step| &step.operands) {
            uses[part] += 1;
        }
        for &output in &kernel.outputs {
            // Outputs are read at the end.
            uses[output as usize] = usize::MAX / 2;
        }
        let (folding, kept) = Folding::new(operations, &constant, &uses);
        let mut places = Places::new(operations.len());
        for &at in &kept {
            places.take(at)?;
        }
        for (at, &operation) in operations.iter().enumerate() {
            if let Operation::Given(Source::Input(_) | Source::Weight(_)) = operation {
                places.take(at)?;
            }
        }
        let mut runs = Vec::new();
        let equal = steps.chunk_by(|one, next| one.kind == next.kind);
        for run in equal {
            let mut registers = Vec::new();
            for step in run {
                let operands: Vec<u16> =
                    step.operands.iter().map(|&part| places.of[part]).collect();
                for &part in &step.operands {
                    uses[part] -= 1;
                    if uses[part] == 0 && !constant[part] {
                        places.free.push(places.of[part]);
                    }
                }
                for &result in &step.results {
                    registers.push(places.take(result)?);
                }
                registers.extend(operands);
            }
            runs.push(Run::new(run[0].kind, &registers));
        }
        let code = Code {
            folding,
            runs,
            registers: places.of,
        };
        let folded = before..before + code.folding.kept.len();
        Ok(Self::of(Arc::new(code), folded, kernel))
    }

    /// The program of a kernel with the operations of another one.
    pub(super) fn like(&self, kernel: &Kernel) -> Self {
        Self::of(Arc::clone(&self.code), self.folded.clone(), kernel)
    }

    fn of(code: Arc<Code>, folded: Range<usize>, kernel: &Kernel) -> Self {
        let register = |at: usize| code.registers[at];
        let mut given = [Vec::new(), Vec::new()];
        for (at, &operation) in kernel.operations.iter().enumerate() {
            match operation {
                Operation::Given(Source::Input(i)) => given[0].push((i, register(at))),
                Operation::Given(Source::Weight(i)) => given[1].push((i, register(at))),
                _ => {}
            }
        }
        let [inputs, weights] = given;
        let outputs = kernel.outputs.iter();
        Self {
            folded,
            inputs,
            weights,
            outputs: outputs.map(|&at| register(at as usize)).collect(),
            code,
        }
    }

    /// The values that depend on parameters only.
    pub(super) fn fold<'a>(&'a self, parameters: &[f64]) -> impl Iterator<Item = f64> + 'a {
        let mut values: Vec<f64> = Vec::with_capacity(self.code.folding.operations.len());
        for &operation in &self.code.folding.operations {
            let given = |source| match source {
                Source::Parameter(i) => parameters[i as usize],
                Source::Constant(value) => value,
                Source::Input(_) | Source::Weight(_) => f64::NAN,
            };
            let value = operation.value(given, |part| values[part as usize]);
            values.push(value);
        }
        self.code
            .folding
            .kept
            .iter()
            .map(move |&at| values[at as usize])
    }

    /// Evaluates it; `folded` are its values that depend on parameters only.
    pub(super) fn run(
        &self,
        folded: &[f64],
        x: &[f64],
        y: &[f64],
        out: &mut [f64],
        r: &mut Registers,
    ) {
        r[..folded.len()].copy_from_slice(folded);
        for &(i, register) in &self.inputs {
            r[usize::from(register)] = x[i as usize];
        }
        for &(i, register) in &self.weights {
            r[usize::from(register)] = y[i as usize];
        }
        for run in &self.code.runs {
            run.go(r);
        }
        for (value, &register) in out.iter_mut().zip(&self.outputs) {
            *value = r[usize::from(register)];
        }
    }
}

impl Folding {
    /// The operations on constants, and the positions in the kernel of those whose values are used by others.
    fn new(operations: &[Operation], constant: &[bool], uses: &[usize]) -> (Self, Vec<usize>) {
        let mut place = vec![0_u32; operations.len()];
        let mut own = Vec::new();
        let mut kept = Vec::new();
        let mut used = Vec::new();
        for (at, &operation) in operations.iter().enumerate() {
            if !constant[at] {
                continue;
            }
            place[at] = own.len() as u32;
            if uses[at] > 0 {
                kept.push(place[at]);
                used.push(at);
            }
            own.push(operation.with_operands(|part| place[part as usize]));
        }
        let folding = Self {
            operations: own,
            kept,
        };
        (folding, used)
    }
}

/// Registers of the values of a kernel.
struct Places {
    of: Vec<u16>,
    /// Registers whose values are not used any more.
    free: Vec<u16>,
    next: usize,
}

impl Places {
    fn new(operations: usize) -> Self {
        Self {
            of: vec![0; operations],
            free: Vec::new(),
            next: 0,
        }
    }

    /// A register for the value of an operation.
    fn take(&mut self, operation: usize) -> Result<u16, TooLarge> {
        let register = match self.free.pop() {
            Some(register) => register,
            None => {
                self.next += 1;
                u16::try_from(self.next - 1).map_err(|_| TooLarge)?
            }
        };
        self.of[operation] = register;
        Ok(register)
    }
}
