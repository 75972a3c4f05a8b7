//! The modelling language of hangtime as a normal library: tokens in, tokens and metadata out.
//!
//! ```text
//! tokens -> parse -> check -> derive -> emit -> tokens
//! ```
//!
//! - `parse`: tokens to a syntax tree that keeps all places; recovers from mistakes, so that all of
//!   them are reported in one run.
//! - `check`: names, lengths of vectors, units, and the rules of mechanics; every expression becomes a
//!   node of the expression graph.
//! - `graph`: hash-consed expressions in normal form behind a `Copy` handle that is a number, and their derivatives.
//! - `derive`: equations of motion, contact quantities, sparse Jacobians and Hessians.
//! - `tape`, `emit`: straight-line Rust in chunks, a static description, documentation.

mod ast;
mod check;
pub mod declaration;
mod derive;
pub mod description;
mod diagnostics;
mod dimension;
mod emit;
mod evaluate;
mod expand;
mod format;
mod graph;
mod mistakes;
mod parse;
mod scene;
mod tape;
mod text;
mod whole;
mod words;

pub use diagnostics::Mistake;
pub use mistakes::{explanation, mistake_codes, page_name};
pub use text::{LONGEST, TextMistake, in_used, with_used};
pub use whole::read_whole;
pub use words::{is_word, words};

use crate::diagnostics::{Checked, Diagnostics, Place};
use description::{Description, Unfit};
use graph::Stage;
use proc_macro2::TokenStream;

/// Expands one `model! { ... }` declaration into Rust items, or into `compile_error!`s and a stub.
#[must_use]
pub fn expand(input: TokenStream) -> TokenStream {
    let stub_of = input.clone();
    match try_expand(input) {
        Ok(tokens) => tokens,
        Err(mistakes) => {
            let mut tokens = diagnostics::to_tokens(&mistakes);
            tokens.extend(stub(stub_of));
            tokens
        }
    }
}

/// A declaration with those of the files that `use "leg.hang"` names in it behind it, and so on; `read` reads one.
///
/// # Errors
/// What `read` said of a file that it cannot read, or that a file is made of no tokens.
pub fn with_files(
    input: TokenStream,
    mut read: impl FnMut(&str) -> Result<String, String>,
) -> Result<TokenStream, String> {
    let own = parse::body(input.clone()).unwrap_or_default();
    let (mut whole, mut names, mut asked) = (input, vec![String::new()], 1);
    text::note_used(own, &mut names, 0);
    while let Some(name) = names.get(asked) {
        let tokens = text::tokens_of_used(&read(name)?);
        let tokens = tokens.map_err(|mistake| format!("{name}: {mistake}"))?;
        text::note_used(tokens.clone(), &mut names, asked);
        whole.extend(tokens);
        asked += 1;
    }
    Ok(match asked {
        1 => whole,
        _ => text::taken_in(whole),
    })
}

/// What stands for a scene with mistakes, so that its uses give no further messages.
fn stub(input: TokenStream) -> TokenStream {
    parse::outline(input).map_or_else(TokenStream::new, |outline| {
        emit::stub(&outline.visibility, &outline.name, &outline.parameters)
    })
}

/// Expands one declaration, with a lint for each warning, or lists its mistakes.
///
/// # Errors
/// Every mistake and every warning found.
pub fn try_expand(input: TokenStream) -> Result<TokenStream, Vec<Mistake>> {
    let (mut tokens, warnings) = expand_and_warn(input)?;
    tokens.extend(diagnostics::to_tokens(&warnings));
    Ok(tokens)
}

/// Every mistake and every warning found in one declaration.
#[must_use]
pub fn mistakes(input: TokenStream) -> Vec<Mistake> {
    expand_and_warn(input).map_or_else(|mistakes| mistakes, |(_, warnings)| warnings)
}

fn expand_and_warn(input: TokenStream) -> Result<(TokenStream, Vec<Mistake>), Vec<Mistake>> {
    let mut diagnostics = Diagnostics::default();
    match expand_or_report(input, &mut diagnostics) {
        Ok(tokens) if diagnostics.mistakes() == 0 => Ok((tokens, diagnostics.into_mistakes())),
        _ => Err(diagnostics.into_mistakes()),
    }
}

/// Tokens, and mistakes and warnings in the order of the text.
pub type Expanded = (TokenStream, Vec<TextMistake>);

/// Expands the text of a file, which holds what stands inside `model! { ... }`, or only the statements of a scene that is
/// then called after `stem`, the name of the file; or lists its mistakes, with a stub for the scene.
///
/// # Errors
/// Every mistake and every warning found, and tokens that stand for the scene.
pub fn expand_text(text: &str, stem: &str) -> Result<Expanded, Expanded> {
    let tokens = text::tokens(text, stem).map_err(|mistakes| (TokenStream::new(), mistakes))?;
    match expand_and_warn(tokens.clone()) {
        Ok((scene, warnings)) => Ok((scene, in_text(warnings))),
        Err(mistakes) => Err((stub(tokens), in_text(mistakes))),
    }
}

