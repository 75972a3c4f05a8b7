//! Impact laws: what their parts may be, and which surface has which.

use super::checker::{CheckedFriction, CheckedLaw, Checker, Sliding, Surface};
use super::friction;
use crate::ast::{Expr, Kind, Law, Name};
use crate::derive::simplify;
use crate::diagnostics::{Checked, Diagnostics, Reported, closest, list};
use crate::dimension::Dimension;
use crate::evaluate::{Number, Value};
use crate::graph::{self, Compose, Sym, Variable};
use crate::parse::law_of;
use crate::scene::{self, Contact, Friction};
use crate::words;
use std::collections::HashSet;

pub(super) fn impact(checker: &mut Checker<'_>, surfaces: &[Name], law: &Law) -> Checked<()> {
    let before = checker.diagnostics.mistakes();
    let restitution = law
        .restitution
        .as_ref()
        .map(|expr| coefficient(checker, expr, "restitution", 1.0));
    let first = checker.laws.sliding.len();
    let sliding = law.sliding.as_ref().map(|expr| {
        let velocities = velocities(expr).iter();
        velocities
            .map(|expr| of_piece(checker, surfaces, expr))
            .collect::<Checked<Vec<Vec<Sym>>>>()
    });
    let speed = speed(checker, &surfaces[0], first);
    let friction = law
        .friction
        .as_ref()
        .map(|expr| friction::coefficients(checker, expr, law.at_rest.as_ref(), speed));
    let along = law.along.as_ref().map(|expr| direction(checker, expr));
    let held = held(checker, &law.holding);
    let (Ok(restitution), Ok(friction), Ok(sliding), Ok(along), Ok(held)) = (
        restitution.transpose(),
        friction.transpose(),
        sliding.transpose(),
        along.transpose(),
        held,
    ) else {
        checker.laws.sliding.truncate(first);
        for surface in surfaces {
            checker.diagnostics.poison(&law_of(&surface.text));
        }
        return Err(Reported);
    };
    let friction = friction.zip(law.friction.as_ref());
    for surface in surfaces {
        let text = surface.text.clone();
        if checker.laws.of_surfaces.contains_key(&text) {
            checker.diagnostics.report(
                "E20",
                surface.place(),
                format!("surface `{text}` has two impact laws; keep one"),
            );
            continue;
        }
        let laws = &mut checker.laws;
        laws.of_surfaces.insert(text, laws.impacts.len());
        laws.impacts.push(CheckedLaw {
            surface: surface.clone(),
            restitution,
            friction: friction
                .as_ref()
                .map(|&((coefficient, at_rest), expr)| CheckedFriction {
                    coefficient,
                    at_rest,
                    sliding: sliding.clone(),
                    place: expr.place,
                }),
            along: along.clone(),
            held: held.clone(),
            sequence: law.sequence,
        });
    }
    checker.diagnostics.none_since(before)
}

/// E10: a coefficient of parameters between 0 and a bound, for their defaults.
fn coefficient(checker: &mut Checker<'_>, expr: &Expr, of: &str, most: f64) -> Checked<Sym> {
    let own = checker.number(expr)?;
    friction::ratio(checker, expr, &own, of);
    let sym = checker.constant(own.sym, expr, &format!("the coefficient of {of}"))?;
    checker.coefficient(sym, expr, of, most)
}

/// The unit of the speed of sliding, as far as it is known: that behind `sliding`, or the rate of the gap.
fn speed(checker: &mut Checker<'_>, surface: &Name, sliding: usize) -> Dimension {
    let units = &mut checker.scope.units;
    let own = checker.laws.sliding.get(sliding);
    match (own, units.gaps.get(&surface.text)) {
        (Some(own), _) => own.unit.clone(),
        (_, Some(gap)) => gap.over(&units.second()),
        _ => units.unknown(words::SPEED),
    }
}

