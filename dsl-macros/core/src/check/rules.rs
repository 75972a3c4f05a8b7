//! Rules of mechanics, one function each.

use super::checker::Checker;
use crate::ast::{Expr, Name};
use crate::derive::simplify;
use crate::diagnostics::{Checked, Diagnostics, Place, list};
use crate::evaluate::Meaning;
use crate::graph::{self, Function, Node, Sym, Variable};
use crate::scene::Coordinate;
use crate::words;

/// E04: a scene needs coordinates and a Lagrangian.
pub(super) fn missing_statements(name: &Name, checker: &mut Checker<'_>) {
    if checker.coordinates.is_empty() && !checker.states.is_empty() {
        without_coordinates(name, checker);
    } else if checker.coordinates.is_empty() && checker.diagnostics.mistakes() == 0 {
        checker.diagnostics.report(
            "E04",
            name.place(),
            format!(
                "scene `{}` declares no coordinates; write `coordinates {{ y: m, z: m }}`",
                name.text
            ),
        );
    } else if checker.lagrangian.is_none() && checker.diagnostics.mistakes() == 0 {
        checker.diagnostics.report(
            "E04",
            name.place(),
            format!(
                "scene `{}` declares no Lagrangian; write `lagrangian` kinetic minus potential energy",
                name.text
            ),
        );
    }
}

/// E04: what a scene of states only has no mechanism for.
fn without_coordinates(name: &Name, checker: &mut Checker<'_>) {
    if checker.lagrangian.is_none() {
        checker.lagrangian = Some((Sym::ZERO, name.place()));
        return;
    }
    if checker.diagnostics.mistakes() == 0 {
        let message = format!(
            "scene `{}` declares states and no coordinates, so that there is nothing to have a Lagrangian; leave it out, or              declare what moves, as in `coordinates {{ y: m }}`",
            name.text
        );
        checker.diagnostics.report("E04", name.place(), message);
    }
}

/// Number of coordinates above which an energy that is quadratic as it is written is not differentiated twice to see it.
const MANY: usize = 8;

/// E22: what is derived is too large; from there on all is zero, of which nothing can be said.
fn derivable(place: Place, diagnostics: &mut Diagnostics) -> Checked<()> {
    if !graph::is_exhausted() {
        return Ok(());
    }
    Err(diagnostics.report(
        "E22",
        place,
        "the declaration is too large: it was given up in the momenta; choose coordinates of which fewer move together, or \
         leave out bodies",
    ))
}

/// E04 and E05: the Lagrangian contains velocities, every coordinate has inertia, and the kinetic
/// energy is quadratic in the velocities.
pub(super) fn inertia(
    coordinates: &[Coordinate],
    lagrangian: Sym,
    place: Place,
    diagnostics: &mut Diagnostics,
) -> Checked<()> {
    derivable(place, diagnostics)?;
    if !graph::contains(lagrangian, Variable::is_velocity) {
        return Err(diagnostics.report(
            "E04",
            place,
            "the Lagrangian contains no velocity, so nothing moves; add the kinetic energy, e.g. \
             `m/2*dot(y)^2`",
        ));
    }
    let velocities = Variable::velocities(coordinates.len());
    let momenta = graph::gradient(lagrangian, &velocities);
    let quadratic = coordinates.len() > MANY
        && graph::degree(lagrangian, Variable::is_velocity).is_some_and(|degree| degree <= 2);
    let mut result = Ok(());
    for (i, coordinate) in coordinates.iter().enumerate() {
        let row = match quadratic {
            true => Vec::new(),
            false => graph::partial(&momenta, velocities[i]),
        };
        derivable(place, diagnostics)?;
        let moves = match quadratic {
            true => graph::contains(momenta[i], Variable::is_velocity),
            false => row.iter().any(|entry| !entry.is_structural_zero()),
        };
        if !moves {
            result = Err(diagnostics.report(
                "E05",
                coordinate.name.place(),
                format!(
                    "coordinate `{0}` carries no inertia: the Lagrangian is not quadratic in `dot({0})`; \
                     add its kinetic energy, or make it a parameter or a control",
                    coordinate.name.text
                ),
            ));
        }
        if row
            .iter()
            .any(|&entry| graph::depends_on(entry, Variable::is_velocity))
        {
            result = Err(diagnostics.report(
                "E04",
                place,
                format!(
                    "the inertia of coordinate `{}` depends on velocities; the Lagrangian must be \
                     quadratic in the velocities",
                    coordinate.name.text
                ),
            ));
        }
    }
    result
}

