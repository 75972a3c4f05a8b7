//! A derived scene to Rust items: the struct, its parameters, and the implementation of the model trait.

mod declaration;
mod inertia;
mod kernel;
mod locals;
mod methods;
mod oracle;
mod structure;

pub(crate) use structure::stub;

use crate::ast::Scene;
use crate::description::{Contact, Description, Friction, Rows};
use crate::scene::CheckedScene;
use proc_macro2::TokenStream;
use std::fmt::Write;

/// Emits a scene, which says what it was declared by.
pub(crate) fn scene(
    declared: &Scene,
    scene: &CheckedScene,
    derived: &Description,
    text: &str,
) -> TokenStream {
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
    let name = scene.name.rust();
    kernel::write_profiles(derived, &mut code);
    for index in 0..derived.kernels.len() {
        kernel::write(derived, index, &mut code);
    }
    for system in &derived.systems {
        methods::helpers(derived, system, &name, &mut code);
    }
    inertia::helpers(derived, &name, &mut code);
    declaration::write(derived, &mut code);
    implementation(scene, derived, text, &mut code);
    if cfg!(feature = "oracle")
        && let Some((helpers, methods)) = oracle::write(declared, scene)
    {
        let _ = write!(code, "impl {name} {{ {helpers} {methods} }}");
    }
    code.push_str("};");
    let mut tokens = structure::tokens(scene, derived);
    match code.parse::<TokenStream>() {
        Ok(emitted) => tokens.extend(locals::reserved(emitted, &name)),
        Err(error) => {
            let text = format!("the emitted code does not read as Rust: {error}");
            tokens.extend(quote::quote!(::core::compile_error! { #text }));
        }
    }
    tokens
}

fn implementation(scene: &CheckedScene, derived: &Description, text: &str, code: &mut String) {
    let name = scene.name.rust();
    let mut read = String::new();
    let mut write = String::new();
    for (i, parameter) in scene.parameters.iter().enumerate() {
        let field = parameter.name.rust();
        let _ = write!(read, "{i} => self.{field},");
        let _ = write!(write, "{i} => self.{field} = value,");
    }
    let arms = |body: &dyn Fn(&Contact) -> String| {
        let mut arms = String::new();
        for (i, contact) in derived.contacts.iter().enumerate() {
            let _ = write!(arms, "{i} => {{ {} }}", body(contact));
        }
        arms
    };
    let joints = derived.joints.as_ref();
    let joints = joints.map_or_else(String::new, |joints| methods::joints(derived, joints));
    let of_control = optimal_control(derived);
    let further = laws(derived)
        + &joints
        + &of_control
        + &shown(derived)
        + &free_parameters(derived)
        + &experiments(derived);
    let given = &derived.given;
    let of_parameters = |kernel, out| methods::of_parameters(derived, kernel, out);
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
            fn text(&self) -> __Option<&str> {{ __Option::Some({text:?}) }}
            fn boxed(&self) -> ::std::boxed::Box<dyn ::hangtime::model::Model> {{ \
         ::std::boxed::Box::new(::core::clone::Clone::clone(self)) }}
        }}",
        of_parameters(given.start[0], "q"),
        of_parameters(given.start[1], "v"),
        methods::horizon(derived),
        of_parameters(given.bounds[0], "lower"),
        of_parameters(given.bounds[1], "upper"),
        methods::free_acceleration(derived),
        methods::free_jacobian(derived),
        methods::free_hessian(derived),
        methods::of_inputs(derived, derived.motion.mass_matrix, "m"),
        methods::of_inputs(derived, derived.motion.energy, "energy"),
        arms(&|contact| methods::of_inputs(derived, contact.gap, "&mut out")),
        arms(&|contact| methods::contact_point(derived, contact)),
        arms(&|contact| methods::rows_jacobian(derived, &contact.rows)),
        arms(&|contact| methods::rows_hessian(derived, &contact.rows)),
    );
}

