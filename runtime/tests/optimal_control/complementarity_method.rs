//! The complementarity method on steps of scenes, transcribed by finite elements with switch detection.

#![allow(clippy::unwrap_used, reason = "test code")]

#[path = "fesd_mpcc/problems.rs"]
mod problems;
#[path = "fesd_mpcc/scenes.rs"]
mod scenes;

use hangtime::model::Model;
use hangtime::mpcc::{self, Mpcc as _, Settings, Status};
use hangtime::nlp::NlpProblem as _;
use hangtime::ocp::{Problem, TimeFreezing, TimeFreezingSettings};

/// Crossovers solve their smooth program to 1e-8.
const SAME: f64 = 1e-6;

#[test]
fn solve_steps_certified_in_few_iterations_of_the_homotopy() {
    let (mut iterations, mut of_homotopy, mut as_good, mut steps) = (0, 0, 0, 0);
    // as the homotopy, and as simulations by complementarity
    let mut settings = Settings::default();
    settings.second_opinion = false;
    // nothing is asked: the objective is the equilibration alone, whose size means nothing
    settings.interior_point.objective_unit = Some(1.0);
    for case in problems::cases().iter() {
        let name = &case.name;
        let mut program = case.program().unwrap();
        let solution = mpcc::solve(&mut program, &settings).unwrap();
        assert_eq!(solution.status, Status::Solved, "{name}");
        assert_eq!(solution.residuals.complementarity, 0.0, "{name}");
        assert!(solution.residuals.primal <= 1e-9, "{name}");
        let homotopy = crate::homotopy::homotopy(&mut case.program().unwrap()).unwrap();
        steps += 1;
        if homotopy.status.is_solved() {
            iterations += solution.iterations;
            of_homotopy += homotopy.iterations;
        }
        as_good += usize::from(
            !homotopy.status.is_solved() || solution.objective <= homotopy.objective + SAME,
        );
    }
    assert!(
        10 * iterations <= 4 * of_homotopy,
        "{iterations} against {of_homotopy}"
    );
    // of a step the objective is its equilibration: two keep a switch in another element than the homotopy
    assert!(5 * as_good >= 4 * steps, "{as_good} of {steps}");
    insta::assert_snapshot!(
        format!("{iterations} iterations, as good on {as_good} of {steps}"),
        @"990 iterations, as good on 17 of 19"
    );
}

hangtime::model! {
    /// A ball that is to end below the ground.
    Buried {
        parameters { m: kg = 0.5, g: m/s^2 = 9.81 }
        coordinates { y: m, z: m }
        lagrangian m/2*(dot(y)^2 + dot(z)^2) - m*g*z
        surface ground: z >= 0
        impact ground: inelastic
        finally { z == -0.5[m] }
        start { z: 0.5 [m], dot(y): 1 [m/s] }
        horizon 0.5 [s]
    }
}

#[test]
fn solve_goal_below_the_ground_is_infeasible_with_names() {
    let ball = Buried::default();
    let problem = Problem::of(&ball, 1);
    let mut program = TimeFreezing::new(&ball, &problem, &TimeFreezingSettings::default()).unwrap();
    let mut settings = Settings::default();
    settings.interior_point.objective_unit = Some(1.0);
    let solution = mpcc::solve(&mut program, &settings).unwrap();
    assert_eq!(solution.status, Status::Infeasible);
    let names: Vec<&str> = solution.violations.iter().map(|v| &v.name[..]).collect();
    insta::assert_snapshot!(
        format!("{} iterations: {}", solution.iterations, names.join("; ")),
        @"260 iterations: alpha _|_ ln of ground in element 1 of interval 0, 0.0000 to 0.5000 s; p _|_ w of ground at stage 0 of element 2 of interval 0, 0.0000 to 0.5000 s; p _|_ w of ground at stage 1 of element 2 of interval 0, 0.0000 to 0.5000 s; alpha _|_ ln of ground in element 2 of interval 0, 0.0000 to 0.5000 s; beta _|_ lp of ground in element 1 of interval 0, 0.0000 to 0.5000 s; p _|_ w of ground at stage 0 of element 1 of interval 0, 0.0000 to 0.5000 s"
    );
}

#[test]
fn names_say_variable_pair_element_and_time() {
    let cases = problems::cases();
    let case = cases
        .iter()
        .find(|case| case.name.starts_with("ball falls, 0.9"));
    let program = case.unwrap().program().unwrap();
    let last = program.complementarities().len() - 1;
    let of = |index| program.complementarity_name(index);
    insta::assert_snapshot!(of(0), @"p _|_ w of ground at stage 0 of element 0 of interval 0, 0.0000 to 0.9000 s");
    insta::assert_snapshot!(of(last), @"beta _|_ lp of ground in element 2 of interval 0, 0.0000 to 0.9000 s");
    let (i, j) = program.complementarities()[last];
    insta::assert_snapshot!(program.variable_name(i), @"sum of beta of ground in element 2 of interval 0, 0.0000 to 0.9000 s");
    insta::assert_snapshot!(program.variable_name(j), @"sum of lp of ground in element 2 of interval 0, 0.0000 to 0.9000 s");
    let names: Vec<String> = (0..program.variables())
        .map(|i| program.variable_name(i))
        .collect();
    for name in [
        "numerical length of interval 0, 0.0000 to 0.9000 s",
        "length of element 0 of interval 0, 0.0000 to 0.9000 s",
        "z at stage 0 of element 0 of interval 0, 0.0000 to 0.9000 s",
    ] {
        assert!(names.iter().any(|known| known == name), "{name}");
    }
    assert_eq!(
        scenes::Ball::default().declaration().contacts[0].name,
        "ground"
    );
}
