//! The steps in which a kernel is evaluated: one operation each, or a few of which nobody else reads what is between
//! them, in an order in which equal steps follow each other.

use hangtime_dsl::description::{Function, Function2, Operation};
use std::collections::{BTreeMap, VecDeque};

/// What is done with some numbers, with the roundings of the single operations.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Kind {
    /// `a + b`
    Add,
    /// `a - b`
    Subtract,
    /// `a b`
    Multiply,
    /// `a / b`
    Divide,
    /// `-a`
    Negate,
    /// The square root.
    Root,
    /// `a b + c`
    ProductPlus,
    /// `a b - c`
    ProductMinus,
    /// `c - a b`
    LessProduct,
    /// `a b + c d`
    SumOfProducts,
    /// `a b - c d`
    DifferenceOfProducts,
    /// `(a b) c`
    ProductOfThree,
    Call(Function),
    Call2(Function2),
    /// Sine and cosine of one number, by one call.
    SineAndCosine,
}

/// One step. Values are named by the operations that make them.
#[derive(Debug)]
pub(super) struct Step {
    pub(super) kind: Kind,
    pub(super) results: Vec<usize>,
    pub(super) operands: Vec<usize>,
}

/// The steps of a kernel in order of evaluation, without what is `constant`.
pub(super) fn steps(operations: &[Operation], outputs: &[u32], constant: &[bool]) -> Vec<Step> {
    scheduled(joined(operations, outputs, constant), operations.len())
}

/// Operations as steps, in their own order.
fn joined(operations: &[Operation], outputs: &[u32], constant: &[bool]) -> Vec<Step> {
    let mut uses = vec![0_usize; operations.len()];
    let computed = |at: usize| !constant[at] && !operations[at].is_given();
    let reading = (0..operations.len()).filter(|&at| computed(at));
    let read = reading.flat_map(|at| operations[at].operands());
    for part in read.chain(outputs.iter().copied()) {
        uses[part as usize] += 1;
    }
    let cosines = cosines(operations, constant);
    // A product that is read once can be part of what reads it.
    let product = |at: u32| match operations[at as usize] {
        Operation::Multiply(a, b) if uses[at as usize] == 1 && computed(at as usize) => {
            Some([a, b])
        }
        _ => None,
    };
    let mut done = vec![false; operations.len()];
    let mut steps = Vec::new();
    // Readers come before what they read.
    for at in (0..operations.len()).rev() {
        if done[at] || !computed(at) || cosines.values().any(|&cosine| cosine == at) {
            continue;
        }
        let Some((kind, operands, parts)) = together(operations[at], product) else {
            continue;
        };
        for part in parts.into_iter().flatten() {
            done[part as usize] = true;
        }
        let cosine = cosines.get(&at).copied();
        steps.push(Step {
            kind: cosine.map_or(kind, |_| Kind::SineAndCosine),
            results: [at].into_iter().chain(cosine).collect(),
            operands: operands.iter().map(|&part| part as usize).collect(),
        });
    }
    steps.reverse();
    steps
}

/// What is done, with what, and which products are part of it.
type Together = (Kind, Vec<u32>, [Option<u32>; 2]);

