//! A kernel as a program: what depends on parameters only is computed when those are set; the rest is grouped into runs of
//! equal operations, so that the processor decides once a run, and not once an operation, what to do.

use hangtime_dsl::description::{Function, Function2, Kernel, Operation};
use std::collections::{BTreeMap, VecDeque};
use std::ops::Range;

/// The values of a program; an index of 16 bits needs no check.
pub(crate) type Registers = [f64; 1 << 16];

/// A kernel as runs of equal operations on registers.
#[derive(Debug)]
pub(crate) struct Program {
    /// What depends on parameters only.
    folding: Folding,
    /// Where the folded values stand among those of all programs of a scene.
    pub(crate) folded: Range<usize>,
    /// Components of the input vector, and their registers.
    inputs: Vec<(u32, u16)>,
    /// The same for the second vector.
    weights: Vec<(u32, u16)>,
    runs: Vec<Run>,
    /// Result and operands of each operation, in order of evaluation.
    registers: Vec<[u16; 3]>,
    /// Registers of the outputs.
    outputs: Vec<u16>,
}

/// Operations on parameters and constants.
#[derive(Debug)]
struct Folding {
    /// Operands are positions in this list.
    operations: Vec<Operation>,
    /// Positions of the values that the rest of the program reads; they fill the first registers.
    kept: Vec<u32>,
}

/// Equal operations, one after the other.
#[derive(Debug)]
struct Run {
    kind: Kind,
    length: usize,
}

/// What is done with one or two numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Kind {
    Add,
    Subtract,
    Multiply,
    Divide,
    Negate,
    Root,
    Call(Function),
    Call2(Function2),
    /// Sine and cosine of one number, by one call; the second register is another result.
    SineAndCosine,
}

/// A kernel has too many values for the registers.
#[derive(Debug)]
pub(crate) struct TooLarge;

impl Program {
    /// The program of a kernel, whose folded values stand behind `before` others.
    pub(crate) fn new(kernel: &Kernel, before: usize) -> Result<Self, TooLarge> {
        let operations = &kernel.operations;
        let mut constant = vec![false; operations.len()];
        for (at, &operation) in operations.iter().enumerate() {
            constant[at] = match operation {
                Operation::Input(_) | Operation::Weight(_) => false,
                known => known.operands().all(|part| constant[part as usize]),
            };
        }
        let mut uses = vec![0_usize; operations.len()];
        for (at, operation) in operations.iter().enumerate() {
            if !constant[at] {
                for part in operation.operands() {
                    uses[part as usize] += 1;
                }
            }
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
        let mut given = [Vec::new(), Vec::new()];
        for (at, &operation) in operations.iter().enumerate() {
            match operation {
                Operation::Input(i) => given[0].push((i, places.take(at)?)),
                Operation::Weight(i) => given[1].push((i, places.take(at)?)),
                _ => {}
            }
        }
        let cosines = cosines(operations, &constant);
        let order = schedule(operations, &constant, &cosines);
        let mut runs: Vec<Run> = Vec::new();
        let mut registers = Vec::with_capacity(order.len());
        for (at, kind) in order {
            match runs.last_mut() {
                Some(run) if run.kind == kind => run.length += 1,
                _ => runs.push(Run { kind, length: 1 }),
            }
            let cosine = cosines.of_sine(at);
            let mut parts = operations[at].operands();
            let first = parts.next().unwrap_or_default() as usize;
            let second = parts.next().map_or(first, |part| part as usize);
            let mut operands = [places.of[first], places.of[second]];
            let read = [Some(at), cosine].into_iter().flatten();
            for part in read.flat_map(|at| operations[at].operands()) {
                let part = part as usize;
                uses[part] -= 1;
                if uses[part] == 0 && !constant[part] {
                    places.free.push(places.of[part]);
                }
            }
            let result = places.take(at)?;
            if let Some(cosine) = cosine {
                operands[1] = places.take(cosine)?;
            }
            registers.push([result, operands[0], operands[1]]);
        }
        let [inputs, weights] = given;
        Ok(Self {
            folded: before..before + folding.kept.len(),
            folding,
            inputs,
            weights,
            runs,
            registers,
            outputs: kernel
                .outputs
                .iter()
                .map(|&at| places.of[at as usize])
                .collect(),
        })
    }

    /// The values that depend on parameters only.
    pub(crate) fn fold<'a>(&'a self, parameters: &[f64]) -> impl Iterator<Item = f64> + 'a {
        let mut values: Vec<f64> = Vec::with_capacity(self.folding.operations.len());
        for &operation in &self.folding.operations {
            let at = |part: u32| values[part as usize];
            let value = match operation {
                Operation::Parameter(i) => parameters[i as usize],
                Operation::Constant(value) => value,
                Operation::Input(_) | Operation::Weight(_) => f64::NAN,
                Operation::Add(a, b) => at(a) + at(b),
                Operation::Subtract(a, b) => at(a) - at(b),
                Operation::Multiply(a, b) => at(a) * at(b),
                Operation::Divide(a, b) => at(a) / at(b),
                Operation::Negate(a) => -at(a),
                Operation::Root(a) => at(a).sqrt(),
                Operation::Call(function, a) => function.value(at(a)),
                Operation::Call2(function, a, b) => function.value(at(a), at(b)),
            };
            values.push(value);
        }
        self.folding.kept.iter().map(move |&at| values[at as usize])
    }

    /// Evaluates it; `folded` are its values that depend on parameters only.
    pub(crate) fn run(
        &self,
        folded: &[f64],
        (x, y): (&[f64], &[f64]),
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
        let mut rest = &self.registers[..];
        for run in &self.runs {
            let (now, later) = rest.split_at(run.length);
            rest = later;
            match run.kind {
                Kind::Add => each(now, r, |a, b| a + b),
                Kind::Subtract => each(now, r, |a, b| a - b),
                Kind::Multiply => each(now, r, |a, b| a * b),
                Kind::Divide => each(now, r, |a, b| a / b),
                Kind::Negate => each(now, r, |a, _| -a),
                Kind::Root => each(now, r, |a, _| a.sqrt()),
                Kind::Call(function) => each(now, r, |a, _| function.value(a)),
                Kind::Call2(function) => each(now, r, |a, b| function.value(a, b)),
                Kind::SineAndCosine => {
                    for &[sine, a, cosine] in now {
                        let values = r[usize::from(a)].sin_cos();
                        (r[usize::from(sine)], r[usize::from(cosine)]) = values;
                    }
                }
            }
        }
        for (value, &register) in out.iter_mut().zip(&self.outputs) {
            *value = r[usize::from(register)];
        }
    }
}

