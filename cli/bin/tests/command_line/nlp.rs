//! `nlp`: programs from `.nl` files.

use crate::support::{Scratch, hangtime, json, refused, solved, unsolved};

/// `min (x - 2)^2 + (y - 1)^2` where `y - s >= 0` complements `x >= 0`: 1 at `(2, 0)` for `s = 0`; no point for `y <= 1`,
/// `x >= 1` and `s = 3`.
pub(crate) fn file(s: f64, x: &str, y: &str) -> String {
    let words = format!(
        "C0 o1 v1 n{s} O0 0 o0 o5 o1 v0 n2 n2 o5 o1 v1 n1 n2 r \"5 1 1\" b \"{x}\" \"{y}\""
    );
    let heading = "g3 1 1 0\n 2 1 1 0 0\n 0 1 1\n 0 0\n 0 2 0\n 0 0 0 1\n 0 0 0 0 0\n 0 0\n 0 0\n 0 0 0 0 0\n";
    heading.to_owned() + &words.replace(['"'], "").replace(' ', "\n") + "\n"
}

#[test]
fn nlp_prints_a_summary_and_one_json_object_with_the_keys_of_solve() {
    let scratch = Scratch::new("nlp");
    let path = scratch.write("two.nl", file(0.0, "2 0", "3"));
    let text = solved(&format!("nlp {path}"));
    for words in [
        "1 pair",
        "status        solved",
        "stationarity  S",
        "CPU time",
    ] {
        assert!(text.contains(words), "`{words}` is missing in\n{text}");
    }
    let document = json(&format!("nlp {path} --json"));
    assert_eq!(document["schema"], 1);
    assert_eq!(document["status"], "solved");
    assert_eq!(document["size"]["complementarities"], 1);
    assert_eq!(document["residuals"]["complementarity"], 0.0);
    assert!((document["objective"].as_f64().unwrap() - 1.0).abs() < 1e-8);
    assert!((document["x"][0].as_f64().unwrap() - 2.0).abs() < 1e-6);
    assert!(document["iterations"]["interior_point"].as_u64().unwrap() > 0);
    assert!(document["seconds"]["total"].as_f64().unwrap() > 0.0);
}

#[test]
fn nlp_writes_the_solution_file_that_modelling_languages_read() {
    let scratch = Scratch::new("nlp-sol");
    let path = scratch.write("two.nl", file(0.0, "2 0", "3"));
    let sol = scratch.0.join("two.sol");
    let text = solved(&format!("nlp {path} --sol {}", sol.display()));
    assert!(text.contains("wrote "), "{text}");
    let lines: Vec<String> = scratch.read("two.sol").lines().map(str::to_owned).collect();
    assert_eq!(
        lines[2..11],
        ["Options", "3", "1", "1", "0", "1", "1", "2", "2"]
    );
    assert!((lines[12].parse::<f64>().unwrap() - 2.0).abs() < 1e-6);
    assert_eq!(lines.last().unwrap(), "objno 0 0");
}

#[test]
fn nlp_without_a_feasible_point_says_what_is_violated_and_ends_with_status_3() {
    let scratch = Scratch::new("nlp-infeasible");
    let path = scratch.write("none.nl", file(3.0, "2 1", "1 1"));
    scratch.write("none.row", "balance\n");
    let (document, stderr) = unsolved(&format!("nlp {path} --json"));
    assert!(
        stderr.contains("infeasible") && stderr.contains("balance"),
        "{stderr}"
    );
    // y <= 1, but y >= 3
    assert!((document["residuals"]["primal"].as_f64().unwrap() - 2.0).abs() < 1e-3);
}

