//! The bodies of the model trait's methods: calls of kernels, and linear systems with the derivatives of their solutions.

use super::inertia::{self, PRIVATE, positions};
use super::kernel::{HELD, function};
use crate::description::{
    Contact, Description, Functions, Joints, MotionDerivatives, Rows, SolvedRows, Solver, System,
};
use std::fmt::Write;

/// The call of a kernel.
pub(super) fn call(
    description: &Description,
    kernel: usize,
    x: &str,
    y: &str,
    out: &str,
) -> String {
    format!("{}(self, {x}, {y}, {out})", function(description, kernel))
}

/// The call of a kernel that reads parameters only.
pub(super) fn of_parameters(description: &Description, kernel: usize, out: &str) -> String {
    call(description, kernel, "&[]", "&[]", out)
}

/// The value of a kernel that reads parameters only and has one output.
pub(super) fn coefficient(description: &Description, kernel: usize) -> String {
    let call = of_parameters(description, kernel, "&mut out");
    format!("let mut out = [0.0_f64]; {call}; out[0]")
}

/// The call of a kernel of the input vector alone.
pub(super) fn of_inputs(description: &Description, kernel: usize, out: &str) -> String {
    call(description, kernel, "x", "&[]", out)
}

pub(super) fn horizon(description: &Description) -> String {
    match description.given.horizon {
        Some(kernel) => format!(
            "let mut out = [0.0_f64]; {}; __Option::Some(out[0])",
            of_parameters(description, kernel, "&mut out")
        ),
        None => "__Option::None".to_owned(),
    }
}

pub(super) fn free_acceleration(description: &Description) -> String {
    let motion = &description.motion;
    match (motion.acceleration, motion.derivatives) {
        (None, MotionDerivatives::System(system)) => {
            let System { name, size, .. } = &description.systems[system];
            format!(
                "let (_, y) = __{name}_solution(self, x); a.copy_from_slice(&y[{size}..{}])",
                size + description.coordinates.len()
            )
        }
        (kernel, _) => of_inputs(description, kernel.unwrap_or_default(), "a"),
    }
}

pub(super) fn free_jacobian(description: &Description) -> String {
    match description.motion.derivatives {
        MotionDerivatives::Kernels([kernel, _]) => of_inputs(description, kernel, "values"),
        MotionDerivatives::System(system) => format!(
            "{}, values)",
            gather(
                &description.systems[system].name,
                &description.motion.jacobian.entries
            )
        ),
    }
}

pub(super) fn free_hessian(description: &Description) -> String {
    match description.motion.derivatives {
        MotionDerivatives::Kernels([_, kernel]) => {
            call(description, kernel, "x", "multipliers", "values")
        }
        MotionDerivatives::System(system) => {
            let System { name, size, .. } = &description.systems[system];
            format!(
                "let mut lambda = [0.0_f64; {size}]; lambda[..{}].copy_from_slice(multipliers); \
                 __{name}_second(self, x, &lambda, {}, values)",
                description.coordinates.len(),
                positions(&description.motion.hessian.entries)
            )
        }
    }
}

/// The methods of joints.
pub(super) fn joints(description: &Description, joints: &Joints) -> String {
    let forces = match (joints.forces, description.motion.derivatives) {
        (None, MotionDerivatives::System(system)) => {
            let System { name, size, .. } = &description.systems[system];
            format!(
                "let (_, y) = __{name}_solution(self, x); for (force, y) in forces.iter_mut().zip(&y[{}..]) {{ *force \
                 = -y; }}",
                size + description.coordinates.len()
            )
        }
        (kernel, _) => of_inputs(description, kernel.unwrap_or_default(), "forces"),
    };
    format!(
        "fn hold_joint_row(&mut self, row: __usize, held: bool) {{ if let __Option::Some(known) = \
         self.{HELD}.get_mut(row) {{ *known = if held {{ 1.0 }} else {{ 0.0 }}; }} }}
        fn joint_row_held(&self, row: __usize) -> bool {{ match self.{HELD}.get(row) {{ __Option::Some(held) => *held \
         > 0.0, __Option::None => true }} }}
        fn joints(&self, x: &[__f64], values: &mut [__f64]) {{ {} }}
        fn joints_jacobian(&self, x: &[__f64], values: &mut [__f64]) {{ {} }}
        fn joints_hessian(&self, x: &[__f64], multipliers: &[__f64], values: &mut [__f64]) {{ {} }}
        fn joint_forces(&self, x: &[__f64], forces: &mut [__f64]) {{ {forces} }}",
        of_inputs(description, joints.values, "values"),
        of_inputs(description, joints.jacobian, "values"),
        call(description, joints.hessian, "x", "multipliers", "values"),
    )
}

