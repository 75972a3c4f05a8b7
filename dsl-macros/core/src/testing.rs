//! Test support: an interpreter of tapes, and an evaluator of the syntax tree over nested dual numbers
//! that shares nothing with the expression graph.

use crate::ast::{Expr, Kind, Operator, Scene, Statement};
use crate::graph::{Sym, Variable};
use crate::tape::{self, Op};
use std::collections::HashMap;
use std::rc::Rc;

/// Values of `outputs`, by the operations that would be emitted.
pub(crate) fn run(outputs: &[Sym], input: impl Fn(Variable) -> f64) -> Vec<f64> {
    let tape = tape::shortest(outputs);
    let mut values: Vec<f64> = Vec::with_capacity(tape.ops.len());
    for op in &tape.ops {
        let at = |i: u32| values[i as usize];
        let value = match *op {
            Op::Load(variable) => input(variable),
            Op::Constant(bits) => f64::from_bits(bits),
            Op::Add(a, b) => at(a) + at(b),
            Op::Subtract(a, b) => at(a) - at(b),
            Op::Multiply(a, b) => at(a) * at(b),
            Op::Divide(a, b) => at(a) / at(b),
            Op::Negate(a) => -at(a),
            Op::Root(a) => at(a).sqrt(),
            Op::Call(function, a) => function.value(at(a)),
            Op::Call2(function, a, b) => function.value(at(a), at(b)),
        };
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
            "recip" => own.times(&own).negated(),
            other => panic!("no rule for {other}"),
        };
        Self::dual(*tag, own, slope.times(eps))
    }
}

/// Evaluates the syntax tree of a scene without units over nested dual numbers.
pub(crate) struct Evaluator<'a> {
    lets: HashMap<&'a str, &'a Expr>,
    functions: HashMap<&'a str, (Vec<&'a str>, &'a Expr)>,
    pub(crate) lagrangian: &'a Expr,
    pub(crate) forces: HashMap<&'a str, &'a Expr>,
    pub(crate) coordinates: Vec<&'a str>,
    controls: Vec<&'a str>,
    parameters: HashMap<&'a str, f64>,
}

/// Values of coordinates, velocities and controls, and the next free tag.
#[derive(Clone)]
pub(crate) struct Point {
    pub(crate) q: Vec<Nested>,
    pub(crate) v: Vec<Nested>,
    pub(crate) u: Vec<Nested>,
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
        for statement in &scene.statements {
            match statement {
                Statement::Let { name, value } => {
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
            coordinates,
            controls,
            parameters,
        }
    }

    pub(crate) fn scalar(&self, expr: &Expr, point: &Point) -> Nested {
        self.value(expr, point, &HashMap::new()).remove(0)
    }

    /// Components; vectors of random models have two, matrices four, row by row.
    fn value(
        &self,
        expr: &Expr,
        point: &Point,
        locals: &HashMap<&str, Vec<Nested>>,
    ) -> Vec<Nested> {
        let of = |inner: &Expr| self.value(inner, point, locals);
        match &expr.kind {
            Kind::Number { value, .. } => vec![Nested::Real(*value)],
            Kind::Name(name) => {
                let name = name.text.as_str();
                let find = |list: &[&str], values: &[Nested]| {
                    list.iter()
                        .position(|known| *known == name)
                        .map(|i| vec![values[i].clone()])
                };
                if let Some(value) = locals.get(name) {
                    return value.clone();
                }
                if let Some(value) = self.parameters.get(name) {
                    return vec![Nested::Real(*value)];
                }
                find(&self.coordinates, &point.q)
                    .or_else(|| find(&self.controls, &point.u))
                    .unwrap_or_else(|| self.value(self.lets[name], point, &HashMap::new()))
            }
            Kind::Negate(inner) => of(inner).iter().map(Nested::negated).collect(),
            Kind::Power { base, exponent, .. } => {
                let Kind::Number { value, .. } = exponent.kind else {
                    panic!("exponents of random models are numbers");
                };
                let base = match &base.kind {
                    // The square of a norm has no root.
                    Kind::Norm(inner) if value == 2.0 => {
                        let components = of(inner);
                        return vec![
                            components
                                .iter()
                                .fold(Nested::Real(0.0), |sum, c| sum.add(&c.times(c))),
                        ];
                    }
                    _ => of(base).remove(0),
                };
                vec![(1..value as usize).fold(base.clone(), |power, _| power.times(&base))]
            }
            Kind::Chain(first, rest) => rest.iter().fold(of(first), |total, link| {
                step(&total, link.operator, &of(&link.operand))
            }),
            Kind::Call {
                function,
                arguments,
            } => self.call(&function.text, arguments, point, locals),
            Kind::Derivative {
                function, argument, ..
            } => {
                let tag = point.tag;
                let mut inside = point.clone();
                inside.tag += 1;
                let at = Nested::dual(tag, of(argument).remove(0), Nested::Real(1.0));
                let (names, body) = &self.functions[function.text.as_str()];
                let locals = HashMap::from([(names[0], vec![at])]);
                self.value(body, &inside, &locals)
                    .iter()
                    .map(|c| c.eps(tag))
                    .collect()
            }
            Kind::Vector(items) => items.iter().flat_map(of).collect(),
            Kind::Component { vector, name } => {
                let components = of(vector);
                let index = usize::from(name.text == "z");
                vec![components[index].clone()]
            }
            Kind::Norm(_) | Kind::Index { .. } | Kind::Profile { .. } => {
                panic!("not part of random models")
            }
        }
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
        if let [left, right] = arguments {
            let (a, b) = (of(left), of(right));
            let products = a.iter().zip(&b).map(|(a, b)| a.times(b));
            return vec![products.fold(Nested::Real(0.0), |sum, p| sum.add(&p))];
        }
        if name == "transpose" {
            let m = of(&arguments[0]);
            return [0, 2, 1, 3].map(|k| m[k].clone()).to_vec();
        }
        if name == "rotation" {
            let angle = of(&arguments[0]).remove(0);
            let (s, c) = (angle.apply("sin"), angle.apply("cos"));
            return vec![c.clone(), s.negated(), s, c];
        }
        if name == "dot" {
            let tag = point.tag;
            let mut moving = point.clone();
            moving.tag += 1;
            for (q, v) in moving.q.iter_mut().zip(&point.v) {
                *q = Nested::dual(tag, q.clone(), v.clone());
            }
            return self
                .value(&arguments[0], &moving, locals)
                .iter()
                .map(|c| c.eps(tag))
                .collect();
        }
        vec![of(&arguments[0])[0].apply(name)]
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
    if operator == Operator::Multiply && a.len() == 4 && b.len() > 1 {
        let columns = b.len() / 2;
        let entry = |i: usize, j: usize| {
            let (above, below) = (&b[j], &b[columns + j]);
            a[2 * i].times(above).add(&a[2 * i + 1].times(below))
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
