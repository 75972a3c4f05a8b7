//! By which names the components of a vector are known.
//!
//! A component that holds one of the coordinates `x`, `y`, `z` carries its name, where the others hold others of them: of
//! `p = (x, y) + r` the second is `p.y`. Elsewhere the components of a pair are `x` and `y` in a scene with these
//! coordinates and without `z`, and `y` and `z` (horizontal and up) in all others; those of three are `x`, `y`, `z`.

use super::scope::{Meaning, Scope};
use super::value::Value;
use crate::graph::{self, Node, Sym, Variable};

/// The names that components may have.
pub(super) const NAMES: [&str; 3] = ["x", "y", "z"];

/// The names of the components, in their order; empty where they have none.
pub(super) fn names(scope: &Scope, components: &[Sym]) -> Vec<&'static str> {
    let known = NAMES.map(|name| coordinate(scope, name));
    if let Some(held) = held(&known, components) {
        return held;
    }
    let flat = known[0].is_some() && known[1].is_some() && known[2].is_none();
    match components.len() {
        2 if flat => vec!["x", "y"],
        2 => vec!["y", "z"],
        3 => NAMES.to_vec(),
        _ => Vec::new(),
    }
}

/// Which component has this name. A horizontal one may be called `y` as well where no coordinate is.
pub(super) fn position(scope: &Scope, components: &[Sym], name: &str) -> Option<usize> {
    let names = names(scope, components);
    let of = |wanted: &str| names.iter().position(|known| *known == wanted);
    let horizontal = name == "y" && names == ["x", "z"] && coordinate(scope, "y").is_none();
    of(name).or_else(|| of("x").filter(|_| horizontal))
}

/// The number of the coordinate of this name, if there is one.
fn coordinate(scope: &Scope, name: &str) -> Option<u16> {
    let Some(Meaning::Value(Value::Scalar(value))) = scope.names.get(name) else {
        return None;
    };
    match value.sym.node() {
        Node::Variable(Variable::Coordinate(index)) => Some(index),
        _ => None,
    }
}

/// The names of the coordinates that components hold, if each holds one of its own.
fn held(known: &[Option<u16>; 3], components: &[Sym]) -> Option<Vec<&'static str>> {
    let mut names = Vec::with_capacity(components.len());
    if components.len() < 2 {
        return None;
    }
    for &component in components {
        let variables = graph::variables(&[component]);
        let holds = |index: &Option<u16>| {
            index.is_some_and(|index| {
                variables.contains(&Variable::Coordinate(index))
                    || variables.contains(&Variable::Velocity(index))
            })
        };
        let mut found = (0..NAMES.len()).filter(|&k| holds(&known[k]));
        let name = NAMES[found.next()?];
        if found.next().is_some() || names.contains(&name) {
            return None;
        }
        names.push(name);
    }
    Some(names)
}
