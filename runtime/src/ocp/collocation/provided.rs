//! What contacts provide, where functions that the scene declares read their forces and impulses.
//!
//! The unknowns of a closed contact are accelerations times the length `h` of its element. What is read is the
//! acceleration itself, `h r_i` over `h`, and along the sliding velocity `s_i`, which is `-+ mu_i r_i` of a contact that
//! slips: further unknowns, in scenes that read forces only, of the contacts that they read. Between the stages both are
//! the polynomials through them. In an impact the velocities that contacts provide are unknowns already; those of friction
//! are added where the contact slips. Open contacts provide 0.

use super::builder::Builder;
use super::discretization::Setting;
use super::layout::{FREE, Phase, Tangential};
use crate::model::{ContactTerms, Declaration, Function, Model, SparsityPattern};
use crate::ocp::program::frame::{Sum, condition};
use crate::ocp::program::units::Units;
use crate::program::kernel::Kernel;
use crate::program::powers::{THOUSAND, nearest_power};
use crate::program::sparse_program::Program;
use crate::simulation::ContactMode;

/// Adds a variable and a row for each sum over impacts.
pub(super) fn sums(program: &mut Program, setting: Setting) -> Vec<Sum> {
    let sizes = sizes_of_sums(setting.model, setting.units, &setting.problem.start());
    let sums = sizes.into_iter().enumerate();
    sums.map(|(k, unit)| {
        let name = format!("sum {k} over impacts");
        let variable = program.variable(name.clone(), FREE, 0.0, unit);
        let row = program.row_in(unit, name, 0.0, 0.0);
        program.linear(row, variable, 1.0);
        Sum { variable, row }
    })
    .collect()
}

/// The size of what each sum adds up, where all contacts provide ordinary velocities at the start of the motion.
fn sizes_of_sums(model: &dyn Model, units: &Units, start: &[f64]) -> Vec<f64> {
    let (declaration, terms) = (model.declaration(), terms(model));
    let mut x = start.to_vec();
    x.resize(declaration.inputs(), 0.0);
    let velocities: Vec<f64> = (0..declaration.contacts.len())
        .map(|contact| units.velocity(contact))
        .collect();
    x.extend([&velocities[..], &velocities].concat());
    let mut values = vec![0.0; terms.impact_functions()];
    model.values(Function::Impact, &x, &mut values);
    let sizes = values[..terms.sums].iter();
    sizes
        .map(|size| nearest_power(THOUSAND, size.abs()))
        .collect()
}

/// What the scene reads of contacts.
fn terms(model: &dyn Model) -> ContactTerms {
    let declared = model.declaration().optimal_control;
    declared.map_or(ContactTerms::NONE, |declared| declared.contacts)
}

/// Which accelerations of contacts, the normal and then the tangential ones, path functions read, and terminal functions
/// where the motion `ends`; nothing if neither ever reads one.
pub(in crate::ocp) fn read(declaration: &Declaration, ends: bool) -> Vec<bool> {
    let Some(declared) = declaration.optimal_control else {
        return Vec::new();
    };
    let terms = declared.contacts;
    if !terms.path && !terms.terminal {
        return Vec::new();
    }
    let count = 2 * declaration.contacts.len();
    let mut read = vec![false; count];
    let mut mark = |pattern: SparsityPattern, inputs: usize| {
        for &(_, column) in pattern.entries {
            if let Some(k) = (column as usize).checked_sub(inputs - count) {
                read[k] = true;
            }
        }
    };
    if terms.path {
        mark(declared.path_jacobian, declaration.path_inputs());
    }
    if terms.terminal && ends {
        mark(declared.terminal_jacobian, declaration.terminal_inputs());
    }
    read
}

/// Adds what the contacts provide at the stages of an element, between two times of the guess.
pub(super) fn at_stages(builder: &mut Builder, phase: &mut Phase, [from, to]: [f64; 2]) {
    let Setting {
        model,
        units,
        tableau,
        ..
    } = builder.setting;
    let declaration = model.declaration();
    let contacts = declaration.contacts;
    let (everywhere, at_the_end) = (read(declaration, false), read(declaration, true));
    if everywhere.is_empty() {
        return;
    }
    let ends = phase.interval + 1 == builder.setting.problem.intervals
        && phase.index.0 + 1 == phase.index.1;
    let (scale, factor) = (phase.scale, phase.factor);
    for (m, stage) in phase.stages.iter_mut().enumerate() {
        let last = m + 1 == tableau.stages();
        let read = if ends && last {
            &at_the_end
        } else {
            &everywhere
        };
        let time = from + tableau.c()[m] * (to - from);
        let sample = builder.guess.at(time, !last);
        let (interval, index) = (phase.interval, phase.index.0);
        stage.provided = vec![None; read.len()];
        let mut add = |k: usize, (force, ratio): (usize, f64)| {
            let contact = k % contacts.len();
            let what = if k < contacts.len() { "" } else { " sliding" };
            let name = format!(
                "provided{what} by `{}` at stage {m} of interval {interval}, phase {index}",
                contacts[contact].name
            );
            let program = &mut builder.program;
            let guess = ratio * sample[2 * builder.n + contact];
            let unit = units.force[contact];
            let provided = program.variable(name.clone(), FREE, guess, unit);
            let row = program.row_in(units.gap_rows[contact], name, 0.0, 0.0);
            program.linear(row, force, ratio);
            program.bilinear(row, scale, provided, -factor);
            stage.provided[k] = Some(provided);
        };
        for (&contact, &force) in phase.closed.iter().zip(&stage.forces) {
            if read[contact] {
                add(contact, (force, 1.0));
            }
        }
        for tangential in &stage.tangential {
            let k = contacts.len() + tangential.contact;
            if let Some(sliding) = sliding(model, tangential).filter(|_| read[k]) {
                add(k, sliding);
            }
        }
    }
}