/// E03: sliding velocities are measured like the gaps, over seconds.
pub(super) fn sliding_units(checker: &mut Checker<'_>) {
    for sliding in std::mem::take(&mut checker.laws.sliding) {
        for surface in sliding.surfaces {
            let units = &mut checker.scope.units;
            let Some(gap) = units.gaps.get(&surface.text) else {
                continue;
            };
            let wanted = gap.over(&units.second());
            let reason = format!(
                "the sliding velocity of `{}` has the unit of its gap over s",
                surface.text
            );
            units.expect(&sliding.expr, &sliding.unit, &wanted, &reason);
        }
    }
    checker.tell_units();
}

/// The sliding velocities of a law: one, or one for each piece of a surface with edges.
pub(super) fn velocities(expr: &Expr) -> &[Expr] {
    match &expr.kind {
        Kind::Vector(items) => items,
        _ => std::slice::from_ref(expr),
    }
}

/// The sliding velocity, which must be `b(q, t)' v + c(q, t)`: `c` is the velocity of a ground that moves.
pub(super) fn sliding(checker: &mut Checker<'_>, expr: &Expr) -> Checked<Number> {
    let sliding = checker.number(expr)?;
    is_sliding(checker, expr, sliding.sym)?;
    Ok(sliding)
}

/// The sliding velocities of a piece of a surface: one in the plane, two in space.
fn of_piece(checker: &mut Checker<'_>, surfaces: &[Name], expr: &Expr) -> Checked<Vec<Sym>> {
    let value = checker.value(expr)?;
    let own = value.components().iter().map(|component| Sliding {
        surfaces: surfaces.to_vec(),
        expr: expr.clone(),
        unit: component.unit.clone(),
    });
    checker.laws.sliding.extend(own);
    let components = value.syms();
    if components.len() > 2 || matches!(value, Value::Matrix(_)) {
        let message = format!(
            "`{expr}` has {} components; a contact slides with one velocity in the plane and with two in space, as in \
             `sliding (dot(x), dot(y))` on a floor",
            components.len()
        );
        return Err(checker.diagnostics.report("E02", expr.place, message));
    }
    let components = components.into_iter();
    components
        .map(|component| is_sliding(checker, expr, component))
        .collect()
}

/// E07: a value is a sliding velocity.
fn is_sliding(checker: &mut Checker<'_>, expr: &Expr, sliding: Sym) -> Checked<Sym> {
    let first_state = checker.scope.first_state;
    let wrong = |variable| match variable {
        Variable::Velocity(i) => i >= first_state,
        other => other.is_control(),
    };
    checker.free_of(&[sliding], wrong, (Some("E07"), expr.place), |wrong| {
        format!("the sliding velocity depends on {wrong}; it may depend on positions and velocities only")
    })?;
    let n = checker.coordinates.len();
    let velocities = Variable::velocities(n);
    let tangent = graph::gradient(sliding, &velocities);
    let linear = tangent
        .iter()
        .all(|&component| !graph::depends_on(simplify(component), Variable::is_velocity));
    if !linear {
        return Err(checker.diagnostics.report(
            "E07",
            expr.place,
            format!(
                "`{expr}` is no sliding velocity: that is a sum of velocities times functions of \
                 positions, such as `dot(y)`, less the speed of a ground that moves"
            ),
        ));
    }
    if tangent
        .iter()
        .all(|component| component.is_structural_zero())
    {
        return Err(checker.diagnostics.report(
            "E07",
            expr.place,
            format!("the sliding velocity `{expr}` contains no velocity; write e.g. `dot(y)`"),
        ));
    }
    Ok(sliding)
}

/// Indices of held coordinates, increasing.
fn held(checker: &mut Checker<'_>, names: &[Name]) -> Checked<Vec<usize>> {
    let mut held = Vec::with_capacity(names.len());
    let mut failed = false;
    for name in names {
        match checker.coordinate_index(name) {
            Ok(index) if held.contains(&index) => {
                checker.diagnostics.report(
                    "E20",
                    name.place(),
                    format!("`{}` is held twice; keep one", name.text),
                );
                failed = true;
            }
            Ok(index) => held.push(index),
            Err(Reported) => failed = true,
        }
    }
    if failed {
        return Err(Reported);
    }
    held.sort_unstable();
    Ok(held)
}