/// Derives the scene that the text of a file declares, which holds what stands inside `model! { ... }`, or only the
/// statements of a scene that is then called after `stem`, the name of the file; with what is accepted, but most likely
/// not meant.
///
/// Time and memory are bounded for any text. The expression graph stays in memory until the next derivation of the
/// thread, and places of tokens as long as the thread lives.
///
/// # Errors
/// Every mistake and every warning found, in the order of the text.
///
/// ```
/// let ball = "
///     parameters { m: kg = 1, g: m/s^2 = 9.81 }
///     coordinates { z: m }
///     lagrangian m/2*dot(z)^2 - m*g*z
/// ";
/// let (derived, warnings) = hangtime_dsl::describe_text(ball, "ball").expect("no mistakes");
/// let declaration = derived.structure.declaration;
/// assert_eq!((declaration.name, declaration.inputs()), ("Ball", 2));
/// assert!(warnings.is_empty());
/// let mistakes = hangtime_dsl::describe_text(&ball.replace("dot(z)", "z'"), "ball").unwrap_err();
/// assert!(mistakes[0].message.contains("dot(z)"));
/// ```
pub fn describe_text(
    text: &str,
    stem: &str,
) -> Result<(Description, Vec<TextMistake>), Vec<TextMistake>> {
    describe_differentiated(text, stem, &[])
}

/// Derives a scene from a text, with derivatives of everything by `parameters`, which are names, as
/// [`sensitivity`](description::Structure::sensitivity); names that no
/// parameter has are left out.
///
/// # Errors
/// Every mistake and every warning found, in the order of the text.
///
/// ```
/// let ball = "
///     parameters { m: kg = 1, g: m/s^2 = 9.81 }
///     coordinates { z: m }
///     lagrangian m/2*dot(z)^2 - m*g*z
/// ";
/// let (derived, _) = hangtime_dsl::describe_differentiated(ball, "ball", &["g"]).expect("no mistakes");
/// let structure = derived.structure;
/// assert_eq!((structure.declaration.inputs(), structure.columns()), (2, 3));
/// assert_eq!(structure.declaration.free_jacobian.entries, [(0, 2)]);
/// ```
pub fn describe_differentiated(
    text: &str,
    stem: &str,
    parameters: &[&str],
) -> Result<(Description, Vec<TextMistake>), Vec<TextMistake>> {
    describe_as(text, stem, parameters, Parameters::Differentiated)
}

/// Derives a scene from a text, with these parameters as coordinates without motion behind all others, as [`held`](description::Structure::held), so
/// that everything is differentiated by them twice; names that no parameter has are left out. The order is that of declaration.
///
/// # Errors
/// Every mistake and every warning found, in the order of the text, among them bounds that depend on those parameters.
///
/// ```
/// let ball = "
///     parameters { m: kg = 1, g: m/s^2 = 9.81 }
///     coordinates { z: m }
///     lagrangian m/2*dot(z)^2 - m*g*z
///     start { z: 0.1*g*1 [s^2] }
/// ";
/// let (derived, _) = hangtime_dsl::describe_held(ball, "ball", &["g"]).expect("no mistakes");
/// let declaration = derived.structure.declaration;
/// assert_eq!((declaration.inputs(), declaration.coordinates[1].name), (4, "g"));
/// assert_eq!(declaration.free_jacobian.entries, [(0, 1)]);
/// assert_eq!(derived.structure.held.map(|held| held.declared.given.len()), Some(1));
/// ```
pub fn describe_held(
    text: &str,
    stem: &str,
    parameters: &[&str],
) -> Result<(Description, Vec<TextMistake>), Vec<TextMistake>> {
    describe_as(text, stem, parameters, Parameters::Held)
}

/// What becomes of the parameters that a derivation is to know about.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Parameters {
    /// Functions are differentiated by them once.
    Differentiated,
    /// They are coordinates without motion.
    Held,
}

fn describe_as(
    text: &str,
    stem: &str,
    parameters: &[&str],
    kind: Parameters,
) -> Result<(Description, Vec<TextMistake>), Vec<TextMistake>> {
    let tokens = text::tokens(text, stem)?;
    let mut diagnostics = Diagnostics::default();
    diagnostics.is_data = true;
    match derived(tokens, (parameters, kind), &mut diagnostics) {
        Ok((_, description)) if diagnostics.mistakes() == 0 => {
            Ok((description, in_text(diagnostics.into_mistakes())))
        }
        _ => Err(in_text(diagnostics.into_mistakes())),
    }
}

