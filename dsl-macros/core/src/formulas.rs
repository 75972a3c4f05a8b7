//! Formulas against the syntax: the graph of scenes with units, vectors, matrices and every function of the language, and of random ones,
//! has the values of an evaluator of the syntax tree. What is derived of the graph is compared in `tests/declarations`.

use crate::diagnostics::Diagnostics;
use crate::graph::{self, Variable};
use crate::random_texts::{Random, source};
use crate::testing::{Evaluator, Nested, Point, run};
use crate::{Mistake, check, parse, text};
use std::fs;

/// Random texts.
const RANDOM: u64 = 120;

/// Scenes of `tests/declarations/scenes`: units other than SI, the time, vectors in space, matrices and every function.
const SCENES: [&str; 4] = ["double-pendulum", "functions", "top", "turntable"];

fn agree(source: &str) {
    graph::reset();
    let mut diagnostics = Diagnostics::default();
    let tokens = text::tokens(source, "scene").expect("made of tokens");
    let declared = parse::scene(tokens, &mut diagnostics).expect("a scene");
    let Ok(scene) = check::scene(&declared, &mut diagnostics) else {
        let mistakes = diagnostics.into_mistakes();
        let texts: Vec<String> = mistakes.iter().map(Mistake::text).collect();
        panic!("{texts:?}\n{source}");
    };
    let evaluator = Evaluator::new(&declared);
    let (n, mut random) = (scene.coordinates.len(), Random::new(7));
    let x: Vec<f64> = (0..=3 * n).map(|_| random.number()).collect();
    let input = |variable| match variable {
        Variable::Coordinate(i) => x[usize::from(i)],
        Variable::Velocity(i) => x[n + usize::from(i)],
        Variable::Control(i) => x[2 * n + usize::from(i)],
        Variable::Time => x[3 * n],
        Variable::Parameter(i) => scene.parameters[usize::from(i)].default,
        other => panic!("{other:?} is no input"),
    };
    let [q, v, u] = [0, 1, 2].map(|k| {
        let part = x[k * n..][..n].iter();
        part.map(|&x| Nested::Real(x)).collect()
    });
    let (t, tag) = (Nested::Real(x[3 * n]), 1);
    let point = Point { q, v, u, t, tag };
    let value = |expr| evaluator.scalar(expr, &point).real();
    let mut wanted = vec![value(evaluator.lagrangian)];
    let force = |name: &&str| {
        let force = evaluator.forces.get(name);
        force.map_or(0.0, |force| value(force) * evaluator.scale(name))
    };
    wanted.extend(evaluator.coordinates.iter().map(force));
    let gaps = evaluator.gaps.iter();
    wanted.extend(gaps.map(|&[free, other]| value(free) - value(other)));
    let mut outputs = vec![scene.lagrangian];
    outputs.extend(&scene.forces);
    outputs.extend(scene.contacts.iter().map(|contact| contact.gap));
    let found = run(&outputs, input);
    assert_eq!(found.len(), wanted.len());
    for (found, wanted) in found.into_iter().zip(wanted) {
        // Tens of roundings, of terms that may cancel.
        let off = 1e-12 * (1.0 + wanted.abs());
        assert!(
            (found - wanted).abs() <= off,
            "{found} and {wanted} of\n{source}"
        );
    }
}

#[test]
fn formulas_are_what_the_syntax_says() {
    for name in SCENES {
        let folder = concat!(
            env!("CARGO_MANIFEST_DIR"),
            "/../../tests/declarations/scenes"
        );
        agree(&fs::read_to_string(format!("{folder}/{name}.hang")).expect("a scene"));
    }
    (0..RANDOM).for_each(|seed| agree(&source(&mut Random::new(seed))));
}
