//! `hangtime sweep`: tables that are the same whoever computes them, in whatever pieces.

use std::process::Command;

use crate::support::{Scratch, hangtime, json, refused, solved};

/// A ball that falls on a floor from a height, where bounces follow from restitution.
const BALL: &str = "parameters { h: m = 1, e = 0.5 }\ncoordinates { z: m }\n\
     lagrangian 1[kg]/2*dot(z)^2 - 9.81[N]*z\nsurface floor: z >= 0\nimpact floor: restitution e\n\
     start { z: h }\nhorizon 0.6 [s]\n";

/// A folder with the scene and room for tables.
fn folder(name: &str) -> Scratch {
    let scratch = Scratch::new(name);
    std::fs::create_dir_all(&scratch.0).unwrap();
    std::fs::write(scratch.0.join("ball.hang"), BALL).unwrap();
    scratch
}

/// The words of a sweep of the ball, with its table in the folder.
fn words(scratch: &Scratch, table: &str, more: &[&str]) -> Vec<String> {
    let text = scratch.text();
    let (scene, out) = (format!("{text}/ball.hang"), format!("{text}/{table}"));
    let fixed = [
        "sweep",
        &scene,
        "--over",
        "h=20:180:9cm",
        "--over",
        "e=0,0.5,1.5",
    ];
    let records = [
        "--record",
        "final.z,final.dot(z),final_time,events",
        "--out",
        &out,
    ];
    let words = fixed.iter().chain(&records).chain(more);
    words.map(|&word| word.to_owned()).collect()
}

fn sweep(scratch: &Scratch, table: &str, more: &[&str]) -> String {
    let words = words(scratch, table, more);
    solved(&words.iter().map(String::as_str).collect::<Vec<_>>());
    scratch.read(table)
}

#[test]
fn row_holds_the_digits_of_a_single_run_and_a_point_that_is_refused_says_why() {
    let scratch = folder("sweep-rows");
    let table = sweep(&scratch, "t.csv", &[]);
    let lines: Vec<&str> = table.lines().collect();
    assert_eq!(lines.len(), 1 + 9 * 3);
    assert!(lines[0].starts_with(
        "point,h [m],e,status,message,sequence,final.z [m],final.dot(z) [m/s],final_time [s],events,sweep"
    ));
    // Point 13: h = 1 m, e = 0.5. One fall of sqrt(2 h/g), then a bounce.
    let cells: Vec<&str> = lines[14].split(',').collect();
    assert_eq!(&cells[..4], ["13", "1", "0.5", "solved"]);
    let scene = format!("{}/ball.hang", scratch.text());
    let single = json(&[
        "simulate", &scene, "--set", "h=1", "--set", "e=0.5", "--json",
    ]);
    assert_eq!(cells[6], single["final"]["q"][0].to_string());
    assert_eq!(cells[7], single["final"]["v"][0].to_string());
    let (g, t) = (9.81_f64, 0.6_f64);
    let fall = (2.0 / g).sqrt();
    let z = 0.5 * g * fall * (t - fall) - g / 2.0 * (t - fall).powi(2);
    assert!((cells[6].parse::<f64>().unwrap() - z).abs() < 1e-6);
    assert_eq!(cells[5], "impact floor");
    assert!(lines[15].contains(",refused,") && lines[15].contains("restitution"));
}

#[test]
fn table_is_the_same_for_any_threads_in_shards_and_after_a_run_that_was_cut() {
    let scratch = folder("sweep-same");
    let whole = sweep(&scratch, "whole.csv", &[]);
    for threads in ["1", "3"] {
        let name = format!("threads-{threads}.csv");
        let status = Command::new(env!("CARGO_BIN_EXE_hangtime"))
            .args(words(&scratch, &name, &[]))
            .env("RAYON_NUM_THREADS", threads)
            .output()
            .unwrap()
            .status;
        assert!(status.success());
        assert_eq!(scratch.read(&name), whole);
    }
    let mut join = vec!["sweep".to_owned(), "--join".to_owned()];
    for shard in 1..=4 {
        let name = format!("shard-{shard}.csv");
        sweep(&scratch, &name, &["--shard", &format!("{shard}/4")]);
        join.push(format!("{}/{name}", scratch.text()));
    }
    let incomplete: Vec<&str> = join[..5].iter().map(String::as_str).collect();
    let out = format!("{}/joined.csv", scratch.text());
    let refusal = refused(&[&incomplete[..], &["--out", &out]].concat());
    assert!(refusal.contains("first of them is 3"), "{refusal}");
    let all: Vec<&str> = join.iter().map(String::as_str).collect();
    solved(&[&all[..], &["--out", &out]].concat());
    assert_eq!(scratch.read("joined.csv"), whole);
    // Wherever a run was cut, also within a row or the header, the resumed table is the same.
    for cut in [0, 7, whole.len() / 3, whole.len() - 1, whole.len()] {
        std::fs::write(scratch.0.join("cut.csv"), &whole[..cut]).unwrap();
        assert_eq!(sweep(&scratch, "cut.csv", &["--resume"]), whole);
    }
}

