//! Optima at which the objective vanishes: relative differences of it mean nothing, and no condition has a multiplier.

use hangtime::ocp::Status;

use crate::support::attempt;

hangtime::model! {
    /// A block falls onto a floor and shall come as near to a goal, and to rest there, as can be: it can be there.
    Dropped {
        parameters { g = 9.81 }
        coordinates { y, z }
        controls { u in -4..=4 }
        lagrangian (dot(y)^2 + dot(z)^2)/2 - g*z
        forces { y: u }
        surface floor: z >= 0
        impact floor: inelastic, friction 0.2
        minimize (y - 1)^2 + dot(y)^2
        finally { z == 0 }
        start { z: 0.5 }
        horizon 2
    }
}

#[test]
fn goal_that_can_be_reached_is_found_on_a_finer_grid_as_well() {
    let intervals = 10;
    let solution = attempt(&Dropped::default(), intervals, &Default::default());
    // No condition has a multiplier there, so that programs of neighbours may not end.
    let found = matches!(solution.status, Status::Solved | Status::Uncertified);
    assert!(found, "{intervals}: {:?}", solution.diagnosis());
    assert!(solution.objective < 1e-20, "{}", solution.objective);
    // Motions with as many switches that differ by rounding are one local optimum on each grid.
    let best = solution.optima.iter().filter(|o| o.objective < 1e-9);
    let mut kinds: Vec<_> = best.map(|o| (o.intervals, o.switches)).collect();
    let all = kinds.len();
    kinds.sort_unstable();
    kinds.dedup();
    assert_eq!(kinds.len(), all, "{:?}", solution.optima);
}
