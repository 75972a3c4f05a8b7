//! A kernel as a Rust function: straight-line arithmetic on slices, in chunks.

use crate::description::{Description, Function, Kernel, Operation, Profile, Source};
use crate::words;
use std::fmt::Write;

/// Most operations of one emitted function. Larger ones run slower (1.5 to 2 times at 900, as values no
/// longer fit the registers), and rustc with debug information, the default of the dev
/// profile, crashes on functions with some 3000 `let`s (rust-lang/rust#93908).
const CHUNK: usize = 400;

/// Field of the scene that tells which equations of joints are held, where there are joints.
pub(super) const HELD: &str = "__held";

/// Deepest nesting of operations that are written into each other.
const NESTED: usize = 24;

/// All kernels of the scene called `scene`, and `static __KERNELS`, in which they stand by their index.
pub(super) fn all(description: &Description, scene: &str) -> String {
    let mut code = String::new();
    write_profiles(description, &mut code);
    for index in 0..description.kernels.len() {
        write(description, index, scene, &mut code);
    }
    let count = description.kernels.len();
    let _ = write!(
        code,
        "static __KERNELS: [fn(&{scene}, &[__f64], &[__f64], &mut [__f64]); {count}] = ["
    );
    for index in 0..count {
        let _ = write!(code, "{},", function(description, index));
    }
    code.push_str("];");
    code
}

/// Name of the function of a kernel; names of surfaces may make two names of kernels equal.
fn function(description: &Description, kernel: usize) -> String {
    let name = format!("__{kernel}_{}", description.kernels[kernel].name);
    words::rust_name(&name)
}

/// Writes the function `fn(p: &Scene, x: &[f64], y: &[f64], out: &mut [f64])` of a kernel, with `y` the multipliers or
/// unknowns that the kernel takes besides the input vector.
fn write(description: &Description, index: usize, scene: &str, code: &mut String) {
    let kernel = &description.kernels[index];
    let operations = &kernel.operations;
    let computed: Vec<usize> = (0..operations.len())
        .filter(|&i| !operations[i].is_given())
        .collect();
    let function = function(description, index);
    let signature = format!("__p: &{scene}, __x: &[__f64], __y: &[__f64], __out: &mut [__f64]");
    // An arm for each output that is an input or a constant goes to the last chunk.
    let plain: Vec<(usize, u32)> = kernel
        .outputs
        .iter()
        .enumerate()
        .map(|(slot, &position)| (slot, position))
        .filter(|&(_, position)| operations[position as usize].is_given())
        .collect();
    let chunks: Vec<&[usize]> = computed.chunks(CHUNK).collect();
    let writer = Writer::new(description, kernel, &chunks);
    let prologue = prologue(kernel);
    if chunks.len() <= 1 {
        let _ = write!(code, "fn {function}({signature}) {{ {prologue}");
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
            "#[inline(never)] fn {function}_{index}({signature}, __w: &mut [__f64; {}]) {{ {prologue}",
            writer.crossing
        );
        writer.body(index, chunk, code);
        if index + 1 == chunks.len() {
            writer.outputs(&plain, code);
        }
        code.push_str("}\n");
    }
    let _ = write!(
        code,
        "fn {function}({signature}) {{ let mut __w = [0.0_f64; {}];",
        writer.crossing
    );
    for index in 0..chunks.len() {
        let _ = write!(code, "{function}_{index}(__p, __x, __y, __out, &mut __w);");
    }
    code.push_str("}\n");
}

/// One bounds check a slice instead of one an access. Each check between two operations would also
/// keep the compiler from joining the sine and the cosine of an angle into one call.
fn prologue(kernel: &Kernel) -> String {
    let mut lengths = [0; 2];
    for operation in &kernel.operations {
        match *operation {
            Operation::Given(Source::Input(index)) => lengths[0] = lengths[0].max(index + 1),
            Operation::Given(Source::Weight(index)) => lengths[1] = lengths[1].max(index + 1),
            _ => {}
        }
    }
    format!(
        "let __x = &__x[..{}]; let __y = &__y[..{}]; let __out = &mut __out[..{}];",
        lengths[0],
        lengths[1],
        kernel.outputs.len()
    )
}

struct Writer<'a> {
    description: &'a Description,
    operations: &'a [Operation],
    /// Chunk in which each operation is computed.
    home: Vec<usize>,
    /// Place in the workspace of values that later chunks need.
    slot: Vec<Option<usize>>,
    crossing: usize,
    /// Outputs that each operation is.
    outputs: Vec<Vec<usize>>,
    /// How often each operation is read by others.
    uses: Vec<usize>,
    /// Whether each operation is written where its value is read, once and within its chunk.
    nested: Vec<bool>,
}

