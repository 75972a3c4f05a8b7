//! Test support: an interpreter of tapes, and an evaluator of the syntax tree over nested dual numbers
//! that shares nothing with the expression graph.

use crate::ast::{Expr, Kind, Operator, Quantity, Relation, Scene, Statement};
use crate::graph::{Sym, Variable};
use crate::tape::{self, Leaf};
use std::collections::HashMap;
use std::rc::Rc;

/// Values of `outputs`, by the operations that would be emitted.
pub(crate) fn run(outputs: &[Sym], input: impl Fn(Variable) -> f64) -> Vec<f64> {
    let tape = tape::shortest(outputs);
    let mut values: Vec<f64> = Vec::with_capacity(tape.ops.len());
    for op in &tape.ops {
        let given = |leaf| match leaf {
            Leaf::Variable(variable) => input(variable),
            Leaf::Constant(bits) => f64::from_bits(bits),
        };
        let value = op.value(given, |i| values[i as usize]);
        values.push(value);
    }
    tape.outputs.iter().map(|&i| values[i as usize]).collect()
}

/// A number, or `re + eps * e_tag` with numbers that contain smaller tags only.
#[derive(Debug, Clone)]
pub(crate) enum Nested {
    Real(f64),
    Dual {
        tag: u32,
        re: Rc<Nested>,
        eps: Rc<Nested>,
    },
}

impl Nested {
    pub(crate) fn dual(tag: u32, re: Self, eps: Self) -> Self {
        Self::Dual {
            tag,
            re: re.into(),
            eps: eps.into(),
        }
    }

    fn tag(&self) -> u32 {
        match self {
            Self::Real(_) => 0,
            Self::Dual { tag, .. } => *tag,
        }
    }

    /// Parts with respect to a tag that is at least the own one.
    fn parts(&self, tag: u32) -> (Self, Self) {
        match self {
            Self::Dual { tag: own, re, eps } if *own == tag => ((**re).clone(), (**eps).clone()),
            _ => (self.clone(), Self::Real(0.0)),
        }
    }

    /// Coefficient of `e_tag`.
    pub(crate) fn eps(&self, tag: u32) -> Self {
        self.parts(tag).1
    }

    pub(crate) fn real(&self) -> f64 {
        match self {
            Self::Real(value) => *value,
            Self::Dual { re, .. } => re.real(),
        }
    }

    pub(crate) fn add(&self, other: &Self) -> Self {
        let tag = self.tag().max(other.tag());
        match (self, other) {
            (Self::Real(a), Self::Real(b)) => Self::Real(a + b),
            _ => {
                let ((a, da), (b, db)) = (self.parts(tag), other.parts(tag));
                Self::dual(tag, a.add(&b), da.add(&db))
            }
        }
    }

    pub(crate) fn times(&self, other: &Self) -> Self {
        let tag = self.tag().max(other.tag());
        match (self, other) {
            (Self::Real(a), Self::Real(b)) => Self::Real(a * b),
            _ => {
                let ((a, da), (b, db)) = (self.parts(tag), other.parts(tag));
                Self::dual(tag, a.times(&b), da.times(&b).add(&a.times(&db)))
            }
        }
    }

    pub(crate) fn negated(&self) -> Self {
        self.times(&Self::Real(-1.0))
    }

    /// A function by name; derivatives by name too.
    pub(crate) fn apply(&self, name: &str) -> Self {
        let Self::Dual { tag, re, eps } = self else {
            let x = self.real();
            return Self::Real(match name {
                "sin" => x.sin(),
                "cos" => x.cos(),
                "tan" => x.tan(),
                "atan" => x.atan(),
                "tanh" => x.tanh(),
                "exp" => x.exp(),
                "ln" => x.ln(),
                "sqrt" => x.sqrt(),
                "cbrt" => x.cbrt(),
                "asin" => x.asin(),
                "acos" => x.acos(),
                "sinh" => x.sinh(),
                "cosh" => x.cosh(),
                "recip" => 1.0 / x,
                other => panic!("no rule for {other}"),
            });
        };
        let own = re.apply(name);
        let one = Self::Real(1.0);
        let slope = match name {
            "sin" => re.apply("cos"),
            "cos" => re.apply("sin").negated(),
            "tan" => one.add(&own.times(&own)),
            "atan" => one.add(&re.times(re)).apply("recip"),
            "tanh" => one.add(&own.times(&own).negated()),
            "exp" => own.clone(),
            "ln" => re.apply("recip"),
            "sqrt" => own.apply("recip").times(&Self::Real(0.5)),
            "cbrt" => own.times(&own).times(&Self::Real(3.0)).apply("recip"),
            "sinh" => re.apply("cosh"),
            "cosh" => re.apply("sinh"),
            "recip" => own.times(&own).negated(),
            other => panic!("no rule for {other}"),
        };
        Self::dual(*tag, own, slope.times(eps))
    }
}

