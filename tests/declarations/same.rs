//! A compiled scene against the same text without a compiler: both do the same operations in the same order, so that
//! values agree to the last bit. Bits are not asserted, since a platform may compute the sine and the cosine of an angle
//! by one call where it compiles.

use hangtime::model::{Declaration, Model, SparsityPattern, contact_point, tangent_point};

/// Roundings of elementary functions, with what cancels behind them.
const TOLERANCE: f64 = 1e-12;

/// Every declaration in a Rust source, by the name of its scene.
pub(crate) fn declarations(source: &str) -> Vec<(String, String)> {
    let starts = source
        .match_indices("model! {")
        .map(|(at, start)| at + start.len());
    let texts = starts.map(|from| {
        let mut depth = 1;
        let end = source[from..].find(|c| {
            depth += i32::from(c == '{') - i32::from(c == '}');
            depth == 0
        });
        &source[from..from + end.expect("the declaration ends")]
    });
    texts
        .filter_map(|text| {
            let name = text.split_once("pub ")?.1.split_whitespace().next()?;
            Some((name.to_owned(), text.to_owned()))
        })
        .collect()
}

/// Pairs of the compiled scenes with their texts in the source; how many there are.
pub(crate) fn assert_all_same(source: &str, compiled: &[&dyn Model]) -> usize {
    let texts = declarations(source);
    for model in compiled {
        let name = model.declaration().name;
        let text = texts.iter().find(|(other, _)| other == name);
        let text = &text.unwrap_or_else(|| panic!("no text of {name}")).1;
        let loaded = hangtime_scene_files::of_text("scene.hang", text);
        assert_same(
            *model,
            &loaded.unwrap_or_else(|error| panic!("{name}: {error}")),
        );
    }
    compiled.len()
}

/// Compares everything that two models say.
pub(crate) fn assert_same(compiled: &dyn Model, loaded: &dyn Model) {
    let declaration = compiled.declaration();
    let [mine, theirs] = [compiled, loaded].map(|model| format!("{:?}", model.declaration()));
    assert_eq!(mine, theirs);
    let [mine, theirs] = [compiled, loaded].map(|model| format!("{:?}", model.outputs()));
    assert_eq!(mine, theirs);
    assert_eq!(compiled.picture(), loaded.picture());
    let (mut compiled, mut loaded) = (compiled.boxed(), loaded.boxed());
    assert_values(&*compiled, &*loaded);
    for (i, parameter) in declaration.parameters.iter().enumerate() {
        let changed = 1.03 * parameter.default + 0.01;
        compiled.set_parameter(i, changed);
        loaded.set_parameter(i, changed);
    }
    assert_values(&*compiled, &*loaded);
    let beyond = declaration.parameters.len();
    assert!(loaded.parameter(beyond).is_nan() && compiled.parameter(beyond).is_nan());
}

/// Two models of one scene.
#[derive(Clone, Copy)]
struct Pair<'a>([&'a dyn Model; 2]);

impl Pair<'_> {
    fn declaration(&self) -> &'static Declaration {
        self.0[0].declaration()
    }

    /// Compares values that both models write.
    fn both(&self, what: &str, length: usize, values: impl Fn(&dyn Model, &mut [f64])) {
        let name = self.declaration().name;
        let [mine, theirs] = self.0.map(|model| {
            // Values that nobody writes are the same as well.
            let mut out = vec![0.5; length];
            values(model, &mut out);
            out
        });
        for (i, (a, b)) in mine.iter().zip(&theirs).enumerate() {
            let same = a == b || (a.is_nan() && b.is_nan());
            let close = (a - b).abs() <= TOLERANCE * (1.0 + a.abs());
            assert!(same || close, "{name}, {what}, value {i}: {a} against {b}");
        }
    }

    /// The same for a function that has a sparse Jacobian and Hessian.
    fn derivatives(
        &self,
        what: &str,
        [jacobian, hessian]: [SparsityPattern; 2],
        first: impl Fn(&dyn Model, &mut [f64]),
        second: impl Fn(&dyn Model, &mut [f64]),
    ) {
        self.both(&format!("{what}, jacobian"), jacobian.entries.len(), first);
        self.both(&format!("{what}, hessian"), hessian.entries.len(), second);
    }
}

