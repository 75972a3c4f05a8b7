//! `solve`.

use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use serde_json::Value;

use crate::support::{
    Scratch, assert_page_shows_its_ride, hangtime, json, program, result_files, solved,
};

/// What `solve` says from one start of a scene with this text, as JSON and as tables.
fn said(scratch: &Scratch, text: &str, more: &str) -> (Value, String) {
    let file = scratch.write("scene.hang", text);
    let line = format!("solve {file} --starts 1 {more}");
    (json(&format!("{line} --json")), solved(&line))
}

fn notes_of(document: &Value) -> Vec<String> {
    let notes = document["notes"].as_array().unwrap().iter();
    notes
        .map(|note| note.as_str().unwrap().to_owned())
        .collect()
}

/// A cart passes a narrow magnet, which one finite element of an interval cannot follow.
#[test]
fn solve_says_how_many_elements_a_plan_has_where_they_are_more_than_asked_for() {
    let scratch = Scratch::new("solve-elements");
    let notes = |depth: f64| -> (Vec<String>, String) {
        let text = format!(
            "coordinates {{ y }} controls {{ u }} lagrangian dot(y)^2/2 + {depth}*exp(-((y - 0.3)/0.02)^2/2) \
             forces {{ y: u }} minimize integral(u^2) finally {{ y == 1, dot(y) == 0 }} horizon 1"
        );
        let (document, tables) = said(&scratch, &text, "--intervals 8");
        (notes_of(&document), tables)
    };
    let (notes_with, tables_with) = notes(0.2);
    let note = notes_with
        .iter()
        .find(|note| note.ends_with("finite elements of a phase instead of 1"));
    assert!(tables_with.contains(note.unwrap()), "{tables_with}");
    let (notes_without, tables_without) = notes(0.0);
    assert!(notes_without.is_empty(), "{notes_without:?}");
    assert!(
        !tables_without.contains("finite elements"),
        "{tables_without}"
    );
}

#[test]
fn solve_says_what_keeping_a_distance_costs() {
    let scratch = Scratch::new("solve-margins");
    let text = "coordinates { y: m, z: m } lagrangian 1 [kg]/2*|dot((y, z))|^2 - 9.81 [N]*z \
                surface roof: z >= 3 [m] - |2*y| impact roof: inelastic minimize 1 [kg]/2*|dot((y, z))|^2 \
                finally { y == 3 [m], z == 1 [m], time <= 5 [s] } free { dot(y) in 0..=20, dot(z) in 0..=20 } \
                start { y: -3 [m], z: 0.5 [m], dot(y): 5, dot(z): 5 } horizon 1.5 [s]";
    let (document, tables) = said(&scratch, text, "");
    let margins = document["margins"].as_array().unwrap();
    assert_eq!(margins.len(), 1, "{margins:?}");
    let name = margins[0]["name"].as_str().unwrap();
    let (amount, unit) = (margins[0]["amount"].as_f64(), margins[0]["unit"].as_str());
    assert_eq!((amount, unit), (Some(1e-5), Some("m")));
    let cost = margins[0]["cost"].as_f64().unwrap();
    let line = format!("kept          {name}, 1.0e-5 m, which costs about {cost:.1e}\n");
    assert!(tables.contains(&line), "{tables}");
}

/// A ball that is struck at the start, and one that reaches its height only with controls that change where it bounces.
#[test]
fn solve_says_what_is_to_be_known_of_its_motion_and_when_controls_change() {
    let scratch = Scratch::new("solve-notes");
    for (start, goal, words) in [
        ("z: 0, dot(z): -3", "0.3", "`floor` is closed at the start"),
        ("z: 1", "2", "those of this one are aligned with its phases"),
    ] {
        let text = format!(
            "coordinates {{ z }} controls {{ u in 0..=5 }} lagrangian dot(z)^2/2 - 9.81*z forces {{ z: u }} surface floor: z >= 0 \
             impact floor: restitution 0.8 minimize time finally {{ z == {goal} }} start {{ {start} }} horizon 3"
        );
        let (document, tables) = said(&scratch, &text, "--intervals 10");
        let notes = notes_of(&document);
        let note = notes.iter().find(|note| note.contains(words));
        let line = format!("note          {}\n", note.unwrap());
        assert!(tables.contains(&line), "{tables}");
        assert_eq!(document["control_times"].as_array().unwrap().len(), 11);
    }
}

