//! The functions of a scene that have derivatives: what each reads and gives.

use super::data::{Contact, Friction, Structure};
use super::places::{contact_point, tangent_point};
use hangtime_dsl::declaration::{ContactDeclaration, FrictionDeclaration, SparsityPattern};

/// A function of a scene that has derivatives.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Function {
    /// Acceleration without contact, `a = M^-1 f`, of `x`: `n_q` values.
    Motion,
    /// Everything about one contact that needs no derivative of a force, of `x`, laid out as [`contact_point`]. Of dry friction gap,
    /// normal velocity, normal and direction are 0, and the curvature is `-r`, the given normal acceleration with the other sign.
    /// Derivatives are those of the rows `(g, v_n, d_1..d_nq)`; of dry friction the second row is `r`.
    Contact(usize),
    /// The tangential side of a contact with friction, of `x`, laid out as [`tangent_point`]. Derivatives are those
    /// of the rows `(v_t, e_1..e_nq)`.
    Tangent(usize),
    /// The same of a contact in space along its second sliding velocity; it has no second derivatives.
    Across(usize),
    /// `(g, w)` of all equations of joints, of `x`, with 0 for `g` of joints of velocities: twice as many values as there are
    /// [equations](hangtime_dsl::declaration::JointsDeclaration::rows).
    Joints,
    /// The running cost if there is one, then the path constraints, of `x`, or of `(x, r, s)` if they read
    /// [forces](hangtime_dsl::declaration::ContactTerms).
    Path,
    /// The final cost if there is one, then the terminal conditions, of `z = (q, v, T)` with what they read of
    /// [contacts](hangtime_dsl::declaration::ContactTerms) behind that.
    Terminal,
    /// What is added up over all impacts, then the conditions on impacts, then what conditions set, of `(x, r, s)`.
    Impact,
    /// [What parameters decide](hangtime_dsl::declaration::Held::given) that are coordinates without motion, of `x`.
    Given,
}

/// What a [`Function`] reads and gives.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Signature {
    /// Length of its input vector.
    pub inputs: usize,
    /// Number of its values.
    pub values: usize,
    /// Pattern of its Jacobian.
    pub jacobian: SparsityPattern,
    /// Pattern (lower triangle) of the Hessian of its weighted values.
    pub hessian: SparsityPattern,
}

/// What is asked for of a function.
#[derive(Clone, Copy)]
pub(super) enum Order {
    Value,
    Jacobian,
    Hessian,
}

/// A contact, what is declared of it and its kernels.
pub(super) fn contact_of(
    structure: &'static Structure,
    contact: usize,
) -> Option<(&'static ContactDeclaration, &'static Contact)> {
    let declared = structure.declaration.contacts.get(contact)?;
    Some((declared, structure.contacts.get(contact)?))
}

/// The friction of a contact, what is declared of it and its kernels.
pub(super) fn friction_of(
    structure: &'static Structure,
    contact: usize,
) -> Option<(&'static FrictionDeclaration, &'static Friction)> {
    let (declared, kernels) = contact_of(structure, contact)?;
    declared.friction.as_ref().zip(kernels.friction.as_ref())
}

/// Lengths and patterns of a function; none where the scene has no such function.
pub(super) fn signature(structure: &'static Structure, function: Function) -> Option<Signature> {
    let declaration = &structure.declaration;
    let n = declaration.coordinates.len();
    let task = declaration.optimal_control.as_ref();
    let of = |inputs, values, jacobian, hessian| Signature {
        inputs,
        values,
        jacobian,
        hessian,
    };
    let of_state = |values, jacobian, hessian| of(declaration.inputs(), values, jacobian, hessian);
    Some(match function {
        Function::Motion => of_state(n, declaration.free_jacobian, declaration.free_hessian),
        Function::Contact(i) => {
            let known = declaration.contacts.get(i)?;
            of_state(contact_point::length(n), known.jacobian, known.hessian)
        }
        Function::Tangent(i) => {
            let (known, _) = friction_of(structure, i)?;
            of_state(tangent_point::length(n), known.jacobian, known.hessian)
        }
        Function::Across(i) => {
            let pattern = friction_of(structure, i)?.0.across?;
            of_state(tangent_point::length(n), pattern, SparsityPattern::EMPTY)
        }
        Function::Joints => {
            let known = declaration.joints.as_ref()?;
            of_state(2 * known.rows(), known.jacobian, known.hessian)
        }
        Function::Given => {
            let known = structure.held?.declared;
            of_state(known.given.len(), known.jacobian, known.hessian)
        }
        Function::Path => {
            let (task, inputs) = (task?, declaration.path_inputs());
            let values = task.path_functions();
            of(inputs, values, task.path_jacobian, task.path_hessian)
        }
        Function::Terminal => {
            let (task, inputs) = (task?, declaration.terminal_inputs());
            let values = task.terminal_functions();
            of(
                inputs,
                values,
                task.terminal_jacobian,
                task.terminal_hessian,
            )
        }
        Function::Impact => {
            let (terms, inputs) = (&task?.contacts, declaration.impact_inputs());
            let values = terms.impact_functions();
            of(inputs, values, terms.impact_jacobian, terms.impact_hessian)
        }
    })
}
