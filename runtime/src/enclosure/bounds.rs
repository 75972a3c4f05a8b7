//! Ranges of the explicit functions of a model.

use super::calm::WIDE;
use super::range::{CALM, Range};
use crate::model::tape::{Function, Function2, Operation, Source};
use crate::model::{Explicit, Model, joint_rows};
use crate::yardstick;

/// Factor by which a divisor may change where its inverse is a polynomial of a few powers.
const FACTOR: f64 = 4.0;
/// Factor by which a divisor may change between places of a part: less than a parabola does whose least value is in the part.
const STEADY: f64 = 1.5;
/// Factors of a product that stages tell: `(1 - x^2)^32` has half of its height over an eighth of where its factors lie.
const FACTORS: f64 = 32.0;
/// Evaluates explicit functions of a model on ranges of their inputs.
pub(crate) struct Bounds<'a> {
    model: &'a dyn Model,
    /// Values of the parameters, and behind them which equations of joints are held.
    parameters: Vec<f64>,
    /// Ranges of the operations of the function last evaluated.
    values: Vec<Range>,
    /// Where among them its values are.
    outputs: &'a [u32],
    /// Sizes of the values of functions at the ends and in the middle of the piece whose parts are looked at.
    sizes: Vec<(Explicit, Vec<f64>)>,
}

impl<'a> Bounds<'a> {
    pub(crate) fn new(model: &'a dyn Model) -> Self {
        let count = model.declaration().parameters.len();
        let held = |row: usize| f64::from(u8::from(model.joint_row_held(row)));
        let parameters = (0..count).map(|i| model.parameter(i));
        Self {
            parameters: parameters.chain((0..joint_rows(model)).map(held)).collect(),
            model,
            values: Vec::new(),
            outputs: &[],
            sizes: Vec::new(),
        }
    }

    /// Whether the operations of a function are known.
    pub(crate) fn knows(&self, function: Explicit) -> bool {
        self.model.tape(function).is_some()
    }

    /// Evaluates a function where the components of the input vector lie in the ranges of `input`; `false` if its operations are not known.
    pub(crate) fn evaluate(
        &mut self,
        function: Explicit,
        mut input: impl FnMut(usize) -> Range,
    ) -> bool {
        let Some(tape) = self.model.tape(function) else {
            return false;
        };
        self.outputs = tape.outputs;
        self.values.clear();
        for &operation in tape.operations {
            let at = |part: u32| self.values[part as usize];
            let value = match operation {
                Operation::Given(Source::Parameter(i)) => Range::of(self.parameters[i as usize]),
                Operation::Given(Source::Constant(value)) => Range::of(value),
                Operation::Given(Source::Input(i)) => input(i as usize),
                Operation::Add(a, b) => at(a) + at(b),
                Operation::Subtract(a, b) => at(a) - at(b),
                Operation::Multiply(a, b) if a == b => at(a).square(),
                Operation::Multiply(a, b) => at(a) * at(b),
                Operation::Divide(a, b) => at(a).over(at(b)),
                Operation::Negate(a) => -at(a),
                Operation::Root(a) => at(a).root(),
                Operation::Call(function, a) => at(a).call(function),
                Operation::Call2(Function2::Atan2, a, b) => at(a).atan2(at(b)),
                Operation::Call2(Function2::Power, a, b) => at(a).power(at(b)),
                Operation::Given(Source::Weight(_)) => Range::ALL,
            };
            self.values.push(value);
        }
        true
    }

    /// Whether something can be confined in a function to a small part of what its inputs are in: whether it contains functions of them
    /// besides sums, sines, sizes and signs, and products of few factors.
    pub(crate) fn may_hide(&self, function: Explicit) -> bool {
        let Some(tape) = self.model.tape(function) else {
            return false;
        };
        let mut counts = Vec::with_capacity(tape.operations.len());
        for &operation in tape.operations {
            let at = |part: u32| counts[part as usize];
            let moves = |part: u32| Factors::moves(&at(part));
            let count = Factors::of(operation, counts.len(), at);
            let hides = match operation {
                Operation::Divide(_, a) => moves(a),
                Operation::Call(called, a) => moves(a) && !is_the_same_everywhere(called),
                Operation::Call2(..) => count.moves(),
                _ => count.most > FACTORS,
            };
            if hides {
                return true;
            }
            counts.push(count);
        }
        false
    }

