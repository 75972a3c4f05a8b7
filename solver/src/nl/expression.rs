//! An expression, from the prefix notation of a file to nodes of the graph.

use super::error::ReadError;
use super::graph::{Graph, NodeId};
use super::operation::{Function, Operation, Relation};
use super::source::Source;

/// What a name or a number in an expression stands for.
pub(super) struct Names<'a> {
    pub(super) variables: usize,
    /// Nodes of the common expressions, as far as they are defined.
    pub(super) common: &'a [Option<NodeId>],
    /// Names of imported functions.
    pub(super) functions: &'a [(usize, String)],
}

/// An operator whose operands are being read.
struct Pending {
    code: usize,
    operands: usize,
    /// Where its operands begin among the nodes that are done.
    first: usize,
}

/// Reads one expression. Nesting costs no stack.
///
/// # Errors
/// [`ReadError`] if it is none, or if an operator or a function has no derivatives here.
pub(super) fn read(
    source: &mut Source,
    graph: &mut Graph,
    names: &Names,
) -> Result<NodeId, ReadError> {
    let mut pending: Vec<Pending> = Vec::new();
    let mut done: Vec<NodeId> = Vec::new();
    loop {
        let node = match source.key() {
            Some(b'n') => {
                let value = source.finite()?;
                graph.constant(value)
            }
            Some(key @ (b's' | b'l')) => {
                let value = source.whole(key == b's')?;
                graph.constant(value)
            }
            Some(b'v') => named(source, names)?,
            Some(b'o') => {
                let code = source.index()?;
                let operands = match operands_of(code) {
                    Some(operands) => operands,
                    None => {
                        let count = source.index()?;
                        if count == 0 || count > source.remaining() {
                            return Err(source.error(format!("a list of {count} operands")));
                        }
                        count
                    }
                };
                check(code).map_err(|what| source.error(what))?;
                pending.push(Pending {
                    code,
                    operands,
                    first: done.len(),
                });
                continue;
            }
            Some(b'f') => return Err(refuse_function(source, names)),
            Some(b'h') => return Err(source.error("the expression holds text; give numbers only")),
            Some(key) => {
                return Err(source.error(format!(
                    "expected an expression, found `{}`",
                    char::from(key).escape_default()
                )));
            }
            None => return Err(source.error("the file ends inside an expression")),
        };
        done.push(node);
        while let Some(last) = pending.last()
            && done.len() - last.first == last.operands
        {
            let node = apply(graph, last.code, &done[last.first..]);
            done.truncate(last.first);
            pending.pop();
            done.push(node);
        }
        if pending.is_empty() {
            return Ok(done[0]);
        }
    }
}

/// A variable or a common expression.
fn named(source: &mut Source, names: &Names) -> Result<NodeId, ReadError> {
    let index = source.index()?;
    if index < names.variables {
        return Ok(index as NodeId);
    }
    match names.common.get(index - names.variables) {
        Some(Some(node)) => Ok(*node),
        Some(None) => Err(source.error(format!(
            "v{index} is named before it is defined; a V segment has to come first"
        ))),
        None => Err(source.error(format!(
            "v{index} does not exist: there are {} variables and {} common expressions",
            names.variables,
            names.common.len()
        ))),
    }
}

fn refuse_function(source: &mut Source, names: &Names) -> ReadError {
    let index = match source.index() {
        Ok(index) => index,
        Err(error) => return error,
    };
    let mut known = names.functions.iter();
    let name = known.find(|(number, _)| *number == index);
    let name = name.map_or("without a name", |(_, name)| name.as_str());
    source.error(format!(
        "the imported function `{name}` has no derivatives here; state it by elementary functions"
    ))
}

/// Operands of an operator; `None` where their number follows.
fn operands_of(code: usize) -> Option<usize> {
    match code {
        0..=6 | 20..=30 | 48 | 55..=58 | 72 | 73 | 75 | 77 => Some(2),
        11 | 12 | 54 | 59..=63 | 66..=71 | 74 => None,
        35 | 65 => Some(3),
        _ => Some(1),
    }
}