/// An operation with the products that become part of it.
fn together(operation: Operation, product: impl Fn(u32) -> Option<[u32; 2]>) -> Option<Together> {
    let alone = |kind| (kind, operation.operands().collect(), [None; 2]);
    let with = |kind, [a, b]: [u32; 2], c, part| (kind, vec![a, b, c], [Some(part), None]);
    Some(match operation {
        Operation::Add(a, b) => match [product(a), product(b)] {
            [Some(c), Some(d)] => (Kind::SumOfProducts, [c, d].concat(), [Some(a), Some(b)]),
            [None, Some(c)] => with(Kind::ProductPlus, c, a, b),
            [Some(c), None] => with(Kind::ProductPlus, c, b, a),
            [None, None] => alone(Kind::Add),
        },
        Operation::Subtract(a, b) => match [product(a), product(b)] {
            [Some(c), Some(d)] => (
                Kind::DifferenceOfProducts,
                [c, d].concat(),
                [Some(a), Some(b)],
            ),
            [None, Some(c)] => with(Kind::LessProduct, c, a, b),
            [Some(c), None] => with(Kind::ProductMinus, c, b, a),
            [None, None] => alone(Kind::Subtract),
        },
        Operation::Multiply(a, b) => match [product(a), product(b)] {
            [Some(c), _] => with(Kind::ProductOfThree, c, b, a),
            [None, Some(c)] => with(Kind::ProductOfThree, c, a, b),
            [None, None] => alone(Kind::Multiply),
        },
        Operation::Divide(..) => alone(Kind::Divide),
        Operation::Negate(_) => alone(Kind::Negate),
        Operation::Root(_) => alone(Kind::Root),
        Operation::Call(function, _) => alone(Kind::Call(function)),
        Operation::Call2(function, ..) => alone(Kind::Call2(function)),
        Operation::Given(_) => return None,
    })
}

/// The cosines that are evaluated together with a sine, by that.
fn cosines(operations: &[Operation], constant: &[bool]) -> BTreeMap<usize, usize> {
    let calls = |wanted: Function| {
        let found = operations.iter().enumerate();
        found.filter_map(move |(at, operation)| match *operation {
            Operation::Call(function, of) if function == wanted && !constant[at] => Some((of, at)),
            _ => None,
        })
    };
    let sines: BTreeMap<u32, usize> = calls(Function::Sin).collect();
    let pairs = calls(Function::Cos).filter_map(|(of, cosine)| Some((*sines.get(&of)?, cosine)));
    pairs.collect()
}

/// These steps, in an order in which equal ones follow each other where possible.
fn scheduled(steps: Vec<Step>, values: usize) -> Vec<Step> {
    let mut made = vec![false; values];
    for &result in steps.iter().flat_map(|step| &step.results) {
        made[result] = true;
    }
    let mut users: Vec<Vec<usize>> = vec![Vec::new(); values];
    let mut waits = vec![0_usize; steps.len()];
    let mut ready: BTreeMap<Kind, VecDeque<usize>> = BTreeMap::new();
    for (index, step) in steps.iter().enumerate() {
        for &part in step.operands.iter().filter(|&&part| made[part]) {
            users[part].push(index);
            waits[index] += 1;
        }
        if waits[index] == 0 {
            ready.entry(step.kind).or_default().push_back(index);
        }
    }
    // How often the kind changes at least, from a step to the last one that needs it.
    let mut changes = vec![0_usize; steps.len()];
    for (index, step) in steps.iter().enumerate().rev() {
        for &user in step.results.iter().flat_map(|&at| &users[at]) {
            let more = usize::from(steps[user].kind != step.kind);
            changes[index] = changes[index].max(changes[user] + more);
        }
    }
    let mut order = Vec::with_capacity(steps.len());
    // The kind behind whose steps the kind changes most often; of what it makes ready, its own kind follows in the same
    // run. The others wait until they are more.
    while let Some((&now, _)) = ready
        .iter()
        .filter(|(_, waiting)| !waiting.is_empty())
        .max_by_key(|(_, waiting)| {
            let most = waiting.iter().map(|&index| changes[index]).max();
            (most, waiting.len())
        })
    {
        while let Some(index) = ready.get_mut(&now).and_then(VecDeque::pop_front) {
            order.push(index);
            for &user in steps[index].results.iter().flat_map(|&at| &users[at]) {
                waits[user] -= 1;
                if waits[user] == 0 {
                    ready.entry(steps[user].kind).or_default().push_back(user);
                }
            }
        }
    }
    let mut steps: Vec<Option<Step>> = steps.into_iter().map(Some).collect();
    let taken = order.into_iter().filter_map(|index| steps[index].take());
    taken.collect()
}