/// Evaluates the syntax tree of a scene over nested dual numbers.
pub(crate) struct Evaluator<'a> {
    lets: HashMap<&'a str, &'a Expr>,
    functions: HashMap<&'a str, (Vec<&'a str>, &'a Expr)>,
    pub(crate) lagrangian: &'a Expr,
    pub(crate) forces: HashMap<&'a str, &'a Expr>,
    /// Both sides of each surface, the one that is larger on the free side first.
    pub(crate) gaps: Vec<[&'a Expr; 2]>,
    pub(crate) coordinates: Vec<&'a str>,
    controls: Vec<&'a str>,
    parameters: HashMap<&'a str, f64>,
    /// SI units in the declared unit of each quantity.
    scales: HashMap<&'a str, f64>,
}

/// Values of coordinates, velocities, controls and time, and the next free tag.
#[derive(Clone)]
pub(crate) struct Point {
    pub(crate) q: Vec<Nested>,
    pub(crate) v: Vec<Nested>,
    pub(crate) u: Vec<Nested>,
    pub(crate) t: Nested,
    pub(crate) tag: u32,
}

impl<'a> Evaluator<'a> {
    pub(crate) fn new(scene: &'a Scene) -> Self {
        let mut lets = HashMap::new();
        let mut functions = HashMap::new();
        let mut lagrangian = None;
        let mut forces = HashMap::new();
        let mut coordinates = Vec::new();
        let mut controls = Vec::new();
        let mut parameters = HashMap::new();
        let (mut gaps, mut scales) = (Vec::new(), HashMap::new());
        for statement in &scene.statements {
            if let Statement::Parameters(list)
            | Statement::Coordinates(list)
            | Statement::Controls(list) = statement
            {
                let scale = |q: &Quantity| q.unit.as_ref().map_or(1.0, |unit| unit.unit.scale);
                scales.extend(list.iter().map(|q| (q.name.text.as_str(), scale(q))));
            }
            match statement {
                Statement::Surface {
                    left,
                    relation,
                    right,
                    ..
                } => gaps.push(match relation {
                    Relation::AtMost => [right, left],
                    Relation::AtLeast | Relation::Equal => [left, right],
                }),
                Statement::Let { name, value, .. } => {
                    lets.insert(name.text.as_str(), value);
                }
                Statement::Function {
                    name,
                    arguments,
                    body,
                } => {
                    let names = arguments.iter().map(|name| name.text.as_str()).collect();
                    functions.insert(name.text.as_str(), (names, body));
                }
                Statement::Lagrangian { value, .. } => lagrangian = Some(value),
                Statement::Forces(list) => {
                    forces.extend(list.iter().map(|f| (f.target.text.as_str(), &f.value)));
                }
                Statement::Coordinates(list) => {
                    coordinates.extend(list.iter().map(|q| q.name.text.as_str()));
                }
                Statement::Controls(list) => {
                    controls.extend(list.iter().map(|q| q.name.text.as_str()));
                }
                Statement::Parameters(list) => {
                    for quantity in list {
                        if let Some(Kind::Number { value, .. }) =
                            quantity.value.as_ref().map(|value| &value.kind)
                        {
                            parameters.insert(quantity.name.text.as_str(), *value);
                        }
                    }
                }
                _ => {}
            }
        }
        Self {
            lets,
            functions,
            lagrangian: lagrangian.expect("the scene has a Lagrangian"),
            forces,
            gaps,
            coordinates,
            controls,
            parameters,
            scales,
        }
    }

    /// SI units in the declared unit of a quantity.
    pub(crate) fn scale(&self, name: &str) -> f64 {
        self.scales.get(name).copied().unwrap_or(1.0)
    }

    pub(crate) fn scalar(&self, expr: &Expr, point: &Point) -> Nested {
        self.value(expr, point, &HashMap::new()).remove(0)
    }

