//! The struct of a scene: its parameters as fields, with defaults and setters.

use crate::ast::{Name, WrittenUnit};
use crate::description::{Description, formula};
use crate::scene::{CheckedScene, Contact, Coordinate, OptimalControl, Parameter};
use proc_macro2::{Literal, Span, TokenStream};
use quote::{format_ident, quote};
use std::fmt::Write;

/// The struct, its default, and its setters.
pub(super) fn tokens(scene: &CheckedScene, derived: &Description) -> TokenStream {
    let (visibility, name) = (&scene.visibility, scene.name.rust_ident());
    let documentation = doc(&scene_documentation(scene, derived));
    let fields = scene.parameters.iter().map(|parameter| {
        let ident = parameter.name.rust_ident();
        let documentation = doc(&parameter_documentation(parameter));
        quote!(#documentation pub #ident: ::core::primitive::f64,)
    });
    let defaults = scene.parameters.iter().map(|parameter| {
        let ident = parameter.name.rust_ident();
        // A literal has no sign.
        let value = Literal::f64_suffixed(parameter.default.abs());
        if parameter.default < 0.0 {
            quote!(#ident: -#value,)
        } else {
            quote!(#ident: #value,)
        }
    });
    let setters = scene.parameters.iter().map(|parameter| {
        let ident = parameter.name.rust_ident();
        let setter = format_ident!("with_{}", ident, span = Span::call_site());
        let documentation = doc(&format!(
            "The same scene with another `{}`{}.",
            parameter.name.text,
            in_brackets(parameter.unit.as_ref())
        ));
        quote! {
            #documentation
            #[must_use]
            pub fn #setter(mut self, value_: ::core::primitive::f64) -> Self {
                self.#ident = value_;
                self
            }
        }
    });
    // Which equations of joints are held: 1 each.
    let held = format_ident!("{}", super::kernel::HELD, span = Span::call_site());
    let rows = derived.structure.joint_rows();
    let rows = (rows > 0).then(|| Literal::usize_unsuffixed(rows));
    let held_field = rows
        .clone()
        .map(|rows| quote!(#[doc(hidden)] pub #held: [::core::primitive::f64; #rows],));
    let held_default = rows.map(|rows| quote!(#held: [1.0; #rows],));
    quote! {
        #documentation
        #[derive(::core::fmt::Debug, ::core::clone::Clone, ::core::cmp::PartialEq)]
        #[allow(non_snake_case)]
        #visibility struct #name {
            #(#fields)*
            #held_field
        }

        #[automatically_derived]
        impl ::core::default::Default for #name {
            fn default() -> Self {
                Self { #(#defaults)* #held_default }
            }
        }

        #[automatically_derived]
        #[allow(non_snake_case, dead_code)]
        impl #name {
            #(#setters)*
        }
    }
}

/// What stands for a scene with mistakes: its name, its parameters and the trait, so that no use of the
/// scene gives a second message.
pub(crate) fn stub(visibility: &TokenStream, name: &Name, parameters: &[Name]) -> TokenStream {
    let name = name.rust_ident();
    let methods = [
        quote!(structure(&self) -> &'static ::hangtime::scene::data::Structure),
        quote!(declared(&self) -> &::hangtime::scene::Declared),
        quote!(number(&self, _: ::core::primitive::usize) -> ::core::primitive::f64),
        quote!(set_number(&mut self, _: ::core::primitive::usize, _: ::core::primitive::f64)),
        quote!(kernel(
            &self,
            _: ::core::primitive::usize,
            _: &[::core::primitive::f64],
            _: &[::core::primitive::f64],
            _: &mut [::core::primitive::f64],
        )),
        quote!(tape(
            &self,
            _: ::hangtime::scene::tape::Explicit,
        ) -> ::core::option::Option<::hangtime::scene::tape::Tape<'_>>),
        quote!(boxed(&self) -> ::std::boxed::Box<dyn ::hangtime::scene::Model>),
    ]
    .map(|signature| quote!(fn #signature { ::core::panic!("this scene has mistakes") }));
    let fields = parameters.iter().map(Name::rust_ident);
    let setters = parameters.iter().map(|parameter| {
        let setter = format_ident!("with_{}", parameter.rust_ident(), span = Span::call_site());
        quote!(pub fn #setter(self, _: ::core::primitive::f64) -> Self { self })
    });
    quote! {
        #[derive(::core::fmt::Debug, ::core::clone::Clone, ::core::cmp::PartialEq, ::core::default::Default)]
        #[allow(missing_docs, dead_code, non_snake_case)]
        #visibility struct #name { #(pub #fields: ::core::primitive::f64,)* }
        #[allow(missing_docs, dead_code, non_snake_case)]
        impl #name { #(#setters)* }
        #[automatically_derived]
        impl ::hangtime::scene::Model for #name {
            #(#methods)*
        }
    }
}

fn doc(text: &str) -> TokenStream {
    quote!(#[doc = #text])
}

fn in_brackets(unit: Option<&WrittenUnit>) -> String {
    // Escaped, as rustdoc takes brackets for links.
    unit.map_or_else(String::new, |unit| format!(" \\[{}\\]", unit.text))
}

fn parameter_documentation(parameter: &Parameter) -> String {
    let mut text = parameter.documentation.clone();
    if text.is_empty() {
        let _ = write!(text, "Parameter `{}`", parameter.name.text);
    }
    if !text.ends_with('.') {
        text.push('.');
    }
    let unit = parameter.unit.as_ref().map_or_else(
        || "a pure number or in no declared unit".to_owned(),
        |unit| format!("in {}", unit.text),
    );
    let _ = write!(text, " {} by default, {unit}.", parameter.default);
    text
}

fn scene_documentation(scene: &CheckedScene, derived: &Description) -> String {
    let mut page = scene.documentation.clone();
    if page.is_empty() {
        let _ = write!(page, "The scene `{}`.", scene.name.text);
    }
    page.push_str("\n\n# Coordinates and controls\n\n");
    for (what, list) in [
        ("coordinate", &scene.coordinates[..scene.mechanical()]),
        ("control", &scene.controls[..]),
        ("state", &scene.states[..]),
    ] {
        for quantity in list {
            page.push_str(&quantity_line(what, quantity));
        }
    }
    if !scene.contacts.is_empty() {
        page.push_str("\n# Contacts\n\n");
        for contact in &scene.contacts {
            let _ = writeln!(
                page,
                "- `{}`: {}{}",
                contact.name.text,
                law(scene, contact),
                sentence(&contact.documentation)
            );
        }
    }
    if scene.explicit_time {
        page.push_str(
            "\nThe scene depends on the physical time `t` (see `hangtime explain E14`); in the time-freezing reformulation that is \
             the clock state.\n",
        );
    }
    if let Some(task) = &scene.optimal_control {
        page.push_str(&optimal_control(scene, task));
    }
    page.push_str("\n# Derived functions\n\n| function | operations | values |\n|---|---|---|\n");
    for kernel in derived.listed() {
        let _ = writeln!(
            page,
            "| `{}` | {} | {} |",
            kernel.name,
            kernel.cost(),
            kernel.outputs.len()
        );
    }
    page.push_str("\n# Pattern of the Jacobian of the free acceleration\n\n```text\n");
    let jacobian = &derived.structure.declaration.free_jacobian;
    for row in 0..jacobian.rows {
        for column in 0..jacobian.columns {
            page.push(if jacobian.entries.contains(&(row as u32, column as u32)) {
                '*'
            } else {
                '.'
            });
        }
        page.push('\n');
    }
    page.push_str("```\n");
    page
}

/// The section about optimal control.
fn optimal_control(scene: &CheckedScene, task: &OptimalControl) -> String {
    let mut page = "\n# Optimal control\n\n".to_owned();
    let costs = [
        (
            task.running_cost.is_some(),
            "the integral of a running cost",
        ),
        (task.final_cost.is_some(), "a final cost"),
    ];
    let costs: Vec<&str> = costs
        .iter()
        .filter(|(declared, _)| *declared)
        .map(|&(_, cost)| cost)
        .collect();
    if !costs.is_empty() {
        let _ = writeln!(page, "- minimized: {}", costs.join(" and "));
    }
    for (what, conditions) in [
        ("constraint", &task.constraints),
        ("constraint", &task.at_impacts),
        ("at the end", &task.goals),
    ] {
        for condition in conditions {
            let documentation = sentence(&condition.documentation);
            let _ = writeln!(page, "- {what} `{}`{documentation}", condition.name);
        }
    }
    if task.free_time {
        page.push_str("- to be found: the final time\n");
    }
    let n = scene.coordinates.len();
    for &(index, _) in &task.free_start {
        let name = &scene.coordinates[index % n].name.text;
        let shown = if index < n {
            name.clone()
        } else {
            format!("dot({name})")
        };
        let _ = writeln!(page, "- to be found: `{shown}` at the start");
    }
    page
}

/// The law of a contact in words.
fn law(scene: &CheckedScene, contact: &Contact) -> String {
    if !contact.reset.is_empty() {
        return "sets velocities or states where it comes true".to_owned();
    }
    if contact.switch.is_some() {
        return "a switch of what acts".to_owned();
    }
    if let Some(bound) = contact.whole_bound() {
        return format!("dry friction, bound {}", formula(scene, bound));
    }
    let mut text = match contact.restitution {
        None => "inelastic".to_owned(),
        Some(coefficient) => format!("restitution {}", formula(scene, coefficient)),
    };
    if let Some(friction) = &contact.friction {
        if friction.across.is_some() {
            text.push_str(", in space");
        }
        let sliding = friction.share.or(friction.kinetic);
        let sliding = formula(scene, sliding.unwrap_or(friction.coefficient));
        let _ = match (friction.kinetic, friction.share) {
            (None, _) => write!(text, ", friction {sliding}"),
            (Some(_), None) => {
                let at_rest = formula(scene, friction.coefficient);
                write!(text, ", friction static {at_rest}, kinetic {sliding}")
            }
            (Some(_), Some(_)) => {
                let ratio = formula(scene, friction.coefficient);
                write!(
                    text,
                    ", friction kinetic {sliding}, at rest {ratio} times that"
                )
            }
        };
    }
    if contact.along.is_some() {
        text.push_str(", impulse in a direction of its own");
    }
    for (i, &held) in contact.held.iter().enumerate() {
        text.push_str(if i == 0 { ", holding " } else { " and " });
        let _ = write!(text, "`{}`", scene.coordinates[held].name.text);
    }
    for (i, &other) in contact.alternatives.iter().enumerate() {
        text.push_str(if i == 0 {
            ", where its gap is larger than of "
        } else {
            " and "
        });
        let _ = write!(text, "`{}`", scene.contacts[other].name.text);
    }
    text
}

fn quantity_line(what: &str, quantity: &Coordinate) -> String {
    format!(
        "- {what} `{}`{}{}\n",
        quantity.name.text,
        in_brackets(quantity.unit.as_ref()),
        sentence(&quantity.documentation)
    )
}

fn sentence(text: &str) -> String {
    if text.is_empty() {
        String::new()
    } else {
        format!(": {text}")
    }
}
