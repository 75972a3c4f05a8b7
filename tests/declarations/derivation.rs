//! What is derived of all scene texts of the tree, by routes that share nothing with the derivation.
//!
//! - Inertia, acceleration, forces of joints and energies fulfil Lagrange's equations, with the Lagrangian and the forces as they are
//!   declared. It is quadratic in the velocities, so that momenta are differences without truncation.
//! - Jacobians and Hessians are the differences of what they are the derivatives of, along a random direction: of all entries at once,
//!   and of those that a pattern leaves out.
//! - What a contact consists of follows from these and the inertia.

use crate::differences::{Near, equal, slopes};
use crate::draw::Draw;
use crate::random_texts::{source, stream};
use hangtime::model::{
    ContactDeclaration, Function, Model, SparsityPattern, contact_point, tangent_point,
};
use hangtime::scene::on_a_thread;
use hangtime_dsl::description::{Kernel, Source};
use hangtime_scene_files::{of_text, read_text};
use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;
use std::fs;
use std::iter;
use std::path::Path;

/// Random texts.
const RANDOM: u64 = 24;

/// Texts with mistakes, and a scene whose mass is zero.
const NO_SCENES: [&str; 3] = ["slips.md", "ui/files", "zero-parameter"];

/// Scenes whose derivation takes long.
const LONG: [&str; 13] = [
    "brick-wall.hang",
    "chain-on-pulley.hang",
    "dice.hang",
    "galton-board.hang",
    "jansens-linkage.hang",
    "plank-bridge.hang",
    "toppling-bricks.hang",
    "trebuchet.hang",
    "bodies.md, A sphere slides over",
    "bodies.md, Dice in space",
    "bodies.md, Two rough spheres in space",
    "many.md, A biped of two equal legs",
    "mechanisms.md, Chain that slides off a pulley",
];

/// Functions without values around the start: of a contact that a joint keeps apart.
const UNKNOWN: [&str; 1] = [
    "tests/cases/joints.md, A piece of a surface that a joint keeps open does nothing: contact(cage.1)",
];

/// Distances from the start at which functions are looked at, until they were known twice: some have no values near it.
const DISTANCES: [f64; 14] = [
    0.6, 0.6, 0.6, 0.3, 0.3, 0.1, 0.1, 0.03, 0.01, 10.0, 10.0, 10.0, 10.0, 10.0,
];

/// A model, and the Lagrangian and the forces that it was declared with.
struct Declared<'a> {
    model: &'a dyn Model,
    acting: Kernel,
    /// Number of coordinates, and of those of the mechanism.
    coordinates: usize,
    mechanical: usize,
}

