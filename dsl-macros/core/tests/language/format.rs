//! The settled style of texts.

use crate::formatted;
use hangtime_dsl::{describe_text, format_text};

#[test]
fn text_in_any_layout_gets_the_settled_style() {
    let text = "//! A ball.\n\n\n\nparameters{/// Mass.\nm:kg=1 , g :m/s ^2= 9.81,r:m=0.1 // radius\n}\n\
        coordinates { y:m,z : m in 0 ..=3[m],  a } controls{u:N}// pushes\n\
        // Where it is.\nlet p=( y,z ) ; fn h( w )=-r*cos( 2 *w/r)\n\
        lagrangian |dot( p )| ^ 2*m/2-m*g*z+m*r^2/4*dot(a)^2\n\n  +\n  -0.5[N]*y // sum\n\
        forces {y:u-2 [N],}\ndry   friction rail :bound 2 [N]*y/1 [m],sliding dot(y)-dot(z) surface floor:z>=h( y )impact floor :inelastic ,friction 0.3,\n  sliding dot(y)-h(0)*-dot(a)\n\
        start{ z:1 }\n\n\n// The end.\noutputs { v:m/s=|dot(p)|, push=force( floor )-m*g }\n\
        picture {\npoint p, rectangle box at (y , -z) size (r,2*r) angle -a, link p to (0,0),\n\
        polygon a at p corners((0,0),(r,0),(0,r)) angle a - 1, curve c:( w,h(w) ) over w in 0[m]..=r }\n// Last.";
    let wanted = "\
//! A ball.

parameters {
    /// Mass.
    m: kg = 1,
    g: m/s^2 = 9.81,
    r: m = 0.1, // radius
}
coordinates { y: m, z: m in 0..=3 [m], a }
controls { u: N } // pushes
// Where it is.
let p = (y, z)
fn h(w) = -r*cos(2*w/r)
lagrangian |dot(p)|^2*m/2 - m*g*z + m*r^2/4*dot(a)^2 + -0.5[N]*y // sum
forces { y: u - 2 [N] }
dry friction rail: bound 2[N]*y/1[m], sliding dot(y) - dot(z)
surface floor: z >= h(y)
impact floor: inelastic, friction 0.3, sliding dot(y) - h(0)*-dot(a)
start { z: 1 }

// The end.
outputs { v: m/s = |dot(p)|, push = force(floor) - m*g }
picture {
    point p,
    rectangle box at (y, -z) size (r, 2*r) angle -a,
    link p to (0, 0),
    polygon a at p corners ((0, 0), (r, 0), (0, r)) angle a - 1,
    curve c: (w, h(w)) over w in 0 [m]..=r,
}
// Last.
";
    assert_eq!(formatted(text), wanted);
}

#[test]
fn points_of_a_profile_are_a_block() {
    let scene = "coordinates { y }\nlagrangian dot(y)^2/2 - h(y)\n";
    for (written, settled) in [
        (
            "profile h( w:m/s ) :m{(0,1),(1,-2),( 2,0),}",
            "profile h(w: m/s): m { (0, 1), (1, -2), (2, 0) }",
        ),
        (
            "profile h(w) {\n(0,1),(1,-2), // deep\n(2,0)}",
            "profile h(w) {\n    (0, 1),\n    (1, -2), // deep\n    (2, 0),\n}",
        ),
    ] {
        let scene = match written.contains(':') {
            true => scene
                .replace("{ y }", "{ y: m/s }")
                .replace("^2/2 - h(y)", "^2/2 - 1[m/s^4]*h(y)"),
            false => scene.to_owned(),
        };
        assert_eq!(
            formatted(&format!("{written}\n{scene}")),
            format!("{settled}\n{scene}")
        );
    }
}

#[test]
fn header_and_vectors_are_formatted_and_long_sums_broken() {
    let terms = ["m*l^2*dot(a)^2"; 12].join("+");
    let text = format!(
        "/// Two angles.\npub  Two{{ parameters {{ m:kg=1e-3,l:m=2. }} coordinates {{ a:rad,b:rad }} \
         let w=(a , b ,a*b) let q=w . w lagrangian {terms}+m*l^2*dot(b)^2-m*q*1[m^2/s^2]*w[0]*|w| /* all */ }}"
    );
    let wanted = "\
/// Two angles.
pub Two {
    parameters { m: kg = 1e-3, l: m = 2. }
    coordinates { a: rad, b: rad }
    let w = (a, b, a*b)
    let q = w . w
    lagrangian m*l^2*dot(a)^2 + m*l^2*dot(a)^2 + m*l^2*dot(a)^2 + m*l^2*dot(a)^2 + m*l^2*dot(a)^2 + m*l^2*dot(a)^2
        + m*l^2*dot(a)^2 + m*l^2*dot(a)^2 + m*l^2*dot(a)^2 + m*l^2*dot(a)^2 + m*l^2*dot(a)^2 + m*l^2*dot(a)^2
        + m*l^2*dot(b)^2 - m*q*1[m^2/s^2]*w[0]*|w| /* all */
}
";
    assert_eq!(formatted(&text), wanted);
}

#[test]
fn text_with_mistakes_is_not_formatted_but_answered() {
    let mistakes = format_text("coordinates { z: m } lagrangian z'", "scene").unwrap_err();
    assert!(mistakes[0].message.contains("dot(z)"));
}

/// The scene files below a folder of the repository.
fn scene_files(folder: &str) -> Vec<std::path::PathBuf> {
    let root = concat!(env!("CARGO_MANIFEST_DIR"), "/../../");
    let entries = std::fs::read_dir(format!("{root}{folder}")).expect("the folder is there");
    let paths = entries.map(|entry| entry.expect("an entry").path());
    paths
        .filter(|path| {
            path.extension()
                .is_some_and(|extension| extension == "hang")
        })
        .collect()
}

#[test]
fn scenes_of_the_repository_declare_the_same_when_they_are_formatted() {
    let mut files = scene_files("models/scenes");
    files.extend(scene_files("cli/src"));
    for file in &files {
        let text = std::fs::read_to_string(file).expect("a text");
        assert_eq!(formatted(&text), text, "{}", file.display());
    }
    files.extend(scene_files("models/hard"));
    files.extend(scene_files("runtime/tests/data"));
    assert!(files.len() > 60, "{}", files.len());
    for file in files {
        let text = std::fs::read_to_string(&file).expect("a text");
        let formatted = formatted(&text);
        let [before, after] =
            [&text, &formatted].map(|text| describe_text(text, "scene").expect("no mistakes").0);
        assert_eq!(before, after, "{}", file.display());
        let comments = |text: &str| text.matches("//").count();
        assert_eq!(comments(&text), comments(&formatted), "{}", file.display());
        assert!(
            formatted
                .lines()
                .all(|line| line.chars().count() <= 120 || line.contains("//"))
        );
    }
}