    /// Whether a function varies no faster than its inputs over a `part` of a piece, so that a few places tell its other values: nothing in
    /// it is confined to a small part of them, and sines go through `wave` radians at most. One whose operations are not known counts as
    /// such. `input` gives the ranges of inputs over a part, which may be a place.
    pub(crate) fn is_calm(
        &mut self,
        (function, wave): (Explicit, f64),
        part: [f64; 2],
        input: impl Fn(usize, [f64; 2]) -> Range,
    ) -> bool {
        if !self.evaluate(function, |k| input(k, part)) {
            return true;
        }
        let tape = self.model.tape(function);
        let operations = tape.map_or(&[][..], |tape| tape.operations);
        let mut sized = Vec::new();
        let mut counts: Vec<Factors> = Vec::with_capacity(operations.len());
        for &operation in operations {
            let at = |part: u32| self.values[part as usize];
            let calm = match operation {
                // Powers that rise are products.
                Operation::Call2(Function2::Power, _, b) if at(b).low >= 0.0 => true,
                Operation::Divide(_, a)
                | Operation::Call2(Function2::Power, a, _)
                | Operation::Call(Function::Ln | Function::InverseRoot, a) => {
                    if !at(a).keeps_its_size(FACTOR) {
                        sized.push(a);
                    }
                    true
                }
                Operation::Call(function, a) => at(a).is_calm_in(function, wave),
                Operation::Call2(Function2::Atan2, a, b) => at(a).atan2(at(b)).width() <= CALM,
                _ => true,
            };
            if !calm {
                return false;
            }
            counts.push(self.factors_over(operation, &counts));
        }
        let steep = |&k: &usize| counts[self.outputs[k] as usize].most > FACTORS;
        let steep = (0..self.outputs.len()).filter(steep);
        let steep: Vec<(usize, f64)> = steep.map(|k| (k, self.output(k).size().high)).collect();
        if part == [0.0, 1.0] {
            self.sizes.retain(|(known, _)| *known != function);
        }
        self.are_nothing(function, &steep, &input) && self.are_steady(function, &sized, part, input)
    }

    /// [`Factors`] of a value over a part, where one that changes by a share of itself counts as that share of all that stages tell, and of
    /// a sum terms do not count that are nothing beside others.
    fn factors_over(&self, operation: Operation, counts: &[Factors]) -> Factors {
        let at = |part: u32| self.values[part as usize];
        let count = |part: u32| counts[part as usize];
        let told = |part: u32| count(part).at_most(FACTORS * at(part).change());
        let is_nothing =
            |a: u32, b: u32| at(a).size().high <= yardstick::ROUNDING * at(b).size().low;
        let place = counts.len();
        let own = Factors::of(operation, place, count);
        match operation {
            Operation::Call(Function::Sin | Function::Cos, a) => {
                let most = own.most.max(at(a).width());
                Factors { most, ..own }
            }
            Operation::Call2(Function2::Power, a, b) => {
                Factors::equal(at(b).size().high * told(a).equal, place)
            }
            _ if own.most <= FACTORS => own,
            Operation::Add(a, b) | Operation::Subtract(a, b) if is_nothing(a, b) => count(b),
            Operation::Add(a, b) | Operation::Subtract(a, b) if is_nothing(b, a) => count(a),
            Operation::Multiply(..) | Operation::Divide(..) => Factors::of(operation, place, told),
            _ => own,
        }
    }

    /// Whether values of a function that are products of too many factors over a part, given with their largest sizes there, are nothing
    /// beside what they are at the ends and in the middle of the piece.
    fn are_nothing(
        &mut self,
        function: Explicit,
        steep: &[(usize, f64)],
        input: impl Fn(usize, [f64; 2]) -> Range,
    ) -> bool {
        let known = |(known, _): &(Explicit, Vec<f64>)| *known == function;
        if !steep.is_empty() && !self.sizes.iter().any(known) {
            let mut sizes = vec![0.0_f64; self.outputs.len()];
            for at in [0.0, 0.5, 1.0] {
                self.evaluate(function, |k| input(k, [at, at]));
                for (size, value) in sizes.iter_mut().zip(self.outputs()) {
                    *size = size.max(value.size().low);
                }
            }
            self.sizes.push((function, sizes));
        }
        let sizes = self.sizes.iter().find(|one| known(one));
        let size = |k: usize| sizes.map_or(0.0, |(_, sizes)| sizes[k]);
        // Numbers below the least normal one have no digits.
        let most = |k: usize| (yardstick::ROUNDING * size(k)).max(f64::MIN_POSITIVE);
        steep.iter().all(|&(k, size)| size <= most(k))
    }

    /// Whether operands of a function that have to keep their size over a part do so. A range is more than what is in it where operands
    /// have much in common, as in a determinant: three places tell what a parabola does.
    fn are_steady(
        &mut self,
        function: Explicit,
        sized: &[u32],
        part: [f64; 2],
        input: impl Fn(usize, [f64; 2]) -> Range,
    ) -> bool {
        if sized.is_empty() || part[1] - part[0] > WIDE {
            return sized.is_empty();
        }
        let mut seen = vec![Vec::new(); sized.len()];
        for at in [part[0], 0.5 * (part[0] + part[1]), part[1]] {
            self.evaluate(function, |k| input(k, [at, at]));
            for (seen, &operand) in seen.iter_mut().zip(sized) {
                seen.push(self.values[operand as usize].low);
            }
        }
        seen.into_iter()
            .all(|values| Range::hull(values).keeps_its_size(STEADY))
    }

