//! Collects emitted functions and gives the calls of them.

use crate::derive::{Implicit, Sparse};
use crate::emit::kernel::Kernel;
use crate::graph::Sym;
use crate::scene::CheckedScene;
use std::fmt::Write;

pub(super) const PRIVATE: &str = "::hangtime::__private";

/// Pattern of a sparse matrix as emitted.
pub(in crate::emit) struct Pattern {
    pub(in crate::emit) rows: usize,
    pub(in crate::emit) columns: usize,
    pub(in crate::emit) entries: Vec<(usize, usize)>,
}

impl Pattern {
    pub(super) fn of(sparse: &Sparse) -> Self {
        Self {
            rows: sparse.rows,
            columns: sparse.columns,
            entries: sparse.entries.clone(),
        }
    }

    /// The positions as a Rust slice.
    pub(in crate::emit) fn entries(&self) -> String {
        positions(&self.entries)
    }
}

pub(super) fn positions(entries: &[(usize, usize)]) -> String {
    let mut text = String::from("&[");
    for (row, column) in entries {
        let _ = write!(text, "({row}, {column}),");
    }
    text.push(']');
    text
}

pub(super) struct Builder<'a> {
    pub(super) scene: &'a CheckedScene,
    pub(super) inputs: usize,
    pub(super) kernels: Vec<Kernel>,
    pub(super) helpers: String,
}

/// A function of the inputs that solves a linear system: names of what is emitted for it.
pub(super) struct System {
    pub(super) name: String,
    pub(super) size: usize,
}

impl Builder<'_> {
    /// Adds a kernel; the call of it.
    pub(super) fn call(
        &mut self,
        name: &str,
        outputs: &[Sym],
        x: &str,
        y: &str,
        out: &str,
    ) -> String {
        let kernel = Kernel::new(self.kernels.len(), name, outputs, true);
        let call = format!("{}(self, {x}, {y}, {out})", kernel.function());
        self.kernels.push(kernel);
        call
    }

    /// Adds a kernel of the parameters alone, evaluated once.
    pub(super) fn unlisted(&mut self, name: &str, outputs: &[Sym], out: &str) -> String {
        let kernel = Kernel::new(self.kernels.len(), name, outputs, false);
        let call = format!("{}(self, &[], &[], {out})", kernel.function());
        self.kernels.push(kernel);
        call
    }

    /// Emits what a linear system and the derivatives of its solution need.
    pub(super) fn system(&mut self, name: &str, implicit: &Implicit) -> System {
        let (size, inputs) = (implicit.size, self.inputs);
        let scene = self.scene.name.rust();
        let mut system = implicit.matrix.clone();
        system.extend(&implicit.right);
        let solve = self.call(
            &format!("{name}_system"),
            &system,
            "x",
            "&[]",
            "&mut system",
        );
        let mut part = |suffix: &str, sparse: &Sparse| {
            let call = self.call(
                &format!("{name}_{suffix}"),
                &sparse.values,
                "x",
                "y",
                "&mut values",
            );
            (
                call.replace("(self,", "(p,"),
                sparse.values.len(),
                positions(&sparse.entries),
            )
        };
        let (first, first_length, first_pattern) = part("jacobian", &implicit.residual_jacobian);
        let (second, second_length, second_pattern) = part("hessian", &implicit.residual_hessian);
        let (cross, cross_length, cross_pattern) = part("cross", &implicit.cross);
        let _ = write!(
            self.helpers,
            "fn __{name}_solution(p: &{scene}, x: &[__f64]) -> ({PRIVATE}::Lu<{size}>, [__f64; {}]) {{
                let mut system = [0.0_f64; {}]; {};
                let (lu, solution) = {PRIVATE}::solve_system::<{size}>(&system);
                let mut y = [0.0_f64; {}]; y[{size}..].copy_from_slice(&solution);
                (lu, y)
            }}
            fn __{name}_sensitivity(p: &{scene}, x: &[__f64], lu: &{PRIVATE}::Lu<{size}>, y: &[__f64]) -> \
             [[__f64; {inputs}]; {size}] {{
                let mut values = [0.0_f64; {first_length}]; {first};
                {PRIVATE}::sensitivity::<{size}, {inputs}>(lu, {first_pattern}, &values)
            }}
            fn __{name}_second(p: &{scene}, x: &[__f64], lambda: &[__f64; {size}], pattern: &[(__u32, __u32)], \
             out: &mut [__f64]) {{
                let (lu, mut y) = __{name}_solution(p, x);
                let a = __{name}_sensitivity(p, x, &lu, &y);
                y[..{size}].copy_from_slice(&lu.solve_transposed(lambda));
                let y = &y[..];
                let residual = {{ let mut values = [0.0_f64; {second_length}]; {second}; values }};
                let cross = {{ let mut values = [0.0_f64; {cross_length}]; {cross}; values }};
                {PRIVATE}::pull_back::<{size}, {inputs}>(&a, ({second_pattern}, &residual), \
             ({cross_pattern}, &cross), pattern, out)
            }}",
            2 * size,
            system.len(),
            solve.replace("(self,", "(p,"),
            2 * size,
        );
        System {
            name: name.to_owned(),
            size,
        }
    }
}
