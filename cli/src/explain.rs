//! `hangtime explain`: what was derived from a scene, or the page about a mistake.

use std::fmt::Write as _;

use crate::Scene;
use hangtime::model::{
    ConstraintDeclaration, Declaration, ImpactLaw, Model, OptimalControlDeclaration, Over,
    SparsityPattern, Switching,
};

use crate::arguments::ExplainArguments;
use crate::failure::BadInput;
use crate::settings::ChosenScene;
use crate::sizes::Sizes;
use crate::table::headed;

pub(crate) fn run(
    scenes: &'static [Scene],
    arguments: &ExplainArguments,
) -> Result<String, BadInput> {
    let code = &arguments.scene.scene;
    if let Some(page) = page(code)? {
        if arguments.size || !arguments.scene.settings.is_empty() {
            return Err(BadInput::new(format!(
                "`{code}` is the page of a mistake, for which --set, --size and --json have no meaning; leave them out, or \
                 name a scene"
            )));
        }
        return Ok(page.to_owned());
    }
    let chosen = ChosenScene::from_arguments(scenes, &arguments.scene)?;
    Ok(answer(&chosen, arguments))
}

/// What is asked for about a scene.
pub(crate) fn answer(chosen: &ChosenScene, arguments: &ExplainArguments) -> String {
    if !arguments.size {
        return text(chosen);
    }
    let sizes = Sizes::of(chosen);
    match arguments.json {
        true => sizes.json(chosen),
        false => sizes.text(),
    }
}

/// What was derived from a scene, for people.
fn text(chosen: &ChosenScene) -> String {
    let declaration = chosen.model.declaration();
    let mut text = format!("{} ({})\n", chosen.scene.name, declaration.name);
    let documentation = declaration.documentation.lines().map(str::trim);
    for line in documentation.filter(|line| !line.is_empty()) {
        let _ = writeln!(text, "  {line}");
    }
    let _ = writeln!(text, "\nparameters  {}", chosen.parameters().join(", "));
    let coordinates = declaration.coordinates[..declaration.mechanical()].iter();
    let coordinates: Vec<String> = coordinates.map(|c| headed(c.name, c.unit)).collect();
    if !coordinates.is_empty() {
        let _ = writeln!(text, "coordinates {}", coordinates.join(", "));
    }
    let states = declaration.states.iter();
    let states: Vec<String> = states.map(|z| headed(z.name, z.unit)).collect();
    if !states.is_empty() {
        let _ = writeln!(text, "states      {}", states.join(", "));
    }
    let controls = declaration.controls.iter();
    let controls: Vec<String> = controls.map(|u| headed(u.name, u.unit)).collect();
    if !controls.is_empty() {
        let _ = writeln!(text, "controls    {}", controls.join(", "));
    }
    text += &joints(declaration);
    text += &laws(&*chosen.model);
    let outputs = chosen.model.outputs().iter();
    let outputs: Vec<String> = outputs.map(|o| headed(o.name, o.unit)).collect();
    if !outputs.is_empty() {
        let _ = writeln!(text, "outputs     {}", outputs.join(", "));
    }
    if declaration.explicit_time {
        text +=
            "time        the scene depends on the physical time t, which becomes the clock (E14)\n";
    }
    if let Some(task) = &declaration.optimal_control {
        text += &optimal_control(&*chosen.model, task);
    }

    text += &measured(&*chosen.model);

    text += "\nderived equations\n";
    let width = declaration.equations.iter().map(|e| e.left.chars().count());
    let width = width.max().unwrap_or_default();
    for equation in declaration.equations {
        let _ = writeln!(text, "  {:>width$} = {}", equation.left, equation.right);
    }
    text += &patterns(declaration);

    let operations = declaration.kernels.iter().map(|kernel| kernel.operations);
    let total: usize = operations.sum();
    let _ = writeln!(text, "\n{total} operations in all");
    text
}

/// The page of a mistake, if its code was given.
fn page(code: &str) -> Result<Option<&'static str>, BadInput> {
    if code == hangtime_dsl::page_name(None) {
        return Ok(hangtime_dsl::explanation(code));
    }
    let number = code.strip_prefix(['E', 'e']);
    if number.is_none_or(|digits| digits.is_empty() || digits.parse::<u32>().is_err()) {
        return Ok(None);
    }
    match hangtime_dsl::explanation(code) {
        Some(page) => Ok(Some(page)),
        None => {
            let codes: Vec<&str> = hangtime_dsl::mistake_codes().collect();
            Err(BadInput::new(format!(
                "there is no mistake `{code}`; the codes are {} to {}",
                codes.first().copied().unwrap_or_default(),
                codes.last().copied().unwrap_or_default()
            )))
        }
    }
}

