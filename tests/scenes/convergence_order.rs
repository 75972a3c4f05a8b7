//! Orders of convergence on the ski jump: what each scheme promises, and what the exit condition is worth.

#![expect(clippy::unwrap_used, reason = "a failed step fails the test")]

use hangtime::rk::Scheme;
use hangtime::simulation::{
    EventKind, Fesd, InitialValueProblem, Simulation, SimulationStatus, Simulator, StepFormulation,
};
use hangtime_models::SkiJump;

/// State `(y, z, dy/dt, dz/dt)` at 5 s of the ride from 10.2759 m, by quadrature at two precisions that
/// agree in 22 digits.
const END: [f64; 4] = [
    59.373_066_742_926_91,
    15.313_466_628_536_545,
    19.390_549_109_241_257,
    -9.695_274_554_620_628,
];
/// Take-off time of the same ride [s].
const TAKE_OFF: f64 = 1.785_438_154_029_445;

fn simulate(simulator: &Fesd) -> Simulation {
    let model = SkiJump::default();
    let problem = InitialValueProblem::of(&model, None).unwrap();
    let simulation = simulator.simulate(&model, &problem, &mut |_| true).unwrap();
    assert_eq!(simulation.status, SimulationStatus::Solved, "{simulator:?}");
    simulation
}

fn error(simulation: &Simulation) -> f64 {
    let (q, v) = (
        simulation.trajectory.q.last().unwrap(),
        simulation.trajectory.v.last().unwrap(),
    );
    q.iter()
        .chain(v)
        .zip(END)
        .fold(0.0, |largest, (value, exact)| {
            (value - exact).abs().max(largest)
        })
}

/// Least-squares slope of log error against log step count, negated.
fn order(simulator: &Fesd, steps: &[usize]) -> f64 {
    let points: Vec<(f64, f64)> = steps
        .iter()
        .map(|&count| {
            let error = error(&simulate(&simulator.clone().with_grid(count, 1)));
            ((count as f64).ln(), error.ln())
        })
        .collect();
    let mean =
        |f: &dyn Fn(&(f64, f64)) -> f64| points.iter().map(f).sum::<f64>() / points.len() as f64;
    let (x, y) = (mean(&|p| p.0), mean(&|p| p.1));
    let covariance = mean(&|p| (p.0 - x) * (p.1 - y));
    -covariance / mean(&|p| (p.0 - x).powi(2))
}

#[test]
fn radau_iia_keeps_its_order_through_sliding_take_off_and_landing() {
    // Step counts where the leading error term dominates and rounding (about 1e-12) does not.
    let cases: [(usize, &[usize]); 4] = [
        (1, &[320, 640, 1280]),
        (2, &[80, 160, 320, 640]),
        (3, &[80, 160, 320]),
        (4, &[40, 80, 160]),
    ];
    let formulations = [StepFormulation::ActiveSet, StepFormulation::TimeFreezing];
    for (stages, steps) in &cases {
        for formulation in formulations {
            let simulator = Fesd::default()
                .with_scheme(Scheme::RadauIia, *stages)
                .with_formulation(formulation);
            let measured = order(&simulator, steps);
            let expected = (2 * stages - 1) as f64;
            assert!(
                (measured - expected).abs() < 0.15,
                "{formulation:?}, {stages} stages: measured order {measured}, expected {expected}"
            );
        }
    }
}

/// With the take-offs of the published equations.
fn published() -> Fesd {
    Fesd {
        exit_condition: false,
        ..Fesd::default()
    }
}

#[test]
fn without_the_exit_condition_every_scheme_is_of_second_order() {
    for stages in [3, 4, 5] {
        let simulator = published().with_scheme(Scheme::RadauIia, stages);
        let measured = order(&simulator, &[160, 320, 640]);
        assert!(
            (measured - 2.0).abs() < 0.05,
            "{stages} stages: measured order {measured}"
        );
    }
}

#[test]
fn without_the_exit_condition_take_off_is_early_by_a_share_of_the_first_node() {
    // The published equations admit any take-off whose flight has its gap at the first stage not
    // negative: a cubic, so c_1 h / 3 early.
    let steps = 320;
    let simulation = simulate(&published().with_grid(steps, 1));
    let take_off = simulation
        .events
        .iter()
        .find(|event| event.kind == EventKind::LiftOff)
        .unwrap();
    let first_node = (4.0 - 6.0_f64.sqrt()) / 10.0;
    let early = TAKE_OFF - take_off.time;
    let expected = first_node * 5.0 / steps as f64 / 3.0;
    // The remainder of the step, not a whole one, follows the take-off.
    assert!(
        early > 0.5 * expected && early < 1.5 * expected,
        "{early} {expected}"
    );
}

#[test]
fn gauss_legendre_loses_order_in_contact() {
    // Collocation of an index-2 system without a stage at the end, projected: order 2 for one stage,
    // then less than the 2 s of ordinary differential equations.
    for (stages, expected) in [(1, 2.0), (2, 3.0), (3, 4.0), (4, 5.0)] {
        let simulator = Fesd::default().with_scheme(Scheme::GaussLegendre, stages);
        let measured = order(&simulator, &[160, 320, 640]);
        assert!(
            (measured - expected).abs() < 0.2,
            "{stages} stages: measured order {measured}, expected {expected}"
        );
    }
}

#[test]
fn tolerance_controls_the_error() {
    for stages in [3, 4, 5] {
        for tolerance in [1e-6, 1e-8, 1e-10] {
            let simulator = Fesd::default()
                .with_scheme(Scheme::RadauIia, stages)
                .with_grid(1, 1)
                .with_tolerance(tolerance);
            let reached = error(&simulate(&simulator));
            // A tolerance on each element: errors add up over the ride and grow at the landing, and the
            // state is of size 60.
            assert!(
                reached < 100.0 * tolerance,
                "{stages} stages, tolerance {tolerance:e}: {reached:e}"
            );
        }
    }
}

#[test]
fn counts_of_sixty_steps_are_pinned() {
    // Those of the run and of the one with half the steps, which measures its error; elements are those of the run.
    let simulation = simulate(&Fesd::default().with_grid(60, 3));
    let counts = simulation.counts;
    assert_eq!(counts.elements, 184);
    assert_eq!(counts.interior_point, 0);
    insta::assert_snapshot!(
        format!(
            "newton {} factorizations {} evaluations {} variables {} equalities {}",
            counts.newton,
            counts.factorizations,
            counts.evaluations,
            simulation.size.variables,
            simulation.size.equalities
        ),
        @"newton 1058 factorizations 166 evaluations 4101 variables 12 equalities 12"
    );
}
