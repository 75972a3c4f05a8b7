//! How load time, simulation and memory grow with the number of bodies and contacts.
//!
//! ```sh
//! cargo bench --bench contacts                            # all families and methods
//! cargo bench --bench contacts -- --family discs --limit 60 --most 20
//! cargo bench --bench contacts -- --out growth --peers peers.csv
//! ```
//!
//! A row is a family of scenes with `n` bodies: contacts, CPU time to load the text, then of one run of each method, with the
//! exponent of that in the number of contacts since the row before (of bodies where contacts do not grow), and the most memory that
//! loading and running took. Each cell is measured in a program of its own. A method that takes longer than the limit \[s\], or
//! does not solve a scene, is not asked for larger ones; what it ends with stands in its place.
//!
//! `--out` writes the rows as `contacts.csv` and as a chart, `contacts.svg`, into that folder; `--peers` adds the rows of a file of
//! the same columns, as `tools/peers/contacts.py` writes them.

mod chart;
mod families;
mod measure;
mod row;

use row::{Row, exponent};
use std::path::Path;

/// A family of scenes.
pub(crate) struct Family {
    /// Its name.
    pub(crate) name: &'static str,
    /// The scene of `n` bodies.
    pub(crate) text: fn(usize) -> String,
    /// Numbers of bodies that are measured.
    pub(crate) sizes: &'static [usize],
}

/// All families.
pub(crate) const FAMILIES: [Family; 9] = [
    Family {
        name: "cradle, elastic",
        text: |n| families::row(n, "restitution 1", 1.0),
        sizes: &[2, 5, 10, 20, 50, 100, 200],
    },
    Family {
        name: "row, inelastic",
        text: |n| families::row(n, "inelastic", 1.0),
        sizes: &[2, 5, 10, 20, 50, 100, 200],
    },
    Family {
        name: "tower of boxes",
        text: families::tower,
        sizes: &[2, 5, 10, 20, 50, 100],
    },
    Family {
        name: "stack of boxes that tilt",
        text: families::stack,
        sizes: &[2, 5, 10, 20, 50, 100],
    },
    Family {
        name: "blocks on a rough floor",
        text: families::rough_blocks,
        sizes: &[2, 5, 10, 20, 50],
    },
    Family {
        name: "discs in a box, all pairs",
        text: families::discs,
        sizes: &[2, 5, 10, 20, 50],
    },
    Family {
        name: "chain above a floor",
        text: families::chain,
        sizes: &[2, 5, 10, 20, 40, 60, 100],
    },
    Family {
        name: "hanging chain",
        text: |n| families::hanging(n, |i| 0.8 + 0.02 * i as f64, 1.0),
        sizes: &[2, 5, 10, 20, 40, 60, 100],
    },
    Family {
        name: "elastic bar",
        text: families::bar,
        sizes: &[2, 5, 10, 20, 50, 100, 200],
    },
];

/// The value that follows an option.
fn option(name: &str) -> Option<String> {
    let mut arguments = std::env::args().skip_while(|argument| argument != name);
    arguments.nth(1)
}

/// The rows of a family, which are printed as they are measured.
fn measured(family: &Family, most: usize, limit: f64) -> Vec<Row> {
    let mut rows: Vec<Row> = Vec::new();
    let mut stopped = [false; measure::METHODS.len()];
    println!("\n{}", family.name);
    println!(
        "     n contacts   load [s]   default [s]  exp    event [s]  exp   moreau [s]  exp  memory [MB]"
    );
    for &n in family.sizes.iter().filter(|&&n| n <= most) {
        let mut known: Option<Row> = None;
        let mut memory = 0.0_f64;
        let mut line = String::new();
        for (method, stopped) in measure::METHODS.into_iter().zip(&mut stopped) {
            if *stopped {
                line.push_str("            -     ");
                continue;
            }
            let row = measure::in_a_program(family.name, n, method, limit);
            memory = memory.max(row.memory);
            if row.ended.is_empty() {
                *stopped = row.seconds > limit;
                let before = rows
                    .iter()
                    .rfind(|before| before.method == method && before.ended.is_empty());
                line.push_str(&match before.and_then(|before| exponent(before, &row)) {
                    Some(exponent) => format!("  {:11.4} {exponent:4.1}", row.seconds),
                    None => format!("  {:11.4}     ", row.seconds),
                });
            } else {
                *stopped = true;
                line.push_str(&format!("  {:>16}", row.ended));
            }
            known = Some(row.clone());
            rows.push(row);
        }
        let Some(row) = known else { break };
        println!(
            "{n:6} {:8}  {:9.3}{line}  {memory:11.1}",
            row.contacts, row.load
        );
    }
    rows
}

fn main() {
    if let Some(child) = measure::child() {
        println!("{}", child.line());
        return;
    }
    let number = |name: &str| option(name).and_then(|text| text.parse::<f64>().ok());
    let limit = number("--limit").unwrap_or(30.0);
    let most = number("--most").map_or(usize::MAX, |most| most as usize);
    let wanted = option("--family").unwrap_or_default();
    let families = FAMILIES.iter();
    let mut rows: Vec<Row> = families
        .filter(|family| family.name.contains(&wanted))
        .flat_map(|family| measured(family, most, limit))
        .collect();
    if let Some(peers) = option("--peers").and_then(|file| std::fs::read_to_string(file).ok()) {
        rows.extend(peers.lines().filter_map(Row::read));
    }
    if let Some(folder) = option("--out") {
        let folder = Path::new(&folder);
        let written = std::fs::create_dir_all(folder)
            .and_then(|()| std::fs::write(folder.join("contacts.csv"), row::table(&rows)))
            .and_then(|()| std::fs::write(folder.join("contacts.svg"), chart::drawn(&rows)));
        match written {
            Ok(()) => println!("\n{}", folder.join("contacts.svg").display()),
            Err(error) => eprintln!("{}: {error}", folder.display()),
        }
    }
}