/// What each joint holds.
fn joints(declaration: &Declaration) -> String {
    let mut text = String::new();
    for joint in declaration.joints.iter().flat_map(|joints| joints.list) {
        let name = headed(joint.name, joint.unit);
        let equations = match (joint.rows, joint.holonomic) {
            (1, true) => "an equation between positions, and its rate".to_owned(),
            (1, false) => "an equation between velocities".to_owned(),
            (count, true) => format!("{count} equations between positions, and their rates"),
            (count, false) => format!("{count} equations between velocities"),
        };
        let _ = writeln!(text, "joint       {name}: {equations}");
    }
    text
}

/// The impact law of each contact, with its coefficients for the parameters in force.
fn laws(model: &dyn Model) -> String {
    let declaration = model.declaration();
    let mut text = String::new();
    for (index, contact) in declaration.contacts.iter().enumerate() {
        if let Some(switch) = contact.switch {
            let how = match switch {
                Switching::Resets => {
                    let _ = writeln!(text, "when        {}", contact.name);
                    continue;
                }
                Switching::Slides => "passed, or slid along",
                _ => "passed",
            };
            let _ = writeln!(text, "switch      {}: its zeros are {how}", contact.name);
            continue;
        }
        if contact.dry {
            let name = headed(contact.name, contact.unit);
            let _ = writeln!(text, "contact     {name}: dry friction, without a surface");
            continue;
        }
        let mut law = match contact.law {
            ImpactLaw::Inelastic => "inelastic".to_owned(),
            ImpactLaw::Restitution => format!("restitution {}", model.restitution(index)),
        };
        if contact.friction.is_some() {
            let _ = write!(law, ", friction {}", model.friction(index));
        }
        law += if contact.custom_direction {
            ", declared impulse direction"
        } else {
            ", impulse along M^-1 grad gap"
        };
        let held = contact.held.iter();
        let held: Vec<&str> = held.map(|&i| declaration.coordinates[i].name).collect();
        if !held.is_empty() {
            let _ = write!(law, " with {} locked", held.join(", "));
        }
        if contact.sequence {
            law += ", in sequence";
        }
        let others = contact.alternatives.iter();
        let others: Vec<&str> = others.map(|&i| declaration.contacts[i].name).collect();
        if !others.is_empty() {
            let _ = write!(
                law,
                ", where its gap is larger than of {}",
                others.join(", ")
            );
        }
        let name = headed(contact.name, contact.unit);
        let _ = writeln!(text, "contact     {name}: {law}");
    }
    text
}

/// The parameters that are looked for.
fn free_parameters(model: &dyn Model) -> String {
    let mut text = String::new();
    let declared = model.declaration().parameters;
    let free = model.free_parameters();
    let (mut lower, mut upper) = (vec![0.0; free.len()], vec![0.0; free.len()]);
    model.free_parameter_bounds(&mut lower, &mut upper);
    for ((&index, lower), upper) in free.iter().zip(lower).zip(upper) {
        let name = headed(declared[index].name, declared[index].unit);
        let _ = writeln!(text, "free        {name} in {lower}..={upper}, a parameter");
    }
    text
}

/// Measured motions and the misfit, in a scene that compares with some.
fn measured(model: &dyn Model) -> String {
    let mut text = String::new();
    let experiments = model.structure().experiments;
    if experiments.is_empty() {
        return text;
    }
    let misfits = experiments.iter().map(|known| match known.huber {
        Some(bound) => format!("misfit({}, huber({bound}))", known.name),
        None => format!("misfit({})", known.name),
    });
    let misfits: Vec<String> = misfits.collect();
    let _ = writeln!(text, "minimize    {}", misfits.join(" + "));
    for known in experiments {
        let quantities = known.quantities.iter().map(|quantity| {
            let within = format!(
                "{} within {} {}",
                quantity.name, quantity.within, quantity.unit
            );
            within.trim_end().to_owned()
        });
        let quantities: Vec<String> = quantities.collect();
        let start = if known.own_start {
            ", a start of its own"
        } else {
            ""
        };
        let _ = writeln!(
            text,
            "measured    {} in {}: {}{start}",
            known.name,
            known.table().map_or(known.file, |_| "the scene itself"),
            quantities.join(", ")
        );
    }
    text + &free_parameters(model)
}

