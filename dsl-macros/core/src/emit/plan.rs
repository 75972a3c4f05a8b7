//! Which functions are emitted for a scene, and how the methods of the model trait call them.

mod builder;
mod contact;
mod optimal_control;

pub(super) use builder::Pattern;
pub(super) use contact::{ContactPlan, FrictionPlan};
pub(super) use optimal_control::ControlPlan;

use super::kernel::Kernel;
use crate::derive::{Equations, Explicit, Solution};
use crate::graph::Sym;
use crate::scene::CheckedScene;
use builder::{Builder, PRIVATE};

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
            free(&mut builder, &equations.acceleration);
        let mass_matrix = builder.call("mass_matrix", &equations.mass, "x", "&[]", "m");
        let energy = builder.call("energy", &equations.energy, "x", "&[]", "energy");
        let contacts = scene
            .contacts
            .iter()
            .zip(&equations.contacts)
            .map(|(declared, contact)| contact::contact(&mut builder, declared, contact))
            .collect();
        let optimal_control = scene
            .optimal_control
            .as_ref()
            .zip(equations.optimal_control.as_ref())
            .map(|(declared, derived)| {
                optimal_control::optimal_control(&mut builder, declared, derived)
            });
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

fn free(builder: &mut Builder<'_>, solution: &Solution) -> (String, String, String, [Pattern; 2]) {
    match solution {
        Solution::Explicit(Explicit {
            values,
            jacobian,
            hessian,
        }) => (
            builder.call("free_acceleration", values, "x", "&[]", "a"),
            builder.call("free_jacobian", &jacobian.values, "x", "&[]", "values"),
            builder.call(
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
                .map(|solution| builder.call("free_acceleration", solution, "x", "&[]", "a"));
            let system = builder.system("motion", implicit);
            let n = implicit.size;
            let jacobian = Pattern {
                rows: n,
                columns: builder.inputs,
                entries: implicit.jacobian_pattern(n),
            };
            let hessian = Pattern {
                rows: builder.inputs,
                columns: builder.inputs,
                entries: implicit.hessian_pattern(),
            };
            let name = &system.name;
            (
                acceleration.unwrap_or_else(|| {
                    format!("let (_, y) = __{name}_solution(self, x); a.copy_from_slice(&y[{n}..])")
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
