//! Every word of the language.

/// Words that begin a statement.
pub(crate) const STATEMENTS: [&str; 26] = [
    "parameters",
    "coordinates",
    "controls",
    "states",
    "rates",
    "let",
    "fn",
    "profile",
    "lagrangian",
    "dissipation",
    "forces",
    "surface",
    "impact",
    "dry",
    "joint",
    "when",
    "at",
    "start",
    "horizon",
    "constraint",
    "minimize",
    "finally",
    "free",
    "measured",
    "outputs",
    "picture",
];

/// The name in place of that of an abbreviation where numbers are above zero, which is written out and which nobody can write.
pub(crate) const POSITIVE: &str = "above.zero";

/// The name of what gravity adds to the Lagrangian for a body, behind that of the body, which nobody can write.
pub(crate) const WEIGHT: &str = "of.gravity";

/// Words that begin a statement where a name follows, and are names otherwise: what is written out before anything is read. Each
/// with how it is written.
pub(crate) const WRITTEN_OUT: [(&str, &str); 12] = [
    ("count", "count n = 3"),
    ("part", "part leg(a: m) { coordinates { q: rad } .. }"),
    ("use", "use \"leg.hang\""),
    ("gravity", "gravity (0, -g)"),
    (
        "body",
        "body block: mass m, inertia j, at (x, z), angle phi",
    ),
    ("shape", "shape block: rectangle (w, h)"),
    ("contact", "contact block, ground: inelastic, friction mu"),
    ("hinge", "hinge elbow: upper.tip == lower.base"),
    ("ball", "ball socket: upper.tip == lower.base"),
    ("weld", "weld seam: block.corner[1] == plate.tip"),
    ("slider", "slider rail: block on frame along (1, 0)"),
    ("rolling", "rolling grip: wheel on ground"),
];

/// How a statement is written that is written out.
pub(crate) fn example(word: &str) -> Option<&'static str> {
    let known = WRITTEN_OUT.iter().find(|(known, _)| *known == word);
    known.map(|(_, example)| *example)
}

/// Whether a word begins a statement of bodies where a name follows.
pub(crate) fn is_of_bodies(word: &str) -> bool {
    WRITTEN_OUT[3..].iter().any(|(known, _)| *known == word)
}

/// Whether what stands behind a word belongs to it and begins no statement.
pub(crate) fn takes_next(word: &str) -> bool {
    is_keyword(word) && word != "inelastic"
}

/// Words that begin what is said of a body.
pub(crate) const BODY: [&str; 7] = ["mass", "inertia", "centre", "at", "angle", "turn", "fixed"];

/// Words that begin what is said of a shape: its kind, how it lies on its body.
pub(crate) const SHAPE: [&str; 12] = [
    "circle",
    "rectangle",
    "polygon",
    "half",
    "below",
    "capsule",
    "segment",
    "point",
    "sphere",
    "box",
    "at",
    "angle",
];

/// Words of bodies and shapes without a value.
pub(crate) const BARE: [&str; 2] = ["fixed", "point"];

/// Words that begin what is said of a joint of bodies.
pub(crate) const JOINT: [&str; 5] = ["along", "angle", "motor", "stop", "restitution"];

/// Whether a word of a statement of bodies stands apart from its value.
pub(crate) fn is_clause(word: &str) -> bool {
    let mut words = [&BODY[..], &SHAPE, &JOINT].into_iter().flatten();
    !BARE.contains(&word) && words.any(|known| *known == word) || ["gravity", "on"].contains(&word)
}

/// Functions of other languages, and what is written instead.
const FOREIGN: [(&[&str], &str); 5] = [
    (&["log"], "the natural logarithm is `ln`"),
    (
        &["pow", "powi", "powf", "square"],
        "powers are written `x^2`",
    ),
    (
        &["d", "ddt", "der", "derivative"],
        "the rate of `y` is `dot(y)`",
    ),
    (
        &["ddot", "acc"],
        "accelerations follow from the `lagrangian`; what acts besides stands in `forces { x: ... }`",
    ),
    (&["norm"], "the length of a vector is `|v|`"),
];

