//! What the user wrote, with all places kept.

use crate::diagnostics::Place;
use crate::graph::Profile;
use crate::words;
use hangtime_units::Unit;
use proc_macro2::{Ident, TokenStream};
use std::fmt::{self, Write as _};

/// A name as written.
#[derive(Debug, Clone)]
pub(crate) struct Name {
    pub(crate) text: String,
    pub(crate) ident: Ident,
}

impl Name {
    /// What is written under another word, and stands where an expression begins.
    pub(crate) fn at(place: Place, text: String) -> Self {
        Self {
            text,
            ident: Ident::new("_at", place.start),
        }
    }

    pub(crate) fn place(&self) -> Place {
        Place::at(self.ident.span())
    }

    /// The name in emitted source.
    pub(crate) fn rust(&self) -> String {
        words::rust_name(&self.text)
    }

    /// The name in emitted tokens.
    pub(crate) fn rust_ident(&self) -> Ident {
        if words::is_raw(&self.text) {
            Ident::new_raw(&self.text, self.ident.span())
        } else {
            Ident::new(&self.rust(), self.ident.span())
        }
    }
}

/// A whole declaration.
#[derive(Debug)]
pub(crate) struct Scene {
    pub(crate) documentation: Documentation,
    pub(crate) visibility: TokenStream,
    pub(crate) name: Name,
    pub(crate) statements: Vec<Statement>,
}

/// Doc comments as plain text.
pub(crate) type Documentation = String;

/// A unit as written, and what it means.
#[derive(Debug, Clone)]
pub(crate) struct WrittenUnit {
    pub(crate) text: String,
    pub(crate) unit: Unit,
}

/// `name: unit in lower..=upper = value`, in `parameters`, `coordinates` and `controls`.
#[derive(Debug)]
pub(crate) struct Quantity {
    pub(crate) documentation: Documentation,
    pub(crate) name: Name,
    pub(crate) unit: Option<WrittenUnit>,
    pub(crate) bounds: Option<(Expr, Expr)>,
    pub(crate) value: Option<Expr>,
    /// Whether it is a parameter that is to be found, `free name: unit in lower..=upper = value`.
    pub(crate) free: bool,
}

/// Numbers that are above zero, written out of shapes and stops.
#[derive(Debug, Clone)]
pub(crate) struct Positive {
    /// Code and message of the mistake where a default is not.
    pub(crate) code: &'static str,
    pub(crate) message: String,
    /// The shape or joint that has such numbers, of which one mistake is told, and the part of it.
    pub(crate) of: String,
    pub(crate) part: String,
    pub(crate) value: Expr,
}

/// `name: value`, in `forces` and `start`, and `name = value`, in `when`.
#[derive(Debug, Clone)]
pub(crate) struct Assignment {
    pub(crate) target: Name,
    /// Whether the target is `dot(name)`.
    pub(crate) velocity: bool,
    pub(crate) value: Expr,
}

/// How two sides compare; a surface has no `Equal`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Relation {
    Equal,
    AtLeast,
    AtMost,
}

/// `left >= right`, in `constraint` and `finally`.
#[derive(Debug)]
pub(crate) struct Condition {
    pub(crate) documentation: Documentation,
    pub(crate) left: Expr,
    pub(crate) relation: Relation,
    pub(crate) right: Expr,
}

impl fmt::Display for Condition {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let relation = match self.relation {
            Relation::Equal => "==",
            Relation::AtLeast => ">=",
            Relation::AtMost => "<=",
        };
        write!(f, "{} {relation} {}", self.left, self.right)
    }
}

/// `name in lower..=upper`, in `free`.
#[derive(Debug)]
pub(crate) struct FreeStart {
    pub(crate) target: Name,
    /// Whether the target is `dot(name)`.
    pub(crate) velocity: bool,
    pub(crate) bounds: Option<(Expr, Expr)>,
}

/// `target within deviation`, in `measured`.
#[derive(Debug)]
pub(crate) struct MeasuredQuantity {
    /// A coordinate, a state or an output.
    pub(crate) target: Name,
    /// Whether the target is `dot(name)`.
    pub(crate) velocity: bool,
    /// The standard deviation of its measurements.
    pub(crate) within: Expr,
}

/// `measured name: "file" { target within deviation, ..., start { ... } }`: one experiment.
#[derive(Debug)]
pub(crate) struct Measured {
    pub(crate) documentation: Documentation,
    pub(crate) name: Name,
    /// The file with the measurements, as written.
    pub(crate) file: String,
    pub(crate) quantities: Vec<MeasuredQuantity>,
    /// Start values of its own.
    pub(crate) start: Vec<Assignment>,
}

