//! Where newcomers stumble: a table of mistakes, each with its code, its place, and what the message says to write.

/// A point mass in a plane, a pendulum, and what is written into them.
fn scene(statements: &str) -> String {
    let pendulum = statements.contains("theta");
    let quantities = if pendulum {
        "parameters { m: kg = 1, l: m = 1, g: m/s^2 = 9.81 } coordinates { theta: rad }"
    } else {
        "parameters { m: kg = 1, g: m/s^2 = 9.81 } coordinates { y: m, z: m }"
    };
    let lagrangian = if pendulum {
        "lagrangian m/2*l^2*dot(theta)^2 + m*g*l*cos(theta)"
    } else {
        "lagrangian m/2*|dot((y, z))|^2 - m*g*z"
    };
    let own = |word: &str| statements.trim_start().starts_with(word);
    match (own("parameters"), statements.contains("lagrangian")) {
        (true, true) => statements.to_owned(),
        (true, false) => format!("{statements} {lagrangian}"),
        (false, true) => format!("{quantities} {statements}"),
        (false, false) => format!("{quantities} {lagrangian} {statements}"),
    }
}

answers! {
    rates_and_functions_are_answered_by_what_to_write: scene => r"
        lagrangian m/2*y'^2 + m/2*z'^2
            y' => `dot(y)`
            z' => `dot(z)`
        fn h(a) = a lagrangian m/2*|dot((y, z))|^2 - m*g*z*h'(y)
            h' => `diff(h)(...)`
        lagrangian m/2*y_dot^2 + m/2*zdot^2 - m*g*z
            E01 y_dot => `dot(y)`
            E01 zdot => `dot(z)`
        lagrangian m/2*y.dot^2 + m/2*dot(z)^2 - m*g*z
            E02 y.dot => `dot(y)`
        lagrangian m/2*y.dot()^2 + m/2*dot(z)^2 - m*g*z
            y.dot() => write `dot(y)`
        lagrangian m/2*dot(y).powi(2) + m/2*dot(z).powf(2.0) - m*g*z
            dot(y).powi(2) => write `dot(y)^2`
            dot(z).powf(2.0) => write `dot(z)^2.0`
        lagrangian m/2*l^2*dot(theta)^2 + m*g*l*cos theta
            cos => `cos(theta)`
        lagrangian m/2*l^2*dot(theta)^2 + m*g*l*(theta/2).cos()
            (theta/2).cos() => `cos(theta/2)`
        lagrangian m/2*l^2*dot(theta)^2 + m*g*l*cos 2*theta
            cos => `cos(2*theta)`
        ";
    numbers_are_answered_by_what_to_write: scene => r"
        parameters { m: kg = 1 kg, g = 9.81 m/s^2 } coordinates { y: m, z: m }
            1 kg => write `1 [kg]`
            9.81 m/s^2 => write `9.81 [m/s^2]`
        horizon 2 s
            2 s => write `2 [s]`
        horizon 2s
            2s => write `2 [s]`
        start { z: 2 m }
            m => a unit as `2 [m]` and a product as `2*m`
        parameters { m: kg = 1, g: m/s^2 = 9,81 } coordinates { y: m, z: m }
            9,81 => write `9.81`
        horizon 1,5 [s] start { z: 0,5, y: 2 }
            1,5 => write `1.5`
            0,5 => write `0.5`
        lagrangian m/2*|dot((y, z))|^2 - m*9,81*z
            9,81 => write `9.81`
        lagrangian 2.0_f64*m/4*|dot((y, z))|^2 - m*g*z
            2.0_f64 => write `2.0`
        lagrangian m/2*|dot((y, z))|^2 - m*g*z*PI
            E01 PI => the number is `pi`
        lagrangian m/2*|dot((y, z))|^2 - m*g*z*std::f64::consts::PI
            std::f64::consts::PI => write `pi`
        ";
    missing_parts_are_answered_by_what_to_write: scene => r"
        parameters { m: kg = 1 g: m/s^2 = 9.81 } coordinates { y: m z: m }
            g => a comma is missing before `g`
            z => a comma is missing before `z`
        start { y: 1 z: 2 }
            z => a comma is missing before `z`
        start { y: 1 dot(z): 2 }
            dot => a comma is missing before `dot(z)`
        finally { y == 1 [m] z == 2 [m] }
            z => a comma is missing before `z`
        free { y z }
            z => a comma is missing before `z`
        lagrangian m/2*|dot((y z))|^2 - m*g*z
            z => components as `y, z`
        surface a: z >= 0 impact a: restitution
            restitution => as in `restitution 0.5`
        surface a: z >= 0 impact a: restitution, friction 0.3
            restitution => as in `restitution 0.5`
        surface a: z >= 0 impact a: restitution = 0.7
            = => write `restitution 0.7`
        ";
    habits_of_other_languages_are_answered_by_what_to_write: scene => r"
        lagrangian m/2*pow(dot(y), 2) + m/2*d(z)^2
            E01 pow => `x^2`
            E01 d => `dot(y)`
        lagrangian m/2*|dot((y, z))|^2 - mgz
            E01 mgz => write `m*g*z`
        lagrangian m/2|dot((y, z))|^2 - m*g*z
            | => write a product as `m/2*|...|`
        lagrangian m/2*|dot((y, z))|^2 - m*g*z*sin^2(y/z)
            ( => write `sin(...)^2`
        parameters { m (kg) = 1, g [m/s^2] = 9.81 } coordinates { y: m, z: m }
            (kg) => write `m: kg`
            [m/s^2] => write `g: m/s^2`
        controls { u: N = 0 in -1..=1 } forces { y: u }
            in => bounds stand before the value
        # a comment that isn't one\nlet a = y'
            # => write `//`
            y' => `dot(y)`
        surface z >= 0
            > => as in `surface ground: z >= 0`
        ";
    places_and_angles_are_doubted_where_they_are_written: scene => r"
        surface a: z >= 1 [m] impact a: inelastic start { y: 7, z: 0.25 }
            E08 0.25 => gap of surface `a` is -0.75 m < 0
        surface a: z >= 1 [m] impact a: inelastic
            E08 a => write `start { z: ... }`
        constraint c: theta <= 30
            E23 30 => write `30 [deg]`
        surface a: -90 <= theta impact a: inelastic
            E23 -90 => write `-90 [deg]`
        start { theta: 45 }
            E23 45 => write `45 [deg]`
        constraint c: theta <= 30 [rad] start { theta: 45 [deg], dot(theta): 20 }
        constraint c: theta <= 2*pi
        constraint c: sin(theta) <= sin(30)
            E23 30 => the argument of `sin` is in rad
        constraint c: sin(theta) <= cos(30 [deg]) + sin(2)
        let a = y
            E16 a => leave it out
        ";
    units_and_unused_names_hide_no_other_mistakes: scene => r"
        // Units that differ, an unused name, a start inside the ground.
        let a = y lagrangian m/2*|dot((y, z))|^2 - m*g surface f: z >= 1 [m] impact f: inelastic start { z: 0.5 }
            E16 a => never used
            E03 - => `m*g` is in N
            E08 0.5 => -0.5 m
        // A coordinate without inertia.
        lagrangian m/2*dot(y)^2 - m*g*y surface f: z >= 1 impact f: inelastic
            E05 z => kinetic energy
            E03 z >= 1 => `1 [m]`
        // A negative kinetic energy, which shows in what is derived only.
        lagrangian m/2*dot(y)^2 - m/2*dot(z)^2 - m*g*z finally { y == 3 }
            E06 z => signs
            E03 y == 3 => `3 [m]`
        // Two terms of one sum; the third one fits the first of them.
        lagrangian m/2*|dot((y, z))|^2 - m*g + m*z - m*g
            E03 - => `m*g` is in N
            E03 + => `m*z` is in kg m
        // A name that is not declared hides no place.
        surface f: z >= 1 [m] impact f: inelastic forces { y: q } start { z: 0.5 }
            E01 q => not declared
            E08 0.5 => -0.5 m
        // What could not be read is no start at zero.
        surface f: z >= 1 [m] impact f: inelastic start { z: 2 ~ }
            ~ => expected `,` or `}`
        ";
    mistakes_stand_at_the_words_that_make_them: scene => r"
        constraint top: z <= 3 [m] free { dot(y) in 1..=3, z in 2..=1 } start { dot(y): 4 }
            E17 2..=1 => lower bound 2 of `z` lies above its upper bound 1
            E17 4 => `dot(y)` starts at 4, outside its bounds 1..=3
        lagrangian m/2*(dot(y) + dot(z))^2 - m*g*z
            E06 z => `z` carries no inertia of its own
        lagrangian m/2*dot(z)^2 - m*g*z - m*g*y
            E05 y => the Lagrangian is not quadratic in `dot(y)`
        lagrangian -m*g*z
            E04 lagrangian => the Lagrangian contains no velocity
        surface a: z >= 0 surface b: y >= 0 impact a: restitution 1.2 impact b: inelastic, friction -0.3
            E10 1.2 => is outside [0, 1]
            E10 -0.3 => the force would drive the sliding
        surface a: z >= 0 surface b: y >= 0 impact a: inelastic, holding z impact b: inelastic, holding x
            E09 a => all coordinates that the gap of `a` depends on are held
            E01 x => `x` is not declared (coordinates: `y`, `z`)
        surface a: z >= 0 impact a: inelastic, restitution 0.5
            E20 inelastic => `inelastic` and `restitution` exclude each other
        surface a: z >= 0 impact a: inelastic, along (1, 1), friction 0.3
            E20 along => `along` and `friction` exclude each other
        surface a: z >= 0 impact a: inelastic, sliding dot(y)
            E20 sliding => there is no `friction`
        surface a: z >= 0 impact a: inelastic, friction 0.3, sliding y
            E07 y => the sliding velocity `y` contains no velocity
        surface a: y >= 0 impact a: inelastic, friction 0.3, sliding dot(z)/1 [m]
            E03 dot(z)/1 [m] => is in 1/s, where m/s is needed
        surface a: theta >= 0 impact a: inelastic, friction m/1 [kg]
            E20 m/1 [kg] => `friction` of `a` needs the sliding velocity
        parameters { m: kg = 1, g: m/s^2 = 9.81, clock = 1 } coordinates { y: m, z: m }
            E11 clock => reserved for the clock of the time-freezing reformulation
        controls { u: N } forces { y: u } finally { u == 0, y = 3 [m] }
            E15 u => a terminal condition depends on the control `u`
            = => a condition is written with `==`, `>=` or `<=`
        constraint mass: m >= 0 constraint late: y <= 1 [m/s]*time
            E15 m >= 0 => is the same for every motion
            E01 time => the time at each instant is `t`
        controls { u: N } forces { y: u } minimize time + integral(u^2) finally { y == 1 }
            E03 + => `time` is in s
            E03 y == 1 => `1` has no unit
        lagrangian m/2*|dot((y, z))|^2 - m*g*abs(z)
            E12 abs(z) => `abs` has a kink or a jump
        lagrangian m/2*|dot((y, z))|^2 - m*g*z - m*|dot((y, z))|*1 [m/s]
            E13 m/2*|dot((y, z))|^2 - m*g*z - m*|dot((y, z))|*1 [m/s] => not differentiable at rest
        surface a: m >= 0 impact a: inelastic
            E07 m >= 0 => surface `a` depends on no coordinate
        surface a: z + 1 [m] >= z impact a: inelastic
            E09 z + 1 [m] >= z => the coordinates cancel out of surface `a`
        surface a: z >= 0 impact ab: inelastic
            E20 a => surface `a` has no impact law
            E20 ab => there is no surface `ab`
        surface a: z >= 0 surface b: 2*z >= 0 impact a, b: inelastic
            E18 b => surfaces `a` and `b` are the same
        surface a: dot(z) >= 0 impact a: inelastic
            E07 dot(z) >= 0 => surface `a` depends on the velocity `dot(z)`
        surface a: z >= 45 - y/2 impact a: inelastic
            E03 - => `45` has no unit, `y/2` is in m
        lagrangian m/2*dot((y, z)) - m*g*z
            E02 - => both must have the same size
        ";
    planted_slips_are_caught_where_they_were_made: scene => r"
        // A square too many, and one forgotten.
        lagrangian m/2*dot(y)^2^2 + m/2*dot(z)^2 - m*g*z
            ^ => put the inner one in parentheses, as in `dot(y)^(2^2)`
        lagrangian m/2*|dot((y, z))| - m*g*z
            E13 m/2*|dot((y, z))| - m*g*z => a root or norm of velocities is not differentiable at rest; square it, as in `|dot(p)|^2`
        // Potential minus kinetic energy.
        parameters { m: kg = 1, g: m/s^2 = 9.81 } coordinates { z: m } lagrangian m*g*z - m/2*dot(z)^2
            E06 z => the kinetic energy of a motion with dot(z) = 1 is negative … check its signs and the masses
        // One wrong sign in the kinetic energy, which shows in a combination of two motions only.
        parameters { m: kg = 1, k: N/m = 3 } coordinates { y: m, z: m } lagrangian m/2*(dot(y) + 2*dot(z))^2 - m/2*dot(z)^2 - k/2*y^2
            E06 z => the kinetic energy of a motion with dot(y) = -2, dot(z) = 1 is negative
        // A mass that is zero.
        parameters { m: kg = 0 } coordinates { z: m } lagrangian m/2*dot(z)^2 start { z: 1 }
            E06 z => not positive definite at the start … a motion with dot(z) = 1 has no kinetic energy … start elsewhere
        // Damping that drives.
        dissipation -0.1 [N s/m]*dot(y)^2
            E10 -0.1 [N s/m]*dot(y)^2 => it feeds energy into `dot(y)`; a damper is written with a plus sign, as in `c/2*dot(y)^2`
        // Mass and length exchanged.
        parameters { m: m = 80, l: kg = 2, g: m/s^2 = 9.81 } coordinates { a: rad } lagrangian m/2*|dot(l*(sin(a), -cos(a)))|^2 + m*g*l*cos(a)
            E03 + => `m/2*|dot(l*(sin(a), -cos(a)))|^2` is in kg^2 m/s^2, `m*g*l*cos(a)` is in J; both sides of `+` must agree
        // A distance for a speed.
        start { z: 1, dot(y): 15 [km] }
            E03 15 [km] => `15 [km]` is in m, where m/s is needed (it is the start value of `dot(y)`)
        // A number without its unit, and a length for an angle.
        surface wall: y >= 3 impact wall: inelastic
            E03 y >= 3 => `y` is in m, `3` has no unit … write it in brackets, as in `3 [m]`
        lagrangian m/2*|dot((y, z))|^2 - m*g*(z + 1 [m]*sin(y))
            E03 y => `sin` needs a pure number, `y` is in m
        // The free side of the ground exchanged, and a start below a slope.
        surface ground: z <= 0 impact ground: inelastic start { z: 2 }
            E08 2 => the gap of surface `ground` is -2 m < 0; start at a gap of 0 or more, or exchange `>=` and `<=`
        fn slope(y) = 4 [m] - y/2 surface hill: z >= slope(y) impact hill: inelastic start { y: 5, z: 1 }
            E08 1 => the start lies inside the ground: with the defaults of the parameters the gap of surface `hill` is -0.5 m < 0
        // Centimetres for metres.
        parameters { m: kg = 1 } coordinates { z: m in 0..=9 } lagrangian m/2*dot(z)^2 start { z: 50 }
            E17 50 => `z` starts at 50, outside its bounds 0..=9
        // A rotation of the plane for a vector of space.
        let p = rotation(y/1 [m])*(y, z, 0) lagrangian m/2*|dot(p)|^2 - m*g*z
            E02 * => a 2 by 2 matrix (`rotation(y/1 [m])`) and a vector with 3 components (`(y, z, 0)`)
        // A misspelt name.
        lagrangian m/2*|dot((y, z))|^2 - m*G*z
            E01 G => `G` is not declared; did you mean `g`?
    ";
    start_that_other_parameters_decide_is_left_to_the_run: str::to_owned => r"
        // Zero is no declared start: polar coordinates are singular there, and the ground may be above it.
        coordinates { r, a } lagrangian dot(r)^2 + r^2*dot(a)^2 surface ground: r >= 1 impact ground: inelastic
            E08 ground => no `start` is declared
        // A start that is to be found is not a given one.
        coordinates { z } lagrangian dot(z)^2 surface ground: z >= 1 impact ground: inelastic start { z: 0 } free { z } minimize time finally { z == 2 }
        // On the ground up to rounding.
        parameters { a = 0.1 } coordinates { z } lagrangian dot(z)^2 surface ground: z >= 3*a impact ground: inelastic start { z: 0.3 }
    ";
}

#[test]
fn surfaces_that_nothing_ever_touches_are_doubted() {
    let of = |gap: &str| format!("surface a: {gap} impact a: inelastic start {{ z: 1 [m] }}");
    let at_angle = |gap: &str| format!("surface a: {gap} impact a: inelastic");
    for (text, least) in [
        (at_angle("sin(theta) <= 2"), "nowhere less than 1;"),
        (of("y^2 + z^2 + 1 [m^2] >= 0"), "nowhere less than 1 m^2;"),
        (of("sqrt(y^2 + z^2) >= -0.25 [m]"), "0.25 m;"),
        (of("1/(1 + (y/1 [m])^2) <= 3"), "less than 2;"),
        (of("exp(-z/1 [m]) + tanh(y/1 [m]) >= -3"), "less than 2;"),
        (of("max(z, y^2/1 [m] + 2 [m]) >= 0"), "less than 2 m;"),
    ] {
        crate::assert_answers(
            scene,
            &format!("        {text}\n            E07 a => {least}"),
        );
    }
    // What can be touched at one place, or by one piece, is not.
    for gap in [
        "cos(y/1 [m]) <= 1",
        "exp(y/1 [m]) >= 0",
        "z^2/1 [m] + y >= -2 [m]",
        "min(z, y^2/1 [m] + 2 [m]) >= 0",
        "1/(y + 2 [m]) >= -1/1 [m]",
        "z >= 0.1*t*1 [m/s]",
    ] {
        crate::assert_answers(scene, &format!("        {}", of(gap)));
    }
}
