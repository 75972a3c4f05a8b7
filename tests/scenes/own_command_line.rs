//! The example that gives a scene of its own the command line: its optimum, and what its commands write.

use std::process::ExitCode;

use hangtime::ocp::{self, Problem, Settings, Stationarity};
use hangtime::simulation::EventKind;
use hangtime_cli::CommandLine;

#[expect(
    dead_code,
    unreachable_pub,
    reason = "the example is a program with a main function"
)]
#[path = "../../examples/own_command_line.rs"]
pub(crate) mod example;

#[test]
fn sledge_flies_over_its_hollow_and_is_certified() {
    let model = (example::SCENES[0].variants[0].model)();
    let problem = Problem::of(&*model, 10);
    let solution = ocp::solve(&*model, &problem, &Settings::default(), &mut |_| true).unwrap();
    assert!(solution.status.is_solved(), "{:?}", solution.diagnosis());
    assert_ne!(solution.stationarity, Stationarity::None);
    assert!(solution.resimulation_error < 1e-6);
    let kinds: Vec<EventKind> = solution
        .planned_events
        .iter()
        .map(|event| event.1)
        .collect();
    assert_eq!(kinds[..2], [EventKind::LiftOff, EventKind::Impact]);
    // On level snow: a push with a = 4 m/s^2, then a brake with b = 2 m/s^2, t = sqrt(2 s (1/a + 1/b)). The far side
    // of the hollow is a stronger brake; without any, t = sqrt(2 s/a).
    let (push, brake, distance) = (4.0_f64, 2.0_f64, 10.0_f64);
    let level = (2.0 * distance * (1.0 / push + 1.0 / brake)).sqrt();
    let without_brake = (2.0 * distance / push).sqrt();
    assert!((without_brake..level).contains(&solution.horizon));
}

#[test]
fn program_of_its_own_writes_figures_and_refuses_what_it_does_not_have() {
    let directory = std::env::temp_dir().join(format!("own-command-line-{}", std::process::id()));
    let out = directory.to_string_lossy().into_owned();
    let run = |arguments: &[&str]| {
        let arguments = ["own"].iter().chain(arguments).map(Into::into);
        CommandLine::new(example::SCENES).run(arguments)
    };
    assert_eq!(
        run(&["simulate", "sledge", "--out", &out]),
        ExitCode::SUCCESS
    );
    for file in ["sledge.html", "sledge.svg", "sledge.json"] {
        let written = std::fs::metadata(directory.join(file)).unwrap();
        assert!(written.len() > 0, "{file}");
    }
    // Nothing pushes the sledge, which stands on the snow from the start: nothing happens.
    let events = std::fs::read_to_string(directory.join("sledge-events.csv")).unwrap();
    assert_eq!(events.lines().count(), 1, "{events}");
    std::fs::remove_dir_all(&directory).unwrap();
    assert_eq!(run(&["simulate", "ski-jump"]), ExitCode::from(2));
    // Without published results to reproduce, the program lists its scenes.
    assert_eq!(run(&[]), ExitCode::SUCCESS);
    assert_eq!(run(&["reproduce"]), ExitCode::from(2));
}
