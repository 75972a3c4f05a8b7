//! A tape as a Rust function: straight-line arithmetic on slices, in chunks.

use crate::graph::{Sym, Variable};
use crate::scene::CheckedScene;
use crate::tape::{self, Op, Tape};
use std::fmt::Write;

/// Most operations of one emitted function. Larger ones run slower (1.5 to 2 times at 900, as values no
/// longer fit the registers), and rustc with debug information, the default of the dev
/// profile, crashes on functions with some 3000 `let`s (rust-lang/rust#93908).
const CHUNK: usize = 400;

/// One emitted function.
pub(crate) struct Kernel {
    pub(crate) name: String,
    /// Position among all kernels: names of surfaces may make two names of kernels equal.
    index: usize,
    pub(crate) tape: Tape,
    /// Whether it is evaluated again and again, so that its cost is of interest.
    pub(crate) listed: bool,
    /// Whether it reads `(q, v, T)` with the final time `T` instead of the input vector.
    pub(crate) at_the_end: bool,
}

impl Kernel {
    pub(crate) fn new(index: usize, name: &str, outputs: &[Sym], listed: bool) -> Self {
        Self {
            name: name.to_owned(),
            index,
            tape: tape::shortest(outputs),
            listed,
            at_the_end: false,
        }
    }

    /// Name of the emitted function.
    pub(crate) fn function(&self) -> String {
        format!("__{}_{}", self.index, self.name)
    }

    /// The function `fn(p: &Scene, x: &[f64], y: &[f64], out: &mut [f64])`, with `y` the multipliers or
    /// unknowns that the kernel takes besides the input vector.
    pub(crate) fn write(&self, scene: &CheckedScene, code: &mut String) {
        let tape = &self.tape;
        let computed: Vec<usize> = (0..tape.ops.len())
            .filter(|&i| !matches!(tape.ops[i], Op::Load(_) | Op::Constant(_)))
            .collect();
        let function = self.function();
        let signature = format!(
            "p: &{}, x: &[__f64], y: &[__f64], out: &mut [__f64]",
            scene.name.rust()
        );
        // An arm for each output that is an input or a constant goes to the last chunk.
        let plain: Vec<(usize, u32)> = tape
            .outputs
            .iter()
            .enumerate()
            .map(|(slot, &position)| (slot, position))
            .filter(|&(_, position)| {
                matches!(tape.ops[position as usize], Op::Load(_) | Op::Constant(_))
            })
            .collect();
        let chunks: Vec<&[usize]> = computed.chunks(CHUNK).collect();
        let writer = Writer::new(scene, self, &chunks);
        if chunks.len() <= 1 {
            let _ = write!(
                code,
                "#[inline] fn {function}({signature}) {{ {}",
                self.prologue(scene)
            );
            for chunk in &chunks {
                writer.body(0, chunk, code);
            }
            writer.outputs(&plain, code);
            code.push_str("}\n");
            return;
        }
        for (index, chunk) in chunks.iter().enumerate() {
            let _ = write!(
                code,
                "#[inline(never)] fn {function}_{index}({signature}, w: &mut [__f64; {}]) {{ {}",
                writer.crossing,
                self.prologue(scene)
            );
            writer.body(index, chunk, code);
            if index + 1 == chunks.len() {
                writer.outputs(&plain, code);
            }
            code.push_str("}\n");
        }
        let _ = write!(
            code,
            "fn {function}({signature}) {{ let mut w = [0.0_f64; {}];",
            writer.crossing
        );
        for index in 0..chunks.len() {
            let _ = write!(code, "{function}_{index}(p, x, y, out, &mut w);");
        }
        code.push_str("}\n");
    }

    /// One bounds check a slice instead of one an access. Each check between two operations would also
    /// keep the compiler from joining the sine and the cosine of an angle into one call.
    fn prologue(&self, scene: &CheckedScene) -> String {
        let mut lengths = [0; 2];
        for op in &self.tape.ops {
            if let Op::Load(variable) = op {
                match place(scene, *variable, self.at_the_end) {
                    Input::Field(_) => {}
                    Input::Vector(index) => lengths[0] = lengths[0].max(index + 1),
                    Input::Second(index) => lengths[1] = lengths[1].max(index + 1),
                }
            }
        }
        format!(
            "let x = &x[..{}]; let y = &y[..{}]; let out = &mut out[..{}];",
            lengths[0],
            lengths[1],
            self.tape.outputs.len()
        )
    }
}

struct Writer<'a> {
    scene: &'a CheckedScene,
    tape: &'a Tape,
    at_the_end: bool,
    /// Chunk in which each operation is computed.
    home: Vec<usize>,
    /// Place in the workspace of values that later chunks need.
    slot: Vec<Option<usize>>,
    crossing: usize,
    /// Outputs that each operation is.
    outputs: Vec<Vec<usize>>,
}

