//! Equations to Rust items: the struct, its parameters, and the implementation of the model trait.

mod declaration;
mod kernel;
mod readable;
mod structure;

pub(crate) use structure::stub;

use crate::derive::{Equations, Sparse};
use crate::graph::Sym;
use crate::scene::CheckedScene;
use kernel::Kernel;
use proc_macro2::TokenStream;
use std::fmt::Write;
use std::time::{Duration, SystemTime};

/// When the expansion began and how long the derivation took.
pub(crate) struct Timing {
    pub(crate) expanded_at: SystemTime,
    pub(crate) derivation: Duration,
}

/// All emitted functions, by the trait method that they serve.
struct Kernels {
    start: [Kernel; 2],
    horizon: Option<Kernel>,
    bounds: [Kernel; 2],
    energy: Kernel,
    mass_matrix: Kernel,
    free_acceleration: Kernel,
    free_jacobian: Kernel,
    free_hessian: Kernel,
    contacts: Vec<ContactKernels>,
}

struct ContactKernels {
    gap: Kernel,
    contact: Kernel,
    jacobian: Kernel,
    hessian: Kernel,
}

impl Kernels {
    fn of(scene: &CheckedScene, equations: &Equations) -> Self {
        let dynamics = &equations.dynamics;
        let bound = |lower: bool| -> Vec<Sym> {
            scene
                .coordinates
                .iter()
                .chain(&scene.controls)
                .map(|quantity| match quantity.bounds {
                    Some((low, high)) => {
                        if lower {
                            low
                        } else {
                            high
                        }
                    }
                    None if lower => Sym::number(f64::NEG_INFINITY),
                    None => Sym::number(f64::INFINITY),
                })
                .collect()
        };
        let contacts = equations
            .contacts
            .iter()
            .zip(&scene.contacts)
            .map(|(contact, declared)| {
                let name = &declared.name.text;
                let mut point = vec![
                    contact.gap,
                    contact.normal_velocity,
                    contact.curvature,
                    contact.inverse_inertia,
                ];
                point.extend(&contact.normal);
                point.extend(&contact.direction);
                ContactKernels {
                    gap: Kernel::new(format!("gap_{name}"), &[contact.gap]),
                    contact: Kernel::new(format!("contact_{name}"), &point),
                    jacobian: sparse(format!("contact_jacobian_{name}"), &contact.jacobian),
                    hessian: sparse(format!("contact_hessian_{name}"), &contact.hessian),
                }
            })
            .collect();
        Self {
            start: [
                Kernel::new("start_coordinates", &scene.start.0),
                Kernel::new("start_velocities", &scene.start.1),
            ],
            horizon: scene
                .horizon
                .map(|horizon| Kernel::new("horizon", &[horizon])),
            bounds: [
                Kernel::new("lower_bounds", &bound(true)),
                Kernel::new("upper_bounds", &bound(false)),
            ],
            energy: Kernel::new("energy", &dynamics.energy),
            mass_matrix: Kernel::new("mass_matrix", &dynamics.mass),
            free_acceleration: Kernel::new("free_acceleration", &dynamics.acceleration),
            free_jacobian: sparse("free_jacobian", &dynamics.jacobian),
            free_hessian: sparse("free_hessian", &dynamics.hessian),
            contacts,
        }
    }

    /// Everything that is evaluated again and again.
    fn listed(&self) -> Vec<&Kernel> {
        let mut kernels = vec![
            &self.free_acceleration,
            &self.free_jacobian,
            &self.free_hessian,
            &self.mass_matrix,
            &self.energy,
        ];
        for contact in &self.contacts {
            kernels.extend([
                &contact.gap,
                &contact.contact,
                &contact.jacobian,
                &contact.hessian,
            ]);
        }
        kernels
    }

    fn all(&self) -> Vec<&Kernel> {
        let mut kernels: Vec<&Kernel> = self.start.iter().chain(&self.bounds).collect();
        kernels.extend(&self.horizon);
        kernels.extend(self.listed());
        kernels
    }
}

fn sparse(name: impl Into<String>, sparse: &Sparse) -> Kernel {
    Kernel::new(name, &sparse.values)
}

/// Most operations of one kernel: some seconds of compile time.
pub(crate) const BUDGET: usize = 60_000;

/// A kernel that is too large to be compiled in reasonable time.
pub(crate) struct TooLarge {
    pub(crate) kernel: String,
    pub(crate) operations: usize,
}

