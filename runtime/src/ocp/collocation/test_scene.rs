//! A scene that declares everything that optimal control knows, and how the tests of this layer set a scene.

use super::discretization::{Lengths, Setting, parabolas};
use crate::model::Model;
use crate::ocp::global::guess::guess;
use crate::ocp::motion::control_grid::ControlShape;
use crate::ocp::motion::trajectory::Trajectory;
use crate::ocp::problem::{Problem, bounds};
use crate::ocp::program::units::Units;
use crate::ocp::scale::Scale;
use crate::ocp::settings::Guess;
use crate::rk::{ButcherTableau, Scheme};

crate::model! {
    /// A sledge on a wavy slope, with an engine along the ground and a rider that shifts.
    pub(super) Demanding {
        parameters { m: kg = 2, g: m/s^2 = 9.81, w: 1/m = 3 }
        coordinates { y: m, z: m, r: m in -1..=1 }
        controls { u: N in -5..=5, p: N in -3..=3 }
        fn ground(y) = 0.1[m]*sin(w*y)
        lagrangian m/2*(dot(y)^2 + dot(z)^2 + dot(r)^2) - m*g*z
        forces { y: u*cos(w*y), r: p }
        surface ground: z - ground(y) >= 0
        impact ground: inelastic
        minimize integral(u^2 + y*p*1[N/m]) + (time*1[m^2/s] + y*z)*1[N^2 s/m^2]
        constraint speed: dot(y)^2 + u*r*1[1/kg] <= 8 [m^2/s^2]
        constraint height: z == 2 [m]
        finally { y + 0.1*z^2/1[m] == 1.5 [m], time*y >= 0.1 [m s] }
        free { z in 0.3..=0.8 }
        start { z: 0.5 [m], dot(y): 1 [m/s] }
    }
}

/// Calls `check` with the setting of a problem on a scheme of so many stages, and a motion to start from.
pub(super) fn with_setting(
    (model, problem): (&dyn Model, &Problem),
    (shape, stages, kind): (ControlShape, usize, Guess),
    check: impl Fn(Setting, &Trajectory),
) {
    let (lower, upper) = bounds(model);
    let bounds = (&lower[..], &upper[..]);
    let guessed = guess(model, problem, &kind, bounds).unwrap();
    let units = Units::new(model, &Scale::of(model, problem), &guessed, bounds);
    let tableau = ButcherTableau::new(Scheme::RadauIia, stages).unwrap();
    let parabolas = parabolas(model, &problem.start());
    let setting = Setting {
        model,
        problem,
        tableau: &tableau,
        units: &units,
        bounds,
        parabolas: &parabolas,
        shape,
        lengths: Lengths::Equal,
        elastic: None,
        kept: 1.0,
        haste: 0.0,
        mesh: None,
    };
    check(setting, &guessed);
}