/// What happens where surfaces are hit: parts of an impact law, which the parser has seen to fit together.
#[derive(Debug)]
pub(crate) struct Law {
    /// Coefficient of restitution; `None` for an inelastic law.
    pub(crate) restitution: Option<Expr>,
    /// Coefficient of friction; where another one holds at rest, that of sliding.
    pub(crate) friction: Option<Expr>,
    /// Coefficient of friction at rest, if it is another one.
    pub(crate) at_rest: Option<Expr>,
    /// Sliding velocity.
    pub(crate) sliding: Option<Expr>,
    /// Direction of the impulse.
    pub(crate) along: Option<Expr>,
    /// Coordinates that are rigid under the impulse.
    pub(crate) holding: Vec<Name>,
    /// Whether contacts that touch are struck one after the other.
    pub(crate) sequence: bool,
}

/// An entry of `picture`.
#[derive(Debug)]
pub(crate) enum Shape {
    /// A rigid body.
    Body {
        name: Name,
        at: Expr,
        angle: Option<Expr>,
        form: Form,
    },
    /// What joins two points: a link, or a spring.
    Line { spring: bool, ends: Box<[Expr; 2]> },
    /// A curve over a number of its own, in a range or over all that is shown.
    Curve {
        name: Name,
        points: Expr,
        over: Name,
        range: Option<(Expr, Expr)>,
    },
}

/// What a body looks like.
#[derive(Debug)]
pub(crate) enum Form {
    Point,
    Circle { radius: Expr },
    Rectangle { size: Expr },
    Polygon { corners: Vec<Expr> },
}

/// One statement.
#[derive(Debug)]
pub(crate) enum Statement {
    Parameters(Vec<Quantity>),
    Coordinates(Vec<Quantity>),
    Controls(Vec<Quantity>),
    /// States of first order.
    States(Vec<Quantity>),
    /// What the states change by, one a state.
    Rates(Vec<Assignment>),
    Let {
        name: Name,
        unit: Option<WrittenUnit>,
        value: Expr,
    },
    Function {
        name: Name,
        arguments: Vec<Name>,
        body: Expr,
    },
    Positive(Positive),
    Lagrangian {
        keyword: Place,
        value: Expr,
    },
    Dissipation {
        keyword: Place,
        value: Expr,
    },
    Forces(Vec<Assignment>),
    Surface {
        documentation: Documentation,
        name: Name,
        left: Expr,
        relation: Relation,
        right: Expr,
    },
    Impact {
        surfaces: Vec<Name>,
        law: Box<Law>,
    },
    /// Friction without a surface: a force of at most `bound` against a sliding velocity.
    Dry {
        documentation: Documentation,
        name: Name,
        bound: Expr,
        sliding: Expr,
    },
    /// An equation between positions, or between velocities.
    Joint {
        documentation: Documentation,
        name: Name,
        left: Expr,
        right: Expr,
    },
    /// What states and velocities are set to where a condition comes true.
    When {
        condition: Condition,
        assignments: Vec<Assignment>,
    },
    /// What holds at a time inside of the motion.
    At {
        time: Expr,
        /// The time as a parameter that is to be found, which it names then; the parser declares it by itself.
        gate: Option<Box<Quantity>>,
        conditions: Vec<Condition>,
        /// What is asked for then by `at(time, value)`, which the parser adds.
        values: Vec<Assignment>,
    },
    Start(Vec<Assignment>),
    Horizon {
        keyword: Place,
        value: Expr,
    },
    Minimize {
        keyword: Place,
        value: Expr,
    },
    Constraint {
        name: Name,
        condition: Condition,
    },
    Finally(Vec<Condition>),
    Free(Vec<FreeStart>),
    Measured(Box<Measured>),
    Outputs(Vec<Quantity>),
    Picture {
        keyword: Place,
        shapes: Vec<Shape>,
    },
}

/// An expression.
#[derive(Debug, Clone)]
pub(crate) struct Expr {
    pub(crate) kind: Kind,
    pub(crate) place: Place,
    /// Longest path to a leaf; bounded by the parser, so that recursion over it is safe.
    pub(crate) depth: usize,
    /// Whether it was written in parentheses.
    pub(crate) parenthesized: bool,
}

/// Operators of chains.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Operator {
    Add,
    Subtract,
    Multiply,
    Divide,
}

impl Operator {
    pub(crate) fn symbol(self) -> char {
        match self {
            Self::Add => '+',
            Self::Subtract => '-',
            Self::Multiply => '*',
            Self::Divide => '/',
        }
    }

    /// The sign of the term behind it.
    pub(crate) fn sign(self) -> f64 {
        match self {
            Self::Subtract => -1.0,
            _ => 1.0,
        }
    }

    /// Whether it joins terms; the others join factors.
    pub(crate) fn is_additive(self) -> bool {
        matches!(self, Self::Add | Self::Subtract)
    }
}

