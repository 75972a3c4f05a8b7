//! Largest values in the objective of a compiled scene; of scenes as texts they stand in `tests/cases`.

use hangtime::prelude::*;

hangtime::model! {
    /// A cart that is brought past a place at a time with least fuel.
    Cart {
        coordinates { x: m }
        controls { u: N in -2..=2 }
        lagrangian dot(x)^2/2*1 [kg]
        forces { x: u }
        minimize integral(|u|) + peak(|u|)*2 [s]
        at 1 [s] { x >= 0.5 [m] }
        horizon 2 [s]
    }
}

#[test]
fn compiled_scene_has_largest_values_as_unknowns() {
    let cart = Cart::default();
    // 3/8 u_1 + u_2/8 = 1/2 on the two intervals before the time, and (u_1 + u_2)/2 + 2 max(u_1, u_2) is least where both are 1.
    let solution = solve(&cart).intervals(4).run().expect("accepted");
    assert!(solution.status.is_solved(), "{solution}");
    // What the solver lets pass of values of the order of one.
    assert!((solution.objective - 3.0).abs() < 1e-8, "{solution}");
    // What the scene itself says of it is the value with its kink.
    let mut values = [0.0];
    let x = [0.0, 0.0, 0.0, 0.0, -1.5, 0.0];
    hangtime::model::Model::values(&cart, hangtime::model::Function::Path, &x, &mut values);
    assert_eq!(values, [1.5]);
}