#[test]
fn killed_sweep_leaves_the_beginning_of_the_table() {
    let scratch = folder("sweep-killed");
    let more = ["--", "--method", "moreau", "--steps", "20000"];
    let whole = sweep(&scratch, "whole.csv", &more);
    let mut child = Command::new(env!("CARGO_BIN_EXE_hangtime"))
        .args(words(&scratch, "killed.csv", &more))
        .spawn()
        .unwrap();
    let path = scratch.0.join("killed.csv");
    // Until the table has begun, or the sweep is over.
    while std::fs::metadata(&path).map_or(0, |file| file.len()) < 400 {
        if child.try_wait().unwrap().is_some() {
            break;
        }
        std::thread::yield_now();
    }
    let _ = child.kill();
    child.wait().unwrap();
    let left = scratch.read("killed.csv");
    assert!(whole.starts_with(&left), "{left}");
    let more = [&["--resume"], &more[..]].concat();
    assert_eq!(sweep(&scratch, "killed.csv", &more), whole);
}

#[test]
fn sweep_refuses_tables_of_others_and_names_what_is_wrong() {
    let scratch = folder("sweep-refusals");
    let whole = sweep(&scratch, "t.csv", &[]);
    let refusal_of = |table: &str, more: &[&str]| {
        let words = words(&scratch, table, more);
        refused(&words.iter().map(String::as_str).collect::<Vec<_>>())
    };
    assert!(refusal_of("t.csv", &[]).contains("add --resume"));
    let other = ["--resume", "--", "--method", "event"];
    assert!(refusal_of("t.csv", &other).contains("another sweep"));
    assert_eq!(scratch.read("t.csv"), whole, "a refusal leaves the table");
    assert!(refusal_of("u.csv", &["--what", "solve"]).contains("no objective"));
    assert!(refusal_of("u.csv", &["--record", "final.y"]).contains("final.z"));
    assert!(refusal_of("u.csv", &["--shard", "5/4"]).contains("1 <= I <= N"));
    assert!(refusal_of("u.csv", &["--over", "h=1,2"]).contains("given twice"));
    assert!(refusal_of("no/u.csv", &[]).contains("file that can be written"));
    assert!(!scratch.0.join("u.csv").exists());
    let output = hangtime(&["sweep", "--out", "t.csv"]);
    assert_eq!(output.status.code(), Some(2));
}

#[test]
fn table_has_one_writer_and_what_is_none_of_its_beginnings_is_left_as_it_is() {
    let scratch = folder("sweep-one-writer");
    let whole = sweep(&scratch, "t.csv", &[]);
    let path = scratch.0.join("t.csv");
    let refusal_of = |table: &str, more: &[&str]| {
        let words = words(&scratch, table, more);
        refused(&words.iter().map(String::as_str).collect::<Vec<_>>())
    };
    let writer = std::fs::OpenOptions::new()
        .append(true)
        .open(&path)
        .unwrap();
    writer.lock().unwrap();
    assert!(refusal_of("t.csv", &["--resume"]).contains("another sweep writes"));
    drop(writer);
    assert_eq!(sweep(&scratch, "t.csv", &["--resume"]), whole);
    // Files of something else, with or without ends of lines, and rows behind the last one.
    let cut = &whole[..whole.rfind("\n26,").unwrap() + 3];
    let foreign = [
        "notes".to_owned(),
        "notes\n".to_owned(),
        "point,x\n".to_owned(),
        cut.to_owned() + "x",
        whole.clone() + "27,",
    ];
    for text in foreign {
        std::fs::write(&path, &text).unwrap();
        assert!(
            refusal_of("t.csv", &["--resume"]).contains("another sweep"),
            "{text}"
        );
        assert_eq!(scratch.read("t.csv"), text);
    }
}