/// The methods for restitution and friction, as far as the scene declares them.
fn laws(derived: &Description) -> String {
    let arms = |body: &dyn Fn(&Contact) -> Option<String>| arms(derived, body);
    let value = |kernel| methods::coefficient(derived, kernel);
    let mut written = String::new();
    let resets = arms(&|contact| {
        let kernel = contact.reset?;
        Some(methods::of_inputs(derived, kernel, "v"))
    });
    if !resets.is_empty() {
        let _ = write!(
            written,
            "fn reset(&self, contact: __usize, x: &[__f64], v: &mut [__f64]) {{ match contact {{ {resets} _ => {{}} }} }}"
        );
    }
    let restitution = arms(&|contact| contact.restitution.map(value));
    if !restitution.is_empty() {
        let _ = write!(
            written,
            "fn restitution(&self, contact: __usize) -> __f64 {{ match contact {{ {restitution} _ => 0.0 }} }}"
        );
    }
    let friction =
        |body: &dyn Fn(&Friction) -> String| arms(&|contact| contact.friction.as_ref().map(body));
    let coefficient = friction(&|friction| value(friction.coefficient));
    if !coefficient.is_empty() {
        let rows = |body: &dyn Fn(&Description, &Rows) -> String| {
            friction(&|friction| body(derived, &friction.rows))
        };
        let _ = write!(
            written,
            "fn friction(&self, contact: __usize) -> __f64 {{ match contact {{ {coefficient} _ => 0.0 }} }}
            fn tangent(&self, contact: __usize, x: &[__f64], point: &mut [__f64]) {{ match contact {{ {} _ => \
             point.fill(__f64::NAN) }} }}
            fn tangent_jacobian(&self, contact: __usize, x: &[__f64], values: &mut [__f64]) {{ match contact {{ \
             {} _ => values.fill(__f64::NAN) }} }}
            fn tangent_hessian(&self, contact: __usize, x: &[__f64], multipliers: &[__f64], values: &mut [__f64]) \
             {{ match contact {{ {} _ => values.fill(__f64::NAN) }} }}",
            friction(&|friction| methods::tangent_point(derived, friction.tangent, &friction.rows)),
            rows(&methods::rows_jacobian),
            rows(&methods::rows_hessian),
        );
    }
    written.push_str(&laws_beyond_one_coefficient(derived));
    written
}

/// The arms of a match over contacts, for those that have a `body`.
fn arms(derived: &Description, body: &dyn Fn(&Contact) -> Option<String>) -> String {
    let mut arms = String::new();
    for (i, contact) in derived.contacts.iter().enumerate() {
        if let Some(body) = body(contact) {
            let _ = write!(arms, "{i} => {{ {body} }}");
        }
    }
    arms
}

/// The methods for friction in space, of speed, of rest and of load, as far as the scene declares them.
fn laws_beyond_one_coefficient(derived: &Description) -> String {
    let arms = |body: &dyn Fn(&Contact) -> Option<String>| arms(derived, body);
    let value = |kernel| methods::coefficient(derived, kernel);
    let mut written = String::new();
    let kinetic = arms(&|contact| contact.friction.as_ref()?.kinetic.map(value));
    if !kinetic.is_empty() {
        let _ = write!(
            written,
            "fn kinetic_friction(&self, contact: __usize) -> __f64 {{ match contact {{ {kinetic} _ => self.friction(contact) }} }}"
        );
    }
    let across = |body: &dyn Fn(usize, &Rows) -> String| {
        arms(&|contact| {
            let (kernel, rows) = contact.friction.as_ref()?.across.as_ref()?;
            Some(body(*kernel, rows))
        })
    };
    let points = across(&|kernel, rows| methods::tangent_point(derived, kernel, rows));
    if !points.is_empty() {
        let _ = write!(
            written,
            "fn across(&self, contact: __usize, x: &[__f64], point: &mut [__f64]) {{ match contact {{ {points} _ => \
             point.fill(__f64::NAN) }} }}
            fn across_jacobian(&self, contact: __usize, x: &[__f64], values: &mut [__f64]) {{ match contact {{ {} _ => \
             values.fill(__f64::NAN) }} }}",
            across(&|_, rows| methods::rows_jacobian(derived, rows))
        );
    }
    let loads = arms(&|contact| {
        let (_, kernel) = contact.loads.as_ref()?;
        Some(methods::of_inputs(derived, *kernel, "loads"))
    });
    if !loads.is_empty() {
        let _ = write!(
            written,
            "fn loads(&self, contact: __usize, x: &[__f64], loads: &mut [__f64]) {{ match contact {{ {loads} _ => {{}} }} }}"
        );
    }
    let share = arms(&|contact| {
        let share = contact.friction.as_ref()?.share?;
        let call = methods::of_inputs(derived, share, "&mut value");
        Some(format!("let mut value = [0.0]; {call}; value[0]"))
    });
    if !share.is_empty() {
        let _ = write!(
            written,
            "fn friction_share(&self, contact: __usize, x: &[__f64]) -> __f64 {{ match contact {{ {share} _ => 1.0 }} }}"
        );
    }
    written
}

