//! Slips that a student makes: each is caught at compile time, at the place where it was made, by a message
//! that says what to do.

use hangtime_dsl::Mistake;

/// The declaration without the marks `<<` and `>>`, and the text between them.
fn unmarked(source: &str) -> (String, String) {
    let (before, rest) = source.split_once("<<").expect("a mark");
    let (inside, after) = rest.split_once(">>").expect("a second mark");
    (format!("{before}{inside}{after}"), inside.to_owned())
}

/// What a message points at.
fn pointed(source: &str, mistake: &Mistake) -> String {
    let [start, end] = mistake.place();
    let place = |line_column: proc_macro2::LineColumn| {
        let line = source.split_inclusive('\n').take(line_column.line - 1);
        line.map(|line| line.chars().count()).sum::<usize>() + line_column.column
    };
    let characters = source.chars().skip(place(start.start()));
    characters
        .take(place(end.end()) - place(start.start()))
        .collect()
}

/// A point mass of 1 kg in a plane.
fn mass(statements: &str) -> String {
    format!(
        "pub S {{ parameters {{ m: kg = 1, g: m/s^2 = 9.81 }}
         coordinates {{ y: m, z: m in 0..=9 }} {statements} }}"
    )
}

/// Each slip is the only mistake, and the message points at its mark.
fn assert_caught<const N: usize>(slips: [(String, &str); N]) {
    for (marked, wanted) in slips {
        let (source, place) = unmarked(&marked);
        let mistakes = hangtime_dsl::try_expand(source.parse().expect("tokens"))
            .err()
            .unwrap_or_default();
        let texts: Vec<String> = mistakes.iter().map(Mistake::text).collect();
        assert_eq!(texts, [wanted], "{source}");
        assert_eq!(pointed(&source, &mistakes[0]), place, "{wanted}");
    }
}

#[test]
fn planted_slips_of_energies_are_caught_where_they_were_made() {
    assert_caught([
        // A square too many.
        (
            mass("lagrangian m/2*dot(y)<<^>>2^2 + m/2*dot(z)^2 - m*g*z"),
            "two powers in a row are easily misread; put the inner one in parentheses, as in `dot(y)^(2^2)`",
        ),
        // A square forgotten.
        (
            mass("lagrangian <<m/2*|dot((y, z))| - m*g*z>>"),
            "E13: a root or norm of velocities is not differentiable at rest; square it, as in `|dot(p)|^2`",
        ),
        // Potential minus kinetic energy.
        (
            "pub S { parameters { m: kg = 1, g: m/s^2 = 9.81 } coordinates { <<z>>: m } lagrangian m*g*z - \
             m/2*dot(z)^2 }"
                .to_owned(),
            "E06: the mass matrix is not positive definite: with the defaults of the parameters the kinetic energy \
             of a motion with dot(z) = 1 is negative; the Lagrangian is kinetic minus potential energy, check its \
             signs and the masses",
        ),
        // One wrong sign in the kinetic energy, which shows in a combination of two motions only.
        (
            "pub S { parameters { m: kg = 1, k: N/m = 3 } coordinates { y: m, <<z>>: m } lagrangian \
             m/2*(dot(y) + 2*dot(z))^2 - m/2*dot(z)^2 - k/2*y^2 }"
                .to_owned(),
            "E06: the mass matrix is not positive definite: with the defaults of the parameters the kinetic energy \
             of a motion with dot(y) = -2, dot(z) = 1 is negative; the Lagrangian is kinetic minus potential \
             energy, check its signs and the masses",
        ),
        // A mass that is zero.
        (
            "pub S { parameters { m: kg = 0 } coordinates { <<z>>: m } lagrangian m/2*dot(z)^2 start { z: 1 } }"
                .to_owned(),
            "E06: the mass matrix is not positive definite at the start: with the defaults of the parameters a \
             motion with dot(z) = 1 has no kinetic energy; add its inertia, start elsewhere or leave a \
             coordinate out",
        ),
        // Damping that drives.
        (
            mass("lagrangian m/2*|dot((y, z))|^2 - m*g*z dissipation <<-0.1 [N s/m]*dot(y)^2>>"),
            "E10: the dissipation is negative: with the defaults of the parameters it feeds energy into `dot(y)`; \
             a damper is written with a plus sign, as in `c/2*dot(y)^2`",
        ),
    ]);
}