/// E13: roots and norms that are not differentiable at rest, or where a contact is open.
pub(super) fn smooth(value: Sym, expr: &Expr, checker: &mut Checker<'_>) -> Checked<()> {
    // States, which are velocities behind those of the mechanism, are at rest nowhere by themselves.
    let states = checker.coordinates.len();
    let is_velocity = |variable| match variable {
        Variable::Velocity(index) => usize::from(index) < states,
        _ => false,
    };
    let at_rest = |part: Sym| graph::vanishes_with(part, is_velocity);
    let parts = graph::reachable(&[value]);
    let is_root = |part: &Sym| match part.node() {
        Node::Product(factors) => factors
            .iter()
            .any(|&(factor, halves)| halves % 2 != 0 && at_rest(factor)),
        _ => false,
    };
    let is_called = |part: &Sym| match part.node() {
        Node::Call(Function::Root | Function::Cbrt | Function::Ln, argument) => at_rest(argument),
        _ => false,
    };
    let message = if parts.iter().any(is_root) {
        "a root or norm of velocities is not differentiable at rest; square it, as in `|dot(p)|^2`"
            .to_owned()
    } else if parts.iter().any(of_open_contact) {
        format!(
            "`{expr}` has a root, a logarithm or the reciprocal of the force or impulse of a contact, which is 0 \
             while the contact is open; use powers of it, as in `force(ground)^2`"
        )
    } else if parts.iter().any(is_called) {
        "a root, norm or logarithm of velocities is not differentiable at rest; square a norm, as in \
         `|dot(p)|^2`"
            .to_owned()
    } else {
        return Ok(());
    };
    Err(checker.diagnostics.report("E13", expr.place, message))
}

/// Whether something has no derivative or no value where forces and impulses are 0, as they are while a contact is open.
fn of_open_contact(part: &Sym) -> bool {
    let vanishes = |part| graph::vanishes_with(part, Variable::is_of_contact);
    match part.node() {
        Node::Product(factors) => factors
            .iter()
            .any(|&(factor, halves)| (halves < 0 || halves % 2 != 0) && vanishes(factor)),
        Node::Call(Function::Cbrt | Function::Ln, argument) => vanishes(argument),
        _ => false,
    }
}

/// E07 and E09: a surface depends on coordinates, on nothing else that moves, and has a normal.
pub(super) fn surface(
    name: &Name,
    gap: Sym,
    (left, right): (&Expr, &Expr),
    checker: &mut Checker<'_>,
) -> Checked<()> {
    let text = &name.text;
    let place = left.place.to(right.place);
    let wrong = |variable: Variable| variable.is_velocity() || variable.is_control();
    checker.free_of(&[gap], wrong, (Some("E07"), place), |wrong| {
        format!("surface `{text}` depends on {wrong}; a surface bounds positions only")
    })?;
    if !graph::depends_on(gap, Variable::is_coordinate) {
        let names: Vec<String> = checker
            .coordinates
            .iter()
            .map(|known| known.name.text.clone())
            .collect();
        let (code, message) = if names
            .iter()
            .any(|name| left.mentions(name) || right.mentions(name))
        {
            (
                "E09",
                format!(
                    "the coordinates cancel out of surface `{text}`, so it has no normal; check both \
                     sides of the inequality"
                ),
            )
        } else {
            (
                "E07",
                format!(
                    "surface `{text}` depends on no coordinate; use one of {}",
                    list(names.iter().map(String::as_str))
                ),
            )
        };
        return Err(checker.diagnostics.report(code, place, message));
    }
    if is_square(gap) {
        return Err(checker.diagnostics.report(
            "E09",
            left.place.to(right.place),
            format!(
                "the gradient of surface `{text}` is zero where it is touched, as the gap is a square; \
                 write the distance itself"
            ),
        ));
    }
    Ok(())
}

