//! A derived scene to Rust items: the struct with its parameters, its kernels as functions, and its static description, of which the
//! runtime makes a model.

mod data;
mod kernel;
mod structure;
mod tapes;

pub(crate) use structure::stub;

use crate::description::Description;
use crate::scene::CheckedScene;
use proc_macro2::TokenStream;
use quote::quote;
use std::fmt::Write;

/// Emits a scene, which says what it was declared by.
pub(crate) fn scene(scene: &CheckedScene, derived: &Description, text: &str) -> TokenStream {
    let name = scene.name.rust();
    let mut code = kernel::all(derived, &name);
    numbers(scene, derived, text, &mut code);
    let items = parsed(&code);
    let structure = data::tokens(&derived.structure);
    let mut tokens = structure::tokens(scene, derived);
    tokens.extend(quote! {
        #[allow(unused, non_snake_case, non_upper_case_globals, clippy::all, clippy::pedantic, clippy::nursery, clippy::restriction)]
        const _: () = {
            // Names that nothing around the scene can take.
            use ::core::primitive::{f64 as __f64, usize as __usize};
            static __STRUCTURE: ::hangtime::scene::data::Structure = #structure;
            #items
        };
    });
    tokens
}

fn parsed(code: &str) -> TokenStream {
    code.parse().unwrap_or_else(|error| {
        let text = format!("the emitted code does not read as Rust: {error}");
        quote!(::core::compile_error! { #text })
    })
}

/// The scene to the runtime: its description, its kernels, and the numbers that it consists of.
fn numbers(scene: &CheckedScene, derived: &Description, text: &str, code: &mut String) {
    let name = scene.name.rust();
    let mut read = String::new();
    let mut write = String::new();
    for (i, parameter) in scene.parameters.iter().enumerate() {
        let field = parameter.name.rust();
        let _ = write!(read, "{i} => self.{field},");
        let _ = write!(write, "{i} => self.{field} = __value,");
    }
    for row in 0..derived.structure.joint_rows() {
        let i = scene.parameters.len() + row;
        let _ = write!(read, "{i} => self.{}[{row}],", kernel::HELD);
        let _ = write!(write, "{i} => self.{}[{row}] = __value,", kernel::HELD);
    }
    let _ = write!(
        code,
        "static __SCENE: ::hangtime::scene::Declared = ::hangtime::scene::Declared::new(&__STRUCTURE, {text:?});
        #[automatically_derived] impl ::hangtime::scene::Model for {name} {{
            fn structure(&self) -> &'static ::hangtime::scene::data::Structure {{ &__STRUCTURE }}
            fn declared(&self) -> &::hangtime::scene::Declared {{ &__SCENE }}
            fn number(&self, __index: __usize) -> __f64 {{ match __index {{ {read} _ => __f64::NAN }} }}
            fn set_number(&mut self, __index: __usize, __value: __f64) {{ match __index {{ {write} _ => {{}} }} }}
            fn kernel(&self, __kernel: __usize, __x: &[__f64], __y: &[__f64], __out: &mut [__f64]) {{
                __KERNELS[__kernel](self, __x, __y, __out)
            }}
            fn boxed(&self) -> ::std::boxed::Box<dyn ::hangtime::scene::Model> {{ ::std::boxed::Box::new(::core::clone::Clone::clone(self)) }}
        {}
         }}",
        tapes::method(derived)
    );
}