/// A door that has to be shut: its motion ends before it slams, unless it is to come to rest.
#[test]
fn solve_says_where_an_impact_follows_the_end() {
    let scratch = Scratch::new("solve-end");
    let tables = |goal: &str| {
        let text = format!(
            "coordinates {{ phi }} controls {{ u }} lagrangian dot(phi)^2/2 forces {{ phi: u }} surface frame: phi >= 0 \
             impact frame: inelastic minimize integral(u^2) finally {{ phi == 0{goal} }} start {{ phi: 1.5 }} horizon 1"
        );
        let (document, tables) = said(&scratch, &text, "--intervals 4");
        (notes_of(&document), tables)
    };
    let (notes, ends) = tables("");
    // 1.5 sum(w) h/sum(w^2) with the weights w = h (1 - t) in the middle of the intervals
    let note = "the motion ends right before `frame` is struck at 2.285714 1/s; that impact is no part of it";
    assert_eq!(notes, [note]);
    assert!(ends.contains(&format!("end           {note}\n")), "{ends}");
    let (notes, rests) = tables(", dot(phi) == 0");
    assert!(
        notes.is_empty() && !rests.contains("no part of it"),
        "{rests}"
    );
}

/// A cart of 2 kg is brought over 0.2 m from rest to rest in a time `T`, by linear controls with the effort
/// `12 m^2 s^2/T^3`; in least time, from whatever guess, by the forces at their bounds.
#[test]
fn solve_takes_a_length_or_the_guess_of_a_free_one() {
    let scratch = Scratch::new("solve-horizon");
    let cart = |least: &str| {
        let text = format!(
            "parameters {{ m: kg = 2, goal: m = 0.2 }} coordinates {{ y: m }} controls {{ u: N in -1..=1 }} \
             lagrangian m/2*dot(y)^2 forces {{ y: u }} minimize {least} \
             finally {{ y == goal, dot(y) == 0 }} horizon 2 [s]"
        );
        scratch.write("cart.hang", text)
    };
    let answer = |line: String| -> (f64, f64) {
        let document = json(&line);
        let number = |name: &str| document[name].as_f64().unwrap();
        (number("objective"), number("horizon"))
    };
    let little = cart("integral(u^2)");
    for (horizon, time) in [("4", 4.0), ("2500ms", 2.5)] {
        let line = format!("solve {little} --controls linear --json --horizon {horizon}");
        let (objective, length) = answer(line);
        let effort = 12.0 * 4.0 * 0.04 / f64::powi(time, 3);
        assert!(
            (objective - effort).abs() < 1e-6 * effort,
            "{objective} {effort}"
        );
        assert_eq!(length, time);
    }
    let fast = cart("time");
    let (objective, _) = answer(format!(
        "solve {fast} --intervals 10 --json --horizon 500ms"
    ));
    let least = 2.0 * (2.0_f64 * 0.2).sqrt();
    assert!((objective - least).abs() < 1e-6, "{objective} {least}");
}

#[test]
fn solve_json_has_the_numbers_of_the_publication() {
    let document = json("solve pump-track --set speed=15km/h --json");
    assert_eq!(document["status"], "solved");
    assert!((document["horizon"].as_f64().unwrap() - 1.4137689).abs() < 1e-6);
    assert_eq!(document["controls"].as_array().unwrap().len(), 30);
    assert_eq!(document["parameters"]["law"], "paper");
}

#[test]
fn solve_with_linear_controls_writes_a_value_for_each_node() {
    let document = json("solve pump-track --intervals 12 --controls linear --starts 1 --json");
    assert_eq!(document["method"]["control_shape"], "linear");
    let nodes = document["controls"].as_array().unwrap();
    assert_eq!(nodes.len(), 13);
    // The trajectory follows the line between the nodes.
    let numbers = |value: &Value| -> Vec<f64> {
        let values = value.as_array().unwrap().iter();
        values.map(|value| value.as_f64().unwrap()).collect()
    };
    let times = numbers(&document["trajectory"]["time"]);
    let length = document["horizon"].as_f64().unwrap() / 12.0;
    for (time, u) in times
        .iter()
        .zip(document["trajectory"]["u"].as_array().unwrap())
    {
        let node = ((time / length) as usize).min(11);
        let share = time / length - node as f64;
        let (from, to) = (numbers(&nodes[node])[0], numbers(&nodes[node + 1])[0]);
        let expected = from + share * (to - from);
        // Forces up to 400 N.
        assert!((numbers(u)[0] - expected).abs() < 1e-9, "{u} at {time}");
    }
}