/// Objective, constraints, terminal conditions and free initial values.
fn optimal_control(model: &dyn Model, task: &OptimalControlDeclaration) -> String {
    let mut text = String::new();
    let costs = [
        (task.running_cost, "integral of the running cost"),
        (task.final_cost, "final cost"),
    ];
    let costs = costs.iter().filter(|(declared, _)| *declared);
    let costs: Vec<&str> = costs.map(|&(_, name)| name).collect();
    if !costs.is_empty() {
        let _ = writeln!(text, "minimize    {}", costs.join(" + "));
    }
    let at_impacts = task.contacts.constraints.iter();
    let at_impacts = at_impacts.map(|known| (known, " at every impact"));
    let constraints = task.constraints.iter().map(|known| (known, ""));
    for (constraint, when) in constraints.chain(at_impacts) {
        let relation = if constraint.equality { "= 0" } else { ">= 0" };
        let name = headed(constraint.name, constraint.unit);
        let _ = writeln!(text, "constraint  {name} {relation}{when}");
    }
    for goal in task.goals {
        let _ = writeln!(text, "finally     {}", goal.name);
    }
    for known in model.structure().epigraphs {
        let (what, place) = match known.over {
            Over::Instants => ("an unknown at each stage", " there"),
            Over::End => ("one unknown", " at the end"),
            Over::Motion => ("one unknown", " at each stage"),
        };
        let rows = match known.rows {
            1 => "1 condition".to_owned(),
            rows => format!("{rows} conditions"),
        };
        let _ = writeln!(text, "largest     in {}: {what}, {rows}{place}", known.name);
    }
    if task.free_time {
        text += "free        the final time\n";
    }
    text += &free_parameters(model);
    let count = task.free_start.len();
    let (mut lower, mut upper) = (vec![f64::NEG_INFINITY; count], vec![f64::INFINITY; count]);
    model.free_start_bounds(&mut lower, &mut upper);
    let coordinates = model.declaration().coordinates;
    for ((&index, lower), upper) in task.free_start.iter().zip(lower).zip(upper) {
        let name = match coordinates.get(index) {
            Some(coordinate) => coordinate.name.to_owned(),
            None => velocity(model.declaration(), index - coordinates.len()),
        };
        let bounds = if lower > f64::NEG_INFINITY || upper < f64::INFINITY {
            format!(" in {lower}..={upper}")
        } else {
            String::new()
        };
        let read = match model.structure().remembered.contains(&index) {
            true => ", which conditions read",
            false => "",
        };
        let _ = writeln!(text, "free        {name} at the start{bounds}{read}");
    }
    text
}

/// What a velocity is called: a state of first order by its own name.
fn velocity(declaration: &Declaration, index: usize) -> String {
    match declaration.state(index) {
        Some(state) => state.name.to_owned(),
        None => format!("{}'", declaration.coordinates[index].name),
    }
}

/// The sparsity patterns of all derivatives.
fn patterns(declaration: &Declaration) -> String {
    let rates = (0..declaration.coordinates.len()).map(|i| velocity(declaration, i));
    let coordinates = declaration.coordinates.iter().map(|c| c.name.to_owned());
    let mut inputs: Vec<String> = coordinates.chain(rates).collect();
    inputs.extend(declaration.controls.iter().map(|u| u.name.to_owned()));
    if declaration.explicit_time {
        inputs.push("t".to_owned());
    }
    let with = |prefix: &str, suffix: &str| -> Vec<String> {
        let coordinates = declaration.coordinates.iter();
        coordinates
            .map(|c| format!("{prefix}{}{suffix}", c.name))
            .collect()
    };
    let mut text = String::from("\nsparsity patterns (x structural nonzero, . zero)\n");
    let (jacobian, hessian) = (&declaration.free_jacobian, &declaration.free_hessian);
    let rows = with("", "''");
    text += &both("the free acceleration", (jacobian, hessian), &rows, &inputs);
    for contact in declaration.contacts {
        let directed = |names: &[&str]| {
            let names = names.iter().map(|name| (*name).to_owned());
            let names = names.chain(with("direction ", ""));
            names.collect::<Vec<String>>()
        };
        let (name, rows) = (contact.name, directed(&["gap", "gap'"]));
        let what = format!("contact `{name}`");
        text += &both(&what, (&contact.jacobian, &contact.hessian), &rows, &inputs);
        if let Some(friction) = &contact.friction {
            let (what, rows) = (format!("the friction of `{name}`"), directed(&["slip"]));
            let patterns = (&friction.jacobian, &friction.hessian);
            text += &both(&what, patterns, &rows, &inputs);
        }
    }
    if let Some(task) = &declaration.optimal_control {
        text += &task_patterns(declaration, task, &inputs);
    }
    text
}