#[test]
fn planted_slips_of_units_and_places_are_caught_where_they_were_made() {
    assert_caught([
        // Mass and length exchanged.
        (
            "pub S { parameters { m: m = 80, l: kg = 2, g: m/s^2 = 9.81 } coordinates { a: rad } lagrangian \
             m/2*|dot(l*(sin(a), -cos(a)))|^2 <<+>> m*g*l*cos(a) }"
                .to_owned(),
            "E03: units differ: `m/2*|dot(l*(sin(a), -cos(a)))|^2` is in kg^2 m/s^2, `m*g*l*cos(a)` is in J; both \
             sides of `+` must agree",
        ),
        // A distance for a speed.
        (
            mass("lagrangian m/2*|dot((y, z))|^2 - m*g*z start { z: 1, dot(y): <<15 [km]>> }"),
            "E03: units differ: `15 [km]` is in m, where m/s is needed (it is the start value of `dot(y)`)",
        ),
        // A number without its unit.
        (
            mass("lagrangian m/2*|dot((y, z))|^2 - m*g*z surface wall: <<y >= 3>> impact wall: inelastic"),
            "E03: units differ: `y` is in m, `3` has no unit; both sides of surface `wall` must agree; a bare \
             number has no unit, write it in brackets, as in `3 [m]`",
        ),
        // A length for an angle.
        (
            mass("lagrangian m/2*|dot((y, z))|^2 - m*g*(z + 1 [m]*sin(<<y>>))"),
            "E03: units differ: `sin` needs a pure number, `y` is in m",
        ),
        // A factor forgotten.
        (
            mass("lagrangian m/2*|dot((y, z))|^2 <<->> m*g"),
            "E03: units differ: `m/2*|dot((y, z))|^2` is in J, `m*g` is in N; both sides of `-` must agree",
        ),
        // The free side of the ground exchanged.
        (
            mass(
                "lagrangian m/2*|dot((y, z))|^2 - m*g*z surface ground: z <= 0 impact ground: inelastic \
                 start { z: <<2>> }",
            ),
            "E08: the start lies inside the ground: with the defaults of the parameters the gap of surface \
             `ground` is -2 m < 0; start at a gap of 0 or more, or exchange `>=` and `<=` if the free side is the \
             other one",
        ),
        // A start below a slope.
        (
            mass(
                "fn slope(y) = 4 [m] - y/2 lagrangian m/2*|dot((y, z))|^2 - m*g*z surface hill: z >= slope(y) \
                 impact hill: inelastic start { y: 5, z: <<1>> }",
            ),
            "E08: the start lies inside the ground: with the defaults of the parameters the gap of surface \
             `hill` is -0.5 m < 0; start at a gap of 0 or more, or exchange `>=` and `<=` if the free side is the \
             other one",
        ),
        // Centimetres for metres.
        (
            mass("lagrangian m/2*|dot((y, z))|^2 - m*g*z start { z: <<50>> }"),
            "E17: `z` starts at 50, outside its bounds 0..=9",
        ),
        // A coordinate forgotten in the kinetic energy.
        (
            "pub S { parameters { m: kg = 1, g: m/s^2 = 9.81 } coordinates { y: m, <<z>>: m } lagrangian \
             m/2*dot(y)^2 - m*g*z }"
                .to_owned(),
            "E05: coordinate `z` carries no inertia: the Lagrangian is not quadratic in `dot(z)`; add its kinetic \
             energy, or make it a parameter or a control",
        ),
        // A rotation of the plane for a vector of space.
        (
            mass("let p = rotation(y/1 [m])<<*>>(y, z, 0) lagrangian m/2*|dot(p)|^2 - m*g*z"),
            "E02: `*` between a 2 by 2 matrix (`rotation(y/1 [m])`) and a vector with 3 components (`(y, z, 0)`); \
             a matrix with 2 columns multiplies a vector with 2 components",
        ),
        // A misspelt name.
        (
            mass("lagrangian m/2*|dot((y, z))|^2 - m*<<G>>*z"),
            "E01: `G` is not declared; did you mean `g`?",
        ),
    ]);
}

#[test]
fn start_that_other_parameters_decide_is_left_to_the_run() {
    let expand = |source: &str| hangtime_dsl::try_expand(source.parse().expect("tokens")).is_ok();
    // Zero is no declared start: polar coordinates are singular there, and the ground may be above it.
    assert!(expand(
        "S { coordinates { r, a } lagrangian dot(r)^2 + r^2*dot(a)^2 surface ground: r >= 1 impact ground: inelastic }"
    ));
    // A start that is to be found is not a given one.
    assert!(expand(
        "S { coordinates { z } lagrangian dot(z)^2 surface ground: z >= 1 impact ground: inelastic start { z: 0 } \
         free { z } minimize time finally { z == 2 } }"
    ));
    // On the ground up to rounding.
    assert!(expand(
        "S { parameters { a = 0.1 } coordinates { z } lagrangian dot(z)^2 surface ground: z >= 3*a impact ground: \
         inelastic start { z: 0.3 } }"
    ));
}
