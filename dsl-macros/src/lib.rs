//! The `model!` macro: a thin shell over [`hangtime_dsl`].

/// Declares a mechanical scene and derives everything that the solvers need from it.
#[proc_macro]
pub fn model(input: proc_macro::TokenStream) -> proc_macro::TokenStream {
    hangtime_dsl::expand(input.into()).into()
}

/// The time at which a library that the current crate depends on was finished, as
/// `Option<f64>` [s since 1970]: `finished_at!(library_name)`.
///
/// It is read from the file that the compiler's arguments name (`--extern name=path`), and is `None`
/// if they name none or the compiler was given its arguments in a file.
#[doc(hidden)]
#[proc_macro]
pub fn finished_at(library: proc_macro::TokenStream) -> proc_macro::TokenStream {
    let prefix = format!("{library}=");
    let finished = std::env::args()
        .filter_map(|argument| {
            let path = argument.strip_prefix("--extern=").unwrap_or(&argument);
            path.strip_prefix(&prefix).map(std::path::PathBuf::from)
        })
        .find(|path| {
            path.extension()
                .is_some_and(|extension| extension == "rlib")
        })
        .and_then(|path| path.metadata().ok()?.modified().ok())
        .and_then(|modified| modified.duration_since(std::time::UNIX_EPOCH).ok());
    let text = match finished {
        Some(time) => format!("::core::option::Option::Some({:?}_f64)", time.as_secs_f64()),
        None => "::core::option::Option::None".to_owned(),
    };
    text.parse().unwrap_or_default()
}