/// The solution of a system and its sensitivity, and the beginning of a call that picks entries of that.
fn gather(system: &str, entries: &[(usize, usize)]) -> String {
    format!(
        "let (lu, y) = __{system}_solution(self, x); let a = __{system}_sensitivity(self, x, &lu, &y); \
         {PRIVATE}::gather(&a, {}",
        positions(entries)
    )
}

/// What is known of a contact at one point.
pub(super) fn contact_point(description: &Description, contact: &Contact) -> String {
    let n = description.coordinates.len();
    let base = formulas(description, contact.point, &contact.rows);
    if contact.inertia_from_motion {
        return format!(
            "{base}; let (lu, _) = __motion_solution(self, x); let mut n = [0.0_f64; {n}]; \
             n.copy_from_slice(&point[4..{}]); point[3] = lu.solve(&n).iter().zip(&n).map(|(a, \
             b)| a * b).sum()",
            4 + n
        );
    }
    match &contact.rows.solved {
        None => base,
        Some(SolvedRows {
            by: Solver::Inertia(vectors),
            ..
        }) => format!(
            "{base}; let (known, direction) = point.split_at_mut({}); known[3] = {}",
            description.kernels[contact.point].outputs.len(),
            inertia::direction(&vectors.name, "direction")
        ),
        Some(SolvedRows {
            by: Solver::System(system),
            ..
        }) => {
            let System { name, size, .. } = &description.systems[*system];
            format!(
                "{base}; let (_, y) = __{name}_solution(self, x); \
                 point[{}..].copy_from_slice(&y[{size}..{}]); point[3] = 1.0 / y[{}]",
                description.kernels[contact.point].outputs.len(),
                size + n,
                2 * size - 1
            )
        }
    }
}

/// What is known of the friction of a contact at one point: a kernel, and rows that may be solved for.
pub(super) fn tangent_point(description: &Description, kernel: usize, rows: &Rows) -> String {
    let base = formulas(description, kernel, rows);
    match &rows.solved {
        None => base,
        Some(SolvedRows {
            by: Solver::Inertia(vectors),
            ..
        }) => format!(
            "{base}; {};",
            inertia::direction(
                &vectors.name,
                &format!(
                    "&mut point[{}..]",
                    description.kernels[kernel].outputs.len()
                )
            )
        ),
        Some(SolvedRows {
            by: Solver::System(system),
            ..
        }) => {
            let System { name, size, .. } = &description.systems[*system];
            format!(
                "{base}; let (_, y) = __{name}_solution(self, x); \
                 point[{}..].copy_from_slice(&y[{size}..{}])",
                description.kernels[kernel].outputs.len(),
                size + description.coordinates.len()
            )
        }
    }
}

/// The values at one point, as far as they are formulas.
fn formulas(description: &Description, kernel: usize, rows: &Rows) -> String {
    match rows.solved {
        None => of_inputs(description, kernel, "point"),
        Some(_) => {
            let length = description.kernels[kernel].outputs.len();
            of_inputs(description, kernel, &format!("&mut point[..{length}]"))
        }
    }
}

pub(super) fn rows_jacobian(description: &Description, rows: &Rows) -> String {
    let kernel = rows.kernels[0];
    let Some(solved) = &rows.solved else {
        return of_inputs(description, kernel, "values");
    };
    let first = description.kernels[kernel].outputs.len();
    let below: Vec<(usize, usize)> = rows.jacobian.entries[first..]
        .iter()
        .map(|&(row, column)| (row - solved.formulas, column))
        .collect();
    let formulas = of_inputs(description, kernel, &format!("&mut values[..{first}]"));
    let rest = format!("&mut values[{first}..]");
    match &solved.by {
        Solver::System(system) => format!(
            "{formulas}; {}, {rest})",
            gather(&description.systems[*system].name, &below)
        ),
        Solver::Inertia(vectors) => format!(
            "{formulas}; {}",
            inertia::jacobian(&vectors.name, &positions(&below), &rest)
        ),
    }
}