/// An operator and what stands on its right.
#[derive(Debug, Clone)]
pub(crate) struct Link {
    pub(crate) operator: Operator,
    pub(crate) place: Place,
    pub(crate) operand: Expr,
}

/// Kinds of expressions.
#[derive(Debug, Clone)]
pub(crate) enum Kind {
    /// A number, with its unit in brackets if it carries one.
    Number {
        value: f64,
        text: String,
        unit: Option<WrittenUnit>,
    },
    Name(Name),
    Negate(Box<Expr>),
    /// A sum or a product of any length, read from left to right: terms joined by `+` and `-`, or factors
    /// joined by `*` and `/`. The list holds one link at least.
    Chain(Box<Expr>, Vec<Link>),
    /// `base^exponent`, with the place of `^`.
    Power {
        base: Box<Expr>,
        place: Place,
        exponent: Box<Expr>,
    },
    /// `function(arguments)`.
    Call {
        function: Name,
        arguments: Vec<Expr>,
    },
    /// `diff(function)(argument)`, the derivative of a declared function of one argument.
    Derivative {
        function: Name,
        order: usize,
        argument: Box<Expr>,
    },
    /// `|vector|`.
    Norm(Box<Expr>),
    /// `(a, b, ...)`.
    Vector(Vec<Expr>),
    /// `vector.z`.
    Component {
        vector: Box<Expr>,
        name: Name,
    },
    /// The value of a function given by points; the body of one, whose argument is the name.
    Profile {
        profile: Profile,
        argument: Name,
        argument_unit: Option<WrittenUnit>,
        value_unit: Option<WrittenUnit>,
    },
    /// `vector[0]`.
    Index {
        vector: Box<Expr>,
        index: usize,
    },
}

/// The expressions directly below one of this kind, to be read or changed.
macro_rules! below {
    ($kind:expr, $iter:ident $(, $mutable:tt)?) => {
        match $kind {
            Kind::Number { .. } | Kind::Name(_) | Kind::Profile { .. } => Vec::new(),
            Kind::Negate(inner) | Kind::Norm(inner) => vec![inner],
            Kind::Chain(first, rest) => {
                let operands = rest.$iter().map(|Link { operand, .. }| operand);
                std::iter::once(&$($mutable)? **first).chain(operands).collect()
            }
            Kind::Power { base, exponent, .. } => vec![base, exponent],
            Kind::Call {
                arguments: items, ..
            }
            | Kind::Vector(items) => items.$iter().collect(),
            Kind::Derivative { argument, .. } => vec![argument],
            Kind::Component { vector, .. } | Kind::Index { vector, .. } => vec![vector],
        }
    };
}

impl Expr {
    /// The expressions directly below.
    pub(crate) fn children(&self) -> Vec<&Self> {
        below!(&self.kind, iter)
    }

    /// The expressions directly below, to be changed.
    pub(crate) fn children_mut(&mut self) -> Vec<&mut Self> {
        below!(&mut self.kind, iter_mut, mut)
    }

    /// Whether it is a number without unit, possibly with sign and arithmetic: such a number is meant in the unit of the
    /// declaration it belongs to.
    pub(crate) fn is_bare(&self) -> bool {
        match &self.kind {
            Kind::Number { unit, .. } => unit.is_none(),
            Kind::Name(name) => name.text == "pi",
            Kind::Negate(inner) => inner.is_bare(),
            Kind::Chain(..) => self.children().into_iter().all(Self::is_bare),
            _ => false,
        }
    }

    /// The unit behind a number, possibly with its sign.
    pub(crate) fn unit(&self) -> Option<&WrittenUnit> {
        match &self.kind {
            Kind::Number { unit, .. } => unit.as_ref(),
            Kind::Negate(inner) => inner.unit(),
            _ => None,
        }
    }

    /// Whether a test holds for it or anything in it.
    pub(crate) fn any(&self, test: &dyn Fn(&Self) -> bool) -> bool {
        test(self) || self.children().into_iter().any(|part| part.any(test))
    }

    /// Whether it contains a call of what is called so.
    pub(crate) fn calls(&self, wanted: &str) -> bool {
        self.any(
            &|part| matches!(&part.kind, Kind::Call { function, .. } if function.text == wanted),
        )
    }

    /// Whether it contains a name.
    pub(crate) fn mentions(&self, wanted: &str) -> bool {
        self.any(&|part| matches!(&part.kind, Kind::Name(name) if name.text == wanted))
    }
}

impl fmt::Display for Expr {
    /// The expression as its author would write it again; the middle of a very long one is left out.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut text = String::new();
        write_expr(&mut text, self, 0)?;
        f.write_str(&shortened(text))
    }
}

