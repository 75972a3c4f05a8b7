//! A scene that declares everything that optimal control knows, with functions written by hand.

use std::sync::OnceLock;

use crate::model::{
    ConstraintDeclaration, ContactTerms, Declaration, Model, OptimalControlDeclaration,
    SparsityPattern,
};

crate::model! {
    /// A sledge on a wavy slope, with an engine along the ground and a rider that shifts.
    pub(in crate::ocp) Sledge {
        parameters { m: kg = 2, g: m/s^2 = 9.81, w: 1/m = 3 }
        coordinates { y: m, z: m, r: m in -1..=1 }
        controls { u: N in -5..=5, p: N in -3..=3 }
        fn ground(y) = 0.1[m]*sin(w*y)
        lagrangian m/2*(dot(y)^2 + dot(z)^2 + dot(r)^2) - m*g*z
        forces { y: u*cos(w*y), r: p }
        surface ground: z - ground(y) >= 0
        impact ground: inelastic
        start { z: 0.5 [m], dot(y): 1 [m/s] }
    }
}

/// The sledge with
///
/// ```text
/// running cost  u^2 + y p        final cost  T + y z
/// path          8 - v_y^2 - u r >= 0,  z - 2 = 0 (for its derivatives only)
/// goals         y + 0.1 z^2 - 1.5 = 0,  T y - 0.1 >= 0
/// free          z in 0.3..=0.8
/// ```
pub(super) struct Demanding(pub(super) Sledge);

const fn pattern(rows: usize, columns: usize, entries: &'static [(u32, u32)]) -> SparsityPattern {
    SparsityPattern {
        rows,
        columns,
        entries,
    }
}

const fn constraint(name: &'static str, equality: bool) -> ConstraintDeclaration {
    ConstraintDeclaration {
        name,
        unit: "",
        equality,
        documentation: "",
    }
}

// x = (y, z, r, v_y, v_z, v_r, u, p)
const PATH_JACOBIAN: [(u32, u32); 7] = [(0, 0), (0, 6), (0, 7), (1, 2), (1, 3), (1, 6), (2, 1)];
const PATH_HESSIAN: [(u32, u32); 4] = [(6, 6), (7, 0), (3, 3), (6, 2)];
// z = (y, z, r, v_y, v_z, v_r, T)
const TERMINAL_JACOBIAN: [(u32, u32); 7] = [(0, 0), (0, 1), (0, 6), (1, 0), (1, 1), (2, 0), (2, 6)];
const TERMINAL_HESSIAN: [(u32, u32); 3] = [(1, 0), (1, 1), (6, 0)];

const DECLARED: OptimalControlDeclaration = OptimalControlDeclaration {
    running_cost: true,
    final_cost: true,
    constraints: &[constraint("speed", false), constraint("height", true)],
    goals: &[
        constraint("far enough", true),
        constraint("late enough", false),
    ],
    free_time: true,
    free_start: &[1],
    path_jacobian: pattern(3, 8, &PATH_JACOBIAN),
    path_hessian: pattern(8, 8, &PATH_HESSIAN),
    terminal_jacobian: pattern(3, 7, &TERMINAL_JACOBIAN),
    terminal_hessian: pattern(7, 7, &TERMINAL_HESSIAN),
    contacts: ContactTerms::NONE,
};

impl Model for Demanding {
    fn declaration(&self) -> &'static Declaration {
        static DECLARATION: OnceLock<Declaration> = OnceLock::new();
        DECLARATION.get_or_init(|| Declaration {
            optimal_control: Some(DECLARED),
            ..*self.0.declaration()
        })
    }

    fn path_functions(&self, x: &[f64], values: &mut [f64]) {
        values[0] = x[6] * x[6] + x[0] * x[7];
        values[1] = 8.0 - x[3] * x[3] - x[6] * x[2];
        values[2] = x[1] - 2.0;
    }

    fn path_jacobian(&self, x: &[f64], values: &mut [f64]) {
        values.copy_from_slice(&[x[7], 2.0 * x[6], x[0], -x[6], -2.0 * x[3], -x[2], 1.0]);
    }

    fn path_hessian(&self, _: &[f64], y: &[f64], values: &mut [f64]) {
        values.copy_from_slice(&[2.0 * y[0], y[0], -2.0 * y[1], -y[1]]);
    }

    fn terminal_functions(&self, z: &[f64], values: &mut [f64]) {
        values[0] = z[6] + z[0] * z[1];
        values[1] = z[0] + 0.1 * z[1] * z[1] - 1.5;
        values[2] = z[6] * z[0] - 0.1;
    }

    fn terminal_jacobian(&self, z: &[f64], values: &mut [f64]) {
        values.copy_from_slice(&[z[1], z[0], 1.0, 1.0, 0.2 * z[1], z[6], z[0]]);
    }

    fn terminal_hessian(&self, _: &[f64], y: &[f64], values: &mut [f64]) {
        values.copy_from_slice(&[y[0], 0.2 * y[1], y[2]]);
    }

    fn free_start_bounds(&self, lower: &mut [f64], upper: &mut [f64]) {
        lower[0] = 0.3;
        upper[0] = 0.8;
    }

    fn parameter(&self, index: usize) -> f64 {
        self.0.parameter(index)
    }

    fn set_parameter(&mut self, index: usize, value: f64) {
        self.0.set_parameter(index, value);
    }

    fn start(&self, q: &mut [f64], v: &mut [f64]) {
        self.0.start(q, v);
    }

    fn horizon(&self) -> Option<f64> {
        self.0.horizon()
    }

    fn bounds(&self, lower: &mut [f64], upper: &mut [f64]) {
        self.0.bounds(lower, upper);
    }

    fn free_acceleration(&self, x: &[f64], a: &mut [f64]) {
        self.0.free_acceleration(x, a);
    }

    fn free_jacobian(&self, x: &[f64], values: &mut [f64]) {
        self.0.free_jacobian(x, values);
    }

    fn free_hessian(&self, x: &[f64], multipliers: &[f64], values: &mut [f64]) {
        self.0.free_hessian(x, multipliers, values);
    }

    fn mass_matrix(&self, x: &[f64], m: &mut [f64]) {
        self.0.mass_matrix(x, m);
    }

    fn energy(&self, x: &[f64], energy: &mut [f64]) {
        self.0.energy(x, energy);
    }

    fn gap(&self, contact: usize, x: &[f64]) -> f64 {
        self.0.gap(contact, x)
    }

    fn contact(&self, contact: usize, x: &[f64], point: &mut [f64]) {
        self.0.contact(contact, x, point);
    }

    fn contact_jacobian(&self, contact: usize, x: &[f64], values: &mut [f64]) {
        self.0.contact_jacobian(contact, x, values);
    }

    fn contact_hessian(&self, contact: usize, x: &[f64], multipliers: &[f64], values: &mut [f64]) {
        self.0.contact_hessian(contact, x, multipliers, values);
    }

    fn boxed(&self) -> Box<dyn Model> {
        Box::new(Self(self.0.clone()))
    }
}