/// The impulse direction as velocities in declared units.
fn direction(checker: &mut Checker<'_>, expr: &Expr) -> Checked<Vec<Sym>> {
    let value = checker.value(expr)?;
    let n = checker.coordinates.len();
    let components = value.syms();
    if components.len() != n
        || (matches!(value, Value::Scalar(_)) && n != 1)
        || matches!(value, Value::Matrix(_))
    {
        return Err(checker.diagnostics.report(
            "E02",
            expr.place,
            format!(
                "the impulse direction has {} component{}; it needs one for each of the {n} \
                 coordinates, in their order",
                components.len(),
                if components.len() == 1 { "" } else { "s" },
            ),
        ));
    }
    proportional(checker, expr, &value);
    let wrong = |variable: Variable| variable.is_velocity() || variable.is_control();
    checker.free_of(&components, wrong, (Some("E07"), expr.place), |wrong| {
        format!("the impulse direction depends on {wrong}; it may depend on positions only")
    })?;
    Ok(components
        .iter()
        .zip(&checker.coordinates)
        .map(|(component, coordinate)| {
            component.scaled(1.0 / scene::scale(coordinate.unit.as_ref()))
        })
        .collect())
}

/// E03: components of an impulse direction are displacements of the coordinates, up to one factor.
fn proportional(checker: &mut Checker<'_>, expr: &Expr, direction: &Value) {
    let Kind::Vector(items) = &expr.kind else {
        return;
    };
    let mut factor: Option<Dimension> = None;
    for (i, (item, own)) in items.iter().zip(direction.components()).enumerate() {
        let name = checker.coordinates[i].name.text.clone();
        let unit = checker.unit_of(&name);
        let factor = factor.get_or_insert_with(|| own.unit.over(&unit));
        let wanted = factor.times(&unit);
        let reason = format!(
            "components of an impulse direction are proportional to displacements, here of `{name}`"
        );
        if !checker
            .scope
            .units
            .expect(item, &own.unit, &wanted, &reason)
        {
            return;
        }
    }
}

/// A coefficient for an example in a message.
fn shown_coefficient(checker: &Checker<'_>, friction: &CheckedFriction) -> String {
    match friction.coefficient.node() {
        graph::Node::Variable(Variable::Parameter(i)) => {
            checker.parameters[usize::from(i)].name.text.clone()
        }
        graph::Node::Number(bits) => f64::from_bits(bits).to_string(),
        _ => "mu".to_owned(),
    }
}

/// E20: one law for each surface, no law without a surface. Each with its own, before that is completed from the Lagrangian.
pub(super) fn of_surfaces(checker: &mut Checker<'_>) -> Checked<Vec<(Surface, CheckedLaw)>> {
    let before = checker.diagnostics.mistakes();
    let laws = std::mem::take(&mut checker.laws.impacts);
    let surfaces = std::mem::take(&mut checker.surfaces);
    let places = std::mem::take(&mut checker.laws.of_surfaces);
    let declared: HashSet<&String> = surfaces.iter().map(|known| &known.name.text).collect();
    for law in &laws {
        let text = &law.surface.text;
        if declared.contains(text) || checker.diagnostics.is_poisoned(text) {
            continue;
        }
        let names = || surfaces.iter().map(|known| known.name.text.as_str());
        let message = match closest(text, names()) {
            Some(near) => format!("there is no surface `{text}`; did you mean `{near}`?"),
            None if surfaces.is_empty() => {
                format!("there is no surface `{text}`; declare it by `surface {text}: ... >= ...`")
            }
            None => format!("there is no surface `{text}` (surfaces: {})", list(names())),
        };
        checker
            .diagnostics
            .report("E20", law.surface.place(), message);
    }
    let mut pairs = Vec::with_capacity(surfaces.len());
    for surface in surfaces {
        let text = &surface.name.text;
        let Some(law) = places.get(text).map(|&place| &laws[place]) else {
            let of = [text.as_str(), ""].map(law_of);
            if of.iter().any(|law| checker.diagnostics.is_poisoned(law)) {
                continue;
            }
            if surface.piece == 0 {
                checker.diagnostics.report(
                    "E20",
                    surface.name.place(),
                    format!("surface `{text}` has no impact law; write `impact {text}: inelastic`"),
                );
            }
            continue;
        };
        impulse(
            &surface,
            law,
            checker.coordinates.len(),
            checker.diagnostics,
        );
        let law = law.clone();
        pairs.push((surface, law));
    }
    checker.diagnostics.none_since(before)?;
    Ok(pairs)
}