    /// Components; vectors have two or three, matrices four or nine, row by row.
    fn value(
        &self,
        expr: &Expr,
        point: &Point,
        locals: &HashMap<&str, Vec<Nested>>,
    ) -> Vec<Nested> {
        let of = |inner: &Expr| self.value(inner, point, locals);
        match &expr.kind {
            Kind::Number { value, unit, .. } => {
                let scale = unit.as_ref().map_or(1.0, |unit| unit.unit.scale);
                vec![Nested::Real(*value * scale)]
            }
            Kind::Name(name) => self.name(&name.text, point, locals),
            Kind::Negate(inner) => of(inner).iter().map(Nested::negated).collect(),
            Kind::Power { base, exponent, .. } => {
                // The square of a norm has no root.
                let (base, square) = match &base.kind {
                    Kind::Norm(inner) => (inner_product(&of(inner), &of(inner)), 2.0),
                    _ => (of(base).remove(0), 1.0),
                };
                let exponent = of(exponent).remove(0).real() / square;
                vec![power(&base, exponent)]
            }
            Kind::Chain(first, rest) => rest.iter().fold(of(first), |total, link| {
                step(&total, link.operator, &of(&link.operand))
            }),
            Kind::Call {
                function,
                arguments,
            } => self.call(&function.text, arguments, point, locals),
            Kind::Derivative {
                function,
                order,
                argument,
            } => {
                let (first, mut inside) = (point.tag, point.clone());
                let mut at = of(argument).remove(0);
                for _ in 0..*order {
                    at = Nested::dual(inside.tag, at, Nested::Real(1.0));
                    inside.tag += 1;
                }
                let (names, body) = &self.functions[function.text.as_str()];
                let locals = HashMap::from([(names[0], vec![at])]);
                let tags = (first..inside.tag).rev();
                let values = self.value(body, &inside, &locals).into_iter();
                let slope = |value| {
                    tags.clone()
                        .fold(value, |value: Nested, tag| value.eps(tag))
                };
                values.map(slope).collect()
            }
            Kind::Vector(items) => items.iter().flat_map(of).collect(),
            Kind::Component { vector, name } => {
                let components = of(vector);
                let index = match (components.len(), name.text.as_str()) {
                    (2, "y") | (3, "x") => 0,
                    (2, "z") | (3, "y") => 1,
                    (3, "z") => 2,
                    _ => {
                        let other = self.name(&name.text, point, locals);
                        return vec![inner_product(&components, &other)];
                    }
                };
                vec![components[index].clone()]
            }
            Kind::Index { vector, index } => {
                let components = of(vector);
                match order(components.len()) {
                    Some(n) => components[index * n..][..n].to_vec(),
                    None => vec![components[*index].clone()],
                }
            }
            Kind::Norm(inner) => vec![inner_product(&of(inner), &of(inner)).apply("sqrt")],
            Kind::Profile { .. } => panic!("functions given by points have tests of their own"),
        }
    }

    /// What a name stands for, in SI units.
    fn name(&self, name: &str, point: &Point, locals: &HashMap<&str, Vec<Nested>>) -> Vec<Nested> {
        if let Some(value) = locals.get(name) {
            return value.clone();
        }
        let scaled = |value: &Nested| vec![value.times(&Nested::Real(self.scale(name)))];
        if let Some(value) = self.parameters.get(name) {
            return scaled(&Nested::Real(*value));
        }
        let find = |list: &[&str], values: &[Nested]| {
            let place = list.iter().position(|known| *known == name);
            place.map(|i| scaled(&values[i]))
        };
        if name == "t" {
            return vec![point.t.clone()];
        }
        find(&self.coordinates, &point.q)
            .or_else(|| find(&self.controls, &point.u))
            .unwrap_or_else(|| self.value(self.lets[name], point, &HashMap::new()))
    }