/// Whether a function of positions is one square, or a multiple of it.
pub(super) fn is_square(function: Sym) -> bool {
    let squared = |sym: Sym| match sym.node() {
        Node::Product(factors) => factors.iter().any(|&(factor, halves)| {
            halves >= 4 && graph::depends_on(factor, Variable::is_coordinate)
        }),
        _ => false,
    };
    match function.node() {
        Node::Sum(terms) if terms.len() == 1 => squared(terms[0].0),
        _ => squared(function),
    }
}

/// E27: gravity is no second one of what the scene writes into the Lagrangian itself: with the defaults of the parameters its forces, or how
/// they change with a parameter, are not those of the weight of a body, or of all of them.
pub(super) fn weight(lagrangian: Sym, checker: &mut Checker<'_>) {
    let (mut weights, mut place) = (Vec::new(), None);
    for name in checker.abbreviations.iter().map(|known| &known.name) {
        let known = checker.scope.names.get(&name.text);
        if let Some(Meaning::Value(value)) = known.filter(|_| name.text.ends_with(words::WEIGHT)) {
            weights.extend(value.syms());
            place = Some(name.place());
        }
    }
    let Some(place) = place else { return };
    let all: Sym = weights.iter().copied().sum();
    let still = |variable: Variable| variable.is_velocity().then_some(Sym::ZERO);
    let written = simplify(graph::substitute(&[lagrangian], still)[0] - all);
    let coordinates = Variable::coordinates(checker.coordinates.len());
    let forces = |energy: Sym| {
        let forces = graph::gradient(checker.with_defaults(energy), &coordinates);
        forces.into_iter().map(simplify)
    };
    let alike = |weight: Sym| {
        let variables = graph::variables(&[written]).into_iter();
        let parameters = variables.filter(|by| matches!(by, Variable::Parameter(_)));
        let changes =
            parameters.map(|by| [written, weight].map(|own| graph::partial(&[own], by)[0]));
        let mut pairs = std::iter::once([written, weight]).chain(changes);
        pairs.any(|[own, its]| {
            forces(own - its).all(|force| force == Sym::ZERO)
                && forces(its).any(|force| force != Sym::ZERO)
        })
    };
    if written != Sym::ZERO && weights.into_iter().chain([all]).any(alike) {
        let message = "the Lagrangian has the weight of a body already, which `gravity` adds once more; leave one of them out";
        checker.diagnostics.warn("E27", place, message);
    }
}

/// E16: everything declared is used; a warning, as the declaration means the same with it.
pub(super) fn unused(checker: &mut Checker<'_>) {
    let mut unused: Vec<(Place, String)> = Vec::new();
    let is_unused = |name: &Name| !checker.scope.used.contains(&name.text);
    // Of free ones more is asked, see `design`.
    let free = |index: usize| {
        let mut free = checker.free_parameters.iter();
        free.any(|free| usize::from(free.index) == index)
    };
    for (index, parameter) in checker.parameters.iter().enumerate() {
        if is_unused(&parameter.name) && !free(index) {
            unused.push((
                parameter.name.place(),
                format!("parameter `{}` is never used", parameter.name.text),
            ));
        }
    }
    for control in &checker.controls {
        if is_unused(&control.name) {
            unused.push((
                control.name.place(),
                format!(
                    "control `{}` is never used; let it act by `forces {{ ... }}`",
                    control.name.text
                ),
            ));
        }
    }
    for abbreviation in &checker.abbreviations {
        // What a part offers, and members of what repeats, need not all be used.
        let alone = !abbreviation.name.text.contains(['[', '.']);
        if alone && is_unused(&abbreviation.name) {
            unused.push((
                abbreviation.name.place(),
                format!(
                    "{} `{}` is never used",
                    abbreviation.what, abbreviation.name.text
                ),
            ));
        }
    }
    for (place, text) in unused {
        let message = if text.contains(';') {
            text
        } else {
            format!("{text}; leave it out")
        };
        checker.diagnostics.warn("E16", place, message);
    }
}
