//! Products of unknowns, with their derivatives.

/// Product of the values at these places but those that are left out.
pub(super) fn product(variables: &[usize], left_out: &[usize], x: &[f64]) -> f64 {
    let kept = variables.iter().enumerate();
    let kept = kept.filter(|(place, _)| !left_out.contains(place));
    kept.fold(1.0, |product, (_, &variable)| product * x[variable])
}

/// Calls `add` with each variable of a product and the derivative by it, as far as it stands at this place.
pub(super) fn slopes(variables: &[usize], x: &[f64], mut add: impl FnMut(usize, f64)) {
    for (place, &variable) in variables.iter().enumerate() {
        add(variable, product(variables, &[place], x));
    }
}

/// Calls `add` with each pair of variables of a product and the second derivative by both, as an entry of one triangle.
pub(super) fn curvatures(variables: &[usize], x: &[f64], mut add: impl FnMut(usize, usize, f64)) {
    for (place, &variable) in variables.iter().enumerate() {
        for (before, &other) in variables[..place].iter().enumerate() {
            let twice = if variable == other { 2.0 } else { 1.0 };
            add(
                variable,
                other,
                twice * product(variables, &[before, place], x),
            );
        }
    }
}

/// A number times a product of any number of unknowns, in a row or in the objective.
pub(super) struct Term {
    pub(super) row: usize,
    pub(super) variables: Vec<usize>,
    pub(super) coefficient: f64,
}
