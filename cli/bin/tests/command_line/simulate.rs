//! `list`, `simulate` and `explain`.

use serde_json::Value;

use crate::support::{
    Said, Scratch, assert_page_shows_its_result, assert_page_shows_its_ride, embedded, hangtime,
    json, program, result_files, solved, unsolved,
};

#[test]
fn list_names_every_scene_and_tells_its_parameters_where_it_is_named() {
    let text = solved("list");
    let document = json("list --json");
    let scenes = document["scenes"].as_array().unwrap();
    assert!(scenes.iter().any(|scene| scene["name"] == "ski-jump"));
    let solvable = |name: &str| {
        let scene = scenes.iter().find(|scene| scene["name"] == name).unwrap();
        scene["commands"]
            .as_array()
            .unwrap()
            .contains(&"solve".into())
    };
    assert!(solvable("pump-track") && !solvable("ski-jump"));
    let told = solved("list pump-track");
    assert!(
        told.contains("for simulate, solve, chart, explain, reproduce"),
        "{told}"
    );
    let names: Vec<&str> = scenes.iter().map(|s| s["name"].as_str().unwrap()).collect();
    let told = solved(&format!("list {}", names.join(" ")));
    for scene in scenes {
        assert!(text.contains(scene["name"].as_str().unwrap()));
        for key in ["question", "answer"] {
            if let Some(words) = scene[key].as_str() {
                assert!(told.contains(words), "{words}");
            }
        }
        for parameter in scene["parameters"].as_array().unwrap() {
            assert!(told.contains(parameter["name"].as_str().unwrap()));
        }
    }
}

#[test]
fn list_shows_the_scenes_of_a_group() {
    let document = json("list --group legs --json");
    let scenes = document["scenes"].as_array().unwrap();
    assert!(scenes.len() >= 4);
    assert!(scenes.iter().all(|scene| scene["group"] == "legs"));
}

/// The paths of all fields, each once, in the order in which a document has them.
fn fields(document: &str) -> String {
    let (mut path, mut fields) = (Vec::new(), Vec::new());
    let (mut name, mut rest) = ("", document);
    while let Some(at) = rest.find(['"', '{', '}']) {
        let (sign, behind) = (&rest[at..=at], &rest[at + 1..]);
        rest = behind;
        match sign {
            "{" => path.push(name),
            "}" => drop(path.pop()),
            _ => {
                let escaped = |end: usize| behind[..end].ends_with('\\');
                let mut ends = behind.match_indices('"').map(|(end, _)| end);
                let end = ends.find(|&end| !escaped(end)).unwrap();
                rest = &behind[end + 1..];
                if rest.starts_with(':') {
                    name = &behind[..end];
                    fields.push(format!("{}.{name}", path.join(".")));
                }
            }
        }
    }
    let mut known = std::collections::BTreeSet::new();
    fields.retain(|field| known.insert(field.clone()));
    fields.join("\n")
}

#[test]
fn documents_have_the_fields_of_the_contract_in_order() {
    let lines = [
        "simulate ski-jump --json",
        "simulate falling-rod --gradient mu --json",
        "simulate thermostat --json",
        "solve pump-track --intervals 6 --formulation time-freezing --json",
        "solve pump-track --intervals 5 --gradient g --json",
        "explain incline --size --json",
        "list hop --json",
    ];
    let mut all = String::new();
    for line in lines {
        let document = solved(line);
        assert_eq!(document.lines().count(), 1);
        all += &format!("{line}\n{}\n\n", fields(&document));
    }
    insta::assert_snapshot!(all);
    assert!(solved(lines[0]).contains("\"start_y\":10.2759"));
}

#[test]
fn simulate_json_rows_belong_together_and_end_at_the_horizon() {
    let document = json("simulate ski-jump --horizon 2 --json");
    let trajectory = &document["trajectory"];
    let rows = trajectory["time"].as_array().unwrap().len();
    assert!(rows > 2);
    for (field, width) in [("q", 2), ("v", 2), ("u", 0), ("contact_force", 2)] {
        let field = trajectory[field].as_array().unwrap();
        assert_eq!(field.len(), rows);
        assert!(
            field
                .iter()
                .all(|row| row.as_array().unwrap().len() == width)
        );
    }
    assert_eq!(document["horizon"], 2.0);
    assert_eq!(document["final"]["time"], trajectory["time"][rows - 1]);
    assert_eq!(document["final"]["q"], trajectory["q"][rows - 1]);
    // The last grid point is the horizon up to the rounding of the sum of the steps.
    let end = document["final"]["time"].as_f64().unwrap();
    assert!((end - 2.0).abs() < 1e-13, "{end}");
}

