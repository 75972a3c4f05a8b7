//! Units with unknowns, and their unification: linear equations between exponents.

use hangtime_units::{Ratio, Unit};
use std::collections::BTreeMap;

/// Exponents of the seven base units and of units that are not known yet.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Dimension {
    base: [Ratio; 7],
    unknown: BTreeMap<usize, Ratio>,
    /// Whether it agrees with every other one: units are not checked, or a mistake with it has been told.
    silent: bool,
}

impl Default for Dimension {
    /// One of which nothing is said.
    fn default() -> Self {
        Self {
            silent: true,
            ..Self::of(Unit::ONE)
        }
    }
}

impl Dimension {
    pub(crate) fn of(unit: Unit) -> Self {
        Self {
            base: unit.exponents,
            unknown: BTreeMap::new(),
            silent: false,
        }
    }

    pub(crate) fn one() -> Self {
        Self::of(Unit::ONE)
    }

    pub(crate) fn times(&self, other: &Self) -> Self {
        self.combine(other, Ratio::ONE)
    }

    pub(crate) fn over(&self, other: &Self) -> Self {
        self.combine(other, Ratio::integer(-1))
    }

    /// `self * other^exponent`.
    fn combine(&self, other: &Self, exponent: Ratio) -> Self {
        let mut result = self.clone();
        result.silent |= other.silent;
        for (own, its) in result.base.iter_mut().zip(other.base) {
            *own = *own + its * exponent;
        }
        for (&unknown, &its) in &other.unknown {
            let own = result.unknown.entry(unknown).or_insert(Ratio::ZERO);
            *own = *own + its * exponent;
        }
        result.unknown.retain(|_, own| !own.is_zero());
        result
    }

    pub(crate) fn power(&self, exponent: Ratio) -> Self {
        Self::one().combine(self, exponent)
    }

    /// Whether nothing is said of it.
    pub(crate) fn is_silent(&self) -> bool {
        self.silent
    }

    fn is_one(&self) -> bool {
        self.unknown.is_empty() && self.base.iter().all(|own| own.is_zero())
    }
}

/// What is known about unknown units.
#[derive(Debug, Default)]
pub(crate) struct Unifier {
    /// Whose unit each unknown is; empty for numbers that fit anywhere.
    owners: Vec<String>,
    solved: BTreeMap<usize, Dimension>,
    /// Those of them that hang on unknowns.
    open: Vec<usize>,
}

impl Unifier {
    /// A unit that is to be inferred.
    pub(crate) fn unknown(&mut self, owner: &str) -> Dimension {
        self.owners.push(owner.to_owned());
        let mut dimension = Dimension::one();
        dimension.unknown.insert(self.owners.len() - 1, Ratio::ONE);
        dimension
    }

    /// The dimension with everything put in that has been inferred.
    pub(crate) fn resolve(&self, dimension: &Dimension) -> Dimension {
        let mut result = Dimension {
            base: dimension.base,
            unknown: BTreeMap::new(),
            silent: dimension.silent,
        };
        for (unknown, &exponent) in &dimension.unknown {
            match self.solved.get(unknown) {
                // Solutions are kept resolved, so one step suffices.
                Some(solution) => result = result.combine(solution, exponent),
                None => {
                    let mut own = Dimension::one();
                    own.unknown.insert(*unknown, exponent);
                    result = result.times(&own);
                }
            }
        }
        result
    }

    /// Makes both dimensions equal, inferring unknown units; whether that is possible.
    pub(crate) fn unify(&mut self, left: &Dimension, right: &Dimension) -> bool {
        let difference = self.resolve(&left.over(right));
        if difference.silent || difference.is_one() {
            return true;
        }
        // Numbers that fit anywhere are solved for first, so that names keep their freedom.
        let pick = difference
            .unknown
            .iter()
            .find(|(unknown, _)| self.owners[**unknown].is_empty())
            .or_else(|| difference.unknown.iter().next_back());
        let Some((&pick, &exponent)) = pick else {
            return false;
        };
        let mut rest = difference;
        rest.unknown.remove(&pick);
        let solution = match exponent.recip() {
            Some(inverse) => rest.power(-inverse),
            None => return false,
        };
        self.open.retain(|open| {
            let Some(known) = self.solved.get_mut(open) else {
                return false;
            };
            if let Some(own) = known.unknown.remove(&pick) {
                *known = known.combine(&solution, own);
            }
            !known.unknown.is_empty()
        });
        if !solution.unknown.is_empty() {
            self.open.push(pick);
        }
        self.solved.insert(pick, solution);
        true
    }

    /// `is in m/s^2`, `has no unit`.
    pub(crate) fn is_in(&self, dimension: &Dimension) -> String {
        if self.resolve(dimension).is_one() {
            "has no unit".to_owned()
        } else {
            format!("is in {}", self.show(dimension))
        }
    }

    /// Readable form: `m/s^2`, `kg * unit of k`.
    pub(crate) fn show(&self, dimension: &Dimension) -> String {
        let resolved = self.resolve(dimension);
        let known = Unit {
            exponents: resolved.base,
            scale: 1.0,
        };
        let mut text = if known.is_dimensionless() && !resolved.unknown.is_empty() {
            String::new()
        } else {
            known.to_string()
        };
        for (&unknown, &exponent) in &resolved.unknown {
            if !text.is_empty() {
                text.push_str(" * ");
            }
            let owner = match self.owners[unknown].as_str() {
                "" => "an unknown unit".to_owned(),
                owner => format!("unit of `{owner}`"),
            };
            text.push_str(&owner);
            if exponent != Ratio::ONE {
                text.push_str(&format!("^{exponent}"));
            }
        }
        text
    }

    /// The unit, if all of it is known.
    pub(crate) fn known(&self, dimension: &Dimension) -> Option<Unit> {
        let resolved = self.resolve(dimension);
        let known = resolved.unknown.is_empty() && !resolved.silent;
        known.then_some(Unit {
            exponents: resolved.base,
            scale: 1.0,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn unit(text: &str) -> Dimension {
        Dimension::of(text.parse::<Unit>().unwrap())
    }

    #[test]
    fn unify_infers_products_and_roots() {
        let mut unifier = Unifier::default();
        let (k, c) = (unifier.unknown("k"), unifier.unknown("c"));
        // k*m^2 = J, so k = N/m; then c = sqrt(k).
        assert!(unifier.unify(&k.times(&unit("m^2")), &unit("J")));
        assert_eq!(unifier.show(&k), "N/m");
        assert!(unifier.unify(&c.power(Ratio::integer(2)), &k));
        assert_eq!(
            unifier.known(&c.power(Ratio::integer(2))),
            "N/m".parse::<Unit>().ok()
        );
        assert!(!unifier.unify(&k, &unit("N")));
    }

    #[test]
    fn unify_chains_of_unknowns_stay_consistent() {
        let mut unifier = Unifier::default();
        let [a, b, c] = ["a", "b", "c"].map(|name| unifier.unknown(name));
        assert!(unifier.unify(&a, &b.times(&c)));
        assert!(unifier.unify(&b, &c));
        assert!(unifier.unify(&a, &unit("m^2")));
        assert_eq!(unifier.show(&c), "m");
        assert_eq!(unifier.show(&a), "m^2");
        assert!(!unifier.unify(&a.over(&b), &unit("s")));
    }
}
