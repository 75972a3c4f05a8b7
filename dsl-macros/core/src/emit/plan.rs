//! Which functions are emitted for a scene, and how the methods of the model trait call them.

mod contact;
mod optimal_control;

pub(super) use contact::{ContactPlan, FrictionPlan};
pub(super) use optimal_control::ControlPlan;

use super::kernel::Kernel;
use crate::derive::{Equations, Explicit, Implicit, Solution, Sparse};
use crate::graph::Sym;
use crate::scene::CheckedScene;
use std::fmt::Write;

const PRIVATE: &str = "::hangtime::__private";

/// Pattern of a sparse matrix as emitted.
pub(super) struct Pattern {
    pub(super) rows: usize,
    pub(super) columns: usize,
    pub(super) entries: Vec<(usize, usize)>,
}

impl Pattern {
    fn of(sparse: &Sparse) -> Self {
        Self {
            rows: sparse.rows,
            columns: sparse.columns,
            entries: sparse.entries.clone(),
        }
    }

    /// The positions as a Rust slice.
    pub(super) fn entries(&self) -> String {
        positions(&self.entries)
    }
}

fn positions(entries: &[(usize, usize)]) -> String {
    let mut text = String::from("&[");
    for (row, column) in entries {
        let _ = write!(text, "({row}, {column}),");
    }
    text.push(']');
    text
}

/// All emitted functions and the bodies of the trait's methods.
pub(super) struct Plan {
    pub(super) kernels: Vec<Kernel>,
    /// Further functions as source.
    pub(super) helpers: String,
    pub(super) start: [String; 2],
    pub(super) horizon: String,
    pub(super) bounds: [String; 2],
    pub(super) energy: String,
    pub(super) mass_matrix: String,
    pub(super) free_acceleration: String,
    pub(super) free_jacobian: String,
    pub(super) free_hessian: String,
    pub(super) free_patterns: [Pattern; 2],
    pub(super) contacts: Vec<ContactPlan>,
    pub(super) optimal_control: Option<ControlPlan>,
}

impl Plan {
    pub(super) fn of(scene: &CheckedScene, equations: &Equations) -> Self {
        let mut builder = Builder {
            scene,
            inputs: equations.inputs,
            kernels: Vec::new(),
            helpers: String::new(),
        };
        let (acceleration, jacobian, hessian, free_patterns) =
            builder.free(&equations.acceleration);
        let mass_matrix = builder.call("mass_matrix", &equations.mass, "x", "&[]", "m");
        let energy = builder.call("energy", &equations.energy, "x", "&[]", "energy");
        let contacts = scene
            .contacts
            .iter()
            .zip(&equations.contacts)
            .map(|(declared, contact)| builder.contact(declared, contact))
            .collect();
        let optimal_control = scene
            .optimal_control
            .as_ref()
            .zip(equations.optimal_control.as_ref())
            .map(|(declared, derived)| builder.optimal_control(declared, derived));
        let bound = |lower: bool| -> Vec<Sym> {
            let open = if lower {
                f64::NEG_INFINITY
            } else {
                f64::INFINITY
            };
            scene
                .coordinates
                .iter()
                .chain(&scene.controls)
                .map(|quantity| match quantity.bounds {
                    Some((low, _)) if lower => low,
                    Some((_, high)) => high,
                    None => Sym::number(open),
                })
                .collect()
        };
        let horizon = match scene.horizon {
            Some(horizon) => format!(
                "let mut out = [0.0_f64]; {}; __Option::Some(out[0])",
                builder.unlisted("horizon", &[horizon], "&mut out")
            ),
            None => "__Option::None".to_owned(),
        };
        Self {
            start: [
                builder.unlisted("start_coordinates", &scene.start.0, "q"),
                builder.unlisted("start_velocities", &scene.start.1, "v"),
            ],
            bounds: [
                builder.unlisted("lower_bounds", &bound(true), "lower"),
                builder.unlisted("upper_bounds", &bound(false), "upper"),
            ],
            horizon,
            energy,
            mass_matrix,
            free_acceleration: acceleration,
            free_jacobian: jacobian,
            free_hessian: hessian,
            free_patterns,
            contacts,
            optimal_control,
            kernels: builder.kernels,
            helpers: builder.helpers,
        }
    }

    /// The functions that are evaluated again and again.
    pub(super) fn listed(&self) -> impl Iterator<Item = &Kernel> {
        self.kernels.iter().filter(|kernel| kernel.listed)
    }
}

struct Builder<'a> {
    scene: &'a CheckedScene,
    inputs: usize,
    kernels: Vec<Kernel>,
    helpers: String,
}

/// A function of the inputs that solves a linear system: names of what is emitted for it.
struct System {
    name: String,
    size: usize,
}

impl Builder<'_> {
    /// Adds a kernel; the call of it.
    fn call(&mut self, name: &str, outputs: &[Sym], x: &str, y: &str, out: &str) -> String {
        let kernel = Kernel::new(self.kernels.len(), name, outputs, true);
        let call = format!("{}(self, {x}, {y}, {out})", kernel.function());
        self.kernels.push(kernel);
        call
    }

    /// Adds a kernel of the parameters alone, evaluated once.
    fn unlisted(&mut self, name: &str, outputs: &[Sym], out: &str) -> String {
        let kernel = Kernel::new(self.kernels.len(), name, outputs, false);
        let call = format!("{}(self, &[], &[], {out})", kernel.function());
        self.kernels.push(kernel);
        call
    }

    fn free(&mut self, solution: &Solution) -> (String, String, String, [Pattern; 2]) {
        match solution {
            Solution::Explicit(Explicit {
                values,
                jacobian,
                hessian,
            }) => (
                self.call("free_acceleration", values, "x", "&[]", "a"),
                self.call("free_jacobian", &jacobian.values, "x", "&[]", "values"),
                self.call(
                    "free_hessian",
                    &hessian.values,
                    "x",
                    "multipliers",
                    "values",
                ),
                [Pattern::of(jacobian), Pattern::of(hessian)],
            ),
            Solution::Implicit(implicit) => {
                let acceleration = implicit
                    .solution
                    .as_ref()
                    .map(|solution| self.call("free_acceleration", solution, "x", "&[]", "a"));
                let system = self.system("motion", implicit);
                let n = implicit.size;
                let jacobian = Pattern {
                    rows: n,
                    columns: self.inputs,
                    entries: implicit.jacobian_pattern(n),
                };
                let hessian = Pattern {
                    rows: self.inputs,
                    columns: self.inputs,
                    entries: implicit.hessian_pattern(),
                };
                let name = &system.name;
                (
                    acceleration.unwrap_or_else(|| {
                        format!(
                            "let (_, y) = __{name}_solution(self, x); a.copy_from_slice(&y[{n}..])"
                        )
                    }),
                    format!(
                        "let (lu, y) = __{name}_solution(self, x); let a = __{name}_sensitivity(self, x, \
                         &lu, &y); {PRIVATE}::gather(&a, {}, values)",
                        jacobian.entries()
                    ),
                    format!(
                        "let mut lambda = [0.0_f64; {n}]; lambda.copy_from_slice(multipliers); \
                         __{name}_second(self, x, &lambda, {}, values)",
                        hessian.entries()
                    ),
                    [jacobian, hessian],
                )
            }
        }
    }

    /// Emits what a linear system and the derivatives of its solution need.
    fn system(&mut self, name: &str, implicit: &Implicit) -> System {
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
