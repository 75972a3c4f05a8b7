//! A declaration that stands in a file of its own.

use proc_macro::TokenStream;
use std::env;
use std::io;
use std::path::{Path, PathBuf};

pub(crate) fn expand(input: TokenStream) -> TokenStream {
    // Places in the file are known to the tokens of `proc_macro2` only, not to those of the compiler.
    let _own = OwnTokens::take();
    let code = expanded(&input.to_string()).unwrap_or_else(|message| refusal(&message));
    code.parse().unwrap_or_default()
}

/// The declaration in the macro itself, with the files beside the manifest that it uses.
pub(crate) fn expand_with_used(input: TokenStream) -> TokenStream {
    let text = input.to_string();
    let mut files = Vec::new();
    let mut read_used = |name: &str| {
        let file = beside_manifest(name);
        let text = read(&file);
        files.push(file);
        text
    };
    let whole = hangtime_dsl::with_files(input.into(), &mut read_used);
    let mut code: TokenStream = match whole {
        Ok(tokens) => hangtime_dsl::expand(tokens).into(),
        Err(message) => refusal(&message).parse().unwrap_or_default(),
    };
    if !files.is_empty() {
        if let Some(told) = told_of_used(&text) {
            code = told.parse().unwrap_or_default();
        }
        let included: String = files.iter().map(|file| included(file)).collect();
        code.extend(included.parse::<TokenStream>());
    }
    code
}

/// Mistakes in files that a declaration uses, whose places the tokens of the compiler do not know; none if it has no such.
fn told_of_used(text: &str) -> Option<String> {
    let _own = OwnTokens::take();
    let whole = hangtime_dsl::with_used(text, |name| read(&beside_manifest(name))).ok()?;
    let (code, told) = translated(&whole, "", |used| used.is_some());
    (told > 0).then_some(code)
}

fn beside_manifest(name: &str) -> PathBuf {
    let folder = env::var_os("CARGO_MANIFEST_DIR").map(PathBuf::from);
    folder.unwrap_or_default().join(name)
}

fn read(file: &Path) -> Result<String, String> {
    let text = hangtime_dsl::read_whole(file, hangtime_dsl::LONGEST).and_then(|bytes| {
        String::from_utf8(bytes).map_err(|error| io::Error::new(io::ErrorKind::InvalidData, error))
    });
    text.map_err(|error| {
        format!(
            "cannot read {}: {error}; give a path from the folder of the package's manifest",
            file.display()
        )
    })
}

/// Another text of a file is another scene.
fn included(file: &Path) -> String {
    let file = file.to_string_lossy();
    format!("const _: &[u8] = ::core::include_bytes!({file:?});")
}

fn expanded(argument: &str) -> Result<String, String> {
    let name = path(argument)?;
    let file = beside_manifest(name);
    let mut files = vec![file.clone()];
    let whole = hangtime_dsl::with_used(&read(&file)?, |name| {
        let file = file.with_file_name(name);
        let text = read(&file);
        files.push(file);
        text
    })?;
    let (mut code, _) = translated(&whole, name, |_| true);
    code.extend(files.iter().map(|file| included(file)));
    Ok(code)
}

/// The code of a text, or of a stub of its scene, behind which its mistakes are told in the files that are asked for; and how many.
fn translated(whole: &str, name: &str, is_asked: fn(Option<&str>) -> bool) -> (String, usize) {
    let stem = Path::new(name).file_stem().unwrap_or_default();
    let (Ok(expanded) | Err(expanded)) = hangtime_dsl::expand_text(whole, &stem.to_string_lossy());
    let (tokens, mistakes) = expanded;
    let (mut code, mut told) = (tokens.to_string(), 0);
    for mistake in mistakes {
        let (used, text, place) = hangtime_dsl::in_used(whole, &mistake.place);
        if !is_asked(used) {
            continue;
        }
        let (line, column) = position(text, place.start);
        let file = used.map_or(PathBuf::from(name), |used| {
            Path::new(name).with_file_name(used)
        });
        let message = format!("{}:{line}:{column}: {}", file.display(), mistake.text());
        code += &if mistake.warning {
            lint(&message)
        } else {
            told += 1;
            refusal(&message)
        };
    }
    (code, told)
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
