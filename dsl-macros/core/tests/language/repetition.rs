//! Repetition and parts: what is written out is the scene that an author would have written, and slips are told where they stand.

use crate::{described, formatted, mistakes_in_file};
use hangtime_dsl::describe_text;
use hangtime_dsl::description::Description;
use proc_macro2::{TokenStream, TokenTree};

/// A scene and its twin without repetition have the same functions.
fn assert_twins(text: &str, twin: &str) -> Description {
    let [own, twin] = [text, twin].map(described);
    let names = |scene: &Description| -> Vec<String> {
        let declaration = scene.structure.declaration;
        let coordinates = declaration.coordinates.iter().map(|known| known.name);
        let parameters = declaration.parameters.iter().map(|known| known.name);
        let contacts = declaration.contacts.iter().map(|known| known.name);
        let names = coordinates.chain(parameters).chain(contacts);
        let plain = |name: &str| name.replace(']', "").replace(['[', '.'], "_");
        names.map(plain).collect()
    };
    assert_eq!(names(&own), names(&twin));
    for (own, twin) in own.kernels.iter().zip(&twin.kernels) {
        assert!(
            own.operations == twin.operations,
            "{own:?}\n{twin:?}\n{text}"
        );
    }
    own
}

/// A chain of links as its author would write it out.
fn chain_by_hand(n: usize) -> String {
    let each = |text: &dyn Fn(usize) -> String, between: &str| {
        (1..=n).map(text).collect::<Vec<_>>().join(between)
    };
    format!(
        "parameters {{ m: kg = 1, l: m = 0.5, g: m/s^2 = 9.81 }}
         coordinates {{ {} }}
         let p_0 = (0, 0)
         {}
         lagrangian {}
         start {{ {} }}",
        each(&|k| format!("theta_{k}: rad"), ", "),
        each(
            &|k| format!(
                "let p_{k} = p_{} + l*(sin(theta_{k}), -cos(theta_{k}))",
                k - 1
            ),
            "\n"
        ),
        each(&|k| format!("(m/2*|dot(p_{k})|^2 - m*g*p_{k}[1])"), " + "),
        each(&|k| format!("theta_{k}: 0.1*{k}"), ", "),
    )
}

const CHAIN: &str = "count n = 3
    parameters { m: kg = 1, l: m = 0.5, g: m/s^2 = 9.81 }
    coordinates { theta[n]: rad }
    let p[k in 1..=n] = p[k-1] + l*(sin(theta[k]), -cos(theta[k])), p[0] = (0, 0)
    lagrangian sum(k in 1..=n: m/2*|dot(p[k])|^2 - m*g*p[k][1])
    start { theta[k in 1..=n]: 0.1*k }";

#[test]
fn chain_of_any_length_is_the_one_that_is_written_out() {
    for n in 1..=5 {
        let text = CHAIN.replace("n = 3", &format!("n = {n}"));
        let own = assert_twins(&text, &chain_by_hand(n));
        let declaration = own.structure.declaration;
        assert_eq!(declaration.coordinates[n - 1].name, format!("theta[{n}]"));
    }
}

#[test]
fn another_count_is_another_text() {
    let text = hangtime_dsl::with_count(CHAIN, "n", 5).expect("a count");
    assert_eq!(text, CHAIN.replace("n = 3", "n = 5"));
    assert_eq!(hangtime_dsl::with_count(CHAIN, "m", 5), None);
    let whole = format!("/// Links.\npub Links {{ {CHAIN} }}");
    let text = hangtime_dsl::with_count(&whole, "n", 12).expect("a count");
    assert_eq!(text, whole.replace("n = 3", "n = 12"));
}