#[test]
fn simulate_that_does_not_converge_prints_what_there_is_and_says_why() {
    // Gravity beyond the range of squares in double precision.
    let (document, said) = unsolved("simulate ski-jump --set g=1e300 --json");
    assert!(
        said.starts_with("error: ski-jump: not_finite at t = 0 s: "),
        "{said}"
    );
    assert_eq!(document["status"], "not_finite");
    assert_eq!(document["diagnosis"]["time"], 0.0);
    assert_eq!(document["final"]["time"], 0.0);
}

/// What is said of a scene that is simulated with further words.
fn simulated(name: &str, text: &str, words: &str) -> Said {
    let scratch = Scratch::new(name);
    scratch.write("scene.hang", text);
    scratch.run(&format!("simulate scene.hang {words}"))
}

#[test]
fn simulate_with_controls_that_cannot_be_zero_says_so() {
    let text = "coordinates { y: m } controls { u: N in 1..=2, w: N in -1..=1 } lagrangian 1 [kg]/2*dot(y)^2
        forces { y: u + w } horizon 1 [s]";
    for method in ["fesd", "event", "moreau", "smooth", "fixed"] {
        let Said { status, out, err } = simulated("controls", text, &format!("--method {method}"));
        assert_eq!(status, Some(0), "{err}");
        let note = "note        controls are zero in a simulation; `u` in 1..=2 N excludes that\n";
        assert!(out.contains(note), "{out}");
    }
}

#[test]
fn simulate_with_one_stage_says_that_its_order_is_low() {
    let (_, said) = unsolved("simulate bouncing-ball --stages 1 --json");
    assert!(said.contains("needs 2 stages or more"), "{said}");
}

#[test]
fn simulate_names_what_is_not_finite() {
    let ball = |lagrangian: &str, surface: &str| {
        format!(
            "parameters {{ m: kg = 1, g: m/s^2 = 9.81, q = 0 }} coordinates {{ y: m, z: m }}
             lagrangian m/2*|dot((y, z))|^2 - m*g*{lagrangian} surface floor: {surface} impact floor: inelastic
             start {{ z: 1, dot(y): 1 }} outputs {{ half = q/2 }} horizon 1 [s]"
        )
    };
    for (text, words) in [
        (
            ball("z/q", "z >= 0"),
            "the acceleration of `z` is infinite or not a number here; look for a division by zero or a root of a \
             negative number (the parameter `q` is 0)",
        ),
        (
            ball("z", "z >= sqrt(y^2)"),
            "the gradient of the gap of `floor` is infinite or not a number here",
        ),
    ] {
        let Said { status, err, .. } = simulated("finite", &text, "");
        assert_eq!(status, Some(3), "{err}");
        assert!(err.contains(words), "{err}");
    }
}

#[test]
fn simulate_with_one_row_writes_the_last() {
    let document = json("simulate ski-jump --rows 1 --json");
    assert_eq!(document["trajectory"]["time"].as_array().unwrap().len(), 1);
    assert_eq!(document["final"]["time"], document["trajectory"]["time"][0]);
}

#[test]
fn simulate_with_a_tolerance_says_so_in_place_of_the_elements() {
    let run = json("simulate ski-jump --stages 5 --tolerance 1e-9 --json");
    let method = &run["method"];
    assert_eq!(method["tolerance"], 1e-9);
    assert!(method.get("elements").is_none());
}

#[test]
fn simulate_twice_gives_the_same_numbers() {
    let run = || {
        let mut document = json("simulate ski-jump --json");
        document.as_object_mut().unwrap().remove("seconds");
        document
    };
    assert_eq!(run(), run());
}

#[test]
fn simulate_every_method_reaches_the_horizon() {
    for method in ["fesd", "event", "moreau", "smooth", "fixed"] {
        let document = json(&format!("simulate ski-jump --method {method} --json"));
        assert_eq!(document["method"]["name"], method);
        assert_eq!(document["status"], "solved", "{method}");
    }
}

#[test]
fn simulate_methods_that_do_not_know_their_error_are_measured_by_another_grid() {
    let exact = json("simulate ski-jump --method event --json");
    let y = |document: &Value| document["final"]["q"][0].as_f64().unwrap();
    for arguments in [
        "--method moreau --steps 400",
        "--method moreau --steps 3000",
        "--method moreau --steps 1",
        "--method fixed --steps 700",
        "--method fixed --steps 40",
        "--method smooth --width 1e-4",
    ] {
        let document = json(&format!("simulate ski-jump --json {arguments}"));
        let estimate = document["error_estimate"].as_f64().unwrap();
        // The way covered is 49 m; methods of order one err by about the distance to half the steps.
        let error = (y(&document) - y(&exact)).abs() / 49.1;
        assert!(
            error < 2.5 * estimate,
            "{arguments:?}: {error:e}, said {estimate:e}"
        );
        let said = document["notes"]
            .to_string()
            .contains("the error is estimated at");
        assert_eq!(said, estimate > 1e-3, "{arguments:?}: {estimate:e}");
    }
}

