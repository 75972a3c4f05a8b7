//! The modelling language of hangtime as a normal library: tokens in, tokens and metadata out.
//!
//! parse → check → derive → emit.

use proc_macro2::TokenStream;

/// Expands one `model! { ... }` declaration into Rust items, or into `compile_error!`s and a stub.
#[must_use]
pub fn expand(_input: TokenStream) -> TokenStream {
    TokenStream::new()
}