    /// The range of one of the values of the function last evaluated.
    pub(crate) fn output(&self, k: usize) -> Range {
        self.values[self.outputs[k] as usize]
    }

    /// The ranges of all values of the function last evaluated.
    pub(crate) fn outputs(&self) -> impl Iterator<Item = Range> {
        self.outputs.iter().map(|&k| self.values[k as usize])
    }

    /// Dividend and divisor of all quotients of a function at a place, one after the other.
    pub(crate) fn quotients(
        &mut self,
        function: Explicit,
        x: &[f64],
        quotients: &mut Vec<[f64; 2]>,
    ) {
        quotients.clear();
        if !self.evaluate(function, |k| Range::of(x[k])) {
            return;
        }
        let tape = self.model.tape(function);
        for &operation in tape.map_or(&[][..], |tape| tape.operations) {
            if let Operation::Divide(a, b) = operation {
                quotients.push([a, b].map(|part| self.values[part as usize].low));
            }
        }
    }

    /// A number that a gap is not below wherever the inputs lie between `low` and `high`, up to rounding; `None` where it is not known.
    pub(crate) fn least_gap(&mut self, contact: usize, low: &[f64], high: &[f64]) -> Option<f64> {
        let range = self.of(Explicit::Gap(contact), |k| Range::between(low[k], high[k]));
        (range.low > f64::NEG_INFINITY).then_some(range.low)
    }

    /// What a normal or a tangent, which stands behind two values of the function last evaluated, makes of `n` accelerations, beside a
    /// `curvature`.
    pub(crate) fn turned(
        &self,
        curvature: Range,
        n: usize,
        acceleration: impl Fn(usize) -> Range,
    ) -> Range {
        (0..n).fold(curvature, |sum, k| match self.output(2 + k) {
            nothing if nothing == Range::of(0.0) => sum,
            component => sum + component * acceleration(k),
        })
    }

    /// The range of one value of a function; all numbers where its operations are not known.
    pub(crate) fn of(&mut self, function: Explicit, input: impl FnMut(usize) -> Range) -> Range {
        if self.evaluate(function, input) {
            self.output(0)
        } else {
            Range::ALL
        }
    }
}

/// What a value is a product of.
#[derive(Debug, Clone, Copy)]
struct Factors {
    /// Equal factors that vary, and which one: a sum is one factor.
    equal: f64,
    base: usize,
    /// Most equal factors of what it is made of; 0 where it does not vary.
    most: f64,
}

impl Factors {
    fn equal(equal: f64, base: usize) -> Self {
        let most = equal;
        Self { equal, base, most }
    }

    /// Of the operation at a `place`, by those of its operands `at` theirs.
    fn of(operation: Operation, place: usize, at: impl Fn(u32) -> Self) -> Self {
        let (equal, base, [a, b]) = match operation {
            Operation::Given(Source::Parameter(_) | Source::Constant(_)) => {
                return Self::equal(0.0, place);
            }
            Operation::Given(Source::Input(_) | Source::Weight(_)) => {
                return Self::equal(1.0, place);
            }
            Operation::Negate(a) | Operation::Root(a) => return at(a),
            Operation::Multiply(a, b) | Operation::Divide(a, b) if !at(b).moves() => return at(a),
            Operation::Multiply(a, b) if !at(a).moves() => return at(b),
            Operation::Multiply(a, b) if at(a).base == at(b).base => {
                (at(a).equal + at(b).equal, at(a).base, [a, b])
            }
            Operation::Multiply(a, b) => (at(a).equal.max(at(b).equal), place, [a, b]),
            Operation::Call(_, a) => (1.0, place, [a, a]),
            Operation::Add(a, b)
            | Operation::Subtract(a, b)
            | Operation::Divide(a, b)
            | Operation::Call2(_, a, b) => (1.0, place, [a, b]),
        };
        let of_parts = at(a).most.max(at(b).most);
        let equal = if of_parts > 0.0 { equal } else { 0.0 };
        let most = of_parts.max(equal);
        Self { equal, base, most }
    }

    fn moves(&self) -> bool {
        self.most > 0.0
    }

    /// The same where its factors are as good as `told`; more of them than stages tell stay.
    fn at_most(self, told: f64) -> Self {
        let [equal, most] = [self.equal, self.most].map(|count| match count > FACTORS {
            true => count,
            false => count.min(told),
        });
        let base = self.base;
        Self { equal, base, most }
    }
}