impl<'a> Writer<'a> {
    fn new(description: &'a Description, kernel: &'a Kernel, chunks: &[&[usize]]) -> Self {
        let operations = &kernel.operations;
        let mut home = vec![usize::MAX; operations.len()];
        for (index, chunk) in chunks.iter().enumerate() {
            for &position in *chunk {
                home[position] = index;
            }
        }
        let mut slot = vec![None; operations.len()];
        let mut crossing = 0;
        for (index, chunk) in chunks.iter().enumerate() {
            for &position in *chunk {
                for operand in operations[position].operands() {
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
        let mut outputs = vec![Vec::new(); operations.len()];
        for (index, &position) in kernel.outputs.iter().enumerate() {
            outputs[position as usize].push(index);
        }
        let mut uses = vec![0_usize; operations.len()];
        for part in operations.iter().flat_map(|operation| operation.operands()) {
            uses[part as usize] += 1;
        }
        let nested = nested(operations, &kernel.outputs, &home, &uses);
        Self {
            description,
            operations,
            home,
            slot,
            crossing,
            outputs,
            uses,
            nested,
        }
    }

    fn operand(&self, chunk: usize, position: u32) -> String {
        let index = position as usize;
        let parameters = self.description.structure.declaration.parameters;
        match self.operations[index] {
            Operation::Given(Source::Parameter(i)) => match parameters.get(i as usize) {
                Some(known) => format!("__p.{}", words::rust_name(known.name)),
                None => format!("__p.{HELD}[{}]", i as usize - parameters.len()),
            },
            Operation::Given(Source::Input(i)) => format!("__x[{i}]"),
            Operation::Given(Source::Weight(i)) => format!("__y[{i}]"),
            Operation::Given(Source::Constant(value)) => literal(value),
            _ if self.nested[index] => format!("({})", self.value(chunk, index)),
            _ if self.home[index] == chunk => format!("__t{index}"),
            _ => match self.slot[index] {
                Some(slot) => format!("__w[{slot}]"),
                None => format!("__t{index}"),
            },
        }
    }

    /// An operation as an expression.
    fn value(&self, chunk: usize, position: usize) -> String {
        let at = |operand| self.operand(chunk, operand);
        match self.operations[position] {
            Operation::Given(_) => at(position as u32),
            Operation::Add(a, b) => format!("{} + {}", at(a), at(b)),
            Operation::Subtract(a, b) => format!("{} - {}", at(a), at(b)),
            Operation::Multiply(a, b) => format!("{} * {}", at(a), at(b)),
            Operation::Divide(a, b) => format!("{} / {}", at(a), at(b)),
            Operation::Negate(a) => format!("-{}", at(a)),
            Operation::Root(a) => format!("__f64::sqrt({})", at(a)),
            Operation::Call(Function::Profile(profile), a) => {
                format!("{}.value({})", written(self.description, profile), at(a))
            }
            Operation::Call(function @ (Function::Root | Function::InverseRoot), a) => {
                format!("::hangtime::scene::{}({})", function.name(), at(a))
            }
            Operation::Call(function, a) => format!("__f64::{}({})", function.name(), at(a)),
            Operation::Call2(function, a, b) => {
                format!("__f64::{}({}, {})", function.name(), at(a), at(b))
            }
        }
    }

    fn body(&self, chunk: usize, positions: &[usize], code: &mut String) {
        for &position in positions.iter().filter(|&&position| !self.nested[position]) {
            let value = self.value(chunk, position);
            let slot = self.slot[position].map(|slot| format!("__w[{slot}]"));
            let outputs = self.outputs[position].iter();
            let mut places: Vec<String> =
                outputs.map(|output| format!("__out[{output}]")).collect();
            places.extend(slot);
            if self.uses[position] == 0
                && let [only] = &places[..]
            {
                let _ = write!(code, "{only} = {value};");
                continue;
            }
            let _ = write!(code, "let __t{position} = {value};");
            for place in places {
                let _ = write!(code, "{place} = __t{position};");
            }
        }
    }

    fn outputs(&self, plain: &[(usize, u32)], code: &mut String) {
        for &(slot, position) in plain {
            let _ = write!(code, "__out[{slot}] = {};", self.operand(0, position));
        }
    }
}

/// Which operations are written where their values are read: in one other operation of the same chunk, and nowhere else.
fn nested(operations: &[Operation], outputs: &[u32], home: &[usize], uses: &[usize]) -> Vec<bool> {
    let mut nested = vec![false; operations.len()];
    let mut depth = vec![0; operations.len()];
    for (reader, operation) in operations.iter().enumerate() {
        for part in operation.operands().map(|part| part as usize) {
            nested[part] = uses[part] == 1
                && !operations[part].is_given()
                && home[part] == home[reader]
                && depth[part] < NESTED;
            if nested[part] {
                depth[reader] = depth[reader].max(depth[part] + 1);
            }
        }
    }
    for &output in outputs {
        nested[output as usize] = false;
    }
    nested
}

/// A constant as Rust source, exact to the last bit.
pub(super) fn literal(value: f64) -> String {
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

/// The functions given by points that the kernels call, without their derivatives.
pub(super) fn profiles(description: &Description) -> Vec<Profile> {
    let mut profiles: Vec<Profile> = Vec::new();
    let kernels = description.kernels.iter();
    for operation in kernels.flat_map(|kernel| &kernel.operations) {
        if let Operation::Call(Function::Profile(profile), _) = *operation
            && profiles.iter().all(|known| known.name() != profile.name())
        {
            profiles.push(profile);
        }
    }
    profiles
}

/// A function given by points as an expression.
pub(super) fn written(description: &Description, profile: Profile) -> String {
    let mut known = profiles(description).into_iter();
    let place = known.position(|known| known.name() == profile.name());
    let (place, order) = (place.unwrap_or_default(), profile.order());
    format!("::hangtime::scene::tape::Profile::of(&__PROFILES[{place}], {order})")
}

/// Writes the points' polynomials as a static array, if there are any.
fn write_profiles(description: &Description, code: &mut String) {
    let profiles = profiles(description);
    if profiles.is_empty() {
        return;
    }
    code.push_str("static __PROFILES: &[::hangtime::scene::tape::Spline] = &[");
    for (number, profile) in profiles.into_iter().enumerate() {
        let name = profile.name();
        let _ = write!(
            code,
            "::hangtime::scene::tape::Spline::new({number}, {name:?}, &["
        );
        for (from, coefficients) in profile.pieces() {
            let coefficients = coefficients.map(literal).join(", ");
            let _ = write!(code, "({}, [{coefficients}]),", literal(*from));
        }
        code.push_str("]),");
    }
    code.push_str("];");
}
