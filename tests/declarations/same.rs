//! All functions of a scene as a list, and a compiled scene against the same text without a compiler: both do the same operations in
//! the same order, so that values agree to the last bit. Bits are not asserted, since a platform may compute the sine and the cosine
//! of an angle by one call where it compiles.

use hangtime::model::{Declaration, Model, SparsityPattern, contact_point, tangent_point};

/// Roundings of elementary functions, with what cancels behind them.
const TOLERANCE: f64 = 1e-12;

/// Writes values of a model, of inputs and of weights.
type Write = Box<dyn Fn(&dyn Model, &[f64], &[f64], &mut [f64])>;

/// A function of a scene.
pub(crate) struct Function {
    pub(crate) name: String,
    /// Numbers of inputs and of values.
    pub(crate) size: (usize, usize),
    pub(crate) values: Write,
    /// By all inputs, if it has one.
    pub(crate) jacobian: Option<(SparsityPattern, Write)>,
    /// Of the weighted values, the lower triangle, if it has one.
    pub(crate) hessian: Option<(SparsityPattern, Write)>,
}

impl Function {
    fn new(
        name: impl Into<String>,
        size: (usize, usize),
        values: impl Fn(&dyn Model, &[f64], &mut [f64]) + 'static,
    ) -> Self {
        Self {
            name: name.into(),
            size,
            values: Box::new(move |model, x, _, out| values(model, x, out)),
            jacobian: None,
            hessian: None,
        }
    }

    fn first(
        mut self,
        pattern: SparsityPattern,
        write: impl Fn(&dyn Model, &[f64], &mut [f64]) + 'static,
    ) -> Self {
        let write = move |model: &dyn Model, x: &[f64], _: &[f64], out: &mut [f64]| {
            write(model, x, out);
        };
        self.jacobian = Some((pattern, Box::new(write)));
        self
    }

    fn second(
        mut self,
        pattern: SparsityPattern,
        write: impl Fn(&dyn Model, &[f64], &[f64], &mut [f64]) + 'static,
    ) -> Self {
        self.hessian = Some((pattern, Box::new(write)));
        self
    }
}

/// All functions of a model.
pub(crate) fn functions(model: &dyn Model) -> Vec<Function> {
    let declared = model.declaration();
    let (n, x) = (declared.coordinates.len(), declared.inputs());
    let acceleration = Function::new("acceleration", (x, n), |m, x, a| m.free_acceleration(x, a));
    let mut all = vec![
        acceleration
            .first(declared.free_jacobian, |m, x, v| m.free_jacobian(x, v))
            .second(declared.free_hessian, |m, x, w, v| m.free_hessian(x, w, v)),
        Function::new("mass matrix", (x, n * n), |m, x, v| m.mass_matrix(x, v)),
        Function::new("energy", (x, 2), |m, x, v| m.energy(x, v)),
    ];
    (0..declared.contacts.len()).for_each(|i| of_contact(declared, i, &mut all));
    of_joints(declared, &mut all);
    of_optimal_control(declared, &mut all);
    shown(model, &mut all);
    given(model, &mut all);
    all
}