/// One operation on many registers.
#[inline(always)]
fn each(registers: &[[u16; 3]], r: &mut Registers, operation: impl Fn(f64, f64) -> f64) {
    for &[result, a, b] in registers {
        r[usize::from(result)] = operation(r[usize::from(a)], r[usize::from(b)]);
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

/// Which sines are evaluated together with a cosine.
struct Cosines {
    of_sine: BTreeMap<usize, usize>,
    sine_of: BTreeMap<usize, usize>,
}

impl Cosines {
    fn of_sine(&self, sine: usize) -> Option<usize> {
        self.of_sine.get(&sine).copied()
    }
}

/// The sines and cosines of the same numbers.
fn cosines(operations: &[Operation], constant: &[bool]) -> Cosines {
    let calls = |wanted: Function| {
        let found = operations.iter().enumerate();
        found.filter_map(move |(at, operation)| match *operation {
            Operation::Call(function, of) if function == wanted && !constant[at] => Some((of, at)),
            _ => None,
        })
    };
    let sines: BTreeMap<u32, usize> = calls(Function::Sin).collect();
    let pairs = calls(Function::Cos).filter_map(|(of, cosine)| Some((*sines.get(&of)?, cosine)));
    let of_sine: BTreeMap<usize, usize> = pairs.collect();
    Cosines {
        sine_of: of_sine
            .iter()
            .map(|(&sine, &cosine)| (cosine, sine))
            .collect(),
        of_sine,
    }
}

/// The operations that are left to do, such that equal ones follow each other where possible.
fn schedule(operations: &[Operation], constant: &[bool], cosines: &Cosines) -> Vec<(usize, Kind)> {
    let kind = |at: usize| match cosines.of_sine(at) {
        Some(_) => Some(Kind::SineAndCosine),
        None => Kind::of(operations[at]),
    };
    let mut users: Vec<Vec<usize>> = vec![Vec::new(); operations.len()];
    let mut waits = vec![0_usize; operations.len()];
    let mut ready: BTreeMap<Kind, VecDeque<usize>> = BTreeMap::new();
    for (at, operation) in operations.iter().enumerate() {
        let Some(kind) = kind(at).filter(|_| !constant[at]) else {
            continue;
        };
        for part in operation.operands() {
            let part = part as usize;
            if !constant[part] && !operations[part].is_given() {
                users[part].push(at);
                waits[at] += 1;
            }
        }
        if waits[at] == 0 && !cosines.sine_of.contains_key(&at) {
            ready.entry(kind).or_default().push_back(at);
        }
    }
    let mut order = Vec::new();
    // The kind of which most are ready; of what it makes ready, its own kind follows in the same run.
    while let Some((&now, _)) = ready
        .iter()
        .filter(|(_, waiting)| !waiting.is_empty())
        .max_by_key(|(_, waiting)| waiting.len())
    {
        while let Some(at) = ready.get_mut(&now).and_then(VecDeque::pop_front) {
            order.push((at, now));
            let done = [Some(at), cosines.of_sine(at)].into_iter().flatten();
            for &user in done.flat_map(|at| &users[at]) {
                waits[user] -= 1;
                // A cosine follows from its sine.
                if waits[user] == 0
                    && !cosines.sine_of.contains_key(&user)
                    && let Some(kind) = kind(user)
                {
                    ready.entry(kind).or_default().push_back(user);
                }
            }
        }
    }
    order
}

impl Kind {
    fn of(operation: Operation) -> Option<Self> {
        Some(match operation {
            Operation::Parameter(_)
            | Operation::Input(_)
            | Operation::Weight(_)
            | Operation::Constant(_) => return None,
            Operation::Add(..) => Self::Add,
            Operation::Subtract(..) => Self::Subtract,
            Operation::Multiply(..) => Self::Multiply,
            Operation::Divide(..) => Self::Divide,
            Operation::Negate(_) => Self::Negate,
            Operation::Root(_) => Self::Root,
            Operation::Call(function, _) => Self::Call(function),
            Operation::Call2(function, ..) => Self::Call2(function),
        })
    }
}