    /// The value of a call of a function, of the scene or of the language.
    fn call(
        &self,
        name: &str,
        arguments: &[Expr],
        point: &Point,
        locals: &HashMap<&str, Vec<Nested>>,
    ) -> Vec<Nested> {
        let of = |inner: &Expr| self.value(inner, point, locals);
        if let Some((names, body)) = self.functions.get(name) {
            let values = arguments.iter().map(of);
            let locals = names.iter().copied().zip(values).collect();
            return self.value(body, point, &locals);
        }
        if let ("dot", [argument]) = (name, arguments) {
            let tag = point.tag;
            let mut moving = point.clone();
            moving.tag += 1;
            for (q, v) in moving.q.iter_mut().zip(&point.v) {
                *q = Nested::dual(tag, q.clone(), v.clone());
            }
            moving.t = Nested::dual(tag, moving.t, Nested::Real(1.0));
            return self
                .value(argument, &moving, locals)
                .iter()
                .map(|c| c.eps(tag))
                .collect();
        }
        let parts: Vec<Vec<Nested>> = arguments.iter().map(of).collect();
        let [zero, one] = [0.0, 1.0].map(Nested::Real);
        match (name, &parts[..]) {
            ("dot", [a, b]) => vec![inner_product(a, b)],
            ("cross", [a, b]) => {
                let minor =
                    |i: usize, j: usize| a[i].times(&b[j]).add(&a[j].times(&b[i]).negated());
                vec![minor(0, 1)]
            }
            ("atan2", [y, x]) => {
                // Where `x` is above 0.
                vec![y[0].times(&x[0].apply("recip")).apply("atan")]
            }
            ("transpose", [m]) => {
                let n = order(m.len()).expect("a matrix");
                (0..n * n).map(|k| m[k % n * n + k / n].clone()).collect()
            }
            ("diagonal", items) => {
                let n = items.len();
                let entry = |k: usize| match k / n == k % n {
                    true => items[k / n][0].clone(),
                    false => zero.clone(),
                };
                (0..n * n).map(entry).collect()
            }
            ("rotation" | "rotation_x" | "rotation_z", [angle]) => {
                let (s, c) = (angle[0].apply("sin"), angle[0].apply("cos"));
                let minus = s.negated();
                match name {
                    "rotation" => vec![c.clone(), minus, s, c],
                    "rotation_x" => {
                        let row = [one, zero.clone(), zero.clone()];
                        let rows = [[zero.clone(), c.clone(), minus], [zero, s, c]];
                        [&row[..], &rows.concat()[..]].concat()
                    }
                    _ => {
                        let rows = [[c.clone(), minus, zero.clone()], [s, c, zero.clone()]];
                        [&rows.concat()[..], &[zero.clone(), zero, one][..]].concat()
                    }
                }
            }
            _ => vec![parts[0][0].apply(name)],
        }
    }
}

/// One step of a chain.
fn step(a: &[Nested], operator: Operator, b: &[Nested]) -> Vec<Nested> {
    let pair = |a: &Nested, b: &Nested| match operator {
        Operator::Add => a.add(b),
        Operator::Subtract => a.add(&b.negated()),
        Operator::Multiply => a.times(b),
        Operator::Divide => a.times(&b.apply("recip")),
    };
    if let (Operator::Multiply, Some(n), 2..) = (operator, order(a.len()), b.len()) {
        let columns = b.len() / n;
        let entry = |i: usize, j: usize| {
            let column: Vec<Nested> = b.iter().skip(j).step_by(columns).cloned().collect();
            inner_product(&a[n * i..][..n], &column)
        };
        return (0..b.len())
            .map(|k| entry(k / columns, k % columns))
            .collect();
    }
    match (a.len(), b.len()) {
        (1, _) => b.iter().map(|b| pair(&a[0], b)).collect(),
        (_, 1) => a.iter().map(|a| pair(a, &b[0])).collect(),
        _ => a.iter().zip(b).map(|(a, b)| pair(a, b)).collect(),
    }
}

fn inner_product(a: &[Nested], b: &[Nested]) -> Nested {
    let products = a.iter().zip(b).map(|(a, b)| a.times(b));
    products.fold(Nested::Real(0.0), |sum, product| sum.add(&product))
}

/// Number of rows of a matrix with so many entries; none of what is shorter or no square.
fn order(entries: usize) -> Option<usize> {
    match entries {
        4 => Some(2),
        9 => Some(3),
        _ => None,
    }
}

/// A power by products, or by the logarithm of a positive base.
fn power(base: &Nested, exponent: f64) -> Nested {
    if exponent.fract() == 0.0 && exponent >= 1.0 {
        return (1..exponent as usize).fold(base.clone(), |power, _| power.times(base));
    }
    base.apply("ln").times(&Nested::Real(exponent)).apply("exp")
}