fn function_of(code: usize) -> Option<Function> {
    Some(match code {
        37 => Function::Tanh,
        38 => Function::Tan,
        39 => Function::Sqrt,
        40 => Function::Sinh,
        41 => Function::Sin,
        42 => Function::Log10,
        43 => Function::Log,
        44 => Function::Exp,
        45 => Function::Cosh,
        46 => Function::Cos,
        47 => Function::Atanh,
        49 => Function::Atan,
        50 => Function::Asinh,
        51 => Function::Asin,
        52 => Function::Acosh,
        53 => Function::Acos,
        _ => return None,
    })
}

fn relation_of(code: usize) -> Option<Relation> {
    Some(match code {
        20 | 71 => Relation::Or,
        21 | 70 => Relation::And,
        22 => Relation::Less,
        23 => Relation::LessOrEqual,
        24 => Relation::Equal,
        28 => Relation::GreaterOrEqual,
        29 => Relation::Greater,
        30 => Relation::NotEqual,
        _ => return None,
    })
}

/// Whether an operator is understood; otherwise why it is refused.
fn check(code: usize) -> Result<(), String> {
    let name = match code {
        4 => "rem",
        13 => "floor",
        14 => "ceil",
        55 => "div",
        56 => "precision",
        57 => "round",
        58 => "trunc",
        59 => "count",
        60 | 61 => "numberof",
        62 | 67 => "atleast",
        63 | 68 => "atmost",
        66 | 69 => "exactly",
        64 => "piecewise-linear term",
        65 => "symbolic if",
        72 => "implies",
        73 => "iff",
        74 => "alldiff",
        0..=3 | 5 | 6 | 11 | 12 | 15 | 16 | 34 | 35 | 48 | 54 | 75..=77 => return Ok(()),
        _ if function_of(code).is_some() || relation_of(code).is_some() => return Ok(()),
        _ => return Err(format!("there is no operator o{code}")),
    };
    Err(format!(
        "the operator `{name}` (o{code}) is not continuous or not differentiated here; state the problem without it"
    ))
}

/// The node of an operator that [`check`] let pass.
fn apply(graph: &mut Graph, code: usize, operands: &[NodeId]) -> NodeId {
    let a = operands[0];
    let b = operands.get(1).copied().unwrap_or(a);
    if let Some(function) = function_of(code) {
        return graph.function(function, a);
    }
    let pair = |graph: &mut Graph, operation, a, b| graph.operation(operation, [a, b, a]);
    let list = |graph: &mut Graph, operation| {
        let rest = operands[1..].iter();
        rest.fold(a, |all, &next| pair(graph, operation, all, next))
    };
    if let Some(relation) = relation_of(code) {
        return list(graph, Operation::Relation(relation));
    }
    match code {
        0 => graph.sum(0.0, &[(a, 1.0), (b, 1.0)]),
        1 => graph.sum(0.0, &[(a, 1.0), (b, -1.0)]),
        2 => graph.product(a, b),
        3 => graph.quotient(a, b),
        5 | 75 | 77 => graph.power(a, b),
        6 => {
            let difference = graph.sum(0.0, &[(a, 1.0), (b, -1.0)]);
            let zero = graph.constant(0.0);
            pair(graph, Operation::Maximum, difference, zero)
        }
        11 => list(graph, Operation::Minimum),
        12 => list(graph, Operation::Maximum),
        15 => graph.operation(Operation::Absolute, [a, a, a]),
        16 => graph.sum(0.0, &[(a, -1.0)]),
        34 => {
            let zero = graph.constant(0.0);
            pair(graph, Operation::Relation(Relation::Equal), a, zero)
        }
        35 => graph.operation(Operation::Select, [b, operands[2], a]),
        48 => pair(graph, Operation::Atan2, a, b),
        76 => graph.operation(Operation::Power(2.0), [a, a, a]),
        _ => {
            let terms: Vec<_> = operands.iter().map(|&node| (node, 1.0)).collect();
            graph.sum(0.0, &terms)
        }
    }
}