fn of_contact(declared: &Declaration, i: usize, all: &mut Vec<Function>) {
    let (n, x) = (declared.coordinates.len(), declared.inputs());
    let contact = &declared.contacts[i];
    let name = |what: &str| format!("{what}({})", contact.name);
    let rows = move |model: &dyn Model, x: &[f64], out: &mut [f64]| {
        let mut point = vec![f64::NAN; contact_point::length(n)];
        model.contact(i, x, &mut point);
        out[0] = model.gap(i, x);
        // Of dry friction it is the normal acceleration that is given.
        out[1] = match model.declaration().contacts[i].dry {
            true => -point[contact_point::CURVATURE],
            false => point[contact_point::NORMAL_VELOCITY],
        };
        out[2..].copy_from_slice(&point[contact_point::direction(n)..]);
    };
    all.push(
        Function::new(name("contact"), (x, 2 + n), rows)
            .first(contact.jacobian, move |m, x, v| m.contact_jacobian(i, x, v))
            .second(contact.hessian, move |m, x, w, v| {
                m.contact_hessian(i, x, w, v)
            }),
    );
    let point = contact_point::length(n);
    all.push(Function::new(name("point"), (x, point), move |m, x, v| {
        m.contact(i, x, v)
    }));
    let laws = move |m: &dyn Model, x: &[f64], out: &mut [f64]| {
        let laws = [
            m.restitution(i),
            m.friction(i),
            m.kinetic_friction(i),
            m.friction_share(i, x),
        ];
        out.copy_from_slice(&laws);
    };
    all.push(Function::new(name("laws"), (x, 4), laws));
    let loads = contact.loads.len();
    all.push(Function::new(name("loads"), (x, loads), move |m, x, v| {
        m.loads(i, x, v)
    }));
    all.push(Function::new(name("reset"), (x, n), move |m, x, v| {
        m.reset(i, x, v)
    }));
    let Some(friction) = contact.friction else {
        return;
    };
    let side = |across: bool| {
        move |model: &dyn Model, x: &[f64], out: &mut [f64]| {
            let mut point = vec![f64::NAN; tangent_point::length(n)];
            match across {
                true => model.across(i, x, &mut point),
                false => model.tangent(i, x, &mut point),
            }
            out[0] = point[tangent_point::SLIDING_VELOCITY];
            out[1..].copy_from_slice(&point[tangent_point::direction(n)..]);
        }
    };
    all.push(
        Function::new(name("tangent"), (x, 1 + n), side(false))
            .first(friction.jacobian, move |m, x, v| {
                m.tangent_jacobian(i, x, v)
            })
            .second(friction.hessian, move |m, x, w, v| {
                m.tangent_hessian(i, x, w, v)
            }),
    );
    let point = tangent_point::length(n);
    all.push(Function::new(name("side"), (x, point), move |m, x, v| {
        m.tangent(i, x, v)
    }));
    if let Some(pattern) = friction.across {
        let across = Function::new(name("across"), (x, 1 + n), side(true));
        all.push(across.first(pattern, move |m, x, v| m.across_jacobian(i, x, v)));
        all.push(Function::new(
            name("side across"),
            (x, point),
            move |m, x, v| m.across(i, x, v),
        ));
    }
}

fn of_joints(declared: &Declaration, all: &mut Vec<Function>) {
    let Some(joints) = declared.joints else {
        return;
    };
    let (x, rows) = (declared.inputs(), joints.rows());
    all.push(
        Function::new("joints", (x, 2 * rows), |m, x, v| m.joints(x, v))
            .first(joints.jacobian, |m, x, v| m.joints_jacobian(x, v))
            .second(joints.hessian, |m, x, w, v| m.joints_hessian(x, w, v)),
    );
    all.push(Function::new("forces of joints", (x, rows), |m, x, v| {
        m.joint_forces(x, v)
    }));
    for row in 0..rows {
        let released = move |model: &dyn Model, x: &[f64], out: &mut [f64]| {
            let mut model = model.boxed();
            assert!(model.joint_row_held(row));
            model.hold_joint_row(row, false);
            assert!(!model.joint_row_held(row));
            model.joint_forces(x, out);
        };
        all.push(Function::new(
            format!("forces without row {row}"),
            (x, rows),
            released,
        ));
    }
}

fn of_optimal_control(declared: &Declaration, all: &mut Vec<Function>) {
    let Some(task) = declared.optimal_control else {
        return;
    };
    let size = (declared.path_inputs(), task.path_functions());
    all.push(
        Function::new("path", size, |m, x, v| m.path_functions(x, v))
            .first(task.path_jacobian, |m, x, v| m.path_jacobian(x, v))
            .second(task.path_hessian, |m, x, w, v| m.path_hessian(x, w, v)),
    );
    let size = (declared.terminal_inputs(), task.terminal_functions());
    all.push(
        Function::new("terminal", size, |m, x, v| m.terminal_functions(x, v))
            .first(task.terminal_jacobian, |m, x, v| m.terminal_jacobian(x, v))
            .second(task.terminal_hessian, |m, x, w, v| {
                m.terminal_hessian(x, w, v)
            }),
    );
    let terms = task.contacts;
    if terms.impact_functions() > 0 {
        let size = (declared.impact_inputs(), terms.impact_functions());
        all.push(
            Function::new("impact", size, |m, x, v| m.impact_functions(x, v))
                .first(terms.impact_jacobian, |m, x, v| m.impact_jacobian(x, v))
                .second(terms.impact_hessian, |m, x, w, v| m.impact_hessian(x, w, v)),
        );
    }
    let free = task.free_start.len();
    let bounds = move |m: &dyn Model, _: &[f64], out: &mut [f64]| {
        let (lower, upper) = out.split_at_mut(free);
        m.free_start_bounds(lower, upper);
    };
    all.push(Function::new("bounds of the start", (0, 2 * free), bounds));
}

