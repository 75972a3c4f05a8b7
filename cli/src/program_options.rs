//! The options of a solve of a program from a file, by name, as modelling languages and other hosts give them.

use hangtime::nl;

use crate::failure::did_you_mean;

/// The options, with what they are.
pub(crate) const OPTIONS: [(&str, &str); 6] = [
    (
        "tol",
        "bound of the optimality error, relative to the scale of the program at its start (1e-8)",
    ),
    (
        "constr_viol_tol",
        "bound of the violation of a solution, in the units of the program (1e-6)",
    ),
    ("max_iter", "most interior point iterations"),
    ("time_limit", "most seconds of wall-clock time"),
    ("starts", "points to start from; the best end is kept (1)"),
    (
        "warm_start",
        "whether multipliers in the file are started from: yes or no (yes)",
    ),
];

/// Other names of options, as solvers of the same kind have them.
const SYNONYMS: [(&str, &str); 5] = [
    ("tolerance", "tol"),
    ("maxit", "max_iter"),
    ("max_wall_time", "time_limit"),
    ("max_cpu_time", "time_limit"),
    ("timelim", "time_limit"),
];

/// Takes in one option; `others` are options that the caller knows beside these.
pub(crate) fn set(
    options: &mut nl::Options,
    name: &str,
    value: &str,
    others: &[(&str, &str)],
) -> Result<(), String> {
    let synonym = SYNONYMS.iter().find(|(other, _)| *other == name);
    let name = synonym.map_or(name, |(_, name)| *name);
    let number = |range: &str, fits: &dyn Fn(f64) -> bool| {
        let number: Option<f64> = value.parse().ok();
        number
            .filter(|number| fits(*number))
            .ok_or_else(|| wrong(name, value, range))
    };
    let count = |least: usize, most: usize| {
        let count: Option<usize> = value.parse().ok();
        let range = format!("a whole number from {least} to {most}");
        count
            .filter(|count| (least..=most).contains(count))
            .ok_or_else(|| wrong(name, value, &range))
    };
    let above_zero = |number: f64| number > 0.0;
    match name {
        "tol" => {
            options.tolerance = number("a number above 0 and below 1", &|v| v > 0.0 && v < 1.0)?;
        }
        "constr_viol_tol" => {
            options.constraint_tolerance = number("a number above 0", &above_zero)?;
        }
        "time_limit" => options.maximum_seconds = number("seconds above 0", &above_zero)?,
        "max_iter" => options.maximum_iterations = Some(count(0, 1_000_000)?),
        "starts" => options.starts = count(1, 10_000)?,
        "warm_start" => {
            options.warm = match value {
                "yes" | "1" => true,
                "no" | "0" => false,
                _ => return Err(wrong(name, value, "yes or no")),
            }
        }
        _ => {
            let known: Vec<_> = OPTIONS.iter().chain(others).collect();
            let meanings = known
                .iter()
                .map(|(name, meaning)| format!("{name} ({meaning})"));
            let meanings: Vec<String> = meanings.collect();
            let near = did_you_mean(name, known.iter().map(|(name, _)| *name));
            return Err(format!(
                "there is no option `{name}`{near}; options are {}",
                meanings.join(", ")
            ));
        }
    }
    Ok(())
}

/// A value that an option cannot have.
pub(crate) fn wrong(name: &str, value: &str, range: &str) -> String {
    format!("option `{name}`: found `{value}`; give {range}")
}