#[test]
fn everything_that_has_a_name_can_have_indices() {
    assert_twins(
        "count n = 3
         parameters { m[k in 1..=n]: kg = 1 + 0.5*k, r: m = 0.1, g: m/s^2 = 9.81, mu[2]: 1 = 0.3 }
         coordinates { x[n]: m, z[n]: m }
         states { a[k in 1..=2]: m }
         rates { a[k in 1..=2]: (x[k] - a[k])/1 [s] }
         controls { u[k in 1..n]: N in -1..=1 }
         forces { x[k in 1..n]: u[k], x[n]: -1 [N/m]*(x[1] - a[2]) }
         lagrangian sum(k in 1..=n: m[k]/2*(dot(x[k])^2 + dot(z[k])^2) - m[k]*g*z[k])
         surface pair[i in 2..=n, j in 1..i]: |(x[i] - x[j], z[i] - z[j])| >= 2*r
         impact pair[i in 1..=n, j in 1..=n, j < i]: inelastic
         surface floor[k in 1..=n]: z[k] >= r
         impact floor[k in 1..=2]: inelastic, friction mu[k], sliding dot(x[k])
         impact floor[3]: restitution if n > 2 { 0.5 } else { 0.25 }
         outputs { height[k in 1..=n]: m = z[k] }
         start { x[k in 1..=n]: k*1 [m], z[k in 1..=n]: 1 [m] }
         picture { circle ball[k in 1..=n] radius r at (x[k], z[k]), link ball[k in 2..=n] to ball[k - 1] }",
        "parameters { m_1: kg = 1 + 0.5*1, m_2: kg = 1 + 0.5*2, m_3: kg = 1 + 0.5*3, r: m = 0.1, g: m/s^2 = 9.81,
                      mu_1: 1 = 0.3, mu_2: 1 = 0.3 }
         coordinates { x_1: m, x_2: m, x_3: m, z_1: m, z_2: m, z_3: m }
         states { a_1: m, a_2: m }
         rates { a_1: (x_1 - a_1)/1 [s], a_2: (x_2 - a_2)/1 [s] }
         controls { u_1: N in -1..=1, u_2: N in -1..=1 }
         forces { x_1: u_1, x_2: u_2, x_3: -1 [N/m]*(x_1 - a_2) }
         lagrangian (m_1/2*(dot(x_1)^2 + dot(z_1)^2) - m_1*g*z_1) + (m_2/2*(dot(x_2)^2 + dot(z_2)^2) - m_2*g*z_2)
            + (m_3/2*(dot(x_3)^2 + dot(z_3)^2) - m_3*g*z_3)
         surface pair_2_1: |(x_2 - x_1, z_2 - z_1)| >= 2*r
         surface pair_3_1: |(x_3 - x_1, z_3 - z_1)| >= 2*r
         surface pair_3_2: |(x_3 - x_2, z_3 - z_2)| >= 2*r
         impact pair_2_1, pair_3_1, pair_3_2: inelastic
         surface floor_1: z_1 >= r
         surface floor_2: z_2 >= r
         surface floor_3: z_3 >= r
         impact floor_1: inelastic, friction mu_1, sliding dot(x_1)
         impact floor_2: inelastic, friction mu_2, sliding dot(x_2)
         impact floor_3: restitution 0.5
         outputs { height_1: m = z_1, height_2: m = z_2, height_3: m = z_3 }
         start { x_1: 1 [m], x_2: 2 [m], x_3: 3 [m], z_1: 1 [m], z_2: 1 [m], z_3: 1 [m] }
         picture { circle ball_1 radius r at (x_1, z_1), circle ball_2 radius r at (x_2, z_2), circle ball_3 radius r at (x_3, z_3),
                   link ball_2 to ball_1, link ball_3 to ball_2 }",
    );
}

/// A swinging rod as a part.
const ROD: &str = "part rod(hip, m: kg, l: m) {
        coordinates { q: rad }
        let tip = hip + l*(sin(q), -cos(q))
        lagrangian += m/2*|dot(tip)|^2 - m*g*tip[1]
        dissipation += c/2*dot(q)^2
        surface stop: q >= -1
        impact stop: inelastic
        start { q: 0.2 }
    }";