/// What acts in the scene that the text of a file declares, before anything is derived of it: its Lagrangian, and behind that the
/// generalized forces, one a coordinate and a state. What is derived can be compared with them.
///
/// # Errors
/// Every mistake and every warning found, in the order of the text.
///
/// ```
/// let ball = "coordinates { y: m, z: m } lagrangian 1 [kg]*(dot(y)^2 + dot(z)^2)/2 forces { z: 3 [N] }";
/// let acting = hangtime_dsl::acting(ball, "ball").expect("no mistakes");
/// assert_eq!(acting.outputs.len(), 3);
/// ```
pub fn acting(text: &str, stem: &str) -> Result<description::Kernel, Vec<TextMistake>> {
    let tokens = text::tokens(text, stem)?;
    let mut diagnostics = Diagnostics::default();
    diagnostics.is_data = true;
    graph::reset();
    let scene = parse::scene(tokens, &mut diagnostics)
        .and_then(|declared| check::scene(&declared, &mut diagnostics));
    match scene {
        Ok(scene) if diagnostics.mistakes() == 0 => Ok(description::Kernel::acting(&scene)),
        _ => Err(in_text(diagnostics.into_mistakes())),
    }
}

/// The text of a scene file with another number in `count name = ..`; none if it has no such count.
///
/// ```
/// let text = "count n = 2 coordinates { x[n]: m } lagrangian sum(k in 1..=n: dot(x[k])^2)";
/// let more = hangtime_dsl::with_count(text, "n", 3).expect("a count");
/// assert!(more.starts_with("count n = 3 ") && hangtime_dsl::with_count(text, "m", 3).is_none());
/// ```
#[must_use]
pub fn with_count(text: &str, name: &str, value: i64) -> Option<String> {
    let tokens = text::tokens(text, name).ok()?;
    let counts = expand::counts(parse::body(tokens)?);
    let (_, place) = counts.into_iter().find(|(known, _)| known == name)?;
    let (before, after) = (text.get(..place.start)?, text.get(place.end..)?);
    Some(format!("{before}{value}{after}"))
}

/// Gives back what this thread remembers of the texts that it has read, for threads that read many. Nothing that
/// [`describe_text`] returned is affected.
///
/// # Panics
/// Within a procedural macro.
pub fn forget_places() {
    proc_macro2::extra::invalidate_current_thread_spans();
}

/// The text of a scene file in the settled style; `stem` is the name of the file, as in [`describe_text`]. Formatting a
/// text that is formatted changes nothing, and the formatted text declares the same scene.
///
/// - Each statement begins a line. A block is one line if it was and has room there, and otherwise has one entry a
///   line, with a comma behind each.
/// - Lines have at most 120 columns where a sum can be broken before a `+` or `-`; what follows is indented.
/// - Comments stay above or behind what they were above or behind; one empty line is kept where there were some.
///
/// # Errors
/// The text has mistakes.
///
/// ```
/// let text = "parameters{m:kg=1,g : m/s^2=9.81}coordinates { z: m }\nlagrangian m / 2*dot(z)^2-m*g*z // plain";
/// let formatted = hangtime_dsl::format_text(text, "ball").expect("no mistakes");
/// assert_eq!(formatted, "\
/// parameters { m: kg = 1, g: m/s^2 = 9.81 }
/// coordinates { z: m }
/// lagrangian m/2*dot(z)^2 - m*g*z // plain
/// ");
/// ```
pub fn format_text(text: &str, stem: &str) -> Result<String, Vec<TextMistake>> {
    let own = in_used(text, &(0..0)).1;
    let behind = &text[own.len()..];
    let described = |own: &str| describe_text(&format!("{own}{behind}"), stem);
    let (declared, _) = described(own)?;
    let formatted = format::formatted(own);
    let same = described(&formatted).is_ok_and(|(again, _)| again == declared);
    // What the style has no rule for stays as it is.
    Ok(if same { formatted } else { own.to_owned() })
}

fn in_text(mistakes: Vec<Mistake>) -> Vec<TextMistake> {
    let mut mistakes: Vec<TextMistake> = mistakes.into_iter().map(TextMistake::of).collect();
    mistakes.sort_by_key(|mistake| mistake.place.start);
    mistakes
}

fn expand_or_report(input: TokenStream, diagnostics: &mut Diagnostics) -> Checked<TokenStream> {
    let text = text::of_declaration(input.clone());
    let (scene, description) = derived(input, (&[], Parameters::Differentiated), diagnostics)?;
    Ok(emit::scene(&scene, &description, &text))
}