pub(super) fn rows_hessian(description: &Description, rows: &Rows) -> String {
    let kernel = rows.kernels[1];
    let Some(SolvedRows {
        by,
        formulas,
        places,
    }) = &rows.solved
    else {
        return call(description, kernel, "x", "multipliers", "values");
    };
    let mut scatter = String::new();
    for (k, place) in places.iter().enumerate() {
        let _ = write!(scatter, "values[{place}] += geometry[{k}];");
    }
    let pattern = positions(&rows.hessian.entries);
    let solved = match by {
        Solver::System(system) => {
            let System { name, size, .. } = &description.systems[*system];
            format!(
                "let mut lambda = [0.0_f64; {size}]; lambda[..{}].copy_from_slice(&multipliers[{formulas}..]); \
                 __{name}_second(self, x, &lambda, {pattern}, values)",
                description.coordinates.len(),
            )
        }
        Solver::Inertia(vectors) => {
            let weights = format!("&multipliers[{formulas}..]");
            inertia::hessian(&vectors.name, &weights, &pattern, "values")
        }
    };
    format!(
        "{solved}; let mut geometry = [0.0_f64; {}]; {}; {scatter}",
        description.kernels[kernel].outputs.len(),
        call(description, kernel, "x", "multipliers", "&mut geometry")
    )
}

/// Values, Jacobian and Hessian of functions of the input called `input`.
pub(super) fn functions(
    description: &Description,
    functions: &Functions,
    input: &str,
) -> Option<[String; 3]> {
    let [values, jacobian, hessian] = functions.kernels?;
    Some([
        call(description, values, input, "&[]", "values"),
        call(description, jacobian, input, "&[]", "values"),
        call(description, hessian, input, "multipliers", "values"),
    ])
}

/// The functions that solve a system and differentiate its solution, for the scene called `scene`.
pub(super) fn helpers(description: &Description, system: &System, scene: &str, code: &mut String) {
    let System { name, size, .. } = system;
    let inputs = description.inputs();
    let of_scene = |kernel: usize, y: &str, out: &str| {
        format!("{}(p, x, {y}, {out})", function(description, kernel))
    };
    let part = |(kernel, entries): &(usize, Vec<(usize, usize)>)| {
        (
            of_scene(*kernel, "y", "&mut values"),
            description.kernels[*kernel].outputs.len(),
            positions(entries),
        )
    };
    let (first, first_length, first_pattern) = part(&system.jacobian);
    let (second, second_length, second_pattern) = part(&system.hessian);
    let (cross, cross_length, cross_pattern) = part(&system.cross);
    let _ = write!(
        code,
        "fn __{name}_solution(p: &{scene}, x: &[__f64]) -> ({PRIVATE}::Lu<{size}>, [__f64; {}]) {{
                let mut system = [0.0_f64; {}]; {};
                let (lu, solution) = {PRIVATE}::solve_system::<{size}>(&system);
                let mut y = [0.0_f64; {}]; y[{size}..].copy_from_slice(&solution);
                (lu, y)
            }}
            fn __{name}_sensitivity(p: &{scene}, x: &[__f64], lu: &{PRIVATE}::Lu<{size}>, y: &[__f64]) -> \
         [[__f64; {inputs}]; {size}] {{
                let mut values = [0.0_f64; {first_length}]; {first};
                {PRIVATE}::sensitivity::<{size}, {inputs}>(lu, {first_pattern}, &values)
            }}
            fn __{name}_second(p: &{scene}, x: &[__f64], lambda: &[__f64; {size}], pattern: &[(__u32, __u32)], \
         out: &mut [__f64]) {{
                let (lu, mut y) = __{name}_solution(p, x);
                let a = __{name}_sensitivity(p, x, &lu, &y);
                y[..{size}].copy_from_slice(&lu.solve_transposed(lambda));
                let y = &y[..];
                let residual = {{ let mut values = [0.0_f64; {second_length}]; {second}; values }};
                let cross = {{ let mut values = [0.0_f64; {cross_length}]; {cross}; values }};
                {PRIVATE}::pull_back::<{size}, {inputs}>(&a, ({second_pattern}, &residual), \
         ({cross_pattern}, &cross), pattern, out)
            }}",
        2 * size,
        description.kernels[system.solve].outputs.len(),
        of_scene(system.solve, "&[]", "&mut system"),
        2 * size,
    );
}
