//! The Lagrangian, the forces and the gaps once more, as functions that are generic over dual
//! numbers: an oracle for the derived equations.
//!
//! They are written from the syntax tree and share nothing with the expression graph: `dot` and
//! `diff` are evaluated at run time by dual numbers of dual numbers.

mod parts;

use super::kernel::literal;
use crate::ast::{Expr, Kind, Link, Name, Operator, Relation, Scene, Statement};
use crate::scene::{self, CheckedScene, Coordinate};
use crate::words;
use parts::{Body, Parts, each, inner_product, matrix_function, matrix_product};
use std::collections::HashMap;
use std::fmt::Write;

/// Longest oracle, in statements; a longer one is left out, as it would only cost compile time.
const LONGEST: usize = 4000;

const BOUND: &str =
    "D: ::hangtime::scene::num_dual::DualNum<Primitive = __f64> + ::core::marker::Copy";
const DUAL: &str = "::hangtime::scene::num_dual::Dual";

/// Source of the helper functions and of the methods; `None` if they would grow too long.
pub(super) fn write(declared: &Scene, checked: &CheckedScene) -> Option<(String, String)> {
    let mut oracle = Oracle {
        checked,
        functions: HashMap::new(),
        abbreviations: HashMap::new(),
        helpers: String::new(),
        count: 0,
        length: 0,
    };
    let sources = oracle.read(declared)?;
    let mut methods = String::new();
    let lagrangian = sources.lagrangian.as_ref()?;
    let _ = write!(
        methods,
        "/// The Lagrangian, for any kind of dual number: `q` and `v` in declared units, `t` in seconds.
        pub fn lagrangian<{BOUND}>(&self, q: &[D], v: &[D], t: D) -> D {{ \
         Self::{lagrangian}(self, q, v, &[], t, t)[0] }}"
    );
    if !sources.dissipation {
        oracle.forces(&sources, &mut methods)?;
    }
    oracle.gaps(&sources, &mut methods)?;
    Some((oracle.helpers, methods))
}

/// What the methods are written from.
#[derive(Default)]
struct Sources<'a> {
    /// The helper of the Lagrangian.
    lagrangian: Option<String>,
    /// Coordinate, scale and value of each force.
    forces: Vec<(usize, f64, &'a Expr)>,
    /// Sides of each surface, of which the first one is larger on the free side.
    gaps: HashMap<&'a str, (&'a Expr, &'a Expr)>,
    dissipation: bool,
}

struct Oracle<'a> {
    checked: &'a CheckedScene,
    functions: HashMap<String, (Vec<Name>, Expr)>,
    /// Helper and shape of each abbreviation.
    abbreviations: HashMap<String, (String, Parts)>,
    helpers: String,
    count: usize,
    length: usize,
}

