//! Functions that differ in the names of their variables only, as those of equal pairs of bodies do, are ordered once.

use crate::graph::{self, Sym, Variable};
use crate::tape::{self, Leaf, Op, Tape};
use std::collections::HashMap;

/// Most variables of a function that is compared with others.
const MOST_VARIABLES: usize = 64;
/// Placeholders begin here, a thousand for each kind of variable; expressions of a scene have no such arguments.
const FIRST: u16 = u16::MAX / 2;
const KIND: u16 = 1024;

/// The functions so far.
#[derive(Default)]
pub(super) struct Renamed {
    tapes: HashMap<Vec<Sym>, Tape>,
}

impl Renamed {
    /// The shortest evaluation of `outputs`.
    pub(super) fn shortest(&mut self, outputs: &[Sym]) -> Tape {
        let names = Names::of(outputs);
        if names.placeholders.len() > MOST_VARIABLES {
            return tape::shortest(outputs);
        }
        let places: Vec<usize> = (0..outputs.len())
            .filter(|&k| !outputs[k].is_structural_zero())
            .collect();
        let nonzero: Vec<Sym> = places.iter().map(|&k| outputs[k]).collect();
        let key = graph::substitute(&nonzero, |variable| {
            let placeholder = names.placeholders.get(&variable);
            placeholder.map(|&placeholder| Sym::variable(placeholder))
        });
        let known = self.tapes.entry(key);
        let known = known.or_insert_with_key(|key| tape::shortest(key));
        let ops = known.ops.iter().map(|&op| match op {
            Op::Given(Leaf::Variable(variable)) => Op::Given(Leaf::Variable(names.name(variable))),
            other => other,
        });
        let mut tape = Tape {
            ops: ops.collect(),
            outputs: Vec::new(),
        };
        // What is zero for some may be written for others.
        let zero = tape.ops.len() as u32;
        if places.len() < outputs.len() {
            tape.ops.push(Op::Given(Leaf::Constant(0.0_f64.to_bits())));
        }
        tape.outputs = vec![zero; outputs.len()];
        for (&place, &output) in places.iter().zip(&known.outputs) {
            tape.outputs[place] = output;
        }
        tape
    }
}

/// The variables of some expressions that have placeholders, in their order.
struct Names {
    placeholders: HashMap<Variable, Variable>,
    variables: HashMap<Variable, Variable>,
}

impl Names {
    fn of(outputs: &[Sym]) -> Self {
        let mut next = [0_u16; 4];
        let mut names = Self {
            placeholders: HashMap::new(),
            variables: HashMap::new(),
        };
        for variable in graph::variables(outputs) {
            let kind: u16 = match variable {
                Variable::Coordinate(_) => 0,
                Variable::Velocity(_) => 1,
                Variable::Multiplier(_) => 2,
                Variable::Unknown(_) => 3,
                _ => continue,
            };
            let rank = &mut next[usize::from(kind)];
            let placeholder = Variable::Argument(FIRST + KIND * kind + *rank % KIND);
            *rank += 1;
            names.placeholders.insert(variable, placeholder);
            names.variables.insert(placeholder, variable);
        }
        names
    }

    fn name(&self, variable: Variable) -> Variable {
        self.variables.get(&variable).copied().unwrap_or(variable)
    }
}