/// Compares what two models say of joints.
fn assert_joints(pair: Pair<'_>, x: &[f64]) {
    let Some(joints) = pair.declaration().joints else {
        return;
    };
    let rows = joints.rows();
    pair.both("joints", 2 * rows, |model, out| model.joints(x, out));
    let entries = joints.jacobian.entries.len();
    pair.both("joints, jacobian", entries, |model, out| {
        model.joints_jacobian(x, out)
    });
    let weights: Vec<f64> = (0..2 * rows).map(|k| (1.0 + k as f64).sin()).collect();
    let entries = joints.hessian.entries.len();
    pair.both("joints, Hessian", entries, |model, out| {
        model.joints_hessian(x, &weights, out)
    });
    pair.both("forces of joints", rows, |model, out| {
        model.joint_forces(x, out)
    });
    for row in 0..rows {
        let released = |model: &dyn Model| {
            let mut model = model.boxed();
            assert!(model.joint_row_held(row));
            model.hold_joint_row(row, false);
            assert!(!model.joint_row_held(row));
            model
        };
        pair.both("forces of the other joints", rows, |model, out| {
            released(model).joint_forces(x, out)
        });
    }
}

/// Compares all values of two models, at some states.
fn assert_values(compiled: &dyn Model, loaded: &dyn Model) {
    let pair = Pair([compiled, loaded]);
    assert_given(pair);
    let declaration = pair.declaration();
    let n = declaration.coordinates.len();
    for state in 0..4 {
        let x: Vec<f64> = (0..=declaration.inputs())
            .map(|i| 0.8 * (1.7 * i as f64 + 0.9 * f64::from(state)).sin() + 0.1)
            .collect();
        let weights = x.iter().chain(&x).chain(&x);
        let w: Vec<f64> = weights.map(|x| (3.0 * x).cos()).collect();
        let z = &x[..=2 * n];
        let x = &x[..declaration.inputs()];
        assert_joints(pair, x);
        pair.both("acceleration", n, |model, out| {
            model.free_acceleration(x, out)
        });
        pair.derivatives(
            "acceleration",
            [declaration.free_jacobian, declaration.free_hessian],
            |model, out| model.free_jacobian(x, out),
            |model, out| model.free_hessian(x, &w[..n], out),
        );
        pair.both("mass matrix", n * n, |model, out| model.mass_matrix(x, out));
        pair.both("energy", 2, |model, out| model.energy(x, out));
        for contact in 0..=declaration.contacts.len() {
            assert_contact(pair, contact, x, &w);
        }
        assert_optimal_control(pair, [x, z], &w);
        assert_shown(pair, &w);
    }
}

/// Compares what is recorded and drawn, if there is anything; `w` is long enough for states, forces and a time.
fn assert_shown(pair: Pair<'_>, w: &[f64]) {
    let declaration = pair.declaration();
    let length = 2 * declaration.coordinates.len() + declaration.controls.len() + 1;
    let x: Vec<f64> = w.iter().copied().cycle().take(length).collect();
    let joints = declaration.joints.map_or(0, |joints| joints.rows());
    let forces: Vec<f64> = w
        .iter()
        .rev()
        .copied()
        .cycle()
        .take(4 * declaration.contacts.len() + joints)
        .collect();
    pair.both("outputs", pair.0[0].outputs().len(), |model, out| {
        model.output_values(&x, &forces, out);
    });
    let values = pair.0[0].picture().map_or(0, |picture| picture.values());
    pair.both("picture", values, |model, out| {
        model.picture_values(&x, w[0], out);
    });
}

