//! One method on one scene, in a program of its own, so that its memory is its own and it can be ended.

use crate::row::Row;
use crate::{FAMILIES, option};
use cpu_time::ProcessTime;
use hangtime::baselines::Moreau;
use hangtime::model::Model;
use hangtime::simulation::{EventDriven, Fesd, InitialValueProblem, Simulator};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

/// Names of the methods.
pub(crate) const METHODS: [&str; 3] = ["default", "event", "moreau"];

/// CPU time that this program has taken \[s\], on all threads: texts are read on one of their own.
fn cpu() -> f64 {
    let taken = ProcessTime::try_now().map(|now| now.as_duration().as_secs_f64());
    taken.unwrap_or(f64::NAN)
}

/// CPU time of a call \[s\].
fn timed<T>(call: impl FnOnce() -> T) -> (T, f64) {
    let begin = cpu();
    let result = call();
    (result, cpu() - begin)
}

/// One run, its CPU time, and how it ended.
fn run(method: &dyn Simulator, model: &dyn Model, limit: f64) -> (f64, String) {
    let mut over = false;
    let begin = cpu();
    let (result, seconds) = timed(|| {
        let problem = InitialValueProblem::of(model, None)?;
        method.simulate(model, &problem, &mut |_| {
            over = cpu() - begin > limit;
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

/// Most memory that this program has held \[MB\], where the system tells it.
fn memory() -> f64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
    let number = line.and_then(|line| line.split_whitespace().next()?.parse::<f64>().ok());
    number.map_or(f64::NAN, |kibibytes| kibibytes * 1024.0 / 1e6)
}

/// What this program measures if it was started for one cell.
pub(crate) fn child() -> Option<Row> {
    let (name, method) = (option("--child")?, option("--method")?);
    let bodies: usize = option("--bodies")?.parse().ok()?;
    let limit: f64 = option("--limit")?.parse().ok()?;
    let family = FAMILIES.iter().find(|family| family.name == name)?;
    let text = (family.text)(bodies);
    let (scene, load) = timed(|| hangtime_scene_files::of_text("scene.hang", &text));
    let mut row = Row {
        family: name,
        bodies,
        method,
        contacts: 0,
        load,
        seconds: f64::NAN,
        memory: f64::NAN,
        ended: String::new(),
    };
    match scene {
        Ok(scene) => {
            row.contacts = scene.declaration().contacts.len();
            let method: &dyn Simulator = match row.method.as_str() {
                "event" => &EventDriven::default(),
                "moreau" => &Moreau::default(),
                _ => &Fesd::default(),
            };
            (row.seconds, row.ended) = run(method, &scene, limit);
        }
        Err(error) => {
            let text = error.to_string();
            let first = text.lines().next().unwrap_or_default();
            row.ended = first.chars().take(60).collect();
        }
    }
    row.memory = memory();
    Some(row)
}

/// The row that a program of its own measures; it is ended where it takes far longer than the limit.
pub(crate) fn in_a_program(family: &str, bodies: usize, method: &str, limit: f64) -> Row {
    let failed = |ended: &str| Row {
        family: family.to_owned(),
        bodies,
        method: method.to_owned(),
        contacts: 0,
        load: f64::NAN,
        seconds: f64::NAN,
        memory: 0.0,
        ended: ended.to_owned(),
    };
    let Ok(program) = std::env::current_exe() else {
        return failed("no program");
    };
    let started = Command::new(program)
        .args(["--child", family, "--method", method])
        .args([
            "--bodies",
            &bodies.to_string(),
            "--limit",
            &limit.to_string(),
        ])
        .stdout(Stdio::piped())
        .stderr(Stdio::null())
        .spawn();
    let Ok(mut running) = started else {
        return failed("not started");
    };
    // One step may take longer than all that a method is asked for.
    let end = Instant::now() + Duration::from_secs_f64(4.0 * limit + 30.0);
    while Instant::now() < end {
        if let Ok(Some(_)) = running.try_wait() {
            let output = running.wait_with_output();
            let text = output.map(|output| String::from_utf8_lossy(&output.stdout).into_owned());
            let row = text.ok().and_then(|text| text.lines().find_map(Row::read));
            return row.unwrap_or_else(|| failed("crashed"));
        }
        std::thread::sleep(Duration::from_millis(5));
    }
    let _ = running.kill();
    let _ = running.wait();
    failed("limit")
}
