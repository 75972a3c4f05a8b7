//! `hangtime sweep`: tables that are the same whoever computes them, in whatever pieces.

use std::process::Command;

use crate::support::{Scratch, json, program, refused, solved};

/// A ball that falls on a floor from a height, where bounces follow from restitution.
const BALL: &str = "parameters { h: m = 1, e = 0.5 }\ncoordinates { z: m }\n\
     lagrangian 1[kg]/2*dot(z)^2 - 9.81[N]*z\nsurface floor: z >= 0\nimpact floor: restitution e\n\
     start { z: h }\nhorizon 0.6 [s]\n";

/// A folder with the scene and room for tables.
fn folder(name: &str) -> Scratch {
    let scratch = Scratch::new(name);
    scratch.write("ball.hang", BALL);
    scratch
}

/// The line of a sweep of the ball, with its table in the folder.
fn words(scratch: &Scratch, table: &str, more: &str) -> String {
    let text = scratch.text();
    format!(
        "sweep {text}/ball.hang --over h=20:180:9cm --over e=0,0.5,1.5 \
         --record final.z,final.dot(z),final_time,events --out {text}/{table} {more}"
    )
}

fn sweep(scratch: &Scratch, table: &str, more: &str) -> String {
    solved(&words(scratch, table, more));
    scratch.read(table)
}

/// Why a sweep is refused.
fn refusal(scratch: &Scratch, table: &str, more: &str) -> String {
    refused(&words(scratch, table, more))
}

#[test]
fn row_holds_the_digits_of_a_single_run_and_a_point_that_is_refused_says_why() {
    let scratch = folder("sweep-rows");
    let table = sweep(&scratch, "t.csv", "");
    let lines: Vec<&str> = table.lines().collect();
    assert_eq!(lines.len(), 1 + 9 * 3);
    assert!(lines[0].starts_with(
        "point,h [m],e,status,message,sequence,final.z [m],final.dot(z) [m/s],final_time [s],events,sweep"
    ));
    // Point 13: h = 1 m, e = 0.5. One fall of sqrt(2 h/g), then a bounce.
    let cells: Vec<&str> = lines[14].split(',').collect();
    assert_eq!(&cells[..4], ["13", "1", "0.5", "solved"]);
    let scene = format!("{}/ball.hang", scratch.text());
    let single = json(&format!("simulate {scene} --set h=1 --set e=0.5 --json"));
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
    let whole = sweep(&scratch, "whole.csv", "");
    for threads in ["1", "3"] {
        let name = format!("threads-{threads}.csv");
        let mut command = program();
        command.args(words(&scratch, &name, "").split_whitespace());
        let run = command.env("RAYON_NUM_THREADS", threads).status();
        assert!(run.unwrap().success());
        assert_eq!(scratch.read(&name), whole);
    }
    let mut shards = Vec::new();
    for shard in 1..=4 {
        let name = format!("shard-{shard}.csv");
        sweep(&scratch, &name, &format!("--shard {shard}/4"));
        shards.push(format!("{}/{name}", scratch.text()));
    }
    let joined = |shards: &[String]| {
        let out = format!("{}/joined.csv", scratch.text());
        format!("sweep --join {} --out {out}", shards.join(" "))
    };
    let refusal = refused(&joined(&shards[..3]));
    assert!(refusal.contains("first of them is 3"), "{refusal}");
    solved(&joined(&shards));
    assert_eq!(scratch.read("joined.csv"), whole);
    // Wherever a run was cut, also within a row or the header, the resumed table is the same.
    for cut in [0, 7, whole.len() / 3, whole.len() - 1, whole.len()] {
        scratch.write("cut.csv", &whole[..cut]);
        assert_eq!(sweep(&scratch, "cut.csv", "--resume"), whole);
    }
}

#[test]
fn killed_sweep_leaves_the_beginning_of_the_table() {
    let scratch = folder("sweep-killed");
    let more = "-- --method moreau --steps 20000";
    let whole = sweep(&scratch, "whole.csv", more);
    let mut child = program()
        .args(words(&scratch, "killed.csv", more).split_whitespace())
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
    assert_eq!(
        sweep(&scratch, "killed.csv", &format!("--resume {more}")),
        whole
    );
}

#[test]
fn sweep_refuses_tables_of_others_and_names_what_is_wrong() {
    let scratch = folder("sweep-refusals");
    let whole = sweep(&scratch, "t.csv", "");
    assert!(refusal(&scratch, "t.csv", "").contains("add --resume"));
    let other = "--resume -- --method event";
    assert!(refusal(&scratch, "t.csv", other).contains("another sweep"));
    assert_eq!(scratch.read("t.csv"), whole, "a refusal leaves the table");
}

