//! Every chart of every scene on one offline page, with the optima of the zoo and the runs of other programs, and what
//! methods do where they fail on another one.
//!
//! `cargo bench --bench charts` writes `out/chart.html` and `out/stability.html`; `-- --out DIR` writes them elsewhere. The
//! arguments are those of `hangtime chart`.

use std::ffi::OsString;
use std::process::ExitCode;

use hangtime_cli::{CommandLine, ControlScene};
use hangtime_models::{hard_optima, hard_scenes, peers, scenes};
use hangtime_zoo::{best, exhibits};

fn main() -> ExitCode {
    let exhibits = exhibits().iter().map(|exhibit| ControlScene {
        name: exhibit.name,
        text: exhibit.text,
        best,
    });
    let charts = CommandLine::new(scenes())
        .with_hard(hard_scenes())
        .with_hard_optima(hard_optima())
        .with_peers(peers())
        .with_controlled(exhibits.collect::<Vec<_>>().leak());
    let given: Vec<OsString> = std::env::args_os().skip(1).collect();
    let given = given.iter().filter(|argument| *argument != "--bench");
    let asked = |first: &[&str]| -> Vec<OsString> {
        let first = first.iter().map(OsString::from);
        first.chain(given.clone().cloned()).collect()
    };
    let hard = charts.run(asked(&["charts", "chart", "--stability"]));
    let all = charts.run(asked(&["charts", "chart"]));
    if hard == ExitCode::SUCCESS { all } else { hard }
}