/// The methods for what is recorded and drawn, as far as the scene declares it.
fn shown(derived: &Description) -> String {
    let mut written = String::new();
    if let Some(outputs) = &derived.outputs {
        let _ = write!(
            written,
            "fn outputs(&self) -> &'static [::hangtime::model::VariableDeclaration] {{ &[{}] }}
            fn output_values(&self, x: &[__f64], contacts: &[__f64], values: &mut [__f64]) {{ {} }}",
            declaration::variables(&outputs.quantities),
            methods::call(derived, outputs.kernel, "x", "contacts", "values")
        );
    }
    if let Some(picture) = &derived.picture {
        let _ = write!(
            written,
            "fn picture(&self) -> __Option<::hangtime::model::Picture> {{ __Option::Some({}) }}
            fn picture_values(&self, x: &[__f64], along: __f64, values: &mut [__f64]) {{ {} }}",
            declaration::picture(picture),
            methods::call(derived, picture.kernel, "x", "&[along]", "values")
        );
    }
    written
}

/// The methods for parameters that are to be found, and for what is remembered of the start, if there is any.
fn free_parameters(derived: &Description) -> String {
    let mut written = String::new();
    if !derived.remembered.is_empty() {
        let remembered = &derived.remembered;
        let _ = write!(
            written,
            "fn remembered(&self) -> &'static [__usize] {{ &{remembered:?} }}"
        );
    }
    let Some(free) = &derived.free_parameters else {
        return written;
    };
    let _ = write!(
        written,
        "fn free_parameters(&self) -> &'static [__usize] {{ &{:?} }}
        fn free_parameter_bounds(&self, lower: &mut [__f64], upper: &mut [__f64]) {{ {}; {} }}",
        free.parameters,
        methods::of_parameters(derived, free.bounds[0], "lower"),
        methods::of_parameters(derived, free.bounds[1], "upper")
    );
    written
}

/// The method for measured motions, if the scene compares with any. Their start values are no part of what is compiled.
fn experiments(derived: &Description) -> String {
    if derived.experiments.is_empty() {
        return String::new();
    }
    format!(
        "fn experiments(&self) -> &'static [::hangtime::model::Experiment] {{ &[{}] }}",
        declaration::experiments(&derived.experiments)
    )
}

/// The methods for optimal control, as far as the scene declares it.
fn optimal_control(derived: &Description) -> String {
    let mut written = String::new();
    let Some(control) = &derived.optimal_control else {
        return written;
    };
    for (kind, input, functions) in [
        ("path", "x", &control.path),
        ("terminal", "z", &control.terminal),
        ("impact", "x", &control.contacts.impact),
    ] {
        if let Some([values, jacobian, hessian]) = methods::functions(derived, functions, input) {
            let _ = write!(
                written,
                "fn {kind}_functions(&self, {input}: &[__f64], values: &mut [__f64]) {{ {values} }}
                fn {kind}_jacobian(&self, {input}: &[__f64], values: &mut [__f64]) {{ {jacobian} }}
                fn {kind}_hessian(&self, {input}: &[__f64], multipliers: &[__f64], values: &mut [__f64]) {{ \
                 {hessian} }}"
            );
        }
    }
    if let Some(bounds) = control.free_start_bounds {
        let [lower, upper] = bounds;
        let _ = write!(
            written,
            "fn free_start_bounds(&self, lower: &mut [__f64], upper: &mut [__f64]) {{ {}; {} }}",
            methods::of_parameters(derived, lower, "lower"),
            methods::of_parameters(derived, upper, "upper")
        );
    }
    written
}
