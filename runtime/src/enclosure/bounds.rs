//! Ranges of the explicit functions of a model.

use super::calm::WIDE;
use super::range::{CALM, Range};
use crate::model::tape::{Function, Function2, Operation, Source};
use crate::model::{Explicit, Model, joint_rows};

/// Factor by which a divisor may change where its inverse is a polynomial of a few powers.
const FACTOR: f64 = 4.0;
/// Factor by which a divisor may change between places of a part: less than a parabola does whose least value is in the part.
const STEADY: f64 = 1.5;

/// Evaluates explicit functions of a model on ranges of their inputs.
pub(crate) struct Bounds<'a> {
    model: &'a dyn Model,
    /// Values of the parameters, and behind them which equations of joints are held.
    parameters: Vec<f64>,
    /// Ranges of the operations of the function last evaluated.
    values: Vec<Range>,
    /// Where among them its values are.
    outputs: &'a [u32],
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
    /// besides sums, products, sines, sizes and signs.
    pub(crate) fn may_hide(&self, function: Explicit) -> bool {
        let Some(tape) = self.model.tape(function) else {
            return false;
        };
        let mut moves = Vec::with_capacity(tape.operations.len());
        for &operation in tape.operations {
            let at = |part: u32| moves[part as usize];
            let (own, hides) = match operation {
                Operation::Given(Source::Parameter(_) | Source::Constant(_)) => (false, false),
                Operation::Given(Source::Input(_) | Source::Weight(_)) => (true, false),
                Operation::Add(a, b) | Operation::Subtract(a, b) | Operation::Multiply(a, b) => {
                    (at(a) || at(b), false)
                }
                Operation::Divide(a, b) => (at(a) || at(b), at(b)),
                Operation::Negate(a) | Operation::Root(a) => (at(a), false),
                Operation::Call(called, a) => (at(a), at(a) && !is_the_same_everywhere(called)),
                Operation::Call2(_, a, b) => (at(a) || at(b), at(a) || at(b)),
            };
            if hides {
                return true;
            }
            moves.push(own);
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
        let mut sized = Vec::new();
        for &operation in tape.map_or(&[][..], |tape| tape.operations) {
            let at = |part: u32| self.values[part as usize];
            let calm = match operation {
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
        }
        if sized.is_empty() || part[1] - part[0] > WIDE {
            return sized.is_empty();
        }
        // A range is more than what is in it where operands have much in common, as in a determinant: three places tell what a parabola does.
        let mut seen = vec![Vec::new(); sized.len()];
        for at in [part[0], 0.5 * (part[0] + part[1]), part[1]] {
            self.evaluate(function, |k| input(k, [at, at]));
            for (seen, &operand) in seen.iter_mut().zip(&sized) {
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
        let range = self.of(Explicit::Gap(contact), |k| Range {
            low: low[k],
            high: high[k],
        });
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