impl Oracle<'_> {
    /// Emits helpers of the abbreviations and of the Lagrangian; notes functions, forces and surfaces.
    fn read<'b>(&mut self, declared: &'b Scene) -> Option<Sources<'b>> {
        let mut sources = Sources::default();
        for statement in &declared.statements {
            match statement {
                Statement::Let { name, value } => {
                    let helper = self.helper(value)?;
                    self.abbreviations.insert(name.text.clone(), helper);
                }
                Statement::Function {
                    name,
                    arguments,
                    body,
                } => {
                    let function = (arguments.clone(), body.clone());
                    self.functions.insert(name.text.clone(), function);
                }
                Statement::Lagrangian { value, .. } => {
                    sources.lagrangian = Some(self.helper(value)?.0);
                }
                Statement::Dissipation { .. } => sources.dissipation = true,
                Statement::Forces(assignments) => {
                    let coordinates = &self.checked.coordinates;
                    for assignment in assignments {
                        let name = &assignment.target.text;
                        let index = coordinates.iter().position(|q| q.name.text == *name)?;
                        let scale = scene::scale(coordinates[index].unit.as_ref());
                        sources.forces.push((index, scale, &assignment.value));
                    }
                }
                Statement::Surface {
                    name,
                    left,
                    relation,
                    right,
                    ..
                } => {
                    let sides = match relation {
                        Relation::AtLeast | Relation::Equal => (left, right),
                        Relation::AtMost => (right, left),
                    };
                    sources.gaps.insert(&name.text, sides);
                }
                _ => {}
            }
        }
        Some(sources)
    }

    fn forces(&mut self, sources: &Sources<'_>, methods: &mut String) -> Option<()> {
        let n = self.checked.coordinates.len();
        let mut body = String::new();
        for &(i, scale, value) in &sources.forces {
            let (helper, _) = self.helper(value)?;
            let _ = write!(
                body,
                "forces[{i}] += Self::{helper}(self, q, v, u, t, t)[0] * {};",
                literal(scale)
            );
        }
        let _ = write!(
            methods,
            "/// The generalized forces, one a coordinate, for any kind of dual number: `q`, `v` and `u` \
             in declared units, `t` in seconds.
            pub fn generalized_forces<{BOUND}>(&self, q: &[D], v: &[D], u: &[D], t: D) -> [D; {n}] {{ \
             let mut forces = [D::from(0.0); {n}]; {body} forces }}"
        );
        Some(())
    }

    fn gaps(&mut self, sources: &Sources<'_>, methods: &mut String) -> Option<()> {
        let mut body = String::new();
        for contact in &self.checked.contacts {
            let &(left, right) = sources.gaps.get(contact.name.text.as_str())?;
            let ((left, _), (right, _)) = (self.helper(left)?, self.helper(right)?);
            let _ = write!(
                body,
                "Self::{left}(self, q, v, &[], t, t)[0] - Self::{right}(self, q, v, &[], t, t)[0],"
            );
        }
        let _ = write!(
            methods,
            "/// The gaps of all contacts in SI units, for any kind of dual number: `q` in declared units, \
             `t` in seconds.
            pub fn gaps<{BOUND}>(&self, q: &[D], t: D) -> [D; {}] {{ let v: &[D] = &[]; [{body}] }}",
            self.checked.contacts.len()
        );
        Some(())
    }

    /// Emits `fn(p, q, v, u, t, s) -> [D; components]` for an expression; `s` is the argument of the
    /// function that is being differentiated.
    fn helper(&mut self, expr: &Expr) -> Option<(String, Parts)> {
        let mut body = Body::default();
        let components = self.expr(expr, &mut body)?;
        self.length += body.count;
        if self.length > LONGEST {
            return None;
        }
        let name = format!("__oracle_{}", self.count);
        self.count += 1;
        let length = components.len();
        let _ = write!(
            self.helpers,
            "fn {name}<{BOUND}>(p: &Self, q: &[D], v: &[D], u: &[D], t: D, s: D) -> [D; {length}] {{ {} \
             [{}] }}",
            body.text,
            components.join(", ")
        );
        Some((name, components))
    }

    /// Names of the components of an expression.
    fn expr(&mut self, expr: &Expr, body: &mut Body) -> Option<Parts> {
        if self.length + body.count > LONGEST {
            return None;
        }
        Some(match &expr.kind {
            Kind::Number { value, unit, .. } => {
                let value = unit.as_ref().map_or(*value, |unit| unit.unit.in_si(*value));
                Parts::one(body.bind(&format!("D::from({})", literal(value))))
            }
            // Dual numbers of other programs know no points.
            Kind::Profile { .. } => return None,
            Kind::Name(name) => self.name(&name.text, body)?,
            Kind::Negate(inner) => {
                let inner = self.expr(inner, body)?;
                inner.with(each(&inner, body, |component| format!("-{component}")))
            }
            Kind::Chain(first, rest) => {
                let mut total = self.expr(first, body)?;
                for link in rest {
                    let operand = self.expr(&link.operand, body)?;
                    total = step(&total, link.operator, &operand, body)?;
                }
                total
            }
            Kind::Power { base, exponent, .. } => self.power(base, exponent, body)?,
            Kind::Call {
                function,
                arguments,
            } => self.call(&function.text, arguments, body)?,
            Kind::Derivative {
                function,
                order,
                argument,
            } => self.derivative(&function.text, *order, argument, body)?,
            Kind::Norm(inner) => {
                let inner = self.expr(inner, body)?;
                let squares = inner
                    .iter()
                    .map(|c| format!("{c} * {c}"))
                    .collect::<Vec<_>>();
                let sum = body.bind(&squares.join(" + "));
                Parts::one(body.bind(&format!("{sum}.sqrt()")))
            }
            Kind::Vector(items) => {
                let mut names = Vec::with_capacity(items.len());
                for item in items {
                    names.extend(self.expr(item, body)?.names);
                }
                let columns = names.len() / items.len();
                Parts {
                    names,
                    columns: (columns > 1).then_some(columns),
                }
            }
            Kind::Component { vector, name } => {
                let vector = self.expr(vector, body)?;
                let index = match (vector.len(), name.text.as_str()) {
                    (2, "y") | (3, "x") => 0,
                    (2, "z") | (3, "y") => 1,
                    (3, "z") => 2,
                    _ => {
                        let other = self.name(&name.text, body)?;
                        return Some(Parts::one(inner_product(&vector, &other, body)));
                    }
                };
                Parts::one(vector.get(index)?.clone())
            }
            Kind::Index { vector, index } => {
                let value = self.expr(vector, body)?;
                match value.columns {
                    Some(columns) => value.chunks(columns).nth(*index)?.to_vec().into(),
                    None => Parts::one(value.get(*index)?.clone()),
                }
            }
        })
    }

    fn name(&self, name: &str, body: &mut Body) -> Option<Parts> {
        if let Some((helper, shape)) = self.abbreviations.get(name) {
            let value = body.bind(&format!("Self::{helper}(p, q, v, u, t, s)"));
            return Some(shape.within(&value));
        }
        let scaled = |text: String, scale: f64| {
            if scale == 1.0 {
                text
            } else {
                format!("{text} * {}", literal(scale))
            }
        };
        let find = |list: &[Coordinate], vector: &str| {
            let index = list.iter().position(|known| known.name.text == name)?;
            let scale = scene::scale(list[index].unit.as_ref());
            Some(scaled(format!("{vector}[{index}]"), scale))
        };
        if let Some(parameter) = self
            .checked
            .parameters
            .iter()
            .find(|known| known.name.text == name)
        {
            let scale = scene::scale(parameter.unit.as_ref());
            let value = scaled(format!("p.{}", words::rust_name(name)), scale);
            return Some(Parts::one(body.bind(&format!("D::from({value})"))));
        }
        let value = find(&self.checked.coordinates, "q")
            .or_else(|| find(&self.checked.controls, "u"))
            .or_else(|| match name {
                "t" => Some("t".to_owned()),
                "pi" => Some("D::from(::core::f64::consts::PI)".to_owned()),
                ARGUMENT => Some("s".to_owned()),
                _ => None,
            })?;
        Some(Parts::one(body.bind(&value)))
    }

    fn power(&mut self, base: &Expr, exponent: &Expr, body: &mut Body) -> Option<Parts> {
        // The square of a norm has no root in it, which would not be differentiable at 0.
        if let Kind::Norm(inner) = &base.kind
            && matches!(&exponent.kind, Kind::Number { value, unit: None, .. } if *value == 2.0)
        {
            let inner = self.expr(inner, body)?;
            return Some(Parts::one(inner_product(&inner, &inner, body)));
        }
        let base = self.expr(base, body)?;
        let constant = match &exponent.kind {
            Kind::Number {
                value, unit: None, ..
            } => Some(*value),
            Kind::Negate(inner) => match inner.kind {
                Kind::Number {
                    value, unit: None, ..
                } => Some(-value),
                _ => None,
            },
            _ => None,
        };
        let base = &base[0];
        Some(Parts::one(match constant {
            Some(value) if value.fract() == 0.0 && (1.0..=64.0).contains(&value) => {
                let factors = vec![base.as_str(); value as usize];
                body.bind(&factors.join(" * "))
            }
            Some(value) => body.bind(&format!("{base}.powf({})", literal(value))),
            None => {
                let exponent = self.expr(exponent, body)?;
                body.bind(&format!("{base}.powd({})", exponent[0]))
            }
        }))
    }

    fn call(&mut self, function: &str, arguments: &[Expr], body: &mut Body) -> Option<Parts> {
        if let Some((names, inner)) = self.functions.get(function) {
            let map: HashMap<&str, &Expr> = names
                .iter()
                .map(|name| name.text.as_str())
                .zip(arguments)
                .collect();
            let inserted = insert(inner, &map);
            return self.expr(&inserted, body);
        }
        match (function, arguments) {
            ("dot", [argument]) => {
                let (helper, shape) = self.helper(argument)?;
                let n = self.checked.coordinates.len();
                let rate = body.bind(&format!(
                    "{{ let q: [{DUAL}<D>; {n}] = ::core::array::from_fn(|i| {DUAL}::new(q[i], v[i])); \
                     Self::{helper}::<{DUAL}<D>>(p, &q, &[], &[], {DUAL}::new(t, D::from(1.0)), \
                     {DUAL}::new(s, D::from(0.0))).map(|c| c.eps) }}"
                ));
                Some(shape.within(&rate))
            }
            ("dot", [left, right]) => {
                let (own, its) = (self.expr(left, body)?, self.expr(right, body)?);
                Some(Parts::one(inner_product(&own, &its, body)))
            }
            (name, _) if words::MATRIX_FUNCTIONS.contains(&name) => {
                let mut parts = Vec::with_capacity(arguments.len());
                for argument in arguments {
                    parts.push(self.expr(argument, body)?);
                }
                matrix_function(name, &parts, body)
            }
            ("cross", [left, right]) => {
                let (a, b) = (self.expr(left, body)?, self.expr(right, body)?);
                let mut minor = |i: usize, j: usize| {
                    body.bind(&format!("{} * {} - {} * {}", a[i], b[j], a[j], b[i]))
                };
                Some(if a.len() == 2 {
                    Parts::one(minor(0, 1))
                } else {
                    vec![minor(1, 2), minor(2, 0), minor(0, 1)].into()
                })
            }
            ("atan2", [y, x]) => {
                let (y, x) = (self.expr(y, body)?, self.expr(x, body)?);
                Some(Parts::one(body.bind(&format!("{}.atan2({})", y[0], x[0]))))
            }
            (function, [argument]) => {
                let argument = self.expr(argument, body)?;
                Some(Parts::one(
                    body.bind(&format!("{}.{function}()", argument[0])),
                ))
            }
            _ => None,
        }
    }

    fn derivative(
        &mut self,
        function: &str,
        order: usize,
        argument: &Expr,
        body: &mut Body,
    ) -> Option<Parts> {
        let at = self.expr(argument, body)?;
        let hole = Expr {
            kind: Kind::Name(Name {
                text: ARGUMENT.to_owned(),
                ident: proc_macro2::Ident::new("argument", proc_macro2::Span::call_site()),
            }),
            place: argument.place,
            depth: 1,
            parenthesized: false,
        };
        let inner = match self.functions.get(function) {
            Some((names, inner)) => {
                let map = names
                    .iter()
                    .map(|name| (name.text.as_str(), &hole))
                    .collect();
                insert(inner, &map)
            }
            None => Expr {
                kind: Kind::Call {
                    function: Name {
                        text: function.to_owned(),
                        ident: proc_macro2::Ident::new(function, proc_macro2::Span::call_site()),
                    },
                    arguments: vec![hole],
                },
                ..argument.clone()
            },
        };
        let (mut helper, shape) = self.helper(&inner)?;
        let length = shape.len();
        let n = self.checked.coordinates.len();
        let (nv, nu) = ("v.len()", self.checked.controls.len());
        for _ in 0..order {
            let name = format!("__oracle_{}", self.count);
            self.count += 1;
            let _ = write!(
                self.helpers,
                "fn {name}<{BOUND}>(p: &Self, q: &[D], v: &[D], u: &[D], t: D, s: D) -> [D; {length}] {{
                    let constant = |x: D| {DUAL}::new(x, D::from(0.0));
                    let q: [{DUAL}<D>; {n}] = ::core::array::from_fn(|i| constant(q[i]));
                    let v: [{DUAL}<D>; {n}] = ::core::array::from_fn(|i| if i < {nv} {{ constant(v[i]) \
                 }} else {{ constant(s) }});
                    let u: [{DUAL}<D>; {nu}] = ::core::array::from_fn(|i| if i < u.len() {{ \
                 constant(u[i]) }} else {{ constant(s) }});
                    Self::{helper}::<{DUAL}<D>>(p, &q, &v, &u, constant(t), {DUAL}::new(s, \
                 D::from(1.0))).map(|c| c.eps)
                }}"
            );
            helper = name;
        }
        let value = body.bind(&format!("Self::{helper}(p, q, v, u, t, {})", at[0]));
        Some(shape.within(&value))
    }
}