#[test]
fn simulate_on_fixed_steps_past_a_pole_says_that_the_error_is_large() {
    let text = "coordinates { y, z } lagrangian (dot(y)^2 + dot(z)^2)/2 - 9.81*z forces { y: tan(2.7*y) } \
                surface ground: z >= 0 impact ground: inelastic start { z: 1, dot(y): 1 } horizon 2";
    let document = simulated("pole", text, "--method fixed --json").json();
    assert!(document["error_estimate"].as_f64().unwrap() > 1e-2);
}

#[test]
fn simulate_horizon_with_a_unit_is_converted() {
    let horizon =
        |text| json(&format!("simulate ski-jump --horizon {text} --json"))["horizon"].clone();
    assert_eq!(horizon("2"), 2.0);
    assert_eq!(horizon("2s"), 2.0);
    assert_eq!(horizon("250ms"), 0.25);
}

#[test]
fn simulate_long_trajectory_is_thinned_and_says_so() {
    let scratch = Scratch::new("thinned");
    let document = json(&format!(
        "simulate bouncing-ball --method moreau --steps 30000 --rows 700 --json --out {}",
        scratch.text()
    ));
    let rows = document["trajectory"]["time"].as_array().unwrap().len();
    assert!((350..=700).contains(&rows), "{rows}");
    assert_eq!(document["trajectory"]["q"].as_array().unwrap().len(), rows);
    assert_eq!(document["final"]["time"], document["horizon"]);
    assert!(
        document["notes"].to_string().contains("--rows"),
        "{}",
        document["notes"]
    );
    let csv = scratch.read("bouncing-ball-moreau-trajectory.csv");
    assert_eq!(csv.lines().count(), rows + 1);
}

#[test]
fn simulate_by_another_method_keeps_the_files_of_the_first_and_tells_what_it_replaced() {
    let scratch = Scratch::new("methods");
    let run = |method| {
        solved(&format!(
            "simulate ski-jump --method {method} --out {}",
            scratch.text()
        ))
    };
    assert!(!run("fesd").contains("replaced"));
    assert!(!run("event").contains("replaced"));
    let mut names = result_files("ski-jump").to_vec();
    names.extend(result_files("ski-jump-event"));
    names.sort();
    assert_eq!(scratch.names(), names);
    let again = run("event");
    assert_eq!(again.matches("replaced").count(), 6, "{again}");
}

#[test]
fn json_names_every_column_with_its_unit() {
    let document = json("simulate incline --json");
    let quantities = &document["quantities"];
    assert_eq!(
        quantities["q"][1],
        serde_json::json!({"name": "z", "unit": "m"})
    );
    assert_eq!(
        quantities["v"][0],
        serde_json::json!({"name": "dy/dt", "unit": "m/s"})
    );
    for force in ["contact_force", "friction_force"] {
        assert_eq!(
            quantities[force],
            serde_json::json!([{"name": "ramp", "unit": "N"}])
        );
    }
    for column in ["q", "v", "u", "contact_force", "friction_force"] {
        let width = document["trajectory"][column][0].as_array().unwrap().len();
        assert_eq!(
            quantities[column].as_array().unwrap().len(),
            width,
            "{column}"
        );
    }
}

#[cfg(unix)]
#[test]
fn report_is_printed_whatever_becomes_of_the_files() {
    let scratch = Scratch::new("in-the-way");
    // A directory with the name of a file.
    std::fs::create_dir_all(scratch.0.join("ski-jump-time.svg")).unwrap();
    let said = scratch.run("simulate ski-jump --json --out .");
    assert_eq!(said.status, Some(2));
    assert_eq!(said.json()["status"], "solved");
    assert!(
        said.err.contains("ski-jump-time.svg`") && said.err.contains("no file was written"),
        "{}",
        said.err
    );
    assert_eq!(scratch.names(), ["ski-jump-time.svg"]);
}