impl<'a> Writer<'a> {
    fn new(scene: &'a CheckedScene, kernel: &'a Kernel, chunks: &[&[usize]]) -> Self {
        let tape = &kernel.tape;
        let mut home = vec![usize::MAX; tape.ops.len()];
        for (index, chunk) in chunks.iter().enumerate() {
            for &position in *chunk {
                home[position] = index;
            }
        }
        let mut slot = vec![None; tape.ops.len()];
        let mut crossing = 0;
        for (index, chunk) in chunks.iter().enumerate() {
            for &position in *chunk {
                for operand in tape.ops[position].operands() {
                    let operand = operand as usize;
                    if home[operand] != usize::MAX
                        && home[operand] != index
                        && slot[operand].is_none()
                    {
                        slot[operand] = Some(crossing);
                        crossing += 1;
                    }
                }
            }
        }
        let mut outputs = vec![Vec::new(); tape.ops.len()];
        for (index, &position) in tape.outputs.iter().enumerate() {
            outputs[position as usize].push(index);
        }
        Self {
            scene,
            tape,
            at_the_end: kernel.at_the_end,
            home,
            slot,
            crossing,
            outputs,
        }
    }

    fn operand(&self, chunk: usize, position: u32) -> String {
        let index = position as usize;
        match self.tape.ops[index] {
            Op::Load(variable) => load(self.scene, variable, self.at_the_end),
            Op::Constant(bits) => literal(f64::from_bits(bits)),
            _ if self.home[index] == chunk => format!("t{index}"),
            _ => match self.slot[index] {
                Some(slot) => format!("w[{slot}]"),
                None => format!("t{index}"),
            },
        }
    }

    fn body(&self, chunk: usize, positions: &[usize], code: &mut String) {
        for &position in positions {
            let at = |operand| self.operand(chunk, operand);
            let value = match self.tape.ops[position] {
                Op::Load(_) | Op::Constant(_) => continue,
                Op::Add(a, b) => format!("{} + {}", at(a), at(b)),
                Op::Subtract(a, b) => format!("{} - {}", at(a), at(b)),
                Op::Multiply(a, b) => format!("{} * {}", at(a), at(b)),
                Op::Divide(a, b) => format!("{} / {}", at(a), at(b)),
                Op::Negate(a) => format!("-{}", at(a)),
                Op::Root(a) => format!("__f64::sqrt({})", at(a)),
                Op::Call(function, a) => format!("__f64::{}({})", function.name(), at(a)),
                Op::Call2(function, a, b) => {
                    format!("__f64::{}({}, {})", function.name(), at(a), at(b))
                }
            };
            let _ = write!(code, "let t{position} = {value};");
            if let Some(slot) = self.slot[position] {
                let _ = write!(code, "w[{slot}] = t{position};");
            }
            for output in &self.outputs[position] {
                let _ = write!(code, "out[{output}] = t{position};");
            }
        }
    }

    fn outputs(&self, plain: &[(usize, u32)], code: &mut String) {
        for &(slot, position) in plain {
            let _ = write!(code, "out[{slot}] = {};", self.operand(0, position));
        }
    }
}

/// Where a kernel finds a variable.
enum Input {
    /// Among the parameters.
    Field(usize),
    /// In the input vector.
    Vector(usize),
    /// Among the multipliers or unknowns.
    Second(usize),
}

fn place(scene: &CheckedScene, variable: Variable, at_the_end: bool) -> Input {
    let n = scene.coordinates.len();
    let index = |i: u16| usize::from(i);
    match variable {
        Variable::Parameter(i) => Input::Field(index(i)),
        Variable::Coordinate(i) => Input::Vector(index(i)),
        Variable::Velocity(i) => Input::Vector(n + index(i)),
        Variable::Control(i) => Input::Vector(2 * n + index(i)),
        Variable::Time if at_the_end => Input::Vector(2 * n),
        Variable::Time => Input::Vector(2 * n + scene.controls.len()),
        Variable::Multiplier(i) | Variable::Unknown(i) | Variable::Argument(i) => {
            Input::Second(index(i))
        }
    }
}

fn load(scene: &CheckedScene, variable: Variable, at_the_end: bool) -> String {
    match place(scene, variable, at_the_end) {
        Input::Field(i) => scene
            .parameters
            .get(i)
            .map_or_else(String::new, |known| format!("p.{}", known.name.rust())),
        Input::Vector(i) => format!("x[{i}]"),
        Input::Second(i) => format!("y[{i}]"),
    }
}

/// A constant as Rust source, exact to the last bit.
pub(crate) fn literal(value: f64) -> String {
    if value.is_nan() {
        "__f64::NAN".to_owned()
    } else if value == f64::INFINITY {
        "__f64::INFINITY".to_owned()
    } else if value == f64::NEG_INFINITY {
        "__f64::NEG_INFINITY".to_owned()
    } else if value < 0.0 {
        format!("({value:?}_f64)")
    } else {
        format!("{value:?}_f64")
    }
}