#[cfg(unix)]
#[test]
fn what_is_no_file_is_refused_before_it_is_read_and_joined_tables_have_usual_modes() {
    use std::os::unix::fs::{FileTypeExt as _, PermissionsExt as _};
    let scratch = folder("sweep-no-file");
    let pipe = scratch.0.join("pipe.csv");
    let made = Command::new("mkfifo").arg(&pipe).status().unwrap();
    assert!(made.success());
    let part = sweep(&scratch, "part.csv", &[]);
    let (part_path, pipe) = (
        format!("{}/part.csv", scratch.text()),
        pipe.to_str().unwrap(),
    );
    for out in [pipe, "/dev/full", "/dev/zero", scratch.text()] {
        for resume in [&[][..], &["--resume"]] {
            let over = ["sweep", "ski-jump", "--over", "m=1,2", "--out", out];
            let refusal = refused(&[&over[..], resume].concat());
            assert!(refusal.contains("this is no file"), "{refusal}");
        }
        let refusal = refused(&["sweep", "--join", &part_path, "--out", out]);
        assert!(refusal.contains("this is no file"), "{refusal}");
    }
    assert!(refused(&["sweep", "--join", pipe, "--out", "x.csv"]).contains("this is no file"));
    assert!(
        std::fs::metadata("/dev/full")
            .unwrap()
            .file_type()
            .is_char_device()
    );
    // So are tables of measurements, of profiles and programs, within any time.
    let scene = scratch.0.join("fitted.hang");
    let fitted = BALL.replace(
        "horizon",
        "measured m: \"pipe.csv\" { z within 1 [cm] }\nminimize misfit(m)\nhorizon",
    );
    std::fs::write(
        &scene,
        fitted.replace(
            "parameters { h: m = 1, ",
            "free h: m in 0..=2 = 1\nparameters { ",
        ),
    )
    .unwrap();
    assert!(refused(&["solve", scene.to_str().unwrap()]).contains("this is no file"));
    assert!(refused(&["profile", pipe]).contains("this is no file"));
    assert!(refused(&["nlp", pipe]).contains("this is no file"));
    let joined = format!("{}/joined.csv", scratch.text());
    solved(&["sweep", "--join", &part_path, "--out", &joined]);
    let mode = |path: &str| std::fs::metadata(path).unwrap().permissions().mode();
    assert_eq!(mode(&joined), mode(&part_path));
    assert_eq!(scratch.read("joined.csv"), part);
}

#[cfg(unix)]
#[test]
fn interrupted_sweep_ends_at_once_and_says_how_to_go_on() {
    let scratch = folder("sweep-interrupted");
    // A point takes seconds.
    let more = ["--", "--method", "moreau", "--steps", "1000000"];
    let mut child = Command::new(env!("CARGO_BIN_EXE_hangtime"))
        .args(words(&scratch, "t.csv", &more))
        .stdout(std::process::Stdio::null())
        .stderr(std::process::Stdio::piped())
        .spawn()
        .unwrap();
    let path = scratch.0.join("t.csv");
    // The table is opened right before Ctrl-C is listened to.
    while std::fs::metadata(&path).map_or(0, |file| file.len()) == 0 {
        assert_eq!(child.try_wait().unwrap(), None);
        std::thread::yield_now();
    }
    std::thread::sleep(std::time::Duration::from_millis(300));
    let pressed = std::time::Instant::now();
    let sent = Command::new("kill")
        .args(["-INT", &child.id().to_string()])
        .status();
    assert!(sent.unwrap().success());
    let output = child.wait_with_output().unwrap();
    // Ten times what it takes, for busy machines.
    assert!(pressed.elapsed() < std::time::Duration::from_secs(2));
    let stderr = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(3), "{stderr}");
    assert!(
        stderr.contains("interrupted: 0 of 27 points are in"),
        "{stderr}"
    );
    assert!(stderr.contains("go on with --resume"), "{stderr}");
    assert_eq!(scratch.read("t.csv").lines().count(), 1);
}

