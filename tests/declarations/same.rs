//! A compiled scene against the same text without a compiler: both do the same operations in the same order, so that
//! values agree to the last bit. Bits are not asserted, since a platform may compute the sine and the cosine of an angle
//! by one call where it compiles.

use hangtime::model::{Model, contact_point, tangent_point};

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

/// Compares all values of two models, at some states.
fn assert_values(compiled: &dyn Model, loaded: &dyn Model) {
    let declaration = compiled.declaration();
    let name = declaration.name;
    let both = |what: &str, length: usize, values: &dyn Fn(&dyn Model, &mut [f64])| {
        let [mine, theirs] = [compiled, loaded].map(|model| {
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
    };
    let (n, m) = (declaration.coordinates.len(), declaration.controls.len());
    both("parameters", declaration.parameters.len(), &|model, out| {
        out.iter_mut()
            .enumerate()
            .for_each(|(i, value)| *value = model.parameter(i));
    });
    both("start", 2 * n, &|model, out| {
        let (q, v) = out.split_at_mut(n);
        model.start(q, v);
    });
    both("bounds", 2 * (n + m), &|model, out| {
        let (lower, upper) = out.split_at_mut(n + m);
        model.bounds(lower, upper);
    });
    assert_eq!(compiled.horizon(), loaded.horizon());
    let task = declaration.optimal_control;
    let free = task.map_or(0, |task| task.free_start.len());
    both("bounds of the start", 2 * free, &|model, out| {
        let (lower, upper) = out.split_at_mut(free);
        model.free_start_bounds(lower, upper);
    });
    for state in 0..4 {
        let x: Vec<f64> = (0..declaration.inputs() + 1)
            .map(|i| 0.8 * (1.7 * i as f64 + 0.9 * f64::from(state)).sin() + 0.1)
            .collect();
        let w: Vec<f64> = x
            .iter()
            .chain(&x)
            .chain(&x)
            .map(|x| (3.0 * x).cos())
            .collect();
        let z = &x[..2 * n + 1];
        let x = &x[..declaration.inputs()];
        both("acceleration", n, &|model, out| {
            model.free_acceleration(x, out)
        });
        both(
            "jacobian",
            declaration.free_jacobian.entries.len(),
            &|model, out| {
                model.free_jacobian(x, out);
            },
        );
        both(
            "hessian",
            declaration.free_hessian.entries.len(),
            &|model, out| {
                model.free_hessian(x, &w[..n], out);
            },
        );
        both("mass matrix", n * n, &|model, out| {
            model.mass_matrix(x, out)
        });
        both("energy", 2, &|model, out| model.energy(x, out));
        for i in 0..=declaration.contacts.len() {
            assert_contact(&both, i, (x, &w), declaration.contacts.get(i).copied(), n);
        }
        if let Some(task) = task {
            let (path, terminal) = (task.path_functions(), task.terminal_functions());
            both("path", path, &|model, out| model.path_functions(x, out));
            both(
                "path jacobian",
                task.path_jacobian.entries.len(),
                &|model, out| {
                    model.path_jacobian(x, out);
                },
            );
            both(
                "path hessian",
                task.path_hessian.entries.len(),
                &|model, out| {
                    model.path_hessian(x, &w[..path], out);
                },
            );
            both("terminal", terminal, &|model, out| {
                model.terminal_functions(z, out)
            });
            both(
                "terminal jacobian",
                task.terminal_jacobian.entries.len(),
                &|model, out| {
                    model.terminal_jacobian(z, out);
                },
            );
            both(
                "terminal hessian",
                task.terminal_hessian.entries.len(),
                &|model, out| {
                    model.terminal_hessian(z, &w[..terminal], out);
                },
            );
        }
    }
}

type Both<'a> = dyn Fn(&str, usize, &dyn Fn(&dyn Model, &mut [f64])) + 'a;

/// Compares all values of one contact; there may be none with this index.
fn assert_contact(
    both: &Both<'_>,
    i: usize,
    (x, w): (&[f64], &[f64]),
    declared: Option<hangtime::model::ContactDeclaration>,
    n: usize,
) {
    both("gap", 1, &|model, out| out[0] = model.gap(i, x));
    both("restitution", 1, &|model, out| {
        out[0] = model.restitution(i)
    });
    both("friction", 1, &|model, out| out[0] = model.friction(i));
    both("contact", contact_point::length(n), &|model, out| {
        model.contact(i, x, out)
    });
    let Some(declared) = declared else { return };
    both(
        "contact jacobian",
        declared.jacobian.entries.len(),
        &|model, out| {
            model.contact_jacobian(i, x, out);
        },
    );
    both(
        "contact hessian",
        declared.hessian.entries.len(),
        &|model, out| {
            model.contact_hessian(i, x, &w[..2 + n], out);
        },
    );
    let Some(friction) = declared.friction else {
        return;
    };
    both("tangent", tangent_point::length(n), &|model, out| {
        model.tangent(i, x, out)
    });
    both(
        "tangent jacobian",
        friction.jacobian.entries.len(),
        &|model, out| {
            model.tangent_jacobian(i, x, out);
        },
    );
    both(
        "tangent hessian",
        friction.hessian.entries.len(),
        &|model, out| {
            model.tangent_hessian(i, x, &w[..1 + n], out);
        },
    );
}
