//! A declaration that stands in a file of its own.

use proc_macro::TokenStream;
use std::env;
use std::fmt::Write as _;
use std::io;
use std::path::{Path, PathBuf};

pub(crate) fn expand(input: TokenStream) -> TokenStream {
    // Places in the file are known to the tokens of `proc_macro2` only, not to those of the compiler.
    let _own = OwnTokens::take();
    let code = expanded(&input.to_string()).unwrap_or_else(|message| refusal(&message));
    code.parse().unwrap_or_default()
}

fn expanded(argument: &str) -> Result<String, String> {
    let name = path(argument)?;
    let folder = env::var_os("CARGO_MANIFEST_DIR").map(PathBuf::from);
    let file = folder.unwrap_or_default().join(name);
    let text = hangtime_dsl::read_whole(&file, hangtime_dsl::LONGEST).and_then(|bytes| {
        String::from_utf8(bytes).map_err(|error| io::Error::new(io::ErrorKind::InvalidData, error))
    });
    let text = text.map_err(|error| {
        format!(
            "cannot read {}: {error}; give a path from the folder of the package's manifest",
            file.display()
        )
    })?;
    let stem = Path::new(name).file_stem().unwrap_or_default();
    let mut code = match hangtime_dsl::expand_text(&text, &stem.to_string_lossy()) {
        Ok(expanded) | Err(expanded) => {
            let (tokens, mistakes) = expanded;
            let mut code = tokens.to_string();
            for mistake in mistakes {
                let (line, column) = position(&text, mistake.place.start);
                let message = format!("{name}:{line}:{column}: {}", mistake.text());
                code += &if mistake.warning {
                    lint(&message)
                } else {
                    refusal(&message)
                };
            }
            code
        }
    };
    // Another text of the file is another scene.
    let _ = write!(
        code,
        "const _: &[u8] = ::core::include_bytes!({:?});",
        file.to_string_lossy()
    );
    Ok(code)
}

/// The path in a string literal, which needs no escapes.
fn path(argument: &str) -> Result<&str, String> {
    let quoted = argument
        .trim()
        .strip_prefix('"')
        .and_then(|rest| rest.strip_suffix('"'));
    quoted
        .filter(|path| !path.contains(['"', '\\']))
        .ok_or_else(|| {
            "write the path of a scene file: `model_file!(\"scenes/ball.hang\")`".to_owned()
        })
}

fn refusal(message: &str) -> String {
    format!("::core::compile_error! {{ {message:?} }}")
}

/// The use of a constant that is deprecated: the one way in which a macro can warn on stable Rust.
fn lint(message: &str) -> String {
    format!(
        "const _: () = {{ #[deprecated(note = {message:?})] #[allow(non_upper_case_globals)] \
         const warning: () = (); warning }};"
    )
}

/// Line and column of a place in a text, both counted from 1.
fn position(text: &str, place: usize) -> (usize, usize) {
    let before = &text[..place.min(text.len())];
    let start = before.rfind('\n').map_or(0, |end| end + 1);
    (
        before.matches('\n').count() + 1,
        before[start..].chars().count() + 1,
    )
}

/// Tokens that know their places, until it is dropped.
struct OwnTokens;

impl OwnTokens {
    fn take() -> Self {
        proc_macro2::fallback::force();
        Self
    }
}

impl Drop for OwnTokens {
    fn drop(&mut self) {
        proc_macro2::fallback::unforce();
    }
}
