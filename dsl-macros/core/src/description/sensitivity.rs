//! Derivatives by parameters, for motions that are differentiated by them.
//!
//! The Jacobians of motion and contacts have their columns already. What stands here besides is read of functions that no
//! solver differentiates: normals, curvatures, the laws of contacts, start, horizon and outputs.

use super::builder::{Builder, pattern};
use super::shown::values;
use crate::declaration::{SparsityPattern, list as static_list};
use crate::derive::{ContactEquations, Equations, InverseInertia, jacobian};
use crate::graph::{Sym, Variable};
use crate::scene::Contact;

/// What is differentiated by parameters beyond motion and contacts. Kernels and parameters are named by their index.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sensitivity {
    /// The parameters, increasing.
    pub parameters: &'static [usize],
    /// Initial coordinates and then velocities by the parameters.
    pub start: Derivative,
    /// Initial coordinates and velocities by the parameters, of each experiment that has a start of its own.
    pub starts: &'static [Option<Derivative>],
    /// Horizon by the parameters, if it is declared.
    pub horizon: Option<Derivative>,
    /// One a contact.
    pub contacts: &'static [ContactSensitivity],
    /// What is recorded, by coordinates, velocities, controls and the time, the time always among them; by what the kernel
    /// of the values has as weights, forces of joints behind those of contacts; and by the parameters.
    pub outputs: Option<Derivative>,
}

/// The nonzeros of a Jacobian.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Derivative {
    /// Kernel of the values.
    pub kernel: usize,
    /// Their positions.
    pub pattern: SparsityPattern,
}

/// Of one contact.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ContactSensitivity {
    /// Curvature, inverse inertia and normal by the inputs and then the parameters.
    pub geometry: Derivative,
    /// Whether the inverse inertia is a formula, and its row right.
    pub knows_inertia: bool,
    /// Coefficient of restitution by the parameters; none for an inelastic contact.
    pub restitution: Option<Derivative>,
    /// Friction, if it is declared.
    pub friction: Option<FrictionSensitivity>,
    /// All velocities right after it has come true by the inputs and then the parameters, if it is a condition that sets some.
    pub reset: Option<Derivative>,
}

/// Of the friction of a contact.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FrictionSensitivity {
    /// Curvature and tangent by the inputs and then the parameters.
    pub geometry: Derivative,
    /// Coefficient of friction by the parameters.
    pub coefficient: Derivative,
}

/// The derivatives of a scene by its chosen parameters; none if there are none.
pub(super) fn sensitivity(builder: &mut Builder<'_>, equations: &Equations) -> Option<Sensitivity> {
    let scene = builder.scene;
    if scene.differentiated.is_empty() {
        return None;
    }
    let parameters: Vec<Variable> = scene
        .differentiated
        .iter()
        .copied()
        .map(Variable::Parameter)
        .collect();
    let mut list = List {
        builder,
        inputs: &equations.inputs,
        parameters: &parameters,
    };
    let start = [&scene.start.0[..], &scene.start.1[..]].concat();
    let contacts = scene.contacts.iter().zip(equations.contacts.iter());
    Some(Sensitivity {
        parameters: static_list(scene.differentiated.iter().copied().map(usize::from)),
        start: list.of_parameters("start", &start),
        starts: static_list(scene.experiments.iter().map(|known| {
            let (q, v) = known.start.as_ref()?;
            let what = format!("start_{}", known.name.text);
            Some(list.of_parameters(&what, &[&q[..], v].concat()))
        })),
        horizon: scene
            .horizon
            .map(|horizon| list.of_parameters("horizon", &[horizon])),
        contacts: static_list(contacts.map(|(declared, derived)| list.contact(declared, &derived))),
        outputs: list.outputs(),
    })
}

struct List<'l, 'b> {
    builder: &'l mut Builder<'b>,
    inputs: &'l [Variable],
    parameters: &'l [Variable],
}

impl List<'_, '_> {
    fn derivative(&mut self, what: &str, values: &[Sym], variables: &[Variable]) -> Derivative {
        let sparse = jacobian(values, variables);
        Derivative {
            kernel: self
                .builder
                .kernel(&format!("{what}_derivative"), &sparse.values),
            pattern: pattern(&sparse),
        }
    }

    fn of_parameters(&mut self, what: &str, values: &[Sym]) -> Derivative {
        self.derivative(what, values, self.parameters)
    }

    fn contact(&mut self, declared: &Contact, derived: &ContactEquations) -> ContactSensitivity {
        let name = declared.name.text.replace('.', "__");
        let (inertia, knows_inertia) = match derived.inverse_inertia {
            InverseInertia::Formula(formula) => (formula, true),
            InverseInertia::Solved => (Sym::ZERO, false),
        };
        let mut geometry = vec![derived.curvature, inertia];
        geometry.extend(&derived.normal);
        let n = self.builder.scene.coordinates.len();
        let reset = declared
            .velocities_set(n)
            .map(|values| self.derivative(&format!("reset_{name}"), &values, self.inputs));
        ContactSensitivity {
            reset,
            geometry: self.derivative(&format!("geometry_{name}"), &geometry, self.inputs),
            knows_inertia,
            restitution: declared
                .restitution
                .map(|value| self.of_parameters(&format!("restitution_{name}"), &[value])),
            friction: declared
                .friction
                .as_ref()
                .zip(derived.friction.as_ref())
                .map(|(declared, derived)| {
                    let mut geometry = vec![derived.curvature];
                    geometry.extend(&derived.tangent);
                    let what = format!("tangent_geometry_{name}");
                    FrictionSensitivity {
                        geometry: self.derivative(&what, &geometry, self.inputs),
                        coefficient: self
                            .of_parameters(&format!("friction_{name}"), &[declared.coefficient]),
                    }
                }),
        }
    }

    fn outputs(&mut self) -> Option<Derivative> {
        let scene = self.builder.scene;
        if scene.outputs.is_empty() {
            return None;
        }
        let values = values(&scene.outputs);
        let controls = scene.controls.len();
        let states = 2 * scene.coordinates.len() + controls;
        let mut variables = self.inputs[..states].to_vec();
        variables.push(Variable::Time);
        let contacts = scene.contacts.len() as u16;
        for kind in [
            Variable::ContactForce,
            Variable::FrictionForce,
            Variable::ContactImpulse,
            Variable::FrictionImpulse,
        ] {
            variables.extend((0..contacts).map(kind));
        }
        let rows: usize = scene.joints.iter().map(|joint| joint.rows.len()).sum();
        variables.extend((0..rows as u16).map(Variable::JointForce));
        variables.extend(self.parameters);
        Some(self.derivative("outputs", &values, &variables))
    }
}
