//! Random scenes of the families of `benches/agreement`, as files: none is refused, independent methods agree, and in which order
//! surfaces are declared changes nothing.
//!
//! A small set runs with the other tests; the large one by
//! `HANGTIME_SCENES=1000 cargo test --workspace --test command_line random_scenes`.

#[path = "../../../../benches/agreement/draw.rs"]
#[allow(dead_code, reason = "what families of models draw")]
mod draw;
#[path = "../../../../benches/agreement/texts.rs"]
mod texts;

use serde_json::Value;

use self::draw::Draw;
use crate::support::{Scratch, hangtime};

/// How many scenes of each family run, unless the variable says how many.
const SCENES: u64 = 5;
const VARIABLE: &str = "HANGTIME_SCENES";
/// How many starts that differ by rounding tell how far a scene is determined.
const ROUNDED: u64 = 6;
/// How far they are moved, in units of the last place.
const UNITS: f64 = 4.0;

/// A scene with its contacts in the opposite order; laws, which name them, and the start stand behind.
fn turned(text: &str) -> String {
    let of = |begins: &[&str], line: &&str| begins.iter().any(|word| line.starts_with(word));
    let pick = |begins: &'static [&'static str]| text.lines().filter(move |line| of(begins, line));
    let surfaces: Vec<&str> = pick(&["surface", "dry friction"]).collect();
    let others = text.lines().filter(|line| {
        !of(
            &["surface", "dry friction", "impact", "start", "horizon"],
            line,
        )
    });
    let behind = pick(&["impact", "start", "horizon"]);
    let lines = others.chain(surfaces.into_iter().rev()).chain(behind);
    lines.collect::<Vec<_>>().join("\n")
}

/// A scene with numbers of its start that are wrong by a few units of the last place.
fn rounded(text: &str, draw: &mut Draw) -> String {
    let mut moved = |word: &str| {
        let number = word.trim_end_matches(',').parse::<f64>().ok()?;
        let moved = number * (1.0 + draw.between(-UNITS, UNITS) * f64::EPSILON);
        Some(format!(
            "{moved}{}",
            &word[word.trim_end_matches(',').len()..]
        ))
    };
    let lines = text.lines().map(|line| {
        let words = line.split(' ').map(|word| match line.starts_with("start") {
            true => moved(word).unwrap_or_else(|| word.to_owned()),
            false => word.to_owned(),
        });
        words.collect::<Vec<_>>().join(" ")
    });
    lines.collect::<Vec<_>>().join("\n")
}

/// What a run of the program says.
struct Run {
    status: String,
    /// Why it ended, on the standard error stream.
    message: String,
    q: Vec<f64>,
    error: f64,
}

fn run(file: &str, method: &str) -> Run {
    let said = hangtime(&format!("simulate {file} --json --time-limit 60s {method}"));
    let result: Value = serde_json::from_str(&said.out).unwrap_or_default();
    let numbers = result["final"]["q"].as_array().into_iter().flatten();
    Run {
        status: result["status"].as_str().unwrap_or("refused").to_owned(),
        message: said.err,
        q: numbers.filter_map(Value::as_f64).collect(),
        error: result["error_estimate"].as_f64().unwrap_or(0.0),
    }
}

/// Largest difference of two ends, relative to lengths of 1 m and angles of 1 rad or their own size.
fn apart(one: &Run, other: &Run) -> f64 {
    one.q.iter().zip(&other.q).fold(0.0, |most, (a, b)| {
        most.max((a - b).abs() / (1.0 + a.abs()))
    })
}

/// Largest difference of ends of a scene whose start is wrong by rounding: where it is a large one, a rounding decides which of several
/// motions is found (in piles, the order of impacts after infinitely many of them).
fn undetermined(folder: &Scratch, text: &str) -> f64 {
    let runs = (0..ROUNDED).map(|number| {
        let moved = rounded(text, &mut Draw::new("rounded", number));
        run(&folder.write("rounded.hang", moved), "")
    });
    let runs: Vec<Run> = runs.collect();
    let of = |one: &Run| runs.iter().map(|run| apart(one, run)).fold(0.0, f64::max);
    runs.iter().map(of).fold(0.0, f64::max)
}

/// What is wrong with a scene.
fn judge(folder: &Scratch, name: &str, text: &str) -> Option<String> {
    let other = turned(text);
    let straight = folder.write(&format!("{name}.hang"), text);
    let turned = folder.write(&format!("{name}-turned.hang"), &other);
    let default = run(&straight, "");
    let turned = run(&turned, "");
    let [event, moreau] = ["event", "moreau"].map(|m| run(&straight, &format!("--method {m}")));
    let all = [
        ("default", &default),
        ("turned", &turned),
        ("event", &event),
        ("moreau", &moreau),
    ];
    if let Some((which, run)) = all.into_iter().find(|(_, run)| run.status != "solved") {
        return Some(format!("{which}: {} {}", run.status, run.message));
    }
    // Located methods differ by what both allow, which an impact magnifies by its change of slope, some tens of times over a dozen
    // impacts; the order of surfaces changes a rounding. Time stepping is of first order; where an impact more or less decides, its
    // estimate says so.
    let bounds = [
        (
            "turned",
            &turned,
            1e-6 + 10.0 * (default.error + turned.error),
        ),
        ("event", &event, 1e-6 + 1e3 * (default.error + event.error)),
        ("moreau", &moreau, 0.05 + 30.0 * moreau.error),
    ];
    let far = bounds.into_iter().find(|(_, run, bound)| {
        let apart = apart(&default, run);
        let own = || undetermined(folder, text).max(undetermined(folder, &other));
        // Of several motions, roundings need not find those that are furthest apart.
        apart > *bound && apart > 2.0 * own()
    });
    far.map(|(which, run, _)| format!("{which}: {:e} apart", apart(&default, run)))
}

#[test]
fn random_scenes_run_by_methods_that_agree_in_any_order_of_their_surfaces() {
    let asked = std::env::var(VARIABLE).ok();
    let count = asked.map_or(SCENES, |count| count.parse().expect("a number of scenes"));
    let folder = Scratch::new("random-scenes");
    let mut wrong = Vec::new();
    for (family, _) in texts::FAMILIES {
        for number in 0..count {
            let text = texts::text(family, &mut Draw::new(family, number));
            let judged = judge(&folder, &format!("{family}-{number}"), &text);
            wrong.extend(judged.map(|what| format!("{family} {number}: {what}\n{text}")));
        }
    }
    assert!(
        wrong.is_empty(),
        "{} of them:\n{}",
        wrong.len(),
        wrong.join("\n")
    );
}