/// E09: an impulse changes the normal velocity.
fn impulse(surface: &Surface, law: &CheckedLaw, n: usize, diagnostics: &mut Diagnostics) {
    let name = &surface.name.text;
    let sliding = law
        .friction
        .as_ref()
        .and_then(|friction| friction.sliding.as_ref());
    let given = sliding.map_or(surface.pieces, Vec::len);
    let in_space = |list: &Vec<Vec<Sym>>| list.iter().any(|velocities| velocities.len() > 1);
    let message = if surface.pieces == 1
        && (given > 2 || given == 2 && sliding.is_some_and(in_space))
    {
        Some(format!(
            "surface `{name}` has no edges, and `sliding` gives {given} velocities; give one in the plane, as in `sliding dot(y)`, \
             or two in space, as in `sliding (dot(x), dot(y))`, in an `impact` of its own where another surface takes several"
        ))
    } else if surface.pieces > 1 && sliding.is_some_and(in_space) {
        Some(format!(
            "surface `{name}` has {} smooth pieces, and two sliding velocities on one of them; declare the pieces as surfaces of \
             their own, each with `sliding (v1, v2)`",
            surface.pieces
        ))
    } else if surface.pieces == 1 {
        None
    } else if sliding.is_some() && given != surface.slides.1 {
        Some(format!(
            "surface `{name}` has {} smooth pieces, and `sliding` gives {given}; give one velocity for each, as in \
             `sliding (dot(y), dot(z))`",
            surface.slides.1
        ))
    } else if law.along.is_some() && surface.pieces > 1 {
        Some(format!(
            "surface `{name}` has edges, and `along` is another direction on each of its pieces; declare the pieces \
             as surfaces of their own"
        ))
    } else {
        None
    };
    if let Some(message) = message.filter(|_| surface.piece == 0) {
        diagnostics.report("E20", law.surface.place(), message);
    }
    let normal = normal(surface.gap, n);
    if let Some(along) = &law.along {
        let product: Sym = normal.iter().zip(along).map(|(&n, &w)| n * w).sum();
        if simplify(product).is_structural_zero() {
            diagnostics.report(
                "E09",
                surface.name.place(),
                format!(
                    "the impulse direction of `{}` is tangential to the surface, so it cannot stop the \
                     motion into it; give it a normal component",
                    surface.name.text
                ),
            );
        }
    }
    let moved = normal
        .iter()
        .enumerate()
        .any(|(i, component)| !law.held.contains(&i) && !component.is_structural_zero());
    if !moved {
        diagnostics.report(
            "E09",
            surface.name.place(),
            format!(
                "all coordinates that the gap of `{}` depends on are held, so no impulse can stop the \
                 motion into it; hold fewer",
                surface.name.text
            ),
        );
    }
}

/// Surfaces and laws as contacts, with the sliding velocities that follow from the Lagrangian.
///
/// `energy` is the Lagrangian, and whether it is free of mistakes.
pub(super) fn contacts(
    pairs: Vec<(Surface, CheckedLaw)>,
    energy: (Sym, bool),
    checker: &mut Checker<'_>,
) -> Checked<Vec<Contact>> {
    let mut contacts = Vec::with_capacity(pairs.len());
    let mut failed = false;
    for (surface, law) in pairs {
        let friction = law
            .friction
            .map(|friction| complete(friction, &surface, &law.held, energy, checker))
            .transpose();
        let Ok(friction) = friction else {
            failed = true;
            continue;
        };
        let name = surface.contact_name();
        contacts.push(Contact {
            unit: checker.scope.units.gap(&surface.name.text),
            gap: surface.gap,
            alternatives: surface.alternatives,
            along: law.along,
            held: law.held,
            sequence: law.sequence,
            restitution: law.restitution,
            friction,
            ..Contact::new(name, surface.documentation)
        });
    }
    if failed { Err(Reported) } else { Ok(contacts) }
}