/// Statements that there are not, and what is written instead.
const OTHERWISE: [(&[&str], &str); 18] = [
    (
        &["maximize", "maximise"],
        "what is to be large is minimized with its sign changed, as in `minimize -(...)`",
    ),
    (
        &["subject"],
        "conditions at the end stand in `finally { ... }`, others in `constraint`",
    ),
    (
        &["objective", "cost"],
        "an objective begins with `minimize`",
    ),
    (
        &["initial", "initially", "init", "guess"],
        "values at the begin stand in `start { x: ..., dot(x): ... }`",
    ),
    (
        &["goal", "target", "terminal"],
        "conditions at the end stand in `finally { x == ... }`",
    ),
    (
        &["constants", "constant", "const", "params"],
        "numbers with names stand in `parameters { m: kg = 1 }`",
    ),
    (
        &["variables", "unknowns"],
        "what moves stands in `coordinates { x: m }`; velocities are `dot(x)`",
    ),
    (
        &["state"],
        "what changes at a rate stands in `states { a: A }`, and the rate in `rates { a: ... }`; what moves stands in `coordinates { x: m }`",
    ),
    (&["rate"], "the rates of states stand in `rates { a: ... }`"),
    (
        &["inputs", "input", "actuators"],
        "what is to be found over the time stands in `controls { u: N in -1..=1 }`",
    ),
    (
        &["kinetic", "potential", "energy"],
        "energies stand in one `lagrangian`, kinetic minus potential",
    ),
    (
        &["damping", "damper", "drag"],
        "what brakes stands in `dissipation c/2*dot(x)^2` or `forces { x: -c*dot(x) }`",
    ),
    (
        &["force", "torque", "load"],
        "what acts stands in `forces { x: ... }`, an entry for each coordinate",
    ),
    (
        &["equations", "equation", "dynamics", "ode"],
        "equations of motion follow from the `lagrangian`; what acts besides stands in `forces { x: ... }`",
    ),
    (
        &["ground", "wall", "obstacle"],
        "what is not passed through is a `surface name: z >= 0` with a law, `impact name: inelastic`",
    ),
    (
        &["bounds"],
        "bounds stand behind a name where it is declared, as in `controls { u: N in -1..=1 }`",
    ),
    (
        &["duration", "tend"],
        "the duration of a motion is `horizon 2 [s]`",
    ),
    (
        &["plot", "record"],
        "what is recorded stands in `outputs { name: unit = ... }`",
    ),
];

/// What is written instead of a function of another language.
pub(crate) fn foreign(text: &str) -> Option<&'static str> {
    instead(&FOREIGN, text)
}