impl Declared<'_> {
    /// The Lagrangian, and behind it the generalized forces.
    fn acting(&self, x: &[f64]) -> Vec<f64> {
        run(&self.acting, |i| self.model.parameter(i), x)
    }

    /// The inputs with `s along` added to the velocities.
    fn faster(&self, x: &[f64], s: f64, along: &[f64]) -> Vec<f64> {
        let mut faster = x.to_vec();
        let velocities = faster[self.coordinates..].iter_mut().zip(along);
        velocities.for_each(|(v, along)| *v += s * along);
        faster
    }

    /// The momentum along a displacement. A state is the velocity of a coordinate of unit mass.
    fn momentum(&self, x: &[f64], along: &[f64]) -> f64 {
        let (own, of_states) = along.split_at(self.mechanical);
        let sides = [1.0, -1.0].map(|s| self.acting(&self.faster(x, s, own))[0]);
        (sides[0] - sides[1]) / 2.0 + inner(&x[self.coordinates + self.mechanical..], of_states)
    }

    /// The mass matrix times a vector.
    fn times(&self, x: &[f64], vector: &[f64]) -> Vec<f64> {
        let mut mass = vec![f64::NAN; self.coordinates.pow(2)];
        self.model.mass_matrix(x, &mut mass);
        let rows = mass.chunks(self.coordinates);
        rows.map(|row| inner(row, vector)).collect()
    }

    /// How the inputs change along a motion with this acceleration, under constant controls.
    fn ahead(&self, x: &[f64], acceleration: &[f64]) -> Vec<f64> {
        let (n, declaration) = (self.coordinates, self.model.declaration());
        let mut ahead = [&x[n..2 * n], acceleration].concat();
        ahead.resize(2 * n + declaration.controls.len(), 0.0);
        ahead.resize(x.len(), 1.0);
        ahead
    }

    /// Derivatives of the equations of joints along a direction.
    fn of_joints(&self, x: &[f64], along: &[f64]) -> Vec<f64> {
        self.model
            .declaration()
            .joints
            .map_or_else(Vec::new, |joints| {
                let mut values = vec![f64::NAN; joints.jacobian.entries.len()];
                self.model.jacobian(Function::Joints, x, &mut values);
                product((joints.jacobian, &values), along, false)
            })
    }

    /// Lagrange's equations along a random displacement, and the energies; whether they were known.
    fn moves(&self, x: &[f64], random: &mut Draw) -> Result<bool, String> {
        let n = self.coordinates;
        let [along, other] = [(); 2].map(|()| vector(random, n));
        let lagrangian = |x: &[f64]| self.acting(x)[0];
        let fastest = self.faster(&self.faster(x, 1.0, &along), 1.0, &other);
        let size = lagrangian(&fastest).abs() + lagrangian(x).abs() + inner(x, x);
        let sides = [1.0, -1.0].map(|s| self.momentum(&self.faster(x, s, &other), &along));
        let inertia = inner(&along, &self.times(x, &other));
        equal("mass matrix", inertia, (sides[0] - sides[1]) / 2.0, size)?;

        let mut energy = [f64::NAN; 2];
        self.model.energy(x, &mut energy);
        let mut v = x[n..2 * n].to_vec();
        v[self.mechanical..].fill(0.0);
        let at_rest = lagrangian(&self.faster(x, -1.0, &v));
        let kinetic = self.momentum(x, &v) - lagrangian(x) + at_rest;
        equal("kinetic energy", energy[0], kinetic, size)?;
        equal("potential energy", energy[1], -at_rest, size)?;

        let mut acceleration = vec![f64::NAN; n];
        self.model.free_acceleration(x, &mut acceleration);
        let inertia = self.times(x, &acceleration);
        let held = self.held(x, &acceleration, &along)?;
        let forces = inner(&along, &self.acting(x)[1..]);
        let ahead = self.ahead(x, &vec![0.0; n]);
        let mut wanted = slopes(|s| {
            let displaced = lagrangian(&moved(x, s, &along));
            vec![displaced - self.momentum(&moved(x, s, &ahead), &along)]
        });
        let terms = along.iter().zip(&inertia).map(|(d, f)| (d * f).abs());
        wanted[0].value += forces;
        wanted[0].off += 1e-13 * (terms.sum::<f64>() + held.abs() + forces.abs());
        Near::compared(
            "Lagrange's equations",
            &[inner(&along, &inertia) - held],
            &wanted,
        )
    }

    /// What the forces of joints do along a displacement, where the acceleration fulfils the rates of all joints.
    fn held(&self, x: &[f64], a: &[f64], along: &[f64]) -> Result<f64, String> {
        let Some(joints) = self.model.declaration().joints else {
            return Ok(0.0);
        };
        let rows = joints.rows();
        let [mut values, mut forces] = [2 * rows, rows].map(|count| vec![f64::NAN; count]);
        self.model.values(Function::Joints, x, &mut values);
        self.model.joint_forces(x, &mut forces);
        let rates = self.of_joints(x, &self.ahead(x, a));
        let size = 1.0 + inner(a, a).sqrt() + inner(x, x);
        for (row, (joint, _)) in joints.equations().enumerate() {
            if joint.holonomic {
                equal("rate of a joint", values[rows + row], rates[row], size)?;
            }
            equal("acceleration of a joint", rates[rows + row], 0.0, size)?;
        }
        let displacement = self.faster(&vec![0.0; x.len()], 1.0, along);
        Ok(inner(&self.of_joints(x, &displacement)[rows..], &forces))
    }

    /// `H b`, with the inverse inertia of the system in which joints hold and the `locked` coordinates rest.
    fn response(&self, x: &[f64], locked: &[usize], b: &[f64]) -> Vec<f64> {
        let (n, joints) = (b.len(), self.model.declaration().joints);
        let rows = joints.map_or(0, |joints| joints.rows());
        let mut matrix = DMatrix::zeros(n + rows, n + rows);
        let mut right = DVector::zeros(n + rows);
        let unit = |k: usize| -> Vec<f64> { (0..n).map(|i| f64::from(u8::from(i == k))).collect() };
        for i in 0..n {
            if locked.contains(&i) {
                matrix[(i, i)] = 1.0;
                continue;
            }
            right[i] = b[i];
            for (j, mass) in self.times(x, &unit(i)).into_iter().enumerate() {
                matrix[(i, j)] = if locked.contains(&j) { 0.0 } else { mass };
            }
            let along = self.faster(&vec![0.0; x.len()], 1.0, &unit(i));
            for (row, rate) in self.of_joints(x, &along).into_iter().skip(rows).enumerate() {
                (matrix[(i, n + row)], matrix[(n + row, i)]) = (rate, rate);
            }
        }
        let solution = matrix.lu().solve(&right).unwrap_or(right);
        solution.as_slice()[..n].to_vec()
    }

    /// What a contact consists of.
    fn touches(&self, i: usize, contact: &ContactDeclaration, x: &[f64]) -> Result<(), String> {
        let n = self.coordinates;
        let mut point = vec![f64::NAN; contact_point::length(n)];
        self.model.contact(i, x, &mut point);
        if !point.iter().all(|value| value.is_finite()) {
            return Ok(());
        }
        let mut values = vec![f64::NAN; contact.jacobian.entries.len()];
        self.model.jacobian(Function::Contact(i), x, &mut values);
        let rates = product(
            (contact.jacobian, &values),
            &self.ahead(x, &vec![0.0; n]),
            false,
        );
        let (normal, direction) = point[contact_point::NORMAL..].split_at(n);
        let scale = point[contact_point::INVERSE_INERTIA];
        if contact.dry {
            let none = [&point[..2], normal, direction].concat();
            all_equal("what dry friction has not", &none, &vec![0.0; none.len()])?;
        } else {
            all_equal("normal", normal, &row((contact.jacobian, &values), 0)[..n])?;
            let known = [contact_point::NORMAL_VELOCITY, contact_point::CURVATURE];
            all_equal(
                "rates of a gap",
                &known.map(|place| point[place]),
                &rates[..2],
            )?;
            let response = self.response(x, contact.held, normal);
            equal("inverse inertia", scale, inner(normal, &response), scale)?;
            equal("unit of a direction", inner(normal, direction), 1.0, 1.0)?;
            if !contact.custom_direction {
                all_equal(
                    "direction",
                    direction,
                    &response.iter().map(|w| w / scale).collect::<Vec<f64>>(),
                )?;
            }
        }
        let Some(friction) = contact.friction else {
            return Ok(());
        };
        let mut side = vec![f64::NAN; tangent_point::length(n)];
        let mut values = vec![f64::NAN; friction.jacobian.entries.len()];
        self.model.tangent(i, x, &mut side);
        self.model.jacobian(Function::Tangent(i), x, &mut values);
        self.slides((i, contact, scale), x, &side, (friction.jacobian, &values))?;
        let Some(pattern) = friction.across else {
            return Ok(());
        };
        let mut values = vec![f64::NAN; pattern.entries.len()];
        self.model.values(Function::Across(i), x, &mut side);
        self.model.jacobian(Function::Across(i), x, &mut values);
        self.slides((i, contact, scale), x, &side, (pattern, &values))
    }

    /// What a side of a contact consists of, that is sliding along one direction.
    fn slides(
        &self,
        (i, contact, scale): (usize, &ContactDeclaration, f64),
        x: &[f64],
        side: &[f64],
        jacobian: (SparsityPattern, &[f64]),
    ) -> Result<(), String> {
        let n = self.coordinates;
        let (tangent, direction) = side[tangent_point::TANGENT..].split_at(n);
        all_equal("tangent", tangent, &row(jacobian, 0)[n..2 * n])?;
        let rates = product(jacobian, &self.ahead(x, &vec![0.0; n]), false);
        all_equal(
            "rate of sliding",
            &[side[tangent_point::CURVATURE]],
            &rates[..1],
        )?;
        if contact.switch.is_some() {
            return Ok(());
        }
        let factor = self.model.friction_share(i, x) / scale;
        let response = self.response(x, contact.held, tangent);
        let wanted: Vec<f64> = response.iter().map(|e| e * factor).collect();
        all_equal("friction direction", direction, &wanted)
    }
}