/// One step of a chain.
fn step(own: &Parts, operator: Operator, its: &Parts, body: &mut Body) -> Option<Parts> {
    let symbol = operator.symbol();
    Some(match (own.len(), its.len()) {
        (1, _) => its.with(each(its, body, |c| format!("{} {symbol} {c}", own[0]))),
        (_, 1) => own.with(each(own, body, |c| format!("{c} {symbol} {}", its[0]))),
        _ if operator == Operator::Multiply => matrix_product(own, its, body)?,
        _ => {
            let pairs = own.iter().zip(its.iter());
            let names = pairs.map(|(a, b)| body.bind(&format!("{a} {symbol} {b}")));
            own.with(names.collect())
        }
    })
}

/// Stands for the argument of the function that is being differentiated; no name of the language has
/// a blank.
const ARGUMENT: &str = "the argument";

/// The expression with names replaced by expressions.
fn insert(expr: &Expr, map: &HashMap<&str, &Expr>) -> Expr {
    let boxed = |inner: &Expr| Box::new(insert(inner, map));
    let all = |items: &[Expr]| items.iter().map(|item| insert(item, map)).collect();
    let kind = match &expr.kind {
        Kind::Profile { .. } => expr.kind.clone(),
        Kind::Number { .. } => expr.kind.clone(),
        Kind::Name(name) => {
            return map
                .get(name.text.as_str())
                .map_or_else(|| expr.clone(), |&replacement| replacement.clone());
        }
        Kind::Negate(inner) => Kind::Negate(boxed(inner)),
        Kind::Chain(first, rest) => {
            let rest = rest.iter().map(|link| Link {
                operand: insert(&link.operand, map),
                ..*link
            });
            Kind::Chain(boxed(first), rest.collect())
        }
        Kind::Power {
            base,
            place,
            exponent,
        } => Kind::Power {
            base: boxed(base),
            place: *place,
            exponent: boxed(exponent),
        },
        Kind::Call {
            function,
            arguments,
        } => Kind::Call {
            function: function.clone(),
            arguments: all(arguments),
        },
        Kind::Derivative {
            function,
            order,
            argument,
        } => Kind::Derivative {
            function: function.clone(),
            order: *order,
            argument: boxed(argument),
        },
        Kind::Norm(inner) => Kind::Norm(boxed(inner)),
        Kind::Vector(items) => Kind::Vector(all(items)),
        Kind::Component { vector, name } => Kind::Component {
            vector: boxed(vector),
            name: name.clone(),
        },
        Kind::Index { vector, index } => Kind::Index {
            vector: boxed(vector),
            index: *index,
        },
    };
    Expr {
        kind,
        ..expr.clone()
    }
}
