//! A compiled scene against the same text without a compiler: what they declare, of which kernels what solvers ask for is made, and the
//! values of all of these. Both do the same operations in the same order, so that values agree to the last bit. Bits are not asserted,
//! since a platform may compute the sine and the cosine of an angle by one call where it compiles.

use hangtime::model::Model;
use hangtime::scene::on_a_thread;
use hangtime_dsl::description::{Kernel, Operation, Source};

/// Roundings of elementary functions, with what cancels behind them.
const TOLERANCE: f64 = 1e-12;

/// Compares everything that two models are made of, with parameters as declared and with others, and with joints of which every other
/// equation is released.
pub(crate) fn assert_same(compiled: &dyn Model, loaded: &dyn Model) {
    // The text that a compiled scene carries has no documentation.
    let is_documented = !loaded.declaration().documentation.is_empty();
    let [one, other] = [compiled, loaded].map(|model| shown(model, is_documented));
    assert_eq!(one, other);
    let (declaration, text) = (compiled.declaration(), compiled.text());
    let derived = on_a_thread(declaration.name, |stem| {
        hangtime_dsl::describe_text(text, stem)
    });
    let (description, _) = derived.expect("a thread").expect("no mistakes");
    let (mut compiled, mut loaded) = (compiled.boxed(), loaded.boxed());
    assert_values([&*compiled, &*loaded], &description.kernels);
    let rows = description.structure.joint_rows();
    for model in [&mut compiled, &mut loaded] {
        for (i, parameter) in declaration.parameters.iter().enumerate() {
            model.set_parameter(i, 1.03 * parameter.default + 0.01);
        }
        for row in (0..rows).step_by(2) {
            assert!(model.joint_row_held(row));
            model.hold_joint_row(row, false);
            assert!(!model.joint_row_held(row));
        }
    }
    for i in 0..=declaration.parameters.len() {
        let [one, other] = [&compiled, &loaded].map(|model| model.parameter(i));
        assert_eq!(one.to_bits(), other.to_bits(), "parameter {i}");
    }
    assert_values([&*compiled, &*loaded], &description.kernels);
}

/// All that a model is made of but its kernels, with its documentation or without.
fn shown(model: &dyn Model, is_documented: bool) -> String {
    let shown = format!("{:?}", model.structure());
    if is_documented {
        return shown;
    }
    let mut parts = shown.split("documentation: \"");
    let first = parts.next().unwrap_or_default().to_owned();
    parts.fold(first, |shown, part| {
        let mut quotes = part.match_indices('"');
        let end = quotes.find(|(at, _)| !part[..*at].ends_with('\\'));
        shown + &part[end.expect("the end of a text").0..]
    })
}

/// Length of what a kernel reads of the inputs, and of the weights.
fn lengths(kernel: &Kernel) -> [usize; 2] {
    let mut lengths = [0; 2];
    for operation in &kernel.operations {
        let (which, index) = match *operation {
            Operation::Given(Source::Input(index)) => (0, index),
            Operation::Given(Source::Weight(index)) => (1, index),
            _ => continue,
        };
        lengths[which] = lengths[which].max(index as usize + 1);
    }
    lengths
}

/// Compares all values of all kernels of two models, at some states.
fn assert_values(models: [&dyn Model; 2], kernels: &[Kernel]) {
    let scene = models[0].declaration().name;
    for (index, kernel) in kernels.iter().enumerate() {
        for state in 0..4 {
            let number = |i: usize| 0.8 * (1.7 * i as f64 + 0.9 * f64::from(state)).sin() + 0.1;
            let [x, y] = lengths(kernel).map(|length| (0..length).map(number).collect::<Vec<_>>());
            let [mine, theirs] = models.map(|model| {
                let mut out = vec![f64::NAN; kernel.outputs.len()];
                model.kernel(index, &x, &y, &mut out);
                out
            });
            for (i, (a, b)) in mine.iter().zip(&theirs).enumerate() {
                let same = a == b || (a.is_nan() && b.is_nan());
                let close = (a - b).abs() <= TOLERANCE * (1.0 + a.abs());
                let name = &kernel.name;
                assert!(same || close, "{scene}, {name}, value {i}: {a} against {b}");
            }
        }
    }
}