#[test]
fn part_under_names_is_its_statements_with_names_in_front() {
    let text = format!(
        "{ROD}
         parameters {{ g: m/s^2 = 9.81, c: N m s = 0.1, m_b: kg = 3 }}
         coordinates {{ x: m }}
         lagrangian += m_b/2*dot(x)^2
         let hip = (x, 0)
         left: rod(hip, 1 [kg], 0.5 [m])
         right: rod(left.tip, 2 [kg], 0.4 [m])
         forces {{ left.q: -0.1 [N m]*right.q }}
         outputs {{ height: m = right.tip[1] }}"
    );
    assert_twins(
        &text,
        "parameters { g: m/s^2 = 9.81, c: N m s = 0.1, m_b: kg = 3 }
         coordinates { x: m, left_q: rad, right_q: rad }
         let left_m = 1 [kg] let left_l = 0.5 [m]
         let left_tip = (x, 0) + left_l*(sin(left_q), -cos(left_q))
         surface left_stop: left_q >= -1
         impact left_stop: inelastic
         start { left_q: 0.2 }
         let right_m = 2 [kg] let right_l = 0.4 [m]
         let right_tip = left_tip + right_l*(sin(right_q), -cos(right_q))
         lagrangian m_b/2*dot(x)^2 + (left_m/2*|dot(left_tip)|^2 - left_m*g*left_tip[1])
            + (right_m/2*|dot(right_tip)|^2 - right_m*g*right_tip[1])
         dissipation c/2*dot(left_q)^2 + c/2*dot(right_q)^2
         surface right_stop: right_q >= -1
         impact right_stop: inelastic
         start { right_q: 0.2 }
         forces { left_q: -0.1 [N m]*right_q }
         outputs { height: m = right_tip[1] }",
    );
}

#[test]
fn parts_repeat_and_hold_indices_and_parts() {
    let own = described(
        "count n = 2
         part wheel(at, k) { coordinates { phi: rad } lagrangian += 1 [kg m^2]*k/2*(dot(phi) + dot(at)/1 [m])^2 }
         part cart(m: kg, n) {
            coordinates { x[n]: m }
            lagrangian += sum(k in 1..=n: m/2*dot(x[k])^2)
            w[k in 1..=n]: wheel(x[k], k)
         }
         train[k in 1..=n]: cart(k*1 [kg], 2)
         joint pull: train[1].x[1] == train[2].x[2]
         forces { train[2].w[1].phi: 1 [N m] }",
    );
    let names = own.structure.declaration.coordinates.iter();
    let names: Vec<&str> = names.map(|known| known.name).collect();
    assert_eq!(
        names,
        [
            "train[1].x[1]",
            "train[1].x[2]",
            "train[1].w[1].phi",
            "train[1].w[2].phi",
            "train[2].x[1]",
            "train[2].x[2]",
            "train[2].w[1].phi",
            "train[2].w[2].phi",
        ]
    );
}

/// A scene with one slip; the text between `<<` and `>>` is where it is told.
pub(super) fn assert_told(marked: &str, wanted: &str) {
    let (before, rest) = marked.split_once("<<").expect("a mark");
    let (inside, after) = rest.split_once(">>").expect("a second mark");
    let text = format!("{before}{inside}{after}");
    let mistakes = describe_text(&text, "s").expect_err(&text);
    let told: Vec<String> = mistakes.iter().map(|known| known.text()).collect();
    assert_eq!(told, [wanted], "{text}");
    assert_eq!(&text[mistakes[0].place.clone()], inside, "{wanted}");
}

#[test]
fn parts_alone_are_told_to_be_no_scene() {
    assert_told(
        "count n = 2 <<part leg>>(a: m) { coordinates { q: rad } lagrangian += a^2*dot(q)^2 }",
        "E27: parts alone are no scene; another text takes them in, as by `use \"leg.hang\"`, and uses them under names, as in \
         `left: leg(..)`",
    );
}