/// Compares what depends on parameters only.
fn assert_given(pair: Pair<'_>) {
    let declaration = pair.declaration();
    let (n, m) = (declaration.coordinates.len(), declaration.controls.len());
    pair.both("parameters", declaration.parameters.len(), |model, out| {
        for (i, value) in out.iter_mut().enumerate() {
            *value = model.parameter(i);
        }
    });
    pair.both("start", 2 * n, |model, out| {
        let (q, v) = out.split_at_mut(n);
        model.start(q, v);
    });
    pair.both("bounds", 2 * (n + m), |model, out| {
        let (lower, upper) = out.split_at_mut(n + m);
        model.bounds(lower, upper);
    });
    pair.both("horizon", 1, |model, out| {
        out[0] = model.horizon().unwrap_or(-1.0);
    });
    let task = declaration.optimal_control;
    let free = task.map_or(0, |task| task.free_start.len());
    pair.both("bounds of the start", 2 * free, |model, out| {
        let (lower, upper) = out.split_at_mut(free);
        model.free_start_bounds(lower, upper);
    });
}

/// Compares all values of one contact; there may be none with this index.
fn assert_contact(pair: Pair<'_>, i: usize, x: &[f64], w: &[f64]) {
    let n = pair.declaration().coordinates.len();
    pair.both("laws", 3, |model, out| {
        out.copy_from_slice(&[model.gap(i, x), model.restitution(i), model.friction(i)]);
    });
    pair.both("contact", contact_point::length(n), |model, out| {
        model.contact(i, x, out);
    });
    let Some(declared) = pair.declaration().contacts.get(i) else {
        return;
    };
    pair.derivatives(
        "contact",
        [declared.jacobian, declared.hessian],
        |model, out| model.contact_jacobian(i, x, out),
        |model, out| model.contact_hessian(i, x, &w[..2 + n], out),
    );
    let Some(friction) = declared.friction else {
        return;
    };
    pair.both("tangent", tangent_point::length(n), |model, out| {
        model.tangent(i, x, out);
    });
    pair.derivatives(
        "tangent",
        [friction.jacobian, friction.hessian],
        |model, out| model.tangent_jacobian(i, x, out),
        |model, out| model.tangent_hessian(i, x, &w[..1 + n], out),
    );
}

/// Compares the functions of optimal control, if there are some.
fn assert_optimal_control(pair: Pair<'_>, [x, z]: [&[f64]; 2], w: &[f64]) {
    let Some(task) = pair.declaration().optimal_control else {
        return;
    };
    let (path, terminal) = (task.path_functions(), task.terminal_functions());
    let with_contacts = |plain: &[f64], length: usize| -> Vec<f64> {
        plain.iter().chain(w).copied().take(length).collect()
    };
    let declaration = pair.declaration();
    let at_impacts = &with_contacts(x, declaration.impact_inputs())[..];
    let x = &with_contacts(x, declaration.path_inputs())[..];
    let z = &with_contacts(z, declaration.terminal_inputs())[..];
    let terms = task.contacts;
    let impact = terms.impact_functions();
    pair.both("impact", impact, |model, out| {
        model.impact_functions(at_impacts, out);
    });
    pair.derivatives(
        "impact",
        [terms.impact_jacobian, terms.impact_hessian],
        |model, out| model.impact_jacobian(at_impacts, out),
        |model, out| model.impact_hessian(at_impacts, &w[..impact], out),
    );
    pair.both("path", path, |model, out| model.path_functions(x, out));
    pair.derivatives(
        "path",
        [task.path_jacobian, task.path_hessian],
        |model, out| model.path_jacobian(x, out),
        |model, out| model.path_hessian(x, &w[..path], out),
    );
    pair.both("terminal", terminal, |model, out| {
        model.terminal_functions(z, out);
    });
    pair.derivatives(
        "terminal",
        [task.terminal_jacobian, task.terminal_hessian],
        |model, out| model.terminal_jacobian(z, out),
        |model, out| model.terminal_hessian(z, &w[..terminal], out),
    );
}
