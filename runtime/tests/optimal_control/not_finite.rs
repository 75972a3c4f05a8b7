//! Guesses at which the functions of a model are not finite.

#![allow(clippy::unwrap_used, reason = "a failed step is a failed test")]

use hangtime::ocp::{Problem, Status, solve};

use crate::support::attempt;

hangtime::model! {
    /// A bead runs up within a hoop, with as little energy as keeps it there. The line from its lowest point to the highest goes through the
    /// centre, where the gap has no gradient.
    Hoop {
        parameters { g = 10 }
        coordinates { y, z }
        lagrangian (dot(y)^2 + dot(z)^2)/2 - g*z
        surface hoop: y^2 + z^2 <= 1
        impact hoop: inelastic
        minimize (dot(y)^2 + dot(z)^2)/2 + g*(z + 1)
        finally { y == 0, z == 1, time <= 4 }
        free { dot(y) in 0..=20 }
        start { z: -1, dot(y): 8 }
        horizon 1
    }
}

hangtime::model! {
    /// A force that is not a number from the start on.
    Nowhere {
        coordinates { y }
        controls { u in -1..=1 }
        lagrangian dot(y)^2/2
        forces { y: u + ln(y - 2) }
        minimize integral(u^2)
        finally { y == 1 }
        horizon 1
    }
}

#[test]
fn guess_that_is_not_finite_leaves_others() {
    // At the top gravity alone holds the bead: dot(y)^2 = g, and the energy is 5/2 g.
    let solution = attempt(&Hoop::default(), 10, &Default::default());
    assert!(
        matches!(solution.status, Status::Solved | Status::Uncertified),
        "{:?}",
        solution.diagnosis()
    );
    // A bead that leaves the hoop a little before its top is held back by the shortest phase, as the result says.
    let own = solution.margins.iter().filter(|margin| !margin.chosen);
    let held_back: f64 = own.map(|margin| margin.cost).sum();
    assert!(
        (solution.objective - 25.0).abs() < 1e-7 + held_back,
        "{}",
        solution.objective
    );
    assert!(solution.resimulation_error < 1e-6);
}

#[test]
fn model_that_is_finite_at_no_guess_is_refused() {
    let model = Nowhere::default();
    let problem = Problem::of(&model, 10);
    let refused = solve(&model, &problem, &Default::default(), &mut |_| true);
    let message = refused.unwrap_err().to_string();
    assert!(message.contains("force on `y`"), "{message}");
    assert!(message.contains("not finite"), "{message}");
}