#[test]
fn simulate_setting_with_another_unit_is_converted() {
    let parameter = |setting| {
        json(&format!("simulate ski-jump --set {setting} --json"))["parameters"]["start_y"].clone()
    };
    assert_eq!(parameter("start_y=8.264m"), 8.264);
    assert_eq!(parameter("start_y=8.264"), 8.264);
    // 826.4 / 100 is 8.264 up to one rounding.
    let centimetres = parameter("start_y=826.4cm").as_f64().unwrap();
    assert!((centimetres - 8.264).abs() < 4e-15, "{centimetres}");
}

#[test]
fn simulate_tables_show_events_and_the_final_state_with_units() {
    let text = solved("simulate ski-jump");
    for words in [
        "start_y = 10.2759 m",
        "radau-iia, 6 stages, tolerance 1e-6",
        "error       about",
        "lift off",
        "impact",
        "y [m]",
        "dz/dt [m/s]",
        "state at t = 5 s",
        "residuals",
        "CPU time",
    ] {
        assert!(text.contains(words), "`{words}` is missing in\n{text}");
    }
}

#[test]
fn simulate_with_out_writes_data_and_a_picture_and_nothing_else() {
    let scratch = Scratch::new("simulate");
    solved(&format!("simulate ski-jump --out {}", scratch.text()));
    assert_eq!(scratch.names(), result_files("ski-jump"));
    let document: Value = serde_json::from_str(&scratch.read("ski-jump.json")).unwrap();
    let rows = document["trajectory"]["time"].as_array().unwrap().len();
    let csv = scratch.read("ski-jump-trajectory.csv");
    assert_eq!(csv.lines().count(), rows + 1);
    assert!(csv.starts_with("time [s],numerical time [s],y [m],z [m],dy/dt [m/s],dz/dt [m/s],"));
    assert!(scratch.read("ski-jump.svg").starts_with("<svg"));
    assert_page_shows_its_result(&scratch, "ski-jump");
}

#[test]
fn simulate_scene_with_friction_tells_when_it_sticks_and_gives_the_friction_force() {
    let scratch = Scratch::new("incline");
    let document = json(&format!("simulate incline --json --out {}", scratch.text()));
    // It slides from the start on, which is no event.
    let initially = &document["initially"][0];
    assert_eq!(initially["contact"], "ramp");
    assert_eq!(initially["mode"], "slipping forward");
    let event = &document["events"][0];
    assert_eq!(event["kind"], "stick");
    // v / (g (mu cos a - sin a)) with the defaults of the scene.
    let (sin, cos) = 15.0_f64.to_radians().sin_cos();
    let stop = 3.0 / (9.81 * (0.5 * cos - sin));
    // The acceleration is constant, and so the collocation exact up to rounding.
    assert!((event["time"].as_f64().unwrap() - stop).abs() < 1e-10);
    let forces = document["trajectory"]["friction_force"].as_array().unwrap();
    let times = document["trajectory"]["time"].as_array().unwrap();
    assert_eq!(forces.len(), times.len());
    // At rest the force carries the block: m g sin a up the incline.
    let last = forces.last().unwrap()[0].as_f64().unwrap();
    assert!((last.abs() - 2.0 * 9.81 * sin).abs() < 1e-9, "{last}");
    let csv = scratch.read("incline-trajectory.csv");
    assert!(
        csv.lines()
            .next()
            .unwrap()
            .ends_with("contact force ramp [N],friction force ramp [N]")
    );
    assert_page_shows_its_result(&scratch, "incline");
    let without = json("simulate ski-jump --json");
    assert!(without["trajectory"].get("friction_force").is_none());
}

#[test]
fn simulate_at_its_time_limit_ends_with_what_it_has() {
    // Lines that take seconds: hundreds of bounces on short waves, many steps.
    for line in [
        "simulate pump-track --set k=300 --set speed=0.2 --method fesd",
        "simulate pump-track --set k=300 --set speed=0.2 --method event",
        "simulate box --horizon 30s --steps 1000000 --method moreau",
        "simulate box --horizon 30s --steps 300000 --method fesd",
    ] {
        let (document, said) = unsolved(&format!("{line} --time-limit 60ms --json"));
        assert!(
            said.contains(": time_limit at t = ") && said.contains("ended after 0.06 s; raise"),
            "{line}: {said}"
        );
        assert_eq!(document["status"], "time_limit");
        let message = document["diagnosis"]["message"].as_str().unwrap();
        assert!(message.contains("--time-limit"), "{message}");
        let (end, horizon) = (&document["final"]["time"], &document["horizon"]);
        assert!(end.as_f64() < horizon.as_f64(), "{end} of {horizon}");
    }
}