impl Expr {
    /// The expression as it stands before the sign of a power.
    pub(crate) fn as_base(&self) -> String {
        let mut text = String::new();
        match write_expr(&mut text, self, AS_BASE) {
            Ok(()) => shortened(text),
            Err(fmt::Error) => self.to_string(),
        }
    }
}

/// How strongly what stands before the sign of a power must bind.
const AS_BASE: u8 = 5;

/// What stands on the left of an operator of a chain.
pub(crate) struct Prefix<'a> {
    pub(crate) first: &'a Expr,
    pub(crate) rest: &'a [Link],
}

impl fmt::Display for Prefix<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.rest.is_empty() {
            return self.first.fmt(f);
        }
        let mut text = String::new();
        write_chain(&mut text, self.first, self.rest)?;
        f.write_str(&shortened(text))
    }
}

/// Longest expression that a message shows in full, in characters.
const LONGEST: usize = 400;

fn shortened(text: String) -> String {
    let length = text.chars().count();
    if length <= LONGEST {
        return text;
    }
    let begin: String = text.chars().take(LONGEST / 2).collect();
    let end: String = text.chars().skip(length - LONGEST / 2).collect();
    format!("{begin} ... {end}")
}

/// Rank of the operators of a chain: terms bind less than factors.
fn rank(rest: &[Link]) -> u8 {
    match rest.first() {
        Some(link) if link.operator.is_additive() => 1,
        _ => 2,
    }
}

fn write_chain(f: &mut String, first: &Expr, rest: &[Link]) -> fmt::Result {
    let own = rank(rest);
    write_expr(f, first, own)?;
    for link in rest {
        if own == 1 {
            write!(f, " {} ", link.operator.symbol())?;
        } else {
            f.push(link.operator.symbol());
        }
        write_expr(f, &link.operand, own + 1)?;
    }
    Ok(())
}

/// How strongly an expression holds together.
fn strength(expr: &Expr) -> u8 {
    match &expr.kind {
        Kind::Chain(_, rest) => rank(rest),
        Kind::Power { .. } => 4,
        Kind::Negate(_) => 2,
        _ => 9,
    }
}

/// `if large >= small { value } else { other }`.
fn write_choice(f: &mut String, parts: &[Expr]) -> fmt::Result {
    for (before, part) in ["if ", " >= ", " { ", " } else { "].into_iter().zip(parts) {
        f.push_str(before);
        write_expr(f, part, 0)?;
    }
    f.push_str(" }");
    Ok(())
}

fn write_expr(f: &mut String, expr: &Expr, outer: u8) -> fmt::Result {
    let sequence = |f: &mut String, items: &[Expr]| {
        f.write_str("(")?;
        for (i, item) in items.iter().enumerate() {
            if i > 0 {
                f.write_str(", ")?;
            }
            write_expr(f, item, 0)?;
        }
        f.write_str(")")
    };
    let own = strength(expr);
    if own < outer {
        f.write_str("(")?;
    }
    match &expr.kind {
        Kind::Number { text, unit, .. } => {
            f.write_str(text)?;
            if let Some(unit) = unit {
                write!(f, " [{}]", unit.text)?;
            }
        }
        Kind::Name(name) => f.write_str(&name.text)?,
        Kind::Negate(inner) => {
            f.write_str("-")?;
            write_expr(f, inner, 3)?;
        }
        Kind::Chain(first, rest) => write_chain(f, first, rest)?,
        Kind::Power { base, exponent, .. } => {
            write_expr(f, base, AS_BASE)?;
            f.write_str("^")?;
            write_expr(f, exponent, AS_BASE)?;
        }
        Kind::Call {
            function,
            arguments,
        } if function.text == words::IF && arguments.len() == 4 => write_choice(f, arguments)?,
        Kind::Call {
            function,
            arguments,
        } => {
            f.write_str(&function.text)?;
            sequence(f, arguments)?;
        }
        Kind::Derivative {
            function,
            order,
            argument,
        } => {
            let (open, close) = ("diff(".repeat(*order), ")".repeat(*order));
            write!(f, "{open}{}{close}(", function.text)?;
            write_expr(f, argument, 0)?;
            f.write_str(")")?;
        }
        Kind::Profile {
            profile, argument, ..
        } => write!(f, "{}({})", profile.name(), argument.text)?,
        Kind::Norm(inner) => {
            f.push('|');
            write_expr(f, inner, 0)?;
            f.push('|');
        }
        Kind::Vector(items) => sequence(f, items)?,
        Kind::Component { vector, name } => {
            write_expr(f, vector, 9)?;
            write!(f, ".{}", name.text)?;
        }
        Kind::Index { vector, index } => {
            write_expr(f, vector, 9)?;
            write!(f, "[{index}]")?;
        }
    }
    if own < outer {
        f.write_str(")")?;
    }
    Ok(())
}
