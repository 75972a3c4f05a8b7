//! The macros behind `hangtime::model!` and `hangtime::model_file!`: a thin shell over [`hangtime_dsl`].
//!
//! The language is described where the macro is used from, at `hangtime::model!`.

/// Expands one declaration; see the language at `hangtime::model!`.
#[proc_macro]
pub fn model(input: proc_macro::TokenStream) -> proc_macro::TokenStream {
    file::expand_with_used(input)
}

mod file;

/// Expands the declaration in a file; see `hangtime::model_file!`.
#[proc_macro]
pub fn model_file(input: proc_macro::TokenStream) -> proc_macro::TokenStream {
    file::expand(input)
}