/// Outputs of a kernel without weights.
pub(crate) fn run(kernel: &Kernel, parameter: impl Fn(usize) -> f64, x: &[f64]) -> Vec<f64> {
    let mut values: Vec<f64> = Vec::with_capacity(kernel.operations.len());
    for operation in &kernel.operations {
        let given = |source| match source {
            Source::Parameter(i) => parameter(i as usize),
            Source::Input(i) => x[i as usize],
            Source::Constant(value) => value,
            Source::Weight(_) => f64::NAN,
        };
        values.push(operation.value(given, |i| values[i as usize]));
    }
    let outputs = kernel.outputs.iter();
    outputs.map(|&output| values[output as usize]).collect()
}

fn vector(random: &mut Draw, length: usize) -> Vec<f64> {
    (0..length).map(|_| random.between(-1.0, 1.0)).collect()
}

fn inner(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// `x + s d`, with zeros behind a `d` that is shorter.
fn moved(x: &[f64], s: f64, d: &[f64]) -> Vec<f64> {
    let steps = d.iter().chain(iter::repeat(&0.0));
    x.iter().zip(steps).map(|(x, d)| x + s * d).collect()
}

fn all_equal(what: &str, found: &[f64], wanted: &[f64]) -> Result<(), String> {
    let size = wanted
        .iter()
        .chain(found)
        .fold(0.0, |size: f64, w| size.max(w.abs()));
    let mut pairs = found.iter().zip(wanted);
    pairs.try_for_each(|(found, wanted)| equal(what, *found, *wanted, size))
}

/// A sparse matrix times a vector; with `is_triangle` the symmetric one whose lower triangle is given.
fn product(
    (pattern, values): (SparsityPattern, &[f64]),
    vector: &[f64],
    is_triangle: bool,
) -> Vec<f64> {
    let mut product = vec![0.0; pattern.rows];
    for (&(row, column), value) in pattern.entries.iter().zip(values) {
        let (row, column) = (row as usize, column as usize);
        product[row] += value * vector[column];
        if is_triangle && row != column {
            product[column] += value * vector[row];
        }
    }
    product
}

/// A row of a sparse matrix.
fn row((pattern, values): (SparsityPattern, &[f64]), row: u32) -> Vec<f64> {
    let mut dense = vec![0.0; pattern.columns];
    let entries = pattern.entries.iter().zip(values);
    for (&(_, column), value) in entries.filter(|((of, _), _)| *of == row) {
        dense[column as usize] = *value;
    }
    dense
}

/// The functions of a model that have derivatives, and their names.
fn functions(model: &dyn Model) -> Vec<(String, Function)> {
    use Function::{Across, Contact, Given, Impact, Joints, Motion, Path, Tangent, Terminal};
    let contacts = model.declaration().contacts.iter().enumerate();
    let of_contacts = contacts.flat_map(|(i, contact)| {
        let sides = [
            ("contact", Contact(i)),
            ("tangent", Tangent(i)),
            ("across", Across(i)),
        ];
        sides.map(|(side, function)| (format!("{side}({})", contact.name), function))
    });
    let others = [Motion, Joints, Path, Terminal, Impact, Given];
    let others = others.map(|function| (format!("{function:?}").to_lowercase(), function));
    let all = others.into_iter().chain(of_contacts);
    let has_values = |function| {
        model
            .signature(function)
            .is_some_and(|known| known.values > 0)
    };
    all.filter(|(_, function)| has_values(*function)).collect()
}

/// Values of a function, of a contact or its side those whose derivatives it has.
fn rows(model: &dyn Model, function: Function, x: &[f64], count: usize) -> Vec<f64> {
    let length = model.signature(function).expect("a function").values;
    let mut values = vec![f64::NAN; length];
    model.values(function, x, &mut values);
    let n = model.declaration().coordinates.len();
    let first = match function {
        Function::Contact(i) if model.declaration().contacts[i].dry => {
            vec![0.0, -values[contact_point::CURVATURE]]
        }
        Function::Contact(i) => vec![model.gap(i, x), values[contact_point::NORMAL_VELOCITY]],
        Function::Tangent(_) | Function::Across(_) => vec![values[tangent_point::SLIDING_VELOCITY]],
        _ => return values,
    };
    let rows = [&first, &values[length - n..]].concat();
    assert_eq!(rows.len(), count);
    rows
}

/// Compares the derivatives of a function with differences; whether these were known.
fn differentiated(
    (name, function): (&str, Function),
    model: &dyn Model,
    x: &[f64],
    random: &mut Draw,
) -> Result<bool, String> {
    let signature = model.signature(function).expect("a function");
    let (pattern, triangle) = (signature.jacobian, signature.hessian);
    let count = pattern.rows;
    assert_eq!(pattern.columns, x.len(), "{name}");
    let (along, weights) = (vector(random, x.len()), vector(random, count));
    let jacobian = |x: &[f64]| {
        let mut values = vec![f64::NAN; pattern.entries.len()];
        model.jacobian(function, x, &mut values);
        values
    };
    let wanted = slopes(|s| rows(model, function, &moved(x, s, &along), count));
    let found = product((pattern, &jacobian(x)), &along, false);
    let is_known = Near::compared(&format!("{name}, Jacobian"), &found, &wanted)?;
    if triangle == SparsityPattern::EMPTY {
        return Ok(is_known);
    }
    let wanted = slopes(|s| {
        let mut gradient = vec![0.0; x.len()];
        let values = jacobian(&moved(x, s, &along));
        for (&(row, column), value) in pattern.entries.iter().zip(values) {
            gradient[column as usize] += weights[row as usize] * value;
        }
        gradient
    });
    let mut values = vec![f64::NAN; triangle.entries.len()];
    model.hessian(function, x, &weights, &mut values);
    let found = product((triangle, &values), &along, true);
    Ok(Near::compared(&format!("{name}, Hessian"), &found, &wanted)? && is_known)
}

/// Whether something is known twice at random points near the start.
fn twice(
    model: &dyn Model,
    inputs: usize,
    mut at: impl FnMut(&[f64], &mut Draw) -> Result<bool, String>,
) -> Result<bool, String> {
    let n = model.declaration().coordinates.len();
    let mut start = vec![0.0; inputs.max(2 * n)];
    let (q, v) = start[..2 * n].split_at_mut(n);
    model.start(q, v);
    let (mut random, mut known) = (stream(7), 0);
    for distance in DISTANCES {
        let step = vector(&mut random, inputs);
        known += usize::from(at(&moved(&start[..inputs], distance, &step), &mut random)?);
        if known == 2 {
            return Ok(true);
        }
    }
    Ok(false)
}

/// Whether each entry of the patterns of the motion is other than zero somewhere.
fn is_minimal(model: &dyn Model, random: &mut Draw) -> bool {
    let declaration = model.declaration();
    let patterns = [declaration.free_jacobian, declaration.free_hessian];
    let mut nonzero = patterns.map(|pattern| vec![false; pattern.entries.len()]);
    for _ in 0..2 {
        let x = vector(random, declaration.inputs());
        let weights = vector(random, declaration.coordinates.len());
        let mut values = nonzero.each_ref().map(|known| vec![0.0; known.len()]);
        model.jacobian(Function::Motion, &x, &mut values[0]);
        model.hessian(Function::Motion, &x, &weights, &mut values[1]);
        for (nonzero, values) in nonzero.iter_mut().zip(values) {
            let size = values
                .iter()
                .fold(0.0, |size: f64, value| size.max(value.abs()));
            let entries = nonzero.iter_mut().zip(values);
            entries.for_each(|(nonzero, value)| *nonzero |= value.abs() > 1e-9 * size);
        }
    }
    nonzero.concat().iter().all(|&nonzero| nonzero)
}

/// Compares all that is derived of a text; what was not known.
fn check(name: &str, text: &str) -> Result<Vec<String>, String> {
    let model = of_text("scene.hang", text).map_err(|error| error.to_string())?;
    let acting = on_a_thread("scene", |stem| hangtime_dsl::acting(text, stem));
    let declaration = model.declaration();
    let declared = Declared {
        model: &model,
        acting: acting.expect("a thread").expect("no mistakes"),
        coordinates: declaration.coordinates.len(),
        mechanical: declaration.mechanical(),
    };
    let mut unknown = Vec::new();
    let is_known = twice(&model, declaration.inputs(), |x, random| {
        for (i, contact) in declaration.contacts.iter().enumerate() {
            let touches = declared.touches(i, contact, x);
            touches.map_err(|message| format!("{}: {message}", contact.name))?;
        }
        declared.moves(x, random)
    })?;
    if !is_known {
        unknown.push("motion".to_owned());
    }
    if name.starts_with("random") && !is_minimal(&model, &mut stream(1)) {
        unknown.push("minimal patterns".to_owned());
    }
    // What is found is held as coordinates.
    let found = [model.free_parameters(), model.structure().remembered];
    let holds = found.concat().len() + model.structure().epigraphs.len() > 0;
    let held = holds.then(|| model.with_held(model.free_parameters()));
    let held = held.map(|held| held.expect("a scene that can be held"));
    for model in
        iter::once(&model as &dyn Model).chain(held.as_ref().map(|held| held as &dyn Model))
    {
        for (name, function) in functions(model) {
            let at =
                |x: &[f64], random: &mut Draw| differentiated((&name, function), model, x, random);
            let inputs = model.signature(function).expect("a function").inputs;
            if !twice(model, inputs, at)? {
                unknown.push(name);
            }
        }
    }
    Ok(unknown)
}

/// Names and texts of the scenes of the tree that take long, or of all others and random ones.
fn texts(are_long: bool) -> Vec<(String, String)> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let folders = ["cli", "models", "runtime/tests", "tests", "tools", "zoo"];
    let mut open: Vec<_> = folders.map(|folder| root.join(folder)).into();
    let mut texts = Vec::new();
    while let Some(path) = open.pop() {
        let name = path
            .strip_prefix(root)
            .expect("below the root")
            .display()
            .to_string();
        let extension = path.extension().and_then(|extension| extension.to_str());
        if path.is_dir() {
            let entries = fs::read_dir(&path).expect("a folder");
            open.extend(entries.map(|entry| entry.expect("an entry").path()));
        } else if extension == Some("hang") {
            texts.push((name, read_text(&path).expect("a text")));
        } else if extension == Some("md") {
            let text = fs::read_to_string(&path).expect("a text");
            for section in text.split("\n## ") {
                let heading = section.lines().next().unwrap_or_default();
                let fences = section.split("\n```hang").skip(1);
                let bodies =
                    fences.filter_map(|fence| fence.split_once('\n')?.1.split("```").next());
                texts.extend(bodies.map(|body| (format!("{name}, {heading}"), body.to_owned())));
            }
        }
    }
    let is_one_of = |name: &str, list: &[&str]| list.iter().any(|other| name.contains(other));
    // A fence that names a file is empty.
    texts.retain(|(name, text)| {
        let is_meant = is_one_of(name, &LONG) == are_long && !is_one_of(name, &NO_SCENES);
        is_meant && !text.trim().is_empty()
    });
    if are_long {
        return texts;
    }
    let random = (0..RANDOM).map(|seed| (format!("random {seed}"), source(&mut stream(seed)).text));
    texts.extend(random);
    texts.sort_by(|a, b| a.1.cmp(&b.1));
    texts.dedup_by(|a, b| a.1 == b.1);
    texts
}

/// Compares all that is derived of these texts; what was not known.
fn check_all(texts: &[(String, String)]) -> Vec<String> {
    let unknown = texts.par_iter().flat_map_iter(|(name, text)| {
        let unknown = check(name, text);
        let unknown = unknown.unwrap_or_else(|message| panic!("{name}: {message}\n{text}"));
        unknown
            .into_iter()
            .map(move |what| format!("{name}: {what}"))
    });
    unknown.collect()
}

#[test]
fn all_that_is_derived_of_texts_agrees_with_differences_and_the_declaration() {
    let texts = texts(false);
    // If they were not found, the test would test nothing.
    assert!(texts.len() > 700, "{} texts", texts.len());
    assert_eq!(check_all(&texts), UNKNOWN);
}

#[test]
#[ignore = "long"]
fn all_that_is_derived_of_long_scenes_agrees_with_differences_and_the_declaration() {
    let texts = texts(true);
    let is_there = |part: &&str| texts.iter().any(|(name, _)| name.contains(*part));
    assert!(LONG.iter().all(is_there));
    assert_eq!(check_all(&texts), [""; 0]);
}