#[test]
fn table_has_one_writer_and_what_is_none_of_its_beginnings_is_left_as_it_is() {
    let scratch = folder("sweep-one-writer");
    let whole = sweep(&scratch, "t.csv", "");
    let path = scratch.0.join("t.csv");
    let writer = std::fs::OpenOptions::new()
        .append(true)
        .open(&path)
        .unwrap();
    writer.lock().unwrap();
    assert!(refusal(&scratch, "t.csv", "--resume").contains("another sweep writes"));
    drop(writer);
    assert_eq!(sweep(&scratch, "t.csv", "--resume"), whole);
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
        scratch.write("t.csv", &text);
        assert!(
            refusal(&scratch, "t.csv", "--resume").contains("another sweep"),
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
    let part = sweep(&scratch, "part.csv", "");
    let (part_path, pipe) = (
        format!("{}/part.csv", scratch.text()),
        pipe.to_str().unwrap(),
    );
    for out in [pipe, "/dev/full", "/dev/zero", scratch.text()] {
        for resume in ["", "--resume"] {
            let over = format!("sweep ski-jump --over m=1,2 --out {out} {resume}");
            assert!(refused(&over).contains("this is no file"), "{over}");
        }
        let refusal = refused(&format!("sweep --join {part_path} --out {out}"));
        assert!(refusal.contains("this is no file"), "{refusal}");
    }
    assert!(refused(&format!("sweep --join {pipe} --out x.csv")).contains("this is no file"));
    assert!(
        std::fs::metadata("/dev/full")
            .unwrap()
            .file_type()
            .is_char_device()
    );
    // So are tables of measurements, of profiles and programs, within any time.
    let fitted = BALL.replace(
        "horizon",
        "measured m: \"pipe.csv\" { z within 1 [cm] }\nminimize misfit(m)\nhorizon",
    );
    let free = "free h: m in 0..=2 = 1\nparameters { ";
    let scene = scratch.write(
        "fitted.hang",
        fitted.replace("parameters { h: m = 1, ", free),
    );
    assert!(refused(&format!("solve {scene}")).contains("this is no file"));
    assert!(refused(&format!("profile {pipe}")).contains("this is no file"));
    assert!(refused(&format!("nlp {pipe}")).contains("this is no file"));
    let joined = format!("{}/joined.csv", scratch.text());
    solved(&format!("sweep --join {part_path} --out {joined}"));
    let mode = |path: &str| std::fs::metadata(path).unwrap().permissions().mode();
    assert_eq!(mode(&joined), mode(&part_path));
    assert_eq!(scratch.read("joined.csv"), part);
}

#[cfg(unix)]
#[test]
fn interrupted_sweep_ends_at_once_and_says_how_to_go_on() {
    let scratch = folder("sweep-interrupted");
    // A point takes seconds.
    let more = "-- --method moreau --steps 1000000";
    let mut child = program()
        .args(words(&scratch, "t.csv", more).split_whitespace())
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
fn warm(scratch: &Scratch, table: &str, more: &str) -> String {
    let text = scratch.text();
    solved(&format!(
        "sweep {text}/cart.hang --what solve --warm=3 --out {text}/{table} --over m=2,2.7 --over d=0.4:1.6:7 {more} \
         --record objective -- --intervals 6"
    ));
    scratch.read(table)
}

#[test]
fn warm_sweep_starts_points_from_each_other_whoever_computes_them() {
    let scratch = folder("sweep-warm");
    scratch.write("cart.hang", CART);
    let whole = warm(&scratch, "whole.csv", "");
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
    for (shard, first) in [(1, 0), (2, 3)] {
        let table = warm(
            &scratch,
            &format!("s{shard}.csv"),
            &format!("--shard {shard}/2"),
        );
        assert_eq!(table.lines().nth(1), Some(rows[first]));
    }
    let text = scratch.text();
    solved(&format!(
        "sweep --join {text}/s1.csv {text}/s2.csv --out {text}/joined.csv"
    ));
    assert_eq!(scratch.read("joined.csv"), whole);
    // Cut within a chain, it is computed anew from its first point on.
    for lines in [3, 6] {
        let cut: String = whole.split_inclusive('\n').take(lines).collect();
        scratch.write("cut.csv", cut);
        assert_eq!(warm(&scratch, "cut.csv", "--resume"), whole);
    }
}