#[test]
fn slips_of_parts_are_told_once() {
    let scene = |slip: &str| {
        format!(
            "{ROD} parameters {{ g: m/s^2 = 9.81, c: N m s = 0.1 }} left: rod((0, 0), 1 [kg], 0.5 [m]) {slip}"
        )
    };
    assert_told(
        &scene("<<use>> leg"),
        "`use` is written as in `use \"leg.hang\"`",
    );
    // Inside of a part that is used twice it is told once.
    let twice = scene("right: rod((1 [m], 0 [m]), 1 [kg], 0.5 [m])");
    let inside = twice.replace("m/2*|dot(tip)|^2", "mass/2*|dot(tip)|^2");
    let mistakes = describe_text(&inside, "s").expect_err(&inside);
    assert_eq!(&inside[mistakes[0].place.clone()], "mass");
    assert!(
        mistakes[0]
            .text()
            .starts_with("E01: `mass` is not declared")
    );
    assert_eq!(mistakes.len(), 1, "{mistakes:?}");
}

#[test]
fn repetition_is_bounded() {
    for text in [
        "count n = 100000000 coordinates { x[n]: m } lagrangian sum(k in 1..=n: dot(x[k])^2)",
        "count n = 1000 coordinates { x: m } lagrangian sum(i in 1..=n, j in 1..=n, k in 1..=n: dot(x)^2)",
        "count n = 3000 coordinates { x: m } lagrangian sum(i in 1..=n: sum(j in 1..=n: dot(x)^2))",
        "coordinates { x[9223372036854775807 + 1]: m } lagrangian dot(x[1])^2",
        "coordinates { x[1 % 0]: m } lagrangian dot(x[1])^2",
    ] {
        assert!(!mistakes_in_file(text).is_empty(), "{text}");
    }
}

#[test]
fn settled_style_keeps_repetition_and_parts() {
    let wanted = "\
//! Links.

use \"leg.hang\"
count n = 3 // links
part link(hip, m: kg, n) {
    coordinates { q[n]: rad }
    // Energies.
    lagrangian += sum(k in 1..=n, k != 0: m/2*dot(hip + 1[m]*q[k])^2) + m/2*dot(hip)^2
    surface stop[i in 2..=n, j in 1..i]: q[i] - q[j] >= -1
    impact stop[i in 2..=n, j in 1..i]: inelastic
}
coordinates { x: m }
first: link(x, 1 [kg], n)
second[k in 1..=2]: link(x, 2 [kg], 2 + k - k)
start { first.q[k in 1..=n]: 0.1*k }
";
    let loose = wanted
        .replace("+=", " +=  ")
        .replace("link(x, ", "link( x ,")
        .replace("count n = 3", "count n=3");
    for text in [&loose, wanted] {
        assert_eq!(formatted(text), wanted);
    }
}

/// What stands behind every `fn` and its name, in all groups.
fn behind_functions(tokens: TokenStream, found: &mut Vec<String>) {
    let tokens: Vec<TokenTree> = tokens.into_iter().collect();
    for (at, token) in tokens.iter().enumerate() {
        match token {
            TokenTree::Group(group) => behind_functions(group.stream(), found),
            TokenTree::Ident(word) if word == "fn" => {
                let behind = tokens.get(at + 2).map(ToString::to_string);
                found.extend(behind.filter(|_| matches!(tokens[at + 1], TokenTree::Ident(_))));
            }
            _ => {}
        }
    }
}

#[test]
fn functions_of_parts_and_members_have_names_of_rust() {
    let scene = "S {
        part leg(hip, l: m) {
            parameters { m: kg = 2 }
            coordinates { angle: rad }
            let foot = hip + l*(sin(angle), -cos(angle))
            lagrangian += m/2*|dot(foot)|^2 - m*9.81 [m/s^2]*foot.z
            surface sole: foot.z >= -1 [m]
            impact sole: inelastic, friction 0.8, sliding dot(foot).y
        }
        left: leg((0, 0), 0.8 [m])
        legs[k in 1..=2]: leg((0, k*0.1 [m]), 0.8 [m])
    }";
    let code = hangtime_dsl::expand(scene.parse().expect("tokens"));
    let text = code.to_string();
    assert!(!text.contains("compile_error"), "{text}");
    assert!(text.contains("with_legs_2_m"), "{text}");
    let mut behind = Vec::new();
    behind_functions(code, &mut behind);
    assert!(behind.len() > 20, "{behind:?}");
    for arguments in behind {
        assert!(arguments.starts_with('('), "{arguments}");
    }
}
