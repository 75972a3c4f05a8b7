//! What the user wrote, with all places kept.

use crate::diagnostics::Place;
use hangtime_units::Unit;
use proc_macro2::{Ident, Literal, TokenStream};
use std::fmt;

/// A name as written.
#[derive(Debug, Clone)]
pub(crate) struct Name {
    pub(crate) text: String,
    pub(crate) ident: Ident,
}

impl Name {
    pub(crate) fn place(&self) -> Place {
        Place::at(self.ident.span())
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

/// Doc comments: one string literal a line.
#[derive(Debug, Clone, Default)]
pub(crate) struct Documentation {
    pub(crate) lines: Vec<Literal>,
}

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
}

/// `name: value`, in `forces` and `start`.
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

/// `name in lower..=upper`, in `free`.
#[derive(Debug)]
pub(crate) struct FreeStart {
    pub(crate) target: Name,
    /// Whether the target is `dot(name)`.
    pub(crate) velocity: bool,
    pub(crate) bounds: Option<(Expr, Expr)>,
}

/// What happens where surfaces are hit: parts of an impact law, which the parser has seen to fit together.
#[derive(Debug)]
pub(crate) struct Law {
    /// Coefficient of restitution; `None` for an inelastic law.
    pub(crate) restitution: Option<Expr>,
    /// Coefficient of friction.
    pub(crate) friction: Option<Expr>,
    /// Sliding velocity.
    pub(crate) sliding: Option<Expr>,
    /// Direction of the impulse.
    pub(crate) along: Option<Expr>,
    /// Coordinates that are rigid under the impulse.
    pub(crate) holding: Vec<Name>,
}

/// One statement.
#[derive(Debug)]
pub(crate) enum Statement {
    Parameters(Vec<Quantity>),
    Coordinates(Vec<Quantity>),
    Controls(Vec<Quantity>),
    Let {
        name: Name,
        value: Expr,
    },
    Function {
        name: Name,
        arguments: Vec<Name>,
        body: Expr,
    },
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

/// Operators between two expressions.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Operator {
    Add,
    Subtract,
    Multiply,
    Divide,
    Power,
}

impl Operator {
    pub(crate) fn symbol(self) -> char {
        match self {
            Self::Add => '+',
            Self::Subtract => '-',
            Self::Multiply => '*',
            Self::Divide => '/',
            Self::Power => '^',
        }
    }
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
    Binary {
        operator: Operator,
        place: Place,
        left: Box<Expr>,
        right: Box<Expr>,
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
    /// `vector[0]`.
    Index {
        vector: Box<Expr>,
        index: usize,
    },
}

impl Expr {
    /// The expressions directly below.
    pub(crate) fn children(&self) -> Vec<&Self> {
        match &self.kind {
            Kind::Number { .. } | Kind::Name(_) => Vec::new(),
            Kind::Negate(inner) | Kind::Norm(inner) => vec![inner],
            Kind::Binary { left, right, .. } => vec![left, right],
            Kind::Call {
                arguments: items, ..
            }
            | Kind::Vector(items) => items.iter().collect(),
            Kind::Derivative { argument, .. } => vec![argument],
            Kind::Component { vector, .. } | Kind::Index { vector, .. } => vec![vector],
        }
    }
}

impl fmt::Display for Expr {
    /// The expression as its author would write it again.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write_expr(f, self, 0)
    }
}

fn write_expr(f: &mut fmt::Formatter<'_>, expr: &Expr, outer: u8) -> fmt::Result {
    let sequence = |f: &mut fmt::Formatter<'_>, items: &[Expr]| {
        f.write_str("(")?;
        for (i, item) in items.iter().enumerate() {
            if i > 0 {
                f.write_str(", ")?;
            }
            write_expr(f, item, 0)?;
        }
        f.write_str(")")
    };
    let own = match &expr.kind {
        Kind::Binary { operator, .. } => match operator {
            Operator::Add | Operator::Subtract => 1,
            Operator::Multiply | Operator::Divide => 2,
            Operator::Power => 4,
        },
        Kind::Negate(_) => 2,
        _ => 9,
    };
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
        Kind::Binary {
            operator,
            left,
            right,
            ..
        } => {
            write_expr(f, left, if own == 4 { 5 } else { own })?;
            if own == 1 {
                write!(f, " {} ", operator.symbol())?;
            } else {
                write!(f, "{}", operator.symbol())?;
            }
            write_expr(f, right, own + 1)?;
        }
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
            write!(
                f,
                "{}{}{}(",
                "diff(".repeat(*order),
                function.text,
                ")".repeat(*order)
            )?;
            write_expr(f, argument, 0)?;
            f.write_str(")")?;
        }
        Kind::Norm(inner) => {
            f.write_str("|")?;
            write_expr(f, inner, 0)?;
            f.write_str("|")?;
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