/// Friction with its sliding velocity: the declared one, or for a point mass in a plane the velocity along
/// the surface, `n_z y' - n_y z'`.
fn complete(
    friction: CheckedFriction,
    surface: &Surface,
    held: &[usize],
    (lagrangian, sound): (Sym, bool),
    checker: &mut Checker<'_>,
) -> Checked<Friction> {
    let n = checker.coordinates.len();
    let declared = friction.sliding.as_ref();
    // Two velocities on a surface without edges are those of a contact in space.
    let own = declared.map(|list| match surface.pieces {
        1 => list.iter().flatten().copied().collect(),
        _ => list.get(surface.slides.0).cloned().unwrap_or_default(),
    });
    let own: Vec<Sym> = own.unwrap_or_default();
    for &sliding in &own {
        braked(sliding, &friction, surface, held, checker)?;
        along_surface(sliding, &friction, surface, checker)?;
    }
    // Between several bodies of one mass other scales may be right.
    let is_one_point = n == 3 && is_in_space(surface, checker) && held.is_empty();
    if is_one_point && sound && surface.pieces == 1 && has_one_mass(lagrangian, n) {
        friction::scaled_like_the_gap(&friction, &own, surface, checker);
    }
    if let [first, second] = own[..] {
        return friction::in_space(&friction, (first, second), surface, checker);
    }
    let sliding = match own.first() {
        Some(&sliding) => {
            // Of several bodies that stand for one another's velocities, as a box on a cart, nothing is missing. A velocity between
            // two bodies does not change where both move on together; one of two coordinates that does is of one body.
            let row = graph::gradient(sliding, &Variable::velocities(n));
            let mixed: Vec<Sym> = row
                .into_iter()
                .filter(|slope| !slope.is_structural_zero())
                .collect();
            let is_of_one = || {
                n == 3 && mixed.len() == 2 && !simplify(mixed[0] + mixed[1]).is_structural_zero()
            };
            let in_space = is_in_space(surface, checker) || is_of_one();
            if in_space && sound && has_one_mass(lagrangian, n) {
                let message = format!(
                    "friction of `{0}` brakes the one velocity behind `sliding` only: a body that moves in space along \
                     `{0}` slides on for ever in the direction across it; write both, as in `sliding (dot(x), dot(y))`",
                    surface.name.text
                );
                checker.diagnostics.warn("E20", friction.place, message);
            }
            sliding
        }
        // Of a kinetic energy with mistakes nothing follows.
        None if !sound => return Err(Reported),
        None if held.is_empty() && is_at_rest(surface) && is_point_mass(lagrangian, n) => {
            let normal = normal(surface.gap, 2);
            let velocity = |i| Sym::variable(Variable::Velocity(i));
            simplify(normal[1] * velocity(0) - normal[0] * velocity(1))
        }
        None => {
            let first = &checker.coordinates[0].name.text;
            let message = if is_in_space(surface, checker) {
                format!(
                    "`friction` of `{0}` needs the sliding velocity: a contact in space has two, perpendicular to each other along `{0}`; \
                     write them, as in `impact {0}: ..., friction {1}, sliding (dot(x), dot(y))` on a floor",
                    surface.name.text,
                    shown_coefficient(checker, &friction)
                )
            } else {
                format!(
                    "`friction` of `{0}` needs the sliding velocity, which follows by itself for one point mass \
                 in two Cartesian coordinates on a surface at rest only; add that of the touching point along \
                 the surface, scaled like the gap, as in `impact {0}: ..., friction {1}, sliding dot({first})`",
                    surface.name.text,
                    shown_coefficient(checker, &friction)
                )
            };
            return Err(checker.diagnostics.report("E20", friction.place, message));
        }
    };
    friction::completed(&friction, sliding, checker)
}

