//! `hangtime explain`: what was derived from a scene.

use std::fmt::Write as _;

use hangtime::model::{Declaration, ImpactLaw, SparsityPattern};
use hangtime_models::scenes;

use super::Report;
use super::arguments::ExplainArguments;
use super::failure::BadInput;
use super::settings::ChosenScene;
use super::table::{headed, table};

/// When the library with the scenes was finished [s since 1970], if the compiler's arguments told.
const LIBRARY_FINISHED: Option<f64> = hangtime_macros::finished_at!(hangtime_models);
/// A compilation that seems to take longer than this was put together from different builds [s].
const LONGEST_COMPILATION: f64 = 3600.0;

pub(super) fn run(arguments: &ExplainArguments) -> Result<Report, BadInput> {
    let chosen = ChosenScene::from_arguments(&arguments.scene)?;
    let declaration = chosen.model.declaration();
    let mut text = format!("{} ({})\n", chosen.scene.name, declaration.name);
    let documentation = declaration.documentation.lines().map(str::trim);
    for line in documentation.filter(|line| !line.is_empty()) {
        let _ = writeln!(text, "  {line}");
    }
    let _ = writeln!(text, "\nparameters  {}", chosen.parameters().join(", "));
    let coordinates = declaration.coordinates.iter();
    let coordinates: Vec<String> = coordinates.map(|c| headed(c.name, c.unit)).collect();
    let _ = writeln!(text, "coordinates {}", coordinates.join(", "));
    let controls = declaration.controls.iter();
    let controls: Vec<String> = controls.map(|u| headed(u.name, u.unit)).collect();
    if !controls.is_empty() {
        let _ = writeln!(text, "controls    {}", controls.join(", "));
    }
    for contact in declaration.contacts {
        let law = match contact.law {
            ImpactLaw::Inelastic => "inelastic",
            ImpactLaw::Restitution => "restitution",
            _ => "other",
        };
        let direction = if contact.custom_direction {
            "declared impulse direction"
        } else {
            "impulse along M^-1 grad gap"
        };
        let name = headed(contact.name, contact.unit);
        let _ = writeln!(text, "contact     {name}: {law}, {direction}");
    }

    text += "\nderived equations\n";
    let width = declaration.equations.iter().map(|e| e.left.chars().count());
    let width = width.max().unwrap_or_default();
    for equation in declaration.equations {
        let _ = writeln!(text, "  {:>width$} = {}", equation.left, equation.right);
    }
    text += &patterns(declaration);

    text += "\nkernels\n";
    let kernels = declaration.kernels.iter();
    text += &table(
        ["function", "operations", "outputs"],
        kernels.map(|kernel| {
            let counts = [kernel.operations, kernel.outputs].map(|count| count.to_string());
            [kernel.name.to_owned()].into_iter().chain(counts).collect()
        }),
    );
    let total: usize = declaration
        .kernels
        .iter()
        .map(|kernel| kernel.operations)
        .sum();
    let _ = writeln!(text, "  {total} operations in all\n");
    let _ = writeln!(
        text,
        "derivation            {:.1} ms at compile time",
        declaration.derivation_seconds * 1e3
    );
    let _ = writeln!(text, "compilation of models {}", compilation());
    Ok(Report {
        text,
        diagnoses: Vec::new(),
    })
}

/// Time from the first derivation to the finished library.
fn compilation() -> String {
    let started = scenes()
        .iter()
        .flat_map(|scene| scene.variants)
        .map(|variant| (variant.model)().declaration().expanded_at)
        .fold(f64::INFINITY, f64::min);
    LIBRARY_FINISHED
        .map(|finished| finished - started)
        .filter(|elapsed| (0.0..LONGEST_COMPILATION).contains(elapsed))
        .map_or_else(
            || "unknown".to_owned(),
            |elapsed| format!("{elapsed:.2} s from the first derivation to the finished library"),
        )
}

/// The sparsity patterns of all derivatives.
fn patterns(declaration: &Declaration) -> String {
    let rates = declaration
        .coordinates
        .iter()
        .map(|c| format!("{}'", c.name));
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
    text += &pattern(
        "Jacobian of the free acceleration",
        &declaration.free_jacobian,
        &with("", "''"),
        &inputs,
    );
    text += &pattern(
        "Hessian of the free acceleration, lower triangle",
        &declaration.free_hessian,
        &inputs,
        &inputs,
    );
    for contact in declaration.contacts {
        let mut rows = vec!["gap".to_owned(), "gap'".to_owned()];
        rows.extend(with("direction ", ""));
        text += &pattern(
            &format!("Jacobian of contact `{}`", contact.name),
            &contact.jacobian,
            &rows,
            &inputs,
        );
        text += &pattern(
            &format!("Hessian of contact `{}`, lower triangle", contact.name),
            &contact.hessian,
            &inputs,
            &inputs,
        );
    }
    text
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