#[cfg(target_os = "linux")]
#[test]
fn simulate_beyond_its_memory_limit_ends_with_status_3() {
    let said = hangtime("simulate pump-track --set k=250 --set speed=0.3 --memory-limit 0.001");
    assert_eq!(said.status, Some(3), "{}", said.err);
    assert_eq!(said.err.lines().count(), 1, "{}", said.err);
    for words in [": memory_limit", "raise --memory-limit (0.001 GB)"] {
        assert!(said.err.contains(words), "{}", said.err);
    }
}

#[test]
fn simulate_every_scene_with_its_defaults_reaches_the_horizon() {
    for scene in json("list --json")["scenes"].as_array().unwrap() {
        let name = scene["name"].as_str().unwrap();
        // Its answer is that its motion is not unique; `switched` in the tests of scenes looks at that.
        if name == "unstable-sliding" {
            continue;
        }
        let scratch = Scratch::new(name);
        let document = json(&format!("simulate {name} --json --out {}", scratch.text()));
        assert_eq!(document["status"], "solved", "{name}");
        assert_eq!(document["final"]["time"], document["horizon"], "{name}");
        // Its blocks are drawn beside each other, away from where their coordinates are zero.
        if name == "three-blocks" {
            let frames = embedded(&scratch.read("three-blocks.html"), "frames");
            let blocks = frames["bodies"].as_array().unwrap();
            assert!(
                blocks
                    .iter()
                    .all(|block| block["outline"].as_array().unwrap().len() == 4)
            );
            assert_eq!(frames["springs"], serde_json::json!([true, true, true]));
        } else if scene["question"].is_null()
            && scene["group"] != "mechanisms of textbooks"
            && document["quantities"]["q"] != serde_json::json!([])
        {
            assert_page_shows_its_ride(&scratch, name);
        } else {
            assert_page_shows_its_result(&scratch, name);
        }
    }
}

#[test]
fn explain_shows_equations_patterns_and_counts() {
    let text = solved("explain ski-jump");
    for words in [
        "derived equations",
        "Jacobian of contact `table`",
        "columns: y, z, y', z'",
        "operations in all",
    ] {
        assert!(text.contains(words), "`{words}` is missing in\n{text}");
    }
}

#[test]
fn explain_prints_the_page_of_a_mistake() {
    let text = solved("explain e07");
    assert!(text.starts_with("# E07: "), "{text}");
    assert!(text.contains("Right:"), "{text}");
    for code in ["E07", "E7", "e7"] {
        assert_eq!(solved(&format!("explain {code}")), text);
    }
    let text = solved("explain syntax");
    assert!(text.starts_with("# Syntax: "), "{text}");
}

#[test]
fn help_goes_to_the_standard_output() {
    assert!(solved("--help").contains("Usage: hangtime"));
    assert!(solved("simulate --help").contains("--scheme"));
}

#[cfg(target_os = "linux")]
#[test]
fn help_that_cannot_be_written_is_told() {
    let full = || std::fs::OpenOptions::new().write(true).open("/dev/full");
    for word in ["--help", "--version", "list"] {
        let mut command = program();
        let output = command.arg(word).stdout(full().unwrap()).output().unwrap();
        assert_eq!(output.status.code(), Some(2), "{word}");
        let said = String::from_utf8(output.stderr).unwrap();
        assert!(said.contains("standard output"), "{said}");
    }
}

#[test]
fn completions_and_manual_pages_know_commands_and_options() {
    for shell in ["bash", "elvish", "fish", "powershell", "zsh"] {
        let script = solved(&format!("completions {shell}"));
        assert!(
            script.contains("hangtime") && script.contains("time-limit"),
            "{shell}"
        );
    }
    for (shell, scenes) in [
        ("bash", "ski-jump pump-track bouncing-ball"),
        ("zsh", ":{compadd ski-jump pump-track"),
        (
            "fish",
            "_using_subcommand simulate\" -a \"ski-jump pump-track",
        ),
    ] {
        let script = solved(&format!("completions {shell}"));
        assert!(script.contains(scenes), "{shell}");
        for command in ["simulate", "nlp", "profile", "reproduce", "man"] {
            let option = solved(&format!("{command} --help"));
            let options = option
                .split_whitespace()
                .filter(|word| word.starts_with("--"));
            let names = options.map(|word| word.trim_matches(|c: char| !c.is_ascii_alphanumeric()));
            for name in names.filter(|name| name.len() > 1) {
                assert!(script.contains(name), "{shell}: {command} {name}");
            }
        }
    }
    let page = solved("man");
    assert!(
        page.contains(".TH hangtime 1") && page.contains("simulate"),
        "{page}"
    );
    let page = solved("man simulate");
    assert!(page.contains("\\-\\-horizon"), "{page}");
}