#[test]
fn solve_with_out_writes_data_and_a_picture() {
    let scratch = Scratch::new("solve");
    let text = solved(&format!(
        "solve pump-track --intervals 12 --out {}",
        scratch.text()
    ));
    for words in [
        "final time",
        "dy/dt [m/s]",
        "stationarity  S",
        // 7.56 km/h as published; with fewer intervals than there it is a little less or more.
        "(published: +7.56 km/h)",
    ] {
        assert!(text.contains(words), "`{words}` is missing in\n{text}");
    }
    // Where a first motion was improved upon, how it was is drawn as well.
    let document: serde_json::Value =
        serde_json::from_str(&scratch.read("pump-track-optimal.json")).unwrap();
    let improved = document["improvements"].as_array().unwrap().len() > 1;
    let mut names = result_files("pump-track-optimal").to_vec();
    names.extend(improved.then(|| "pump-track-optimal-search.svg".to_owned()));
    names.sort();
    assert_eq!(scratch.names(), names);
    let page = scratch.read("pump-track-optimal.html");
    assert_eq!(page.contains("best objective over CPU time"), improved);
    assert_page_shows_its_ride(&scratch, "pump-track-optimal");
}

#[test]
fn solve_says_that_a_final_time_is_fixed_where_time_does_not_occur() {
    let scratch = Scratch::new("fixed");
    for (objective, fixed) in [("integral(u^2)", true), ("integral(u^2) + time", false)] {
        let scene = format!(
            "coordinates {{ x }}\ncontrols {{ u in -9..=9 }}\nlagrangian dot(x)^2/2\nforces {{ x: u }}\n\
             minimize {objective}\nfinally {{ x == 1, dot(x) == 0 }}\nhorizon 2\n"
        );
        let file = scratch.write("cart.hang", scene);
        let text = solved(&format!("solve {file} --intervals 2"));
        let line = text.lines().find(|line| line.starts_with("final time"));
        let line = line.unwrap();
        assert_eq!(
            line.contains(", fixed: `time` occurs neither"),
            fixed,
            "{line}"
        );
    }
}

/// Waits for what another process does.
fn wait_until(what: &str, condition: impl Fn() -> bool) {
    // Long enough for a machine with other work; only a broken program waits so long.
    let end = Instant::now() + Duration::from_secs(60);
    while !condition() {
        assert!(Instant::now() < end, "{what} did not happen");
        std::thread::sleep(Duration::from_millis(2));
    }
}

#[cfg(unix)]
#[test]
fn solve_interrupted_writes_what_it_has_and_ends_with_status_3() {
    let scratch = Scratch::new("interrupted");
    std::fs::create_dir(&scratch.0).unwrap();
    // So many intervals take far longer than the test waits.
    let child = program()
        .args("solve pump-track --intervals 2000 --json --out".split(' '))
        .arg(scratch.text())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    // The program listens before it makes its folder in the directory, so that no interrupt leaves one behind.
    wait_until("the folder of the run", || !scratch.names().is_empty());
    let killed = Command::new("kill")
        .args(["-INT", &child.id().to_string()])
        .status();
    assert!(killed.unwrap().success());
    let output = child.wait_with_output().unwrap();
    let stderr = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(3), "{stderr}");
    assert!(
        stderr.starts_with("error: pump-track: interrupted: stopped"),
        "{stderr}"
    );
    assert_eq!(stderr.lines().count(), 1, "{stderr}");
    let document: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(document["status"], "interrupted");
    let written: Value = serde_json::from_str(&scratch.read("pump-track-optimal.json")).unwrap();
    assert_eq!(written, document);
}

#[test]
fn solve_at_its_time_limit_ends_with_what_it_has() {
    let said = hangtime("solve pump-track --intervals 2000 --time-limit 300ms --json");
    assert_eq!(said.status, Some(3), "{}", said.err);
    let ended = "error: pump-track: time_limit: ended after 0.3 s; raise --time-limit";
    assert!(said.err.starts_with(ended), "{}", said.err);
    assert_eq!(said.err.lines().count(), 1, "{}", said.err);
    // The solver answers within the grace period, unless the machine is very busy.
    if !said.out.is_empty() {
        assert_eq!(said.json()["status"], "time_limit");
    }
}