/// From tokens to everything that is derived from them, differentiated by those parameters besides the inputs.
fn derived(
    input: TokenStream,
    (parameters, kind): (&[&str], Parameters),
    diagnostics: &mut Diagnostics,
) -> Checked<(scene::CheckedScene, Description)> {
    graph::reset();
    let declared = parse::scene(input, diagnostics)?;
    let mut scene = check::scene(&declared, diagnostics)?;
    let known = scene.parameters.iter().zip(0_u16..);
    let chosen = known.filter(|(known, _)| parameters.contains(&known.name.text.as_str()));
    let chosen: Vec<u16> = chosen.map(|(_, index)| index).collect();
    if kind == Parameters::Differentiated {
        scene.differentiated = chosen;
        derive::at_declared_start(&mut scene);
    } else if !chosen.is_empty() || !scene.remembered.is_empty() || scene.has_epigraphs() {
        check::without_free_bounds(&scene, &chosen, diagnostics)?;
        scene = derive::with_held(scene, &chosen);
    }
    // Only what happens to constants from here on is of interest.
    graph::take_fault();
    let place = lagrangian(&declared);
    let equations = derive::equations(&scene).map_err(|failure| match failure {
        // From there on all is zero.
        _ if graph::is_exhausted() => diagnostics.report("E22", place, too_large(&scene)),
        derive::Failure::SingularMass { coordinate } => {
            let name = &scene.coordinates[coordinate].name;
            diagnostics.report(
                "E06",
                name.place(),
                format!(
                    "the mass matrix is not positive definite whatever the parameters: `{}` carries no \
                     inertia of its own; add its kinetic energy or leave the coordinate out",
                    name.text
                ),
            )
        }
    })?;
    if graph::is_exhausted() {
        return Err(diagnostics.report("E22", place, too_large(&scene)));
    }
    if graph::take_fault().is_some_and(graph::Fault::is_of_range) {
        return Err(diagnostics.report("E21", place, DERIVED_CONSTANT));
    }
    check::inertia_at_start(&declared, &scene, &equations.mass, diagnostics)?;
    if diagnostics.mistakes() > 0 {
        return Err(diagnostics::Reported);
    }
    // What is not compiled takes no compile time.
    let most = match diagnostics.is_data {
        true => usize::MAX,
        false => description::BUDGET,
    };
    let description = Description::of(&scene, &equations, most).map_err(|unfit| match unfit {
        Unfit::Long { kernel, operations } => diagnostics.report(
            "E22",
            scene.name.place(),
            format!(
                "the derived function {kernel} has {operations} operations, more than {}; split the mechanism \
                 into smaller scenes or choose coordinates in which its inertia is simpler",
                description::BUDGET
            ),
        ),
        Unfit::Exhausted => diagnostics.report("E22", place, too_large(&scene)),
        Unfit::Constant => diagnostics.report("E21", place, DERIVED_CONSTANT),
    })?;
    Ok((scene, description))
}

/// What is said where not a formula of the declaration but what follows from it is too long.
fn too_large(scene: &scene::CheckedScene) -> String {
    let (what, remedy) = match graph::stage() {
        Stage::Declaration | Stage::Inertia => (
            "the mass matrix".to_owned(),
            "choose coordinates of which fewer move together, or leave out bodies",
        ),
        Stage::Forces => (
            "the inertial and conservative forces".to_owned(),
            "choose coordinates in which the kinetic energy is simpler, or leave out bodies",
        ),
        Stage::Motion => (
            "the derivatives of the accelerations".to_owned(),
            "choose coordinates of which fewer move together, or leave out bodies or forces",
        ),
        Stage::Contact(index) => (
            match scene.contacts.get(index) {
                Some(contact) => format!("contact `{}`", contact.name.text),
                None => "the contacts".to_owned(),
            },
            "write its gap by fewer coordinates, or leave out contacts",
        ),
        Stage::OptimalControl => (
            "costs and conditions".to_owned(),
            "write them by fewer coordinates",
        ),
        Stage::Kernels => (
            "the order of all operations".to_owned(),
            "leave out bodies or contacts",
        ),
    };
    format!(
        "the scene, of {} coordinates and {} contacts, takes more than {} million terms to derive, which is more than some seconds \
         of work, and is given up at {what}; {remedy}",
        scene.coordinates.len(),
        scene.contacts.len(),
        graph::allowed() / 1_000_000,
    )
}

const DERIVED_CONSTANT: &str = "a constant in the derivatives of the declaration has no finite value in double \
    precision; choose units in which the numbers are closer to 1";

/// Where the Lagrangian begins; mistakes that belong to all that is derived are shown there.
fn lagrangian(declared: &ast::Scene) -> Place {
    let mut statements = declared.statements.iter();
    let keyword = statements.find_map(|statement| match statement {
        ast::Statement::Lagrangian { keyword, .. } => Some(*keyword),
        _ => None,
    });
    keyword.unwrap_or_else(|| declared.name.place())
}