/// What is recorded and drawn.
fn shown(model: &dyn Model, all: &mut Vec<Function>) {
    let declared = model.declaration();
    let state = 2 * declared.coordinates.len() + declared.controls.len() + 1;
    let joints = declared.joints.map_or(0, |joints| joints.rows());
    let forces = 4 * declared.contacts.len() + joints;
    let outputs = move |m: &dyn Model, x: &[f64], out: &mut [f64]| {
        m.output_values(&x[..state], &x[state..], out);
    };
    let count = model.outputs().len();
    all.push(Function::new("outputs", (state + forces, count), outputs));
    if let Some(picture) = model.picture() {
        let values = move |m: &dyn Model, x: &[f64], out: &mut [f64]| {
            m.picture_values(&x[..state], x[state], out);
        };
        all.push(Function::new(
            "picture",
            (state + 1, picture.values()),
            values,
        ));
    }
}

/// What depends on parameters only, or on those that are held.
fn given(model: &dyn Model, all: &mut Vec<Function>) {
    let declared = model.declaration();
    let (n, m) = (declared.coordinates.len(), declared.controls.len());
    let mut add = |name: &str, count: usize, values: fn(&dyn Model, &mut [f64])| {
        let values = move |model: &dyn Model, _: &[f64], out: &mut [f64]| values(model, out);
        all.push(Function::new(name, (0, count), values));
    };
    add("parameters", 1 + declared.parameters.len(), |model, out| {
        out.iter_mut()
            .enumerate()
            .for_each(|(i, value)| *value = model.parameter(i));
    });
    add("start", 2 * n, |model, out| {
        let (q, v) = out.split_at_mut(out.len() / 2);
        model.start(q, v);
    });
    add("bounds", 2 * (n + m), |model, out| {
        let (lower, upper) = out.split_at_mut(out.len() / 2);
        model.bounds(lower, upper);
    });
    add(
        "free parameters",
        2 * model.free_parameters().len(),
        |model, out| {
            let (lower, upper) = out.split_at_mut(out.len() / 2);
            model.free_parameter_bounds(lower, upper);
        },
    );
    add("horizon", 1, |model, out| {
        out[0] = model.horizon().unwrap_or(-1.0)
    });
    if let Some(held) = model.held() {
        let size = (declared.inputs(), held.given.len());
        all.push(
            Function::new("given", size, |m, x, v| m.given_values(x, v))
                .first(held.jacobian, |m, x, v| m.given_jacobian(x, v))
                .second(held.hessian, |m, x, w, v| m.given_hessian(x, w, v)),
        );
    }
}

/// Compares everything that two models say, with parameters as declared and with others.
pub(crate) fn assert_same(compiled: &dyn Model, loaded: &dyn Model) {
    let said = |model: &dyn Model| {
        let (free, experiments) = (model.free_parameters(), model.experiments());
        let shown = (model.outputs(), model.picture());
        format!(
            "{:?}",
            (
                model.declaration(),
                shown,
                free,
                experiments,
                model.positive()
            )
        )
    };
    assert_eq!(said(compiled), said(loaded));
    let (mut compiled, mut loaded) = (compiled.boxed(), loaded.boxed());
    assert_values([&*compiled, &*loaded]);
    for (i, parameter) in compiled.declaration().parameters.iter().enumerate() {
        let changed = 1.03 * parameter.default + 0.01;
        compiled.set_parameter(i, changed);
        loaded.set_parameter(i, changed);
    }
    assert_values([&*compiled, &*loaded]);
}

/// Compares all values of two models, at some states.
fn assert_values(models: [&dyn Model; 2]) {
    let scene = models[0].declaration().name;
    for function in functions(models[0]) {
        let (inputs, count) = function.size;
        let kinds = [&function.jacobian, &function.hessian];
        let derivatives = kinds.into_iter().flatten();
        let derivatives = derivatives.map(|(pattern, write)| (pattern.entries.len(), write));
        let all = std::iter::once((count, &function.values)).chain(derivatives);
        for ((length, write), state) in all.flat_map(|kind| (0..4).map(move |s| (kind, s))) {
            let number = |i: usize| 0.8 * (1.7 * i as f64 + 0.9 * f64::from(state)).sin() + 0.1;
            let x: Vec<f64> = (0..inputs).map(number).collect();
            let w: Vec<f64> = (0..count).map(|i| (3.0 * number(i)).cos()).collect();
            let [mine, theirs] = models.map(|model| {
                // Values that nobody writes are the same as well.
                let mut out = vec![0.5; length];
                write(model, &x, &w, &mut out);
                out
            });
            for (i, (a, b)) in mine.iter().zip(&theirs).enumerate() {
                let same = a == b || (a.is_nan() && b.is_nan());
                let close = (a - b).abs() <= TOLERANCE * (1.0 + a.abs());
                let what = &function.name;
                assert!(same || close, "{scene}, {what}, value {i}: {a} against {b}");
            }
        }
    }
}
