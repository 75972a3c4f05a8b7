//! Equations to Rust items: the struct, its parameters, and the implementation of the model trait.

mod declaration;
mod equations;
mod kernel;
mod locals;
mod oracle;
mod plan;
mod readable;
mod structure;

pub(crate) use structure::stub;

use crate::ast::Scene;
use crate::derive::Equations;
use crate::graph;
use crate::scene::CheckedScene;
use plan::{ContactPlan, FrictionPlan, Plan};
use proc_macro2::TokenStream;
use std::fmt::Write;

/// Most operations of one kernel: some seconds of compile time.
pub(crate) const BUDGET: usize = 60_000;

/// Why a scene is not emitted.
pub(crate) enum Unfit {
    /// A kernel has too many operations to be compiled in reasonable time.
    Long { kernel: String, operations: usize },
    /// Ordering the operations takes too much work.
    Exhausted,
    /// A constant in a kernel is not finite.
    Constant,
}

/// Emits a scene.
pub(crate) fn scene(
    declared: &Scene,
    scene: &CheckedScene,
    equations: &Equations,
) -> Result<TokenStream, Unfit> {
    let plan = Plan::of(scene, equations);
    if graph::is_exhausted() {
        return Err(Unfit::Exhausted);
    }
    for kernel in &plan.kernels {
        let operations = kernel.tape.operations();
        if operations > BUDGET {
            return Err(Unfit::Long {
                kernel: kernel.name.clone(),
                operations,
            });
        }
        // Bounds, which are not listed, may be open.
        if kernel.listed && !kernel.tape.is_finite() {
            return Err(Unfit::Constant);
        }
    }
    let mut code = String::new();
    code.push_str(
        "#[allow(unused, non_snake_case, non_upper_case_globals, clippy::all, clippy::pedantic, \
         clippy::nursery, clippy::restriction)] const _: () = {",
    );
    // Names that nothing around the scene can take: it may itself be called `Option`.
    code.push_str(
        "use ::core::primitive::{f64 as __f64, u32 as __u32, usize as __usize}; \
         use ::core::option::Option as __Option;",
    );
    for kernel in &plan.kernels {
        kernel.write(scene, &mut code);
    }
    code.push_str(&plan.helpers);
    declaration::write(scene, equations, &plan, &mut code);
    implementation(scene, &plan, &mut code);
    if cfg!(feature = "oracle")
        && let Some((helpers, methods)) = oracle::write(declared, scene)
    {
        let name = scene.name.rust();
        let _ = write!(code, "impl {name} {{ {helpers} {methods} }}");
    }
    code.push_str("};");
    let mut tokens = structure::tokens(scene, &plan);
    match code.parse::<TokenStream>() {
        Ok(emitted) => tokens.extend(locals::reserved(emitted, &scene.name.rust())),
        Err(error) => {
            let text = format!("the emitted code does not read as Rust: {error}");
            tokens.extend(quote::quote!(::core::compile_error! { #text }));
        }
    }
    Ok(tokens)
}

fn implementation(scene: &CheckedScene, plan: &Plan, code: &mut String) {
    let name = scene.name.rust();
    let mut read = String::new();
    let mut write = String::new();
    for (i, parameter) in scene.parameters.iter().enumerate() {
        let field = parameter.name.rust();
        let _ = write!(read, "{i} => self.{field},");
        let _ = write!(write, "{i} => self.{field} = value,");
    }
    let arms = |body: &dyn Fn(&ContactPlan) -> &str| {
        let mut arms = String::new();
        for (i, contact) in plan.contacts.iter().enumerate() {
            let _ = write!(arms, "{i} => {{ {} }}", body(contact));
        }
        arms
    };
    let further = laws(plan) + &optimal_control(plan);
    let _ = write!(
        code,
        "#[automatically_derived] impl ::hangtime::model::Model for {name} {{
            fn declaration(&self) -> &'static ::hangtime::model::Declaration {{ &DECLARATION }}
            fn parameter(&self, index: __usize) -> __f64 {{ match index {{ {read} _ => __f64::NAN }} }}
            fn set_parameter(&mut self, index: __usize, value: __f64) {{ match index {{ {write} _ => {{}} }} }}
            fn start(&self, q: &mut [__f64], v: &mut [__f64]) {{ {}; {} }}
            fn horizon(&self) -> __Option<__f64> {{ {} }}
            fn bounds(&self, lower: &mut [__f64], upper: &mut [__f64]) {{ {}; {} }}
            fn free_acceleration(&self, x: &[__f64], a: &mut [__f64]) {{ {} }}
            fn free_jacobian(&self, x: &[__f64], values: &mut [__f64]) {{ {} }}
            fn free_hessian(&self, x: &[__f64], multipliers: &[__f64], values: &mut [__f64]) {{ {} }}
            fn mass_matrix(&self, x: &[__f64], m: &mut [__f64]) {{ {} }}
            fn energy(&self, x: &[__f64], energy: &mut [__f64]) {{ {} }}
            fn gap(&self, contact: __usize, x: &[__f64]) -> __f64 {{ let mut out = [__f64::NAN]; match contact {{ \
         {} _ => {{}} }} out[0] }}
            fn contact(&self, contact: __usize, x: &[__f64], point: &mut [__f64]) {{ match contact {{ {} _ => \
         point.fill(__f64::NAN) }} }}
            fn contact_jacobian(&self, contact: __usize, x: &[__f64], values: &mut [__f64]) {{ match contact \
         {{ {} _ => values.fill(__f64::NAN) }} }}
            fn contact_hessian(&self, contact: __usize, x: &[__f64], multipliers: &[__f64], values: &mut \
         [__f64]) {{ match contact {{ {} _ => values.fill(__f64::NAN) }} }}
            {further}
            fn boxed(&self) -> ::std::boxed::Box<dyn ::hangtime::model::Model> {{ \
         ::std::boxed::Box::new(::core::clone::Clone::clone(self)) }}
        }}",
        plan.start[0],
        plan.start[1],
        plan.horizon,
        plan.bounds[0],
        plan.bounds[1],
        plan.free_acceleration,
        plan.free_jacobian,
        plan.free_hessian,
        plan.mass_matrix,
        plan.energy,
        arms(&|contact| &contact.gap),
        arms(&|contact| &contact.contact),
        arms(&|contact| &contact.derivatives.jacobian),
        arms(&|contact| &contact.derivatives.hessian),
    );
}

/// The methods for restitution and friction, as far as the scene declares them.
fn laws(plan: &Plan) -> String {
    let arms = |body: &dyn Fn(&ContactPlan) -> Option<&String>| {
        let mut arms = String::new();
        for (i, contact) in plan.contacts.iter().enumerate() {
            if let Some(body) = body(contact) {
                let _ = write!(arms, "{i} => {{ {body} }}");
            }
        }
        arms
    };
    let mut methods = String::new();
    let restitution = arms(&|contact| contact.restitution.as_ref());
    if !restitution.is_empty() {
        let _ = write!(
            methods,
            "fn restitution(&self, contact: __usize) -> __f64 {{ match contact {{ {restitution} _ => 0.0 }} }}"
        );
    }
    let friction = |body: &dyn Fn(&FrictionPlan) -> &String| {
        arms(&|contact| contact.friction.as_ref().map(body))
    };
    let coefficient = friction(&|friction| &friction.coefficient);
    if !coefficient.is_empty() {
        let _ = write!(
            methods,
            "fn friction(&self, contact: __usize) -> __f64 {{ match contact {{ {coefficient} _ => 0.0 }} }}
            fn tangent(&self, contact: __usize, x: &[__f64], point: &mut [__f64]) {{ match contact {{ {} _ => \
             point.fill(__f64::NAN) }} }}
            fn tangent_jacobian(&self, contact: __usize, x: &[__f64], values: &mut [__f64]) {{ match contact {{ \
             {} _ => values.fill(__f64::NAN) }} }}
            fn tangent_hessian(&self, contact: __usize, x: &[__f64], multipliers: &[__f64], values: &mut [__f64]) \
             {{ match contact {{ {} _ => values.fill(__f64::NAN) }} }}",
            friction(&|friction| &friction.tangent),
            friction(&|friction| &friction.derivatives.jacobian),
            friction(&|friction| &friction.derivatives.hessian),
        );
    }
    methods
}

/// The methods for optimal control, as far as the scene declares it.
fn optimal_control(plan: &Plan) -> String {
    let mut methods = String::new();
    let Some(control) = &plan.optimal_control else {
        return methods;
    };
    for (kind, input, plan) in [
        ("path", 'x', &control.path),
        ("terminal", 'z', &control.terminal),
    ] {
        if let Some([values, jacobian, hessian]) = &plan.bodies {
            let _ = write!(
                methods,
                "fn {kind}_functions(&self, {input}: &[__f64], values: &mut [__f64]) {{ {values} }}
                fn {kind}_jacobian(&self, {input}: &[__f64], values: &mut [__f64]) {{ {jacobian} }}
                fn {kind}_hessian(&self, {input}: &[__f64], multipliers: &[__f64], values: &mut [__f64]) {{ \
                 {hessian} }}"
            );
        }
    }
    if let Some([lower, upper]) = &control.free_start_bounds {
        let _ = write!(
            methods,
            "fn free_start_bounds(&self, lower: &mut [__f64], upper: &mut [__f64]) {{ {lower}; {upper} }}"
        );
    }
    methods
}