/// Whether a surface is in space: its gap is of a body with the three places `x`, `y` and `z`, in one unit, so that it
/// may slide in two directions.
fn is_in_space(surface: &Surface, checker: &Checker<'_>) -> bool {
    let place = |name: &str| {
        let mut all = checker.coordinates.iter();
        all.position(|known| known.name.text == name)
    };
    let Some(places) = ["x", "y", "z"]
        .into_iter()
        .map(place)
        .collect::<Option<Vec<usize>>>()
    else {
        return false;
    };
    let unit = |i: &usize| checker.coordinates[*i].unit.as_ref().map(|unit| unit.unit);
    let is_place =
        |variable| matches!(variable, Variable::Coordinate(i) if places.contains(&usize::from(i)));
    places.iter().all(|i| unit(i) == unit(&places[0])) && graph::depends_on(surface.gap, is_place)
}

/// E09: a tangential force must be able to change the sliding velocity.
fn braked(
    sliding: Sym,
    friction: &CheckedFriction,
    surface: &Surface,
    held: &[usize],
    checker: &mut Checker<'_>,
) -> Checked<()> {
    let free = |variable: Variable| match variable {
        Variable::Velocity(i) => !held.contains(&usize::from(i)),
        _ => false,
    };
    if graph::depends_on(sliding, free) {
        return Ok(());
    }
    Err(checker.diagnostics.report(
        "E09",
        friction.place,
        format!(
            "all coordinates that the sliding velocity of `{}` depends on are held, so friction cannot \
             brake it; hold fewer",
            surface.name.text
        ),
    ))
}

/// E20: the sliding velocity is not the velocity into the surface. A multiple of that is known by its row of velocities. Of
/// a gap of one coordinate every velocity of this coordinate is one, and may be right where the coordinate leads along
/// and into the surface at once; there the factor has to be a number.
fn along_surface(
    sliding: Sym,
    friction: &CheckedFriction,
    surface: &Surface,
    checker: &mut Checker<'_>,
) -> Checked<()> {
    let n = checker.coordinates.len();
    let velocities = Variable::velocities(n);
    let normal: Vec<Sym> = normal(surface.gap, n).into_iter().map(simplify).collect();
    let row = graph::gradient(sliding, &velocities).into_iter();
    let row: Vec<Sym> = row.map(simplify).collect();
    let mut entries = (0..n).filter(|&i| !normal[i].is_structural_zero());
    let Some(first) = entries.next() else {
        return Ok(());
    };
    let apart = |i: usize| simplify(row[i] * normal[first] - row[first] * normal[i]);
    if !(0..n).all(|i| apart(i).is_structural_zero()) {
        return Ok(());
    }
    let factor = simplify(row[first] * normal[first].power(-2));
    if entries.next().is_none() && factor.as_number().is_none() {
        return Ok(());
    }
    let name = &surface.name.text;
    let message = format!(
        "the sliding velocity of `{name}` is the velocity into the surface, the rate of its gap, or a multiple of it; friction \
         brakes the motion along the surface, so write the velocity of the touching point along it behind `sliding`"
    );
    Err(checker.diagnostics.report("E20", friction.place, message))
}

/// Whether a surface does not move: of one that moves, the gap does not tell how it moves along itself.
fn is_at_rest(surface: &Surface) -> bool {
    !graph::depends_on(surface.gap, |variable| variable == Variable::Time)
}

/// Whether the mass matrix is one mass times the identity of two coordinates.
fn is_point_mass(lagrangian: Sym, n: usize) -> bool {
    n == 2 && has_one_mass(lagrangian, n)
}

/// Whether all coordinates have the same inertia and none is coupled to another one.
fn has_one_mass(lagrangian: Sym, n: usize) -> bool {
    let velocities = Variable::velocities(n);
    let momenta = graph::gradient(lagrangian, &velocities);
    let rows: Vec<Vec<Sym>> = velocities
        .iter()
        .map(|&velocity| {
            let row = graph::partial(&momenta, velocity).into_iter();
            row.map(simplify).collect()
        })
        .collect();
    (0..n).all(|i| {
        let others = (0..n).filter(|&j| j != i);
        rows[i][i] == rows[0][0] && others.into_iter().all(|j| rows[i][j].is_structural_zero())
    })
}

/// Gradient of a gap with respect to the coordinates.
pub(crate) fn normal(gap: Sym, coordinates: usize) -> Vec<Sym> {
    let by = Variable::coordinates(coordinates);
    graph::gradient(gap, &by)
}
