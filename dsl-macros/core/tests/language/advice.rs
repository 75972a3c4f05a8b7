//! Slips of people who come from elsewhere: each message says what to write here.

const CART: &str =
    "parameters { m: kg = 2, i: kg m^2 = 0.3, g: m/s^2 = 9.81 } coordinates { s: m, phi: rad }";

/// A cart of two coordinates, with its energy and further statements.
fn moved(statements: &str) -> String {
    format!("{CART} lagrangian m/2*dot(s)^2 + i/2*dot(phi)^2 - m*g*s {statements}")
}

/// What is said of the text of a file; empty where nothing is.
fn of_text(text: &str) -> Vec<String> {
    let found = crate::mistakes_or_warnings(text).into_iter();
    found.map(|mistake| mistake.message).collect()
}

/// The only message, which contains all of the words.
fn assert_says(messages: &[String], words: &[&str]) {
    let [message] = messages else {
        panic!("{words:?}: {messages:?}");
    };
    for word in words {
        assert!(message.contains(word), "{word}: {message}");
    }
}

answers! {
    sign_and_size_of_a_velocity_act_and_name_dry_friction_and_drag_elsewhere: moved => r"
        forces { s: -3 [N]*sign(dot(s)) }
        let w = dot(s) - 1 [m/s] forces { s: -3 [N]*sign(w) }
        forces { s: -3 [kg/m]*|dot(s)|*dot(s) }
        forces { s: -3 [N]*sign(s) }
        dissipation 3 [N]*sign(dot(s))*dot(s)
            E12 sign(dot(s)) => dry friction name: bound f, sliding dot(s)
        dissipation 3 [kg/m]*|dot(s)|*dot(s)^2
            E12 dot(s) => `sqrt(dot(s)^2 + v_0^2)` … dry friction
        dissipation 3 [kg/m]*sqrt(dot(s)^2 + (1 [mm/s])^2)*dot(s)^2
    ";
    laws_without_a_surface_ask_for_its_name: moved => r"
        surface floor: s >= 0 [m] impact restitution 0.4 start { s: 1 }
            restitution => `impact name: restitution ...`
    ";
    integrals_and_bounds_are_written_as_they_are_written_here: moved => r"
        controls { u: N } forces { s: u } minimize integral u^2
            u => `integral(u)`
        controls { u: N in [-2, 3] } forces { s: u } minimize integral(u^2)
            [ => in -2..=3
        controls { u: N in (0, 4) } forces { s: u } minimize integral(u^2)
            ( => in 0..=4
        controls { u: N in [-1; 1] } forces { s: u } minimize integral(u^2)
            [ => in -1..=1
        controls { u: N in -2..3 } forces { s: u } minimize integral(u^2)
            . => `-2..=`
        controls { -2 <= u <= 3 } forces { s: u } minimize integral(u^2)
            - => `u in -2..=3`
        controls { u: N } forces { s: u } minimize integral(u^2) constraint c: -2 [N] <= u <= 3 [N]
            < => two conditions … `u in -1..=1`
        controls { u: N } forces { s: u } minimize T
            E01 T => `minimize time`
    ";
    undeclared_force_is_a_control_and_an_undeclared_velocity_a_rate: moved => r"
        forces { s: thrust }
            E01 thrust => `controls { thrust: N }`
        start { sdot: 1 }
            E01 sdot => `dot(s)`
        start { s_dot: 1 }
            E01 s_dot => `dot(s)`
        start { ds: 1 }
            E01 ds => `dot(s)`
    ";
    units_of_angles_are_called_as_usual: moved => r"
        forces { phi: 4 [N] }
            E03 4 [N] => is in N, where N m is needed
        controls { tau: N m } forces { phi: tau, s: tau }
            E03 tau => `tau` is in N m, where N is needed
        start { dot(phi): 2 [m/s] }
            E03 2 [m/s] => where rad/s is needed
        start { dot(s): 2 [rad/s] }
            E03 2 [rad/s] => is in rad/s, where m/s is needed
    ";
    equations_of_motion_are_said_to_follow: moved => r"
        m*ddot(s) = -m*g
            m => follow from the `lagrangian` … `forces { x: ... }`
        i*ddot(phi) = 2 [N m]
            i => follow from the `lagrangian` … `forces { x: ... }`
        forces { s: m*ddot(s) }
            E01 ddot => accelerations follow
        let v = dot(s) forces { (s, phi): v }
            ( => one for each
    ";
    unknown_statements_say_what_to_write: moved => r"
        damping s: 3
            damping => dissipation
        gravity 9.81
            gravity => gravity (0, -g)
        initial s: 1
            initial => start {
        goal s: 1
            goal => finally {
        variables s
            variables => coordinates {
        inputs u
            inputs => controls {
        ground s >= 0
            ground => surface name:
        duration 3
            duration => horizon
        cost time
            cost => minimize
    ";
    profile_of_a_file_names_its_command: |text| format!("{CART} {text}") => r#"
        profile h(x: m): m "track.csv" lagrangian m/2*dot(s)^2 + i/2*dot(phi)^2 - m*g*s
            "track.csv" => `hangtime profile track.csv`
    "#;
}

#[test]
fn electric_and_turning_units_are_known() {
    // In each term the units of one more: the scene is accepted only if all of them fit.
    let scene = "
        parameters {
            m: kg = 1, l: H = 1, flux: Wb = 1, field: T = 1, area: m^2 = 1, c: F = 1, v: V = 1, i: A = 1, r: Ohm = 1, s: S = 1,
            turn: rev = 1, day: d = 1,
        }
        coordinates { x: m, a: rad }
        lagrangian m/2*dot(x)^2 + m*(1 [m])^2/2*dot(a)^2 - l*i^2/2 - (flux + field*area)*i - c*v^2/2 - r*i^2*day - s*v^2*day
            - 1 [J]*cos(a - turn)*x/1 [m]";
    assert_eq!(of_text(scene), [""; 0]);
}

#[test]
fn words_of_rust_are_names_in_files_and_not_in_macros() {
    let scene = "parameters { type: kg = 1, loop: m = 2, move: N = 3, match: m = 1 } coordinates { self: m }
        lagrangian type/2*dot(self)^2 - move*self^2/(loop + match)";
    assert_eq!(of_text(scene), [""; 0]);
    let compiled = hangtime_dsl::mistakes(format!("S {{ {scene} }}").parse().unwrap());
    assert!(
        compiled
            .iter()
            .all(|mistake| mistake.message.contains("word of Rust"))
    );
    assert!(!compiled.is_empty());
}

#[test]
fn components_carry_the_names_of_the_coordinates_that_they_hold() {
    // Each pair of scenes is one and the same if the component is the coordinate that it is called after.
    for (coordinates, vector, component, wanted) in [
        ("x, y", "(x, y)", "p.y", "y"),
        ("x, y", "(x, y)", "p.x", "x"),
        ("x, y", "2*(x, y) + (cos(x), sin(y))", "p.y", "2*y + sin(y)"),
        ("x, y", "dot((y, x))", "p.y", "dot(y)"),
        ("x, y", "rotation(x)*(1, x)", "p.y", "sin(x) + cos(x)*x"),
        ("x, y, z", "(x, y)", "p.y", "y"),
        ("x, y, z", "(z, x)", "p.z", "z"),
        ("x, z", "(x, z)", "p.x", "x"),
        ("x, z", "(x, z)", "p.y", "x"),
        (
            "x, z",
            "(x, z) + rotation(x)*(1, 2)",
            "p.z",
            "z + sin(x) + 2*cos(x)",
        ),
        ("a, b", "(a, b)", "p.y", "a"),
        ("a, b", "(a, b)", "p.z", "b"),
    ] {
        let energy = coordinates
            .split(", ")
            .map(|q| format!("dot({q})^2/2"))
            .collect::<Vec<_>>()
            .join(" + ");
        let scene = |of: &str, value: &str| {
            let text =
                format!("coordinates {{ {coordinates} }} {of} lagrangian {energy} + ({value})^2");
            hangtime_dsl::describe_text(&text, "s").map(|(scene, _)| scene)
        };
        let named = scene(&format!("let p = {vector}"), component);
        assert!(
            named.is_ok() && named == scene("", wanted),
            "{vector}: {component} is {wanted}: {named:?}"
        );
    }
    let none = of_text("coordinates { x, y } let p = (x, y) lagrangian |dot(p)|^2 - p.z");
    assert_says(&none, &["`x`, `y`; there is no `z`"]);
}

#[test]
fn friction_in_space_is_not_said_to_have_one_direction() {
    let scene = |law: &str| {
        of_text(&format!(
            "parameters {{ m: kg = 3 }} coordinates {{ x: m, y: m, z: m }} lagrangian m/2*|dot((x, y, z))|^2 - m*9.81 \
             [m/s^2]*z surface floor: z >= 0 impact floor: {law}"
        ))
    };
    let asked = scene("inelastic, friction 0.4");
    assert_says(&asked, &["a contact in space has two"]);
    assert!(!asked[0].contains("sliding dot("), "{asked:?}");
    assert_says(
        &scene("inelastic, friction 0.4, sliding dot(y)"),
        &["slides on for ever"],
    );
    assert_eq!(scene("restitution 0.5"), [""; 0]);
    let sliding = |both: &str| scene(&format!("inelastic, friction 0.4, sliding ({both})"));
    for (wrong, words) in [
        ("dot(x), dot(x) + dot(y)", "angle is 0.707"),
        ("dot(x), 2*dot(y)", "2.0000 times what"),
        ("dot(x) + 0.75*dot(z), dot(y)", "not along the surface"),
    ] {
        assert_says(&sliding(wrong), &[words, "scaled like the gap"]);
    }
    for right in [
        "dot(x), dot(y)",
        "0.6*dot(x) + 0.8*dot(y), 0.8*dot(x) - 0.6*dot(y)",
    ] {
        assert_eq!(sliding(right), [""; 0], "{right}");
    }
    let on_cart = |sliding: &str| {
        of_text(&format!(
            "parameters {{ m: kg = 3 }} coordinates {{ b: m, c: m, h: m }} lagrangian m/2*|dot((b, c, h))|^2 - m*9.81 \
             [m/s^2]*h surface cart: h >= 0 impact cart: inelastic, friction 0.4, sliding {sliding}"
        ))
    };
    assert_eq!(on_cart("dot(b) - dot(c)"), [""; 0]);
    assert_says(&on_cart("0.6*dot(b) + 0.8*dot(c)"), &["slides on for ever"]);
}

#[test]
fn number_that_is_chosen_and_moves_is_named_and_a_body_that_is_released_is_not() {
    let task = |kinetic: &str, potential: &str| {
        of_text(&format!(
            "parameters {{ m: kg = 2, dummy: kg m^2 = 1, g: m/s^2 = 9.81 }} coordinates {{ s: m, slope: rad in 0..=1.5 }} \
             lagrangian m/2*dot(s)^2 + {kinetic} - {potential} minimize time finally {{ s == 2 [m] }} \
             free {{ slope in 0.2..=1.2 }} start {{ slope: 0.4 }} horizon 2 [s]"
        ))
    };
    let named = task("dummy/2*dot(slope)^2", "m*g*s*sin(slope)");
    assert_says(&named, &["`slope`", "`dummy`", "does not stay"]);
    // Nothing acts on it.
    assert_eq!(task("dummy/2*dot(slope)^2", "m*g*s"), [""; 0]);
    // The inertia is that of a body with weight.
    assert_eq!(
        task("dummy/2*dot(slope)^2", "(m*s + dummy/1 [m])*g*sin(slope)"),
        [""; 0]
    );
    // A pendulum that is let go at an angle that is to be found: its inertia is that of its weight.
    assert_eq!(
        task(
            "m/2*(dummy/m)*dot(slope)^2*(m/1 [kg])",
            "m*g*(s + dummy/(1 [kg m]))*sin(slope)"
        ),
        [""; 0]
    );
}