/// A cart that is pushed over a distance in least time, from rest to rest: `2 sqrt(m d/F)`.
const CART: &str = "parameters { m: kg = 2, d: m = 1 }\ncoordinates { y: m }\ncontrols { u: N in -1..=1 }\n\
     lagrangian m/2*dot(y)^2\nforces { y: u }\nminimize time\nstart { y: 0 }\nfinally { y == d, dot(y) == 0 }\n";

/// The table of a warm sweep over 2 x 7 points in chains of three, written to a file of the folder.
fn warm(scratch: &Scratch, table: &str, more: &[&str]) -> String {
    let (scene, out) = (
        format!("{}/cart.hang", scratch.text()),
        format!("{}/{table}", scratch.text()),
    );
    let fixed = [
        "sweep", &scene, "--what", "solve", "--warm=3", "--out", &out,
    ];
    let over = ["--over", "m=2,2.7", "--over", "d=0.4:1.6:7"];
    let last = ["--record", "objective", "--", "--intervals", "6"];
    solved(&[&fixed[..], &over, more, &last].concat());
    scratch.read(table)
}

#[test]
fn warm_sweep_starts_points_from_each_other_whoever_computes_them() {
    let scratch = folder("sweep-warm");
    std::fs::write(scratch.0.join("cart.hang"), CART).unwrap();
    let whole = warm(&scratch, "whole.csv", &[]);
    let rows: Vec<&str> = whole.lines().skip(1).collect();
    assert_eq!(rows.len(), 14);
    for (k, row) in rows.iter().enumerate() {
        let cells: Vec<&str> = row.split(',').collect();
        let [number, m, d, objective] =
            [0, 1, 2, 6].map(|place| cells[place].parse::<f64>().unwrap());
        assert_eq!(number, k as f64);
        assert_eq!(cells[3], "solved");
        // The tolerance of the solver is 1e-8, and the plan is polished.
        assert!((objective - 2.0 * (m * d).sqrt()).abs() < 1e-7, "{row}");
    }
    // Chains are 0..3, 3..6, 6..7 and the same of the other mass: six of them for two shards.
    let mut join = vec!["sweep".to_owned(), "--join".to_owned()];
    for shard in ["1/2", "2/2"] {
        let name = format!("s{}.csv", &shard[..1]);
        let table = warm(&scratch, &name, &["--shard", shard]);
        let first = table.lines().nth(1).unwrap().to_owned();
        assert_eq!(first, rows[if shard == "1/2" { 0 } else { 3 }]);
        join.push(format!("{}/{name}", scratch.text()));
    }
    let out = format!("{}/joined.csv", scratch.text());
    join.extend(["--out".to_owned(), out]);
    solved(&join.iter().map(String::as_str).collect::<Vec<_>>());
    assert_eq!(scratch.read("joined.csv"), whole);
    // Cut within a chain, it is computed anew from its first point on.
    for lines in [3, 6] {
        let cut: String = whole.split_inclusive('\n').take(lines).collect();
        std::fs::write(scratch.0.join("cut.csv"), cut).unwrap();
        assert_eq!(warm(&scratch, "cut.csv", &["--resume"]), whole);
    }
}

#[test]
fn warm_sweep_is_refused_where_nothing_is_handed_on() {
    let scratch = folder("sweep-warm-refused");
    let words = |more: &[&str]| words(&scratch, "t.csv", more);
    let refusal =
        |more: &[&str]| refused(&words(more).iter().map(String::as_str).collect::<Vec<_>>());
    assert!(refusal(&["--warm"]).contains("--what solve"));
    assert!(refusal(&["--warm=1"]).contains("at least 2"));
    let out = format!("{}/u.csv", scratch.text());
    // The last parameter chooses a form of the scene.
    let choice = refused(&[
        "sweep",
        "pump-track",
        "--what",
        "solve",
        "--warm",
        "--over",
        "speed=4,5",
        "--over",
        "law=holding",
        "--out",
        &out,
    ]);
    assert!(choice.contains("`law`"), "{choice}");
}