fn instead(known: &[(&[&str], &'static str)], text: &str) -> Option<&'static str> {
    let mut known = known.iter();
    known.find_map(|(words, instead)| words.contains(&text).then_some(*instead))
}

/// What is said of a word where a statement begins that there is not, if it is near to one or known otherwise.
pub(crate) fn unknown_statement(text: &str, near: Option<&str>) -> Option<String> {
    if let Some(instead) = instead(&OTHERWISE, text) {
        return Some(format!("there is no statement `{text}`; {instead}"));
    }
    near.map(|near| format!("unknown statement `{text}`; did you mean `{near}`?"))
}

/// Words that begin a part of an impact law.
pub(crate) const LAW_PARTS: [&str; 7] = [
    "inelastic",
    "restitution",
    "friction",
    "sliding",
    "along",
    "holding",
    "in",
];

/// Words that begin a part of `dry friction`; the first may be taken by declarations.
pub(crate) const DRY_PARTS: [&str; 2] = ["bound", "sliding"];

/// Whether a word belongs to the language, so that it names nothing else.
pub(crate) fn is_keyword(text: &str) -> bool {
    STATEMENTS.contains(&text) || LAW_PARTS.contains(&text)
}

/// Whether a word begins a statement, a part of an impact law, or a shape of a picture: what an editor sets apart.
///
/// ```
/// assert!(hangtime_dsl::is_word("surface") && hangtime_dsl::is_word("spring"));
/// assert!(!hangtime_dsl::is_word("sin"));
/// ```
#[must_use]
pub fn is_word(text: &str) -> bool {
    is_keyword(text) || SHAPES.contains(&text) || example(text).is_some()
}

/// All words that an editor sets apart: those of which [`is_word`] is true.
///
/// ```
/// assert!(hangtime_dsl::words().iter().all(|word| hangtime_dsl::is_word(word)));
/// assert!(hangtime_dsl::words().contains(&"states"));
/// ```
#[must_use]
pub fn words() -> Vec<&'static str> {
    let written_out = WRITTEN_OUT.map(|(word, _)| word);
    [&STATEMENTS[..], &LAW_PARTS, &SHAPES, &written_out].concat()
}

/// Functions of one number.
pub(crate) const FUNCTIONS: [&str; 13] = [
    "sin", "cos", "tan", "asin", "acos", "atan", "sinh", "cosh", "tanh", "exp", "ln", "sqrt",
    "cbrt",
];

/// Functions with their own rules.
pub(crate) const SPECIAL_FUNCTIONS: [&str; 4] = ["dot", "diff", "atan2", "cross"];

/// Whether a name is that of a function of the language.
pub(crate) fn is_function(text: &str) -> bool {
    FUNCTIONS.contains(&text)
        || SPECIAL_FUNCTIONS.contains(&text)
        || MATRIX_FUNCTIONS.contains(&text)
}

/// The running cost in an objective.
pub(crate) const INTEGRAL: &str = "integral";

/// The largest value of a quantity over the motion, in an objective and in a goal; its name may be taken by declarations.
pub(crate) const PEAK: &str = "peak";

/// What adds a function of impulses up over all impacts; its name may be taken by declarations.
pub(crate) const SUM: &str = "sum";

/// How far a motion is from a measured one, in an objective; its name may be taken by declarations.
pub(crate) const MISFIT: &str = "misfit";

/// The loss of a misfit that grows linearly far away, so that outliers count less.
pub(crate) const HUBER: &str = "huber";
/// What a quantity is at the start of the motion; its word begins a statement as well, where braces follow.
pub(crate) const START: &str = "start";
/// What a quantity is at a time; its word begins a statement as well, where braces follow.
pub(crate) const AT: &str = "at";
/// The size of the sliding velocity in a coefficient of friction and in the bound of dry friction; its name may be taken by
/// declarations.
pub(crate) const SPEED: &str = "speed";

/// The final time in an objective or a terminal condition.
pub(crate) const FINAL_TIME: &str = "time";

/// Functions that make matrices; their names may be taken by declarations.
pub(crate) const MATRIX_FUNCTIONS: [&str; 6] = [
    "rotation",
    "rotation_x",
    "rotation_y",
    "rotation_z",
    "transpose",
    "diagonal",
];

/// Functions of a contact in `outputs` and in optimal control: its normal and its tangential force, and the same of the impulses of its impacts;
/// their names may be taken by declarations.
pub(crate) const CONTACT_FUNCTIONS: [&str; 4] =
    ["force", "friction_force", "impulse", "friction_impulse"];

/// Words that begin an entry of `picture`.
pub(crate) const SHAPES: [&str; 7] = [
    "point",
    "circle",
    "rectangle",
    "polygon",
    "link",
    "spring",
    "curve",
];

/// Words in front of the properties of a shape, where an expression ends.
pub(crate) const PROPERTIES: [&str; 7] = ["at", "angle", "radius", "size", "corners", "to", "over"];

/// Whether a word of a picture stands apart from what follows, so that an expression ends before it.
pub(crate) fn is_of_picture(word: &str) -> bool {
    PROPERTIES.contains(&word) || SHAPES.contains(&word)
}

/// Functions with a kink or a jump, which dynamics must not have.
pub(crate) const NONSMOOTH: [&str; 11] = [
    "abs",
    "min",
    "max",
    "clamp",
    "sign",
    "signum",
    "floor",
    "ceil",
    "round",
    "step",
    "heaviside",
];

/// Those of them that a surface may contain, as its pieces are smooth.
pub(crate) const EDGES: [&str; 4] = ["abs", "min", "max", "clamp"];

/// Those of them that jump, which forces and rates may contain besides.
pub(crate) const JUMPS: [&str; 4] = ["sign", "signum", "step", "heaviside"];

/// What chooses between two values by a comparison; its name as that of a function is no name of a scene.
pub(crate) const IF: &str = "if";

/// Names that the time-freezing reformulation and the emitted code keep for themselves.
pub(crate) const RESERVED: [&str; 6] =
    ["t", "time", "clock", "numerical_time", "clock_state", "pi"];

/// Words that an edition of Rust reserves and older ones do not; they are emitted raw.
const RAW: [&str; 1] = ["gen"];

/// Whether a name is emitted as a raw identifier.
pub(crate) fn is_raw(text: &str) -> bool {
    RAW.contains(&text)
}

/// A name, or what contains one, as source of any edition of Rust: all that is emitted under a declared name goes through here.
pub(crate) fn rust_name(text: &str) -> String {
    if is_raw(text) {
        format!("r#{text}")
    } else {
        // Members and parts: `theta[3]`, `left.knee`.
        text.replace(']', "").replace(['[', '.', '-'], "_")
    }
}

/// Whether a word cannot name a field or a type in Rust.
pub(crate) fn is_rust_word(text: &str) -> bool {
    let in_rust = || syn::parse_str::<syn::Ident>(&rust_name(text));
    !is_raw(text) && (text.starts_with("r#") || in_rust().is_err())
}

/// The name whose velocity is written like this elsewhere, such as `y` by `ydot`, `y_dot` or `dy`; `dot(y)` is meant.
pub(crate) fn velocity_of<'a>(text: &str, known: &[&'a str]) -> Option<&'a str> {
    let stem = text
        .strip_suffix("_dot")
        .or_else(|| text.strip_suffix("dot"))
        .or_else(|| text.strip_prefix('d'))?;
    known.iter().copied().find(|name| *name == stem)
}
