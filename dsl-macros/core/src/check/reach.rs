//! E07: surfaces that nothing can reach, by the ranges of their gaps over all places and times.

use super::checker::Checker;
use crate::graph::{self, Function, Function2, Node, Sym, Variable};
use std::collections::HashMap;
use std::f64::consts::{FRAC_PI_2, PI};

/// Gaps that stay above it are not touched, whatever is rounded on the way.
const GAP: f64 = 1e-6;

/// Warns of every surface whose gap is positive everywhere, for the defaults of the parameters.
pub(super) fn surfaces(checker: &mut Checker<'_>) {
    let parameters = checker.parameters.iter();
    let parameters: Vec<f64> = parameters.map(|known| known.default).collect();
    let gaps: Vec<Sym> = checker.surfaces.iter().map(|known| known.gap).collect();
    let ranges = Ranges::of(&gaps, &parameters);
    let least: Vec<f64> = gaps.iter().map(|gap| ranges.get(*gap).least).collect();
    // A maximum is at least its largest piece.
    let bound = |i: usize| {
        let others = checker.surfaces[i].alternatives.iter();
        others.fold(least[i], |bound, &other| bound.max(least[other]))
    };
    let mut untouched = Vec::new();
    let mut i = 0;
    while let Some(first) = checker.surfaces.get(i) {
        let pieces = i..i + first.pieces.max(1);
        i = pieces.end;
        let gap = pieces.map(bound).fold(f64::INFINITY, f64::min);
        if gap > GAP && gap.is_finite() && !checker.scope.units.faulty.contains(&first.name.text) {
            untouched.push((first.name.clone(), gap));
        }
    }
    for (name, gap) in untouched {
        let message = format!(
            "nothing ever touches surface `{}`: with the defaults of the parameters its gap is nowhere less than {}; \
             check both sides of the inequality",
            name.text,
            checker.scope.units.shown_gap(&name.text, gap)
        );
        checker.diagnostics.warn("E07", name.place(), message);
    }
}

/// All numbers from `least` to `most`.
#[derive(Clone, Copy)]
struct Range {
    least: f64,
    most: f64,
}

const ALL: Range = Range::new(f64::NEG_INFINITY, f64::INFINITY);

impl Range {
    const fn new(least: f64, most: f64) -> Self {
        Self { least, most }
    }

    /// The range between values at corners; everything where one of them is no number.
    fn around(values: &[f64]) -> Self {
        if values.iter().any(|value| value.is_nan()) {
            return ALL;
        }
        let least = values.iter().fold(f64::INFINITY, |l, v| l.min(*v));
        let most = values.iter().fold(f64::NEG_INFINITY, |m, v| m.max(*v));
        Self::new(least, most)
    }

    fn times(self, other: Self) -> Self {
        let corner = |a: f64, b: f64| match a == 0.0 || b == 0.0 {
            true => 0.0,
            false => a * b,
        };
        Self::around(&[
            corner(self.least, other.least),
            corner(self.least, other.most),
            corner(self.most, other.least),
            corner(self.most, other.most),
        ])
    }

    fn plus(self, other: Self) -> Self {
        Self::around(&[self.least + other.least, self.most + other.most])
    }

    /// Absolute values.
    fn size(self) -> Self {
        let ends = Self::around(&[self.least.abs(), self.most.abs()]);
        match self.least < 0.0 && self.most > 0.0 {
            true => Self::new(0.0, ends.most),
            false => ends,
        }
    }

    /// To a power counted in halves.
    fn power(self, halves: i32) -> Self {
        let power = |x: f64| match halves % 2 {
            0 => x.powi(halves / 2),
            _ => x.sqrt().powi(halves),
        };
        let base = match (halves % 2 == 0, halves % 4 == 0) {
            (true, true) => self.size(),
            (true, false) => self,
            // Roots have values above zero only.
            (false, _) => Self::new(self.least.max(0.0), self.most.max(0.0)),
        };
        if halves < 0 && base.least <= 0.0 && base.most >= 0.0 {
            // Beyond a pole both signs come, unless the base has one only.
            return match base.least >= 0.0 {
                true => Self::new(power(base.most), f64::INFINITY),
                false => ALL,
            };
        }
        Self::around(&[power(base.least), power(base.most)])
    }

    fn call(self, function: Function) -> Self {
        match function {
            Function::Sin | Function::Cos => Self::new(-1.0, 1.0),
            Function::Asin => Self::new(-FRAC_PI_2, FRAC_PI_2),
            Function::Acos => Self::new(0.0, PI),
            Function::Root => {
                Self::new(self.least.max(0.0), self.most.max(0.0)).grown(Function::Root)
            }
            Function::InverseRoot => Self::new(0.0, f64::INFINITY),
            Function::Abs => self.size(),
            Function::Sign => Self::new(-1.0, 1.0),
            Function::Cosh => {
                let size = self.size();
                Self::around(&[size.least.cosh(), size.most.cosh()])
            }
            // These grow everywhere.
            Function::Atan | Function::Sinh | Function::Tanh | Function::Exp | Function::Cbrt => {
                self.grown(function)
            }
            Function::Ln => Self::new(self.least.max(0.0), self.most.max(0.0)).grown(Function::Ln),
            Function::Tan | Function::Profile(_) => ALL,
        }
    }

    /// Values of a function that grows.
    fn grown(self, function: Function) -> Self {
        Self::around(&[function.value(self.least), function.value(self.most)])
    }
}

/// Ranges of expressions over all coordinates and times.
struct Ranges(HashMap<Sym, Range>);

impl Ranges {
    fn of(roots: &[Sym], parameters: &[f64]) -> Self {
        let mut ranges = Self(HashMap::new());
        for sym in graph::reachable(roots) {
            let range = ranges.node(&sym.node(), parameters);
            ranges.0.insert(sym, range);
        }
        ranges
    }

    fn get(&self, sym: Sym) -> Range {
        self.0.get(&sym).copied().unwrap_or(ALL)
    }

    fn node(&self, node: &Node, parameters: &[f64]) -> Range {
        let number = |value: f64| Range::around(&[value]);
        match node {
            Node::Number(bits) => number(f64::from_bits(*bits)),
            Node::Variable(Variable::Parameter(i)) => {
                parameters.get(usize::from(*i)).map_or(ALL, |&p| number(p))
            }
            Node::Variable(_) => ALL,
            Node::Sum(terms) => {
                let terms = terms.iter();
                let terms =
                    terms.map(|(term, bits)| self.get(*term).times(number(f64::from_bits(*bits))));
                terms.fold(number(0.0), Range::plus)
            }
            Node::Product(factors) => {
                let factors = factors.iter();
                let factors = factors.map(|&(factor, halves)| self.get(factor).power(halves));
                factors.fold(number(1.0), Range::times)
            }
            Node::Call(function, argument) => self.get(*argument).call(*function),
            Node::Call2(Function2::Atan2, ..) => Range::new(-PI, PI),
            Node::Call2(Function2::Power, ..) => Range::new(0.0, f64::INFINITY),
            Node::Kept(inner) => self.get(*inner),
        }
    }
}