/// The variable that is the tangential force or impulse of a contact, but for a factor.
fn sliding(model: &dyn Model, tangential: &Tangential) -> Option<(usize, f64)> {
    match (tangential.force.or(tangential.slipping), tangential.mode) {
        (Some(force), _) => Some((force, 1.0)),
        (None, ContactMode::Slip(direction)) => {
            let mu = model.friction(tangential.contact);
            Some((tangential.normal, -direction.sign() * mu))
        }
        (None, _) => None,
    }
}

/// Adds what the contacts provide at the share `theta` of an element.
pub(super) fn within(
    builder: &mut Builder,
    phase: &Phase,
    theta: f64,
    at: &str,
) -> Vec<Option<usize>> {
    let mut weights = vec![0.0; phase.stages.len()];
    builder.setting.tableau.lagrange_values(theta, &mut weights);
    let names = builder.setting.model.declaration().contacts;
    let program = &mut builder.program;
    let mut add = |k: usize| {
        let stages = phase.stages.iter();
        let variables: Vec<usize> = stages.map(|s| s.provided[k]).collect::<Option<_>>()?;
        let first = *variables.first()?;
        let name = format!("provided ({k}) by `{}` {at}", names[k % names.len()].name);
        let unit = program.unit(first);
        let terms = variables.iter().zip(&weights);
        let guess = terms.clone().map(|(&i, w)| w * program.guessed(i)).sum();
        let variable = program.variable(name.clone(), FREE, guess, unit);
        let row = program.row_in(unit, name, 0.0, 0.0);
        program.linear(row, variable, -1.0);
        for (&i, &weight) in terms {
            program.linear(row, i, weight);
        }
        Some(variable)
    };
    let count = phase.stages.first().map_or(0, |stage| stage.provided.len());
    (0..count).map(&mut add).collect()
}

/// The values of what contacts provide at the share of an element that has these weights of its stages.
pub(super) fn values<'p>(
    phase: &'p Phase,
    weights: &'p [f64],
    x: &'p [f64],
) -> impl Iterator<Item = f64> + 'p {
    let count = phase.stages.first().map_or(0, |stage| stage.provided.len());
    (0..count).map(move |k| {
        let stages = phase.stages.iter().zip(weights);
        stages
            .map(|(stage, weight)| stage.provided[k].map_or(0.0, |i| weight * x[i]))
            .sum()
    })
}

/// Path constraints that hold at the start of an element as well as at its stages: those on forces, which jump there.
pub(super) fn at_start(declaration: &Declaration) -> impl Fn(usize) -> bool {
    let declared = declaration.optimal_control;
    let inputs = declaration.inputs();
    move |constraint| {
        declared.is_some_and(|declared| {
            let row = usize::from(declared.running_cost) + constraint;
            !declared.constraints[constraint].equality && declared.path_jacobian.reads(row, inputs)
        })
    }
}

/// Adds what an impact adds to the sums, and the conditions on it; `impulses` are the contacts that take part
/// and the variables of their impulses, and those with friction are impacts of the builder from `first` on.
pub(super) fn in_impact(
    builder: &mut Builder,
    first: usize,
    impulses: &[(usize, usize)],
    label: &str,
) {
    let Setting { model, units, .. } = builder.setting;
    let (declaration, terms) = (model.declaration(), terms(model));
    let pattern = terms.impact_jacobian;
    let (inputs, contacts) = (declaration.inputs(), declaration.contacts);
    if terms.of_impacts() == 0 {
        return;
    }
    let reads = |row: Option<usize>, k: usize| {
        let mut entries = pattern.entries.iter();
        entries.any(|&(r, column)| {
            column as usize == inputs + k && row.is_none_or(|row| r as usize == row)
        })
    };
    let mut provided = vec![None; 2 * contacts.len()];
    for &(contact, impulse) in impulses {
        provided[contact] = Some(impulse);
    }
    let program = &mut builder.program;
    for (_, tangential) in &builder.impacts[first..] {
        let k = contacts.len() + tangential.contact;
        let Some((impulse, ratio)) = sliding(model, tangential).filter(|_| reads(None, k)) else {
            continue;
        };
        let unit = units.gap_rows[tangential.contact];
        let name = contacts[tangential.contact].name;
        let name = format!("provided sliding by `{name}` in the impact that ends {label}");
        let variable = program.variable(name.clone(), FREE, 0.0, unit);
        let row = program.row_in(unit, name, 0.0, 0.0);
        program.linear(row, variable, -1.0);
        program.linear(row, impulse, ratio);
        provided[k] = Some(variable);
    }
    let acts =
        |row: usize| (0..provided.len()).any(|k| provided[k].is_some() && reads(Some(row), k));
    let sums = builder.frame.sums.iter().enumerate();
    let mut uses: Vec<(usize, usize, f64)> = sums
        .filter(|&(k, _)| acts(k))
        .map(|(k, sum)| (sum.row, k, -1.0))
        .collect();
    for (i, declared) in terms.constraints.iter().enumerate() {
        let function = terms.sums + i;
        if acts(function) {
            let place = format!("in the impact that ends {label}");
            uses.push((condition(program, declared, 1.0, &place), function, 1.0));
        }
    }
    if !uses.is_empty() {
        let (q, drive) = (&builder.state[..builder.n], &builder.before[..]);
        program.block_behind(
            &Kernel::Whole(Function::Impact),
            [q, &[], drive],
            &provided,
            None,
            uses,
        );
    }
}