/// The patterns of the functions of optimal control.
fn task_patterns(
    declaration: &Declaration,
    task: &OptimalControlDeclaration,
    inputs: &[String],
) -> String {
    let names = |list: &[ConstraintDeclaration]| -> Vec<String> {
        list.iter().map(|known| known.name.to_owned()).collect()
    };
    let rows = |cost: bool, name: &str, list: &[ConstraintDeclaration]| -> Vec<String> {
        let cost = cost.then(|| name.to_owned());
        cost.into_iter().chain(names(list)).collect()
    };
    let terms = task.contacts;
    let sums: Vec<String> = (0..terms.sums).map(|k| format!("sum {k}")).collect();
    // What contacts provide stands behind all else.
    let contacts = declaration.contacts.iter();
    let provided = ["r", "s"].into_iter().flat_map(|letter| {
        let contacts = contacts.clone();
        contacts.map(move |contact| format!("{letter}({})", contact.name))
    });
    let with_provided: Vec<String> = inputs.iter().cloned().chain(provided.clone()).collect();
    let mut at_the_end = inputs[..2 * declaration.coordinates.len()].to_vec();
    at_the_end.push("time".to_owned());
    at_the_end.extend_from_slice(&sums);
    at_the_end.extend(provided);
    let path = rows(task.running_cost, "running cost", task.constraints);
    let terminal = rows(task.final_cost, "final cost", task.goals);
    let impact = [sums, names(terms.constraints)].concat();
    let path_inputs = &with_provided[..declaration.path_inputs()];
    let patterns = (&task.path_jacobian, &task.path_hessian);
    let mut text = both("the path functions", patterns, &path, path_inputs);
    let patterns = (&task.terminal_jacobian, &task.terminal_hessian);
    let inputs = &at_the_end[..declaration.terminal_inputs()];
    text += &both("the terminal functions", patterns, &terminal, inputs);
    let patterns = (&terms.impact_jacobian, &terms.impact_hessian);
    text + &both("the impact functions", patterns, &impact, &with_provided)
}

/// The patterns of some functions, if there are any: rows of a Jacobian are functions, those of a Hessian are inputs.
fn both(
    what: &str,
    (jacobian, hessian): (&SparsityPattern, &SparsityPattern),
    rows: &[String],
    inputs: &[String],
) -> String {
    if rows.is_empty() {
        return String::new();
    }
    let title = format!("Hessian of {what}, lower triangle");
    pattern(&format!("Jacobian of {what}"), jacobian, rows, inputs)
        + &pattern(&title, hessian, inputs, inputs)
}

/// One pattern as a small matrix of dots and crosses.
fn pattern(title: &str, pattern: &SparsityPattern, rows: &[String], columns: &[String]) -> String {
    let mut text = format!(
        "\n  {title}: {} x {}, {} nonzeros\n",
        pattern.rows,
        pattern.columns,
        pattern.entries.len()
    );
    if pattern.entries.is_empty() {
        return text;
    }
    let label = |index: usize| rows.get(index).map_or("", String::as_str);
    let width = (0..pattern.rows)
        .map(|row| label(row).chars().count())
        .max();
    let width = width.unwrap_or_default();
    for row in 0..pattern.rows {
        let mut marks = vec!["."; pattern.columns];
        for &(_, column) in pattern
            .entries
            .iter()
            .filter(|entry| entry.0 as usize == row)
        {
            marks[column as usize] = "x";
        }
        let _ = writeln!(text, "    {:>width$}  {}", label(row), marks.join(" "));
    }
    let _ = writeln!(text, "    columns: {}", columns.join(", "));
    text
}
