//! Scenes and problems on which methods fail, a file a phenomenon: what promises an accuracy is right, or stops with a name.
//! `hangtime chart --stability` shows the same for every method.

mod crowds;
mod jamming;
mod optimal_control;
mod steps;
mod sweeps;

use hangtime::prelude::*;
use hangtime::simulation::{
    EventDriven, Fesd, InitialValueProblem, Simulation, SimulationStatus, Simulator,
    StepFormulation,
};
use hangtime_cli::{HardScene, Right};
use hangtime_models::hard_scenes;
use hangtime_scene_files::{TextScene, of_text};

/// The hard scenes of each phenomenon, on which the methods that promise an accuracy are right or stop with a name.
macro_rules! phenomena {
    ($($(#[$doc:meta])* $test:ident: $scenes:literal)*) => {
        const PHENOMENA: &[&str] = &[$($scenes),*];
        $($(#[$doc])* #[test] fn $test() { assert_outcomes($scenes); })*
    };
}

phenomena! {
    /// Friction: the beginning and the end of slips, spontaneous and on several contacts at once (codimension 2).
    slips_begin_and_end_where_the_cone_says:
        "impact-ends-stick resting-threshold sliding-threshold stop-at-step-end stop-in-bowl three-feet \
         turning-friction two-slips"
    /// Grazing: surfaces that are touched with no velocity, or hardly any.
    grazing_contacts_change_nothing_that_they_should_not: "grazing-apex slight-graze tangent-flight weightless-slide"
    /// Jamming, and Painleve's rod.
    rods_that_jam_are_told_from_rods_that_slide: "below-painleve leaning-ladder painleve sliding-ladder"
    /// Forces without a value: poles, roots of negative numbers, divisions by zero.
    functions_without_a_value_stop_a_run_with_a_name: "infinite-start not-a-number pole zero-parameter"
    /// Scales: far from the origin, large and small lengths and masses, stiff springs, fast rotation.
    scales_change_nothing_but_scales:
        "curved-gap far-from-origin fast-rotation heavy-on-light large-gap mass-ratio megametre micrometre small-gap \
         stiff-spring"
    /// Simultaneous impacts, with couplings of both signs, and impacts within rounding error of each other.
    impacts_at_once_follow_one_law:
        "almost-flat-rod blunt-corner corner falling-stack flat-rod flight-into-corner near-corner newtons-cradle \
         sharp-corner"
    /// Starts on a boundary, with either acceleration, in slight and in deep penetration.
    starts_on_a_boundary_are_contacts_or_not: "leaving-at-once rest slight-penetration"
    /// Impacts at places that are special for a method with steps, very short and very long steps and motions.
    nothing_depends_on_where_steps_end: "bowl impact-at-horizon impact-at-stage impact-at-step-end long-fall short-horizon"
    /// Leaving a surface: where the contact force vanishes, or the ground goes away.
    contacts_open_where_their_force_vanishes: "balanced dome lift moving-wall shaken-floor slack-string"
    /// Infinitely many impacts in finite time, and very many.
    bounces_end_where_their_series_ends: "elastic-floor long-zeno narrow-gap zeno"
}

fn scene(hard: &HardScene) -> TextScene {
    of_text(&format!("{}.hang", hard.name), hard.text)
        .unwrap_or_else(|error| panic!("{}: {error}", hard.name))
}

fn run(scene: &dyn Model, method: &dyn Simulator) -> (Simulation, f64) {
    let problem = InitialValueProblem::of(scene, None).expect("a horizon");
    let run = method
        .simulate(scene, &problem, &mut |_| true)
        .expect("a problem that can be simulated");
    (run, problem.horizon)
}

fn largest<'v>(values: impl Iterator<Item = &'v f64>) -> f64 {
    values.fold(0.0, |largest, value| largest.max(value.abs()))
}

/// Whether a run is as close to the right end as ten times its estimate, or rounding of the way at the largest velocity.
fn assert_right(name: &str, run: &Simulation, horizon: f64, right: &[f64]) {
    assert_eq!(run.status, SimulationStatus::Solved, "{name}");
    let trajectory = &run.trajectory;
    let size = largest(trajectory.q.iter().flatten().chain(right));
    let way = size.max(horizon * largest(trajectory.v.iter().flatten()));
    let estimate = run.error_estimate.expect("an estimate");
    let end = trajectory.q.last().expect("a state");
    for (is, right) in end.iter().zip(right) {
        assert!(
            (is - right).abs() <= (10.0 * estimate * size).max(1e-11 * way),
            "{name}: {is} {right}, estimate {estimate}"
        );
    }
}

/// The methods that promise an accuracy are right on the scenes of these names, or stop with a name where there is no motion.
fn assert_outcomes(names: &str) {
    let methods: [(&str, Box<dyn Simulator>); 3] = [
        ("default", Box::new(Fesd::default())),
        (
            "time-freezing",
            Box::new(Fesd::default().with_formulation(StepFormulation::TimeFreezing)),
        ),
        ("event-driven", Box::new(EventDriven::default())),
    ];
    for name in names.split(' ') {
        let hard = hard_scenes().iter().find(|hard| hard.name == name);
        let hard = hard.unwrap_or_else(|| panic!("no scene {name}"));
        let scene = scene(hard);
        for (method, simulator) in &methods {
            assert_outcome(hard, &scene, method, simulator.as_ref());
        }
    }
}

fn assert_outcome(hard: &HardScene, scene: &TextScene, method: &str, simulator: &dyn Simulator) {
    let name = format!("{} by {method}", hard.name);
    let (run, horizon) = run(scene, simulator);
    match hard.right {
        Right::Formula(formula) => assert_right(&name, &run, horizon, &formula(scene, horizon)),
        Right::Agreed => {
            let exact = EventDriven {
                tolerance: 1e-13,
                ..EventDriven::default()
            };
            let (exact, _) = self::run(scene, &exact);
            let end = exact.trajectory.q.last().expect("a state");
            assert_right(&name, &run, horizon, end);
        }
        Right::Stop => assert!(!run.status.is_solved(), "{name}"),
    }
}

#[test]
fn every_hard_scene_and_problem_shows_one_phenomenon() {
    let named = PHENOMENA.iter().flat_map(|names| names.split(' '));
    let mut shown: Vec<&str> = named.chain(crowds::SCENES.iter().copied()).collect();
    let mut known: Vec<&str> = hard_scenes().iter().map(|hard| hard.name).collect();
    shown.sort_unstable();
    known.sort_unstable();
    assert_eq!(shown, known);
}
