//! What is wrong with a scene where a motion cannot go on, in the words of all methods.

use crate::model::Model;

/// What is wrong where steps shrink to nothing as an acceleration grows.
pub(crate) fn unbounded(coordinate: &str) -> String {
    format!(
        "the acceleration of `{coordinate}` grows without bound; check divisions and poles of the scene"
    )
}

/// What is wrong where a gap has one sign and then the other, and vanishes nowhere between.
pub(crate) fn leaps(name: &str) -> String {
    format!(
        "the gap of `{name}` changes its sign without passing zero, through infinity or by a jump, so that nothing can close; \
         check divisions, poles and angles of the scene"
    )
}

/// What is wrong where a condition changes at a pole or a jump of its function.
pub(crate) fn has_pole(name: &str) -> String {
    format!(
        "the function of the condition `{name}` changes its sign without passing zero, through infinity or by a jump, where neither side \
         is told from rounding; write the condition with a function that is continuous"
    )
}

/// What is wrong where the bound of a dry friction falls below zero.
pub(crate) fn negative_bound(name: &str) -> String {
    format!(
        "the bound of dry friction `{name}` is negative, so that no force obeys it; write one that is 0 or more all along \
         the motion"
    )
}

/// What is wrong where the motion is on the zero of a switch that it may leave to either side at any time.
pub(crate) fn not_unique(name: &str) -> String {
    format!(
        "the motion is not unique: it is where the function of `{name}` vanishes, and may go on with either side of it, to which what acts \
         pushes or from which nothing moves it; start to one side, or check the sign of what it switches"
    )
}

/// What is said where a motion slides along the zero of a switch that only its second rate feels.
pub(crate) fn second_order(name: &str) -> String {
    format!(
        "the function of `{name}` and its rate vanish here and stay zero while something else moves (sliding of second order), which no \
         method follows; write the motion with that function held at zero, or smooth the switch, as in tanh(c/width)"
    )
}

/// The parameters that are zero, as the end of a sentence about a division.
pub(in crate::simulation) fn zero_parameters(model: &dyn Model) -> String {
    let parameters = model.declaration().parameters.iter().enumerate();
    let zero = parameters.filter(|&(index, _)| model.parameter(index) == 0.0);
    let names: Vec<String> = zero.map(|(_, known)| format!("`{}`", known.name)).collect();
    match names.len() {
        0 => String::new(),
        1 => format!(" (the parameter {} is 0)", names[0]),
        _ => format!(" (the parameters {} are 0)", names.join(", ")),
    }
}
