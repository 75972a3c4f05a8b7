//! Free parameters: what they derive, and what is refused with what to write instead.

use crate::formatted;
use hangtime_dsl::{describe_held, describe_text};

/// A mass on a spring that is to be chosen, with the words for it and further statements.
fn scene(free: &str, further: &str) -> String {
    format!(
        "parameters {{ m: kg = 1 }} {free} coordinates {{ z: m }} controls {{ u: N in -1..=1 }} \
         lagrangian m/2*dot(z)^2 - k/2*z^2 forces {{ z: u }} {further}"
    )
}

const FREE: &str = "free k: N/m in 1..=10 = 2";
const TASK: &str = "minimize integral(u^2) finally { z == 1 [m] } horizon 1 [s]";

/// The scene with words for what is to be chosen, and statements behind a semicolon if it has another task.
fn chosen(words: &str) -> String {
    let (free, task) = words.split_once("; ").unwrap_or((words, TASK));
    scene(free, task)
}

answers! {
    mistakes_with_free_parameters_say_what_to_write: chosen => r"
        free k: N/m = 2
            k => needs the range in which it is looked for, as in `free k: N/m in 1..=10 = 2` … stands in braces, `free { k }`
        free k: N/m in 1..=10
            k => needs a value to begin with, as in `free k: N/m in 1..=10 = 2` … stands in braces, `free { k in ... }`
        free k: N/m in 1..=10 = 20
            E17 k => `k` starts at 20, outside its bounds 1..=10
        free k: N/m in 10..=1 = 2
            E17 10..=1 => lower bound 10 of `k` lies above its upper bound 1; exchange them
        free k: N/m in 1..=10 = 2; horizon 1 [s]
            E15 k => free parameter `k` in a scene without `minimize` … add an objective, or write `parameters { k = ... }`
        free k: N/m in 1..=10 = 2 free extra: N in 1..=2 = 1
            E15 extra => nothing in the motion, its conditions or its objective reads the free parameter `extra` … use it or leave it out
        free k: N/m in 1..=10 = 2 free most: m in 1..=2 = 1; minimize integral(u^2) finally { z == most } free { z in 0..=most } horizon 1 [s]
            most => a bound of `z` depends on the free parameter `most` … as a condition, such as `constraint limit: z <= most`
        free k: N/m in 1..=far = 2 free far: N/m in 5..=10 = 6; minimize far finally { z == 1 [m] } horizon 1 [s]
            far => a bound of `k` depends on the free parameter `far` … as a condition, such as `constraint limit: k <= far`
        free k: N/m in 1..=10 = m*2 [N/m/kg]
            m*2 [N/m/kg] => the default of parameter `k` must be a number; abbreviations of other parameters belong to `let`
        free k: N/m in 1..=10 = 2 free m: kg in 1..=2 = 1
            E19 m => `m` is declared twice; rename this parameter
        parameters { k: N/m in 1..=10 = 2 }
            1 => bounds belong to coordinates, controls and free parameters; parameter `k` has none … `free k...` outside of
        free k: N/m in 1..=10 = 2 [m]
            E03 2 [m] => units differ
    ";
}

#[test]
fn free_parameter_is_a_parameter_with_a_range_and_nothing_else_changes() {
    let (free, _) = describe_text(&scene(FREE, TASK), "s").expect("no mistakes");
    let known = free.structure.free_parameters.expect("declared");
    assert_eq!(known.parameters, [1]);
    assert!(free.structure.held.is_none());
    let (plain, _) =
        describe_text(&scene("parameters { k: N/m = 2 }", TASK), "s").expect("no mistakes");
    assert!(plain.structure.free_parameters.is_none());
    assert_eq!(
        (free.structure.given, free.structure.declaration),
        (plain.structure.given, plain.structure.declaration)
    );
    let kernels = plain.kernels.len();
    assert_eq!(free.kernels[..kernels], plain.kernels);
    assert_eq!(free.kernels.len(), kernels + 2);
}

#[test]
fn held_parameter_has_a_column_everywhere_no_motion_and_no_contact() {
    let text = "
        parameters { m: kg = 1, g: m/s^2 = 9.81 }
        free h: m in 0..=1 = 0.5
        free e in 0..=1 = 0.5
        coordinates { y: m, z: m }
        lagrangian m/2*(dot(y)^2 + dot(z)^2)*(1 + h/1 [m]) - m*g*z
        surface ground: z - h*sin(y/1 [m]) >= 0
        impact ground: restitution e, friction e/2, sliding dot(y)
        start { z: 2*h }
        minimize h/1 [m] - z/1 [m]
        constraint small: h + e*1 [m] <= 1.2 [m]
        constraint low: z <= 3 [m]
        horizon h*1 [s/m]
    ";
    let (derived, _) = describe_held(text, "s", &["h", "e"]).expect("no mistakes");
    use hangtime_dsl::declaration::Given;
    let declaration = derived.structure.declaration;
    assert_eq!(declaration.coordinates.len(), 4);
    let held = derived.structure.held.expect("asked for").declared;
    assert_eq!(held.parameters, [2, 3]);
    assert_eq!(
        held.given,
        [
            Given::Start(1),
            Given::Horizon,
            Given::Restitution(0),
            Given::Friction(0)
        ]
    );
    assert_eq!(held.jacobian.entries, [(0, 2), (1, 2), (2, 3), (3, 3)]);
    // Rows of coordinates without motion are empty, and so are the columns of their velocities.
    let entries = declaration.free_jacobian.entries;
    assert!(
        entries
            .iter()
            .all(|&(row, column)| row < 2 && !(6..8).contains(&column))
    );
    let contact = declaration.contacts[0].jacobian.entries;
    assert!(contact.contains(&(0, 2)) && contact.contains(&(1, 2)));
    assert!(
        contact
            .iter()
            .all(|&(row, column)| row < 4 && !(6..8).contains(&column))
    );
    let task = declaration.optimal_control.expect("declared");
    assert_eq!(task.free_start, [2, 3]);
    // What reads nothing that moves holds once, at the end.
    assert_eq!((task.constraints.len(), task.goals.len()), (1, 1));
}

#[test]
fn free_parameters_are_formatted_like_the_statements_around_them() {
    let text = "parameters{m:kg=1}\nfree  k :N/m in 1..=10=2 // found\ncoordinates { z: m }\nlagrangian m/2*dot(z)^2-k/2*z^2\nminimize z/1[m]";
    let formatted = formatted(text);
    assert!(
        formatted.contains("\nfree k: N/m in 1..=10 = 2 // found\n"),
        "{formatted}"
    );
}