/// Emits a scene.
pub(crate) fn scene(
    scene: &CheckedScene,
    equations: &Equations,
    timing: &Timing,
) -> Result<TokenStream, TooLarge> {
    let kernels = Kernels::of(scene, equations);
    for kernel in kernels.all() {
        let operations = kernel.tape.operations();
        if operations > BUDGET {
            return Err(TooLarge {
                kernel: kernel.name.clone(),
                operations,
            });
        }
    }
    let mut code = String::new();
    code.push_str(
        "#[allow(unused, non_snake_case, non_upper_case_globals, clippy::all, clippy::pedantic, \
         clippy::nursery, clippy::restriction)] const _: () = {",
    );
    for kernel in kernels.all() {
        kernel.write(scene, &mut code);
    }
    declaration::write(scene, equations, &kernels, timing, &mut code);
    implementation(scene, &kernels, &mut code);
    code.push_str("};");
    let mut tokens = structure::tokens(scene, equations, &kernels.listed());
    match code.parse::<TokenStream>() {
        Ok(emitted) => tokens.extend(emitted),
        Err(error) => {
            let text = format!("the emitted code does not read as Rust: {error}");
            tokens.extend(quote::quote!(::core::compile_error! { #text }));
        }
    }
    Ok(tokens)
}

fn implementation(scene: &CheckedScene, kernels: &Kernels, code: &mut String) {
    let name = &scene.name.text;
    let _ = write!(
        code,
        "#[automatically_derived] impl ::hangtime::model::Model for {name} {{
            fn declaration(&self) -> &'static ::hangtime::model::Declaration {{ &DECLARATION }}
            fn parameter(&self, index: usize) -> f64 {{ match index {{"
    );
    for (i, parameter) in scene.parameters.iter().enumerate() {
        let _ = write!(code, "{i} => self.{},", parameter.name.text);
    }
    code.push_str(
        "_ => f64::NAN } } fn set_parameter(&mut self, index: usize, value: f64) { match index {",
    );
    for (i, parameter) in scene.parameters.iter().enumerate() {
        let _ = write!(code, "{i} => self.{} = value,", parameter.name.text);
    }
    let _ = write!(
        code,
        "_ => {{}} }} }}
        fn start(&self, q: &mut [f64], v: &mut [f64]) {{ {}(self, &[], &[], q); {}(self, &[], &[], v); }}",
        kernels.start[0].function(),
        kernels.start[1].function()
    );
    match &kernels.horizon {
        Some(horizon) => {
            let _ = write!(
                code,
                "fn horizon(&self) -> Option<f64> {{ let mut out = [0.0_f64]; {}(self, &[], &[], &mut \
                 out); Some(out[0]) }}",
                horizon.function()
            );
        }
        None => code.push_str("fn horizon(&self) -> Option<f64> { None }"),
    }
    let _ = write!(
        code,
        "fn bounds(&self, lower: &mut [f64], upper: &mut [f64]) {{ {}(self, &[], &[], lower); {}(self, \
         &[], &[], upper); }}
        fn free_acceleration(&self, x: &[f64], a: &mut [f64]) {{ {}(self, x, &[], a) }}
        fn free_jacobian(&self, x: &[f64], values: &mut [f64]) {{ {}(self, x, &[], values) }}
        fn free_hessian(&self, x: &[f64], multipliers: &[f64], values: &mut [f64]) {{ {}(self, x, \
         multipliers, values) }}
        fn mass_matrix(&self, x: &[f64], m: &mut [f64]) {{ {}(self, x, &[], m) }}
        fn energy(&self, x: &[f64], energy: &mut [f64]) {{ {}(self, x, &[], energy) }}",
        kernels.bounds[0].function(),
        kernels.bounds[1].function(),
        kernels.free_acceleration.function(),
        kernels.free_jacobian.function(),
        kernels.free_hessian.function(),
        kernels.mass_matrix.function(),
        kernels.energy.function(),
    );
    let arms = |call: &dyn Fn(&ContactKernels) -> String| {
        let mut arms = String::new();
        for (i, contact) in kernels.contacts.iter().enumerate() {
            let _ = write!(arms, "{i} => {},", call(contact));
        }
        arms
    };
    let _ = write!(
        code,
        "fn gap(&self, contact: usize, x: &[f64]) -> f64 {{ let mut out = [f64::NAN]; match contact {{ \
         {} _ => {{}} }} out[0] }}
        fn contact(&self, contact: usize, x: &[f64], point: &mut [f64]) {{ match contact {{ {} _ => \
         point.fill(f64::NAN) }} }}
        fn contact_jacobian(&self, contact: usize, x: &[f64], values: &mut [f64]) {{ match contact {{ \
         {} _ => values.fill(f64::NAN) }} }}
        fn contact_hessian(&self, contact: usize, x: &[f64], multipliers: &[f64], values: &mut [f64]) \
         {{ match contact {{ {} _ => values.fill(f64::NAN) }} }}
        fn boxed(&self) -> ::std::boxed::Box<dyn ::hangtime::model::Model> {{ \
         ::std::boxed::Box::new(::core::clone::Clone::clone(self)) }} }}",
        arms(&|c| format!("{}(self, x, &[], &mut out)", c.gap.function())),
        arms(&|c| format!("{}(self, x, &[], point)", c.contact.function())),
        arms(&|c| format!("{}(self, x, &[], values)", c.jacobian.function())),
        arms(&|c| format!("{}(self, x, multipliers, values)", c.hessian.function())),
    );
}
