//! The Lagrangian, the forces and the gaps once more, as functions that are generic over dual numbers: what is derived of
//! them can be compared with what dual numbers say.

use super::kernel::literal;
use crate::graph::{Function, Function2, Sym, Variable};
use crate::scene::{CheckedScene, Contact};
use crate::tape::{self, Leaf, Op};
use std::fmt::Write;

/// Longest of these functions, in operations: well below some 3000, from which on rustc with debug information crashes
/// (rust-lang/rust#93908).
const LONGEST: usize = 2000;

const NUMBER: &str =
    "__D: ::hangtime::scene::num_dual::DualNum<Primitive = __f64> + ::core::marker::Copy";

/// Source of the methods; `None` if dual numbers do not know a function in them, or if something acts that is none of these.
pub(super) fn write(scene: &CheckedScene) -> Option<String> {
    let acts = |contact: &Contact| contact.bound.is_some() || !contact.reset.is_empty();
    if scene.contacts.iter().any(acts) {
        return None;
    }
    let gaps: Vec<Sym> = scene.contacts.iter().map(|contact| contact.gap).collect();
    let lagrangian = body(&[scene.lagrangian], scene)?;
    let (forces, gaps) = (body(&scene.forces, scene)?, body(&gaps, scene)?);
    let (n, contacts) = (scene.forces.len(), scene.contacts.len());
    Some(format!(
        "/// The Lagrangian, for any kind of dual number: `q` and `v` in declared units, `t` in seconds.
        pub fn lagrangian<{NUMBER}>(&self, __q: &[__D], __v: &[__D], __t: __D) -> __D {{ let __value: [__D; 1] = {lagrangian}; __value[0] }}
        /// The generalized forces, one a coordinate, for any kind of dual number: `q`, `v` and `u` in declared units, `t` in seconds.
        pub fn generalized_forces<{NUMBER}>(&self, __q: &[__D], __v: &[__D], __u: &[__D], __t: __D) -> [__D; {n}] {forces}
        /// The gaps of all contacts in SI units, for any kind of dual number: `q` in declared units, `t` in seconds.
        pub fn gaps<{NUMBER}>(&self, __q: &[__D], __t: __D) -> [__D; {contacts}] {gaps}"
    ))
}

/// A block whose value is the array of the outputs.
fn body(outputs: &[Sym], scene: &CheckedScene) -> Option<String> {
    let tape = tape::shortest(outputs);
    if tape.ops.len() > LONGEST {
        return None;
    }
    let mut code = String::from("{");
    for (position, op) in tape.ops.iter().enumerate() {
        let value = value(*op, scene)?;
        let _ = write!(code, "let __e{position} = {value};");
    }
    let outputs = tape.outputs.iter().map(|output| format!("__e{output}"));
    let outputs: Vec<String> = outputs.collect();
    let _ = write!(code, "[{}] }}", outputs.join(", "));
    Some(code)
}

/// An operation as an expression.
fn value(op: Op, scene: &CheckedScene) -> Option<String> {
    Some(match op {
        Op::Given(Leaf::Variable(Variable::Parameter(i))) => {
            let name = scene.parameters[usize::from(i)].name.rust();
            format!("__D::from(self.{name})")
        }
        Op::Given(Leaf::Variable(Variable::Coordinate(i))) => format!("__q[{i}]"),
        Op::Given(Leaf::Variable(Variable::Velocity(i))) => format!("__v[{i}]"),
        Op::Given(Leaf::Variable(Variable::Control(i))) => format!("__u[{i}]"),
        Op::Given(Leaf::Variable(Variable::Time)) => "__t".to_owned(),
        Op::Given(Leaf::Constant(bits)) => format!("__D::from({})", literal(f64::from_bits(bits))),
        Op::Add(a, b) => format!("__e{a} + __e{b}"),
        Op::Subtract(a, b) => format!("__e{a} - __e{b}"),
        Op::Multiply(a, b) => format!("__e{a} * __e{b}"),
        Op::Divide(a, b) => format!("__e{a} / __e{b}"),
        Op::Negate(a) => format!("-__e{a}"),
        Op::Root(a) | Op::Call(Function::Root, a) => format!("__e{a}.sqrt()"),
        Op::Call2(Function2::Atan2, a, b) => format!("__e{a}.atan2(__e{b})"),
        Op::Call2(Function2::Power, a, b) => format!("__e{a}.powd(__e{b})"),
        Op::Call(function, a) => {
            let name = Function::named(function.name())?.name();
            format!("__e{a}.{name}()")
        }
        Op::Given(_) => return None,
    })
}
