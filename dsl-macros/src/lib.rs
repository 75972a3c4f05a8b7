//! The `model!` macro: a thin shell over [`hangtime_dsl`].

/// Declares a mechanical scene and derives everything that the solvers need from it.
#[proc_macro]
pub fn model(input: proc_macro::TokenStream) -> proc_macro::TokenStream {
    hangtime_dsl::expand(input.into()).into()
}