#[test]
fn nlp_writes_its_solution_whole_or_leaves_what_there_was() {
    let scratch = Scratch::new("nlp-whole");
    let path = scratch.write("two.nl", file(0.0, "2 0", "3"));
    let sol = scratch.write("two.sol", "older");
    let text = solved(&format!("nlp {path} --sol {sol}"));
    assert!(text.contains("replaced "), "{text}");
    assert!(scratch.read("two.sol").ends_with("objno 0 0\n"));
    assert_eq!(scratch.names(), ["two.nl", "two.sol"]);
    // Refused before the run, as an output directory is.
    let below = format!("{path}/two.sol");
    for target in [scratch.text(), below.as_str()] {
        let line = refused(&format!("nlp {path} --sol {target}"));
        assert!(line.contains("give"), "{line}");
    }
    assert_eq!(scratch.names(), ["two.nl", "two.sol"]);
}

#[cfg(unix)]
#[test]
fn nlp_writes_into_a_link_without_touching_what_it_leads_to() {
    let scratch = Scratch::new("nlp-link");
    let path = scratch.write("two.nl", file(0.0, "2 0", "3"));
    scratch.write("precious", "keep");
    let sol = scratch.0.join("two.sol");
    std::os::unix::fs::symlink("precious", &sol).unwrap();
    solved(&format!("nlp {path} --sol {}", sol.display()));
    assert_eq!(scratch.read("precious"), "keep");
    assert!(scratch.read("two.sol").ends_with("objno 0 0\n"));
}

#[cfg(unix)]
#[test]
fn nlp_shows_names_of_files_without_obeying_them() {
    let scratch = Scratch::new("nlp-steering");
    let name = "a\u{1b}[2J\u{9b}31m\u{202e}\nstatus b.nl";
    let path = scratch.write(name, file(0.0, "2 0", "3"));
    let steers = |c: char| c.is_control() && c != '\n' || c == '\u{202e}';
    let text = solved(vec!["nlp", &path]);
    assert!(!text.contains(steers), "{text:?}");
    assert!(
        text.lines().next().unwrap().ends_with("status b.nl"),
        "{text:?}"
    );
    let said = hangtime(vec!["nlp", &path, "--json"]);
    assert!(!said.out.contains(steers), "{:?}", said.out);
    let document = said.json();
    assert_eq!(document["file"], path.as_str());
}

#[test]
fn nlp_keeps_its_own_program_from_being_replaced() {
    let scratch = Scratch::new("nlp-own");
    let text = file(0.0, "2 0", "3");
    let path = scratch.write("two.nl", &text);
    let other = scratch.0.join("./two.nl");
    for sol in [path.as_str(), other.to_str().unwrap()] {
        let line = refused(&format!("nlp {path} --sol {sol}"));
        assert!(line.contains("the program itself"), "{line}");
    }
    assert_eq!(scratch.read("two.nl"), text);
}

#[cfg(unix)]
#[test]
fn nlp_beyond_the_limit_on_the_size_of_files_says_so_and_leaves_none() {
    let scratch = Scratch::new("nlp-limit");
    // 3000 free variables, whose values take more than 1 kB
    let count = 3000;
    let path = scratch.write("many.nl",
        format!(
            "g3 1 1 0\n {count} 0 1 0 0\n 0 1\n 0 0\n 0 1 0\n 0 0 0 1\n 0 0 0 0 0\n 0 0\n 0 0\n 0 0 0 0 0\nO0 0\no5\nv0\nn2\nb\n{}",
            "3\n".repeat(count)
        ),
    );
    let sol = scratch.0.join("many.sol");
    let command = format!(
        "ulimit -f 1; exec '{}' nlp '{path}' --sol '{}'",
        env!("CARGO_BIN_EXE_hangtime"),
        sol.display()
    );
    let output = std::process::Command::new("sh")
        .args(["-c", &command])
        .output()
        .unwrap();
    assert_eq!(output.status.code(), Some(2), "{output:?}");
    let stderr = String::from_utf8(output.stderr).unwrap();
    assert!(
        stderr.contains("many.sol") && stderr.contains("no file was written"),
        "{stderr}"
    );
    assert_eq!(scratch.names(), ["many.nl"]);
}
