//! How load time and simulation grow with the number of bodies and contacts.
//!
//! ```sh
//! cargo bench --bench contacts                            # all families and methods
//! cargo bench --bench contacts -- --family discs --limit 60 --most 20
//! ```
//!
//! A row is a family of scenes with `n` bodies: contacts, CPU time to load the text, then of one run of each method, with the
//! exponent of that in the number of contacts since the row before. A method that takes longer than the limit \[s\], or
//! does not solve a scene, is not asked for larger ones; what it ends with stands in its place.

mod families;

use std::time::Instant;

use hangtime::model::Model;
use hangtime::simulation::{EventDriven, Fesd, InitialValueProblem, Moreau, Simulator};
use hangtime_solver::clock::ThreadTime;

/// A family of scenes.
struct Family {
    /// Its name.
    name: &'static str,
    /// The scene of `n` bodies.
    text: fn(usize) -> String,
    /// Numbers of bodies that are measured.
    sizes: &'static [usize],
}

/// All families.
const FAMILIES: [Family; 7] = [
    Family {
        name: "cradle, elastic",
        text: |n| families::row(n, "restitution 1", 1.0),
        sizes: &[5, 10, 20, 50, 100],
    },
    Family {
        name: "row, inelastic",
        text: |n| families::row(n, "inelastic", 1.0),
        sizes: &[5, 10, 20, 50, 100],
    },
    Family {
        name: "tower of boxes",
        text: families::tower,
        sizes: &[5, 10, 20, 50],
    },
    Family {
        name: "stack of boxes that tilt",
        text: |n| families::stack(n, None),
        sizes: &[2, 5, 10, 20],
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
        sizes: &[2, 5, 10],
    },
];

/// The value that follows an option.
fn option(name: &str) -> Option<String> {
    let mut arguments = std::env::args().skip_while(|argument| argument != name);
    arguments.nth(1)
}

/// CPU time of a call \[s\].
fn timed<T>(call: impl FnOnce() -> T) -> (T, f64) {
    let clock = ThreadTime::try_now();
    let result = call();
    let elapsed = clock.and_then(|clock| clock.try_elapsed());
    (
        result,
        elapsed.map_or(f64::NAN, |elapsed| elapsed.as_secs_f64()),
    )
}

/// One run, its CPU time, and how it ended.
fn run(method: &dyn Simulator, model: &dyn Model, limit: f64) -> (f64, String) {
    let begin = Instant::now();
    let mut over = false;
    let (result, seconds) = timed(|| {
        let problem = InitialValueProblem::of(model, None)?;
        method.simulate(model, &problem, &mut |_| {
            over = begin.elapsed().as_secs_f64() > limit;
            !over
        })
    });
    let ended = match result {
        _ if over => "limit".to_owned(),
        Ok(run) if run.status.is_solved() => String::new(),
        Ok(run) => run.status.name().to_owned(),
        Err(error) => error.to_string(),
    };
    (seconds, ended)
}

/// The rows of a family.
fn measure(family: &Family, most: usize, limit: f64) {
    let methods: [(&str, &dyn Simulator); 3] = [
        ("default", &Fesd::default()),
        ("event", &EventDriven::default()),
        ("moreau", &Moreau::default()),
    ];
    let mut last: [Option<(f64, f64)>; 3] = [None; 3];
    let mut stopped = [false; 3];
    println!("\n{}", family.name);
    println!("     n contacts   load [s]   default [s]  exp    event [s]  exp   moreau [s]  exp");
    for &n in family.sizes.iter().filter(|&&n| n <= most) {
        let text = (family.text)(n);
        let (scene, load) = timed(|| hangtime_scene_files::of_text("scene.hang", &text));
        let scene = match scene {
            Ok(scene) => scene,
            Err(error) => {
                let line = error.to_string();
                println!(
                    "{n:6}          {load:9.3}   {}",
                    line.lines().next().unwrap_or_default()
                );
                break;
            }
        };
        let contacts = scene.declaration().contacts.len();
        print!("{n:6} {contacts:8}  {load:9.3}");
        for (k, (_, method)) in methods.iter().enumerate() {
            if stopped[k] {
                print!("            -     ");
                continue;
            }
            let (seconds, ended) = run(*method, &scene, limit);
            if !ended.is_empty() {
                stopped[k] = true;
                print!("  {ended:>16}");
                continue;
            }
            let exponent = last[k].map(|(before, then): (f64, f64)| {
                (seconds / then).ln() / (contacts as f64 / before).ln()
            });
            last[k] = Some((contacts as f64, seconds));
            stopped[k] = seconds > limit;
            match exponent {
                Some(exponent) => print!("  {seconds:11.4} {exponent:4.1}"),
                None => print!("  {seconds:11.4}     "),
            }
        }
        println!();
    }
}

fn main() {
    let limit = option("--limit")
        .and_then(|text| text.parse().ok())
        .unwrap_or(30.0);
    let most = option("--most")
        .and_then(|text| text.parse().ok())
        .unwrap_or(usize::MAX);
    let wanted = option("--family").unwrap_or_default();
    for family in FAMILIES
        .iter()
        .filter(|family| family.name.contains(&wanted))
    {
        measure(family, most, limit);
    }
}
