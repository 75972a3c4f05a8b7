//! A surface with edges as smooth contacts.
//!
//! The smallest of some gaps is not negative where none of them is: each piece is a contact by itself. The largest is not
//! negative where one of them is not: a piece of it acts only where it is the largest. Every combination of `min`, `max`
//! and sums is the smallest of some largest ones.

use super::checker::Checker;
use crate::ast::Expr;
use crate::derive::simplify;
use crate::diagnostics::{Checked, Place, Reported};
use crate::evaluate::Kink;
use crate::graph::{self, Sym, Variable};
use std::collections::HashSet;

/// Most pieces of one surface.
const MOST: usize = 32;

/// Why a gap cannot be taken apart.
enum Refusal {
    /// An edge has a factor that is no number, or is inside of a function.
    Factor,
    Many,
    /// A piece belongs to more than one maximum.
    Shared,
    /// A maximum is nowhere negative.
    Everywhere,
    /// A piece does not depend on where the bodies are.
    Fixed,
}

/// The smallest of the largest of these gaps: one group of pieces for each maximum.
pub(super) fn groups(
    gap: Sym,
    (left, right): (&Expr, &Expr),
    checker: &mut Checker<'_>,
) -> Checked<Vec<Vec<Sym>>> {
    let kinks = std::mem::take(&mut checker.scope.kinks);
    let place = left.place.to(right.place);
    let message = match taken_apart(gap, &kinks).and_then(lean) {
        Ok(groups) => return Ok(groups),
        Err(Refusal::Factor) => {
            "`max`, `min` and `|x|` can be taken apart in sums and with numbers as factors only, as the sign of \
             another factor is not known; write it inside, as in `|slope*y|` or `max(a*y, a*z)`"
                .to_owned()
        }
        Err(Refusal::Many) => {
            format!("the surface has more than {MOST} pieces; declare several surfaces")
        }
        Err(Refusal::Shared) => {
            "a piece belongs to more than one `max`, so that it is not clear where it acts; declare several \
             surfaces, each with its own pieces"
                .to_owned()
        }
        Err(Refusal::Everywhere) => {
            "the surface holds everywhere, so that nothing ever touches it: two of its pieces are never negative \
             together; check the signs, or write `min` where all pieces have to hold"
                .to_owned()
        }
        Err(Refusal::Fixed) => {
            "a piece of the surface contains no coordinate, so that nothing can touch it; leave it out".to_owned()
        }
    };
    checker.diagnostics.report("E12", place, message);
    Err(Reported)
}

/// The functions that are not negative where this one is not, as a condition without edges for each of them.
pub(super) fn all_hold(
    function: Sym,
    (left, right): (&Expr, &Expr),
    checker: &mut Checker<'_>,
) -> Checked<Vec<Sym>> {
    let kinks = std::mem::take(&mut checker.scope.kinks);
    all_pieces(function, left.place.to(right.place), checker, &kinks)
}

/// The smooth pieces of a function whose maxima and minima are known.
pub(super) fn all_pieces(
    function: Sym,
    place: Place,
    checker: &mut Checker<'_>,
    kinks: &[Kink],
) -> Checked<Vec<Sym>> {
    let message = match taken_apart(function, kinks) {
        Ok(groups) if groups.iter().all(|group| group.len() == 1) => {
            let mut seen = HashSet::new();
            let all = groups.into_iter().flatten();
            return Ok(all.filter(|piece| seen.insert(*piece)).collect());
        }
        Ok(_) => {
            "a condition that holds where one of several does is none of a smooth problem; state the one that is meant, or \
             declare a `surface`, which the motion may pass on either side"
        }
        Err(Refusal::Factor) => {
            "`max`, `min` and `|x|` can be taken apart in sums and with numbers as factors only, as the sign of another factor is \
             not known; write it inside, as in `|slope*y|`"
        }
        Err(_) => "the condition has too many pieces; write several conditions",
    };
    Err(checker.diagnostics.report("E12", place, message))
}

fn taken_apart(gap: Sym, kinks: &[Kink]) -> Result<Vec<Vec<Sym>>, Refusal> {
    let variables = graph::variables(&[gap]);
    // What contains others was made after them.
    let mut last_first = kinks.iter().rev();
    let Some(kink) = last_first.find(|kink| variables.contains(&kink.variable)) else {
        return Ok(vec![vec![gap]]);
    };
    let slope = simplify(graph::partial(&[gap], kink.variable)[0]);
    let Some(slope) = slope.as_number().filter(|slope| *slope != 0.0) else {
        return Err(Refusal::Factor);
    };
    let mut groups = Vec::new();
    for (i, &part) in kink.parts.iter().enumerate() {
        let replace = |variable| (variable == kink.variable).then_some(part);
        let of_part = taken_apart(graph::substitute(&[gap], replace)[0], kinks)?;
        if i == 0 || kink.largest != (slope > 0.0) {
            groups.extend(of_part);
        } else {
            // The largest of two smallest ones is the smallest of the largest of each two.
            groups = groups
                .iter()
                .flat_map(|one| of_part.iter().map(move |other| [&one[..], other].concat()))
                .collect();
        }
        if groups.iter().map(Vec::len).sum::<usize>() > MOST {
            return Err(Refusal::Many);
        }
    }
    Ok(groups)
}

/// Each piece once, and no maximum that another one implies.
fn lean(groups: Vec<Vec<Sym>>) -> Result<Vec<Vec<Sym>>, Refusal> {
    let mut lean: Vec<Vec<Sym>> = Vec::new();
    for mut group in groups {
        let mut seen = HashSet::new();
        group.retain(|piece| seen.insert(*piece));
        let within = |small: &[Sym], large: &[Sym]| small.iter().all(|piece| large.contains(piece));
        if !lean.iter().any(|known| within(known, &group)) {
            lean.retain(|known| !within(&group, known));
            lean.push(group);
        }
    }
    // The largest of two numbers is at least half of their sum.
    let holds = |group: &Vec<Sym>| {
        let pairs = group
            .iter()
            .flat_map(|one| group.iter().map(move |other| (*one, *other)));
        let mut sums = pairs
            .filter(|(one, other)| one != other)
            .map(|(one, other)| simplify(one + other).as_number());
        sums.any(|sum| sum.is_some_and(|sum| sum >= 0.0))
    };
    if lean.iter().any(holds) {
        return Err(Refusal::Everywhere);
    }
    let fixed = |piece: &Sym| !graph::depends_on(*piece, Variable::is_coordinate);
    if lean.iter().map(Vec::len).sum::<usize>() > 1 && lean.iter().flatten().any(fixed) {
        return Err(Refusal::Fixed);
    }
    // A piece that stands in two maxima acts in one of them at a time where two others, one of each, have a positive sum, as `c - x` and
    // `c + x` of `max(a, c - |x|)`. Where the sum is negative both act, as equal contacts that share a load.
    let still = |sum: Sym| !graph::depends_on(simplify(sum), Variable::is_coordinate);
    let apart = |one: &Vec<Sym>, other: &Vec<Sym>| {
        let shared = one.iter().any(|piece| other.contains(piece));
        let opposite = |piece: &Sym| {
            other
                .iter()
                .any(|its| !one.contains(its) && still(*piece + *its))
        };
        !shared
            || one
                .iter()
                .any(|piece| !other.contains(piece) && opposite(piece))
    };
    let mut rest = lean.iter().enumerate();
    match rest.all(|(k, one)| lean[k + 1..].iter().all(|other| apart(one, other))) {
        true => Ok(lean),
        false => Err(Refusal::Shared),
    }
}