/// Whether a function does nothing in some places that it does not do in others, but where its argument vanishes.
fn is_the_same_everywhere(function: Function) -> bool {
    use Function::{Abs, Acos, Asin, Cbrt, Cos, Root, Sign, Sin};
    matches!(function, Sin | Cos | Asin | Acos | Cbrt | Root | Abs | Sign)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::{contact_point, tangent_point};

    crate::model! {
        /// Surfaces with functions of all kinds, friction on one of them, and a ground that moves.
        pub Kinds {
            parameters { m: kg = 1.3, r: m = 0.4, w: rad/s = 2 }
            coordinates { x: m, y: m, a: rad }
            lagrangian m/2*(dot(x)^2 + dot(y)^2) + m*r^2/2*dot(a)^2*(2 + sin(a)) - 9.81[m/s^2]*m*y
            surface wave: y - r*sin(a)*cos(x/r) - 0.1*x^3/r^2 >= 0
            surface far: sqrt(x^2 + y^2 + r^2) - r^2/(3*r + x) >= 0
            surface ground: y - r*exp(-(x/r)^2) - r*tanh(x/r)*sin(w*t) - 0.01*r*atan2(y, 3*r + x) >= 0
            surface power: (2 + x/r)^2.3*r - y*ln(3 + y/r) + r*cosh(y/r) >= 0
            impact wave: inelastic, friction 0.3, sliding dot(x) + sin(a)*dot(y) - r*dot(a)
            impact far, ground, power: inelastic
            start { y: 3 [m] }
            horizon 1 [s]
        }
    }

    /// Values of a function at a place: of a range that is a point.
    fn values(bounds: &mut Bounds<'_>, function: Explicit, x: &[f64], count: usize) -> Vec<f64> {
        assert!(bounds.evaluate(function, |k| Range::of(x[k])));
        let range = |k: usize| bounds.output(k);
        let middle = |range: Range| 0.5 * (range.low + range.high);
        (0..count).map(|k| middle(range(k))).collect()
    }

    /// Places that are spread evenly in a box around the origin.
    fn place(k: usize) -> Vec<f64> {
        let share = |salt: f64| (k as f64 * salt).fract();
        let scales = [0.7, 0.7, 1.5, 2.0, 2.0, 3.0, 4.0];
        let salts = [0.618, 0.755, 0.570, 0.423, 0.912, 0.334, 0.871];
        let pairs = scales.iter().zip(salts);
        pairs
            .map(|(scale, salt)| scale * (2.0 * share(salt) - 1.0))
            .collect()
    }

    #[test]
    fn operations_are_those_of_the_functions() {
        let model = Kinds::default();
        let mut bounds = Bounds::new(&model);
        let n = 3;
        for k in 1..200 {
            let x = place(k);
            for contact in 0..4 {
                let mut point = vec![0.0; contact_point::length(n)];
                model.contact(contact, &x, &mut point);
                let gap = values(&mut bounds, Explicit::Gap(contact), &x, 1)[0];
                let side = values(&mut bounds, Explicit::Normal(contact), &x, 2 + n);
                let normal = &point[contact_point::NORMAL..][..n];
                let expected = point[..3].iter().chain(normal);
                for (found, expected) in std::iter::once(&gap).chain(&side).zip(expected) {
                    assert!((found - expected).abs() <= 1e-12 * expected.abs().max(1.0));
                }
            }
            let mut tangent = vec![0.0; tangent_point::length(n)];
            model.tangent(0, &x, &mut tangent);
            let side = values(&mut bounds, Explicit::Tangent(0), &x, 2 + n);
            for (found, expected) in side.iter().zip(&tangent) {
                assert!((found - expected).abs() <= 1e-12 * expected.abs().max(1.0));
            }
        }
    }

    #[test]
    fn gaps_are_nowhere_below_their_bounds() {
        let model = Kinds::default();
        let mut bounds = Bounds::new(&model);
        for k in 1..200 {
            let (low, wide) = (place(k), place(k + 7));
            let high: Vec<f64> = low
                .iter()
                .zip(&wide)
                .map(|(x, w)| x + 0.5 * w.abs())
                .collect();
            for contact in 0..4 {
                let Some(least) = bounds.least_gap(contact, &low, &high) else {
                    continue;
                };
                for inside in 0..50 {
                    let share = |i: usize| ((inside * (i + 1)) as f64 * 0.618).fract();
                    let ends = low.iter().zip(&high).enumerate();
                    let x: Vec<f64> = ends.map(|(i, (a, b))| a + share(i) * (b - a)).collect();
                    let gap = model.gap(contact, &x);
                    assert!(gap.is_nan() || gap >= least - 1e-12, "{contact} at {x:?}");
                }
            }
        }
    }
}
