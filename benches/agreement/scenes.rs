//! The kinds of scenes: the shipped ones with random parameters, and families that are drawn as a whole.

use hangtime::model::Model;
use hangtime_models::scenes;
use hangtime_scene_files::of_text;

use super::draw::Draw;
use super::texts;

/// Range of a parameter of a shipped scene around its default: six decades.
const FACTOR: f64 = 1e3;
/// Largest shift of a scene \[m\], and in units of its size: rounding leaves `1e-11` of the size.
const SHIFT: f64 = 1e5;

/// Draws a scene of a kind, whose name is given.
type Scene = fn(&str, &mut Draw) -> Box<dyn Model>;

/// A kind of scenes.
pub(crate) struct Kind {
    /// Name in the table.
    pub(crate) name: String,
    scene: Scene,
}

impl Kind {
    /// The scene with this number.
    pub(crate) fn scene(&self, number: u64) -> Box<dyn Model> {
        (self.scene)(&self.name, &mut Draw::new(&self.name, number))
    }
}

/// Every form of the shipped scenes.
pub(crate) fn shipped() -> Vec<Kind> {
    let variants = scenes().iter().flat_map(|scene| {
        let name = |settings: &[(&str, &str)]| {
            let choices = settings.iter().map(|(_, choice)| format!(" {choice}"));
            scene.name.to_owned() + &choices.collect::<String>()
        };
        scene
            .variants
            .iter()
            .map(move |variant| name(variant.settings))
    });
    variants
        .map(|name| Kind {
            name,
            scene: shipped_scene,
        })
        .collect()
}

/// The shipped scene of this name, with about half of its parameters drawn over six decades. Parameters that the
/// scene refuses are drawn again.
fn shipped_scene(name: &str, draw: &mut Draw) -> Box<dyn Model> {
    let index = shipped()
        .iter()
        .position(|kind| kind.name == name)
        .unwrap_or_default();
    loop {
        let mut variants = scenes().iter().flat_map(|scene| scene.variants);
        let Some(variant) = variants.nth(index) else {
            unreachable!("kinds are named after variants");
        };
        let mut model = (variant.model)();
        for (i, parameter) in model.declaration().parameters.iter().enumerate() {
            if draw.chance(0.5) {
                model.set_parameter(i, parameter.default * draw.factor(FACTOR));
            }
        }
        let problem = hangtime::simulation::InitialValueProblem::of(&*model, None);
        if problem.is_ok_and(|problem| problem.check(&*model).is_ok()) {
            return model;
        }
    }
}

/// The scene of a text.
///
/// # Panics
/// If the text is refused: every scene of these families is one.
fn of_family(name: &str, draw: &mut Draw) -> Box<dyn Model> {
    let text = texts::text(name, draw);
    match of_text("scene.hang", &text) {
        Ok(scene) => Box::new(scene),
        Err(error) => panic!("{name} is refused: {error}\n{text}"),
    }
}

/// What is drawn of a scene: parameters and their values.
type Drawn = Vec<(&'static str, f64)>;

/// Draws what fills the places of a text.
type Fill = fn(&Setting, &mut Draw) -> Drawn;

/// Families whose parameters are drawn: their names, scenes, and what is drawn beside what all have.
const FAMILIES: [(&str, &str, Fill); 6] = [
    ("rods", ROD, rod),
    ("boxes", CRATE, crate_on_incline),
    ("springs", HOPPER, hopper),
    ("waves", RIDE, ride),
    ("stacks", STACK, stack),
    ("cranes", CRANE, crane),
];

/// A scene of such a family.
///
/// # Panics
/// If its text is refused or has no such parameter.
fn of_parameters(name: &str, draw: &mut Draw) -> Box<dyn Model> {
    let family = FAMILIES.iter().find(|family| family.0 == name);
    let &(_, text, drawn) = family.expect("a family of this name");
    let mut scene = of_text("scene.hang", text).expect("the scene of a family");
    let setting = Setting::draw(draw);
    let known = scene.declaration().parameters;
    let place = |name: &str| known.iter().position(|known| known.name == name);
    let Setting {
        g, e, mu, x0, z0, ..
    } = setting;
    for (name, value) in [("g", g), ("e", e), ("mu", mu), ("x0", x0), ("z0", z0)] {
        if let Some(index) = place(name) {
            scene.set_parameter(index, value);
        }
    }
    for (name, value) in drawn(&setting, draw) {
        scene.set_parameter(place(name).expect("a parameter of this name"), value);
    }
    Box::new(scene)
}

/// Families of random scenes.
pub(crate) fn random() -> Vec<Kind> {
    let parameters = FAMILIES
        .iter()
        .map(|family| (family.0, of_parameters as Scene));
    let texts = texts::FAMILIES
        .iter()
        .map(|family| (family.0, of_family as Scene));
    let kinds = parameters.chain(texts).map(|(name, scene)| Kind {
        name: name.to_owned(),
        scene,
    });
    kinds.collect()
}

/// A rod whose two ends hit a floor.
const ROD: &str = "
    parameters {
        m: kg = 1, j: kg m^2 = 0.1, a: m = 0.5, b: m = 0.5, g: m/s^2 = 9.81, e = 0, mu = 0, x0: m = 0, z0: m = 0,
        height: m = 1, angle0 = 0, v_x: m/s = 0, v_z: m/s = 0, spin: 1/s = 0,
    }
    coordinates { x: m, z: m, angle }
    lagrangian m/2*|dot((x, z))|^2 + j/2*dot(angle)^2 - m*g*z
    surface left: z - a*sin(angle) >= z0
    surface right: z + b*sin(angle) >= z0
    impact left: restitution e, friction mu, sliding dot(x - a*cos(angle))
    impact right: restitution e, friction mu, sliding dot(x + b*cos(angle))
    start { x: x0, z: z0 + height, angle: angle0, dot(x): v_x, dot(z): v_z, dot(angle): spin }
    horizon 1.5 [s]
";

/// A box with a gabled top that falls on an incline; a fourth corner would be a combination of the others.
const CRATE: &str = "
    parameters {
        m: kg = 1, j: kg m^2 = 0.1, a: m = 0.5, b: m = 0.3, c: m = 0, g: m/s^2 = 9.81, e = 0, mu = 0, x0: m = 0, z0: m = 0,
        incline = 0, height: m = 1, angle0 = 0, v_x: m/s = 0, v_z: m/s = 0, spin: 1/s = 0,
    }
    coordinates { x: m, z: m, angle }
    let i = (cos(angle), sin(angle))
    let j_ = (-sin(angle), cos(angle))
    let centre = (x - x0, z - z0)
    fn above(p) = p.y*sin(incline) + p.z*cos(incline)
    fn down(p) = p.y*cos(incline) - p.z*sin(incline)
    lagrangian m/2*|dot((x, z))|^2 + j/2*dot(angle)^2 - m*g*z
    surface lower_left: above(centre - a*i - b*j_) >= 0
    surface lower_right: above(centre + a*i - b*j_) >= 0
    surface top: above(centre + c*i + b*j_) >= 0
    impact lower_left: restitution e, friction mu, sliding dot(down(centre - a*i - b*j_))
    impact lower_right: restitution e, friction mu, sliding dot(down(centre + a*i - b*j_))
    impact top: restitution e, friction mu, sliding dot(down(centre + c*i + b*j_))
    start {
        x: x0 + height*sin(incline), z: z0 + height*cos(incline), angle: angle0,
        dot(x): v_x, dot(z): v_z, dot(angle): spin,
    }
    horizon 1.5 [s]
";

/// A ball on a spring under a second one, which hop along a floor; the spring has a stop.
const HOPPER: &str = "
    parameters {
        m_1: kg = 1, m_2: kg = 2, k: N/m = 200, d: N s/m = 0, l: m = 1, stop: m = 0.3, g: m/s^2 = 9.81, e = 0,
        mu = 0, x0: m = 0, z0: m = 0, height: m = 0, stretch: m = 0, v_x: m/s = 0, v_z: m/s = 0, v_s: m/s = 0,
    }
    coordinates { x: m, z: m, s: m }
    let upper = (x, z + s)
    lagrangian m_1/2*|dot((x, z))|^2 + m_2/2*|dot(upper)|^2 - m_1*g*z - m_2*g*upper.z - k/2*(s - l)^2
    dissipation d/2*dot(s)^2
    surface floor: z >= z0
    surface stop: s >= stop
    impact floor: restitution e, friction mu, sliding dot(x)
    impact stop: restitution e
    start { x: x0, z: z0 + height, s: l + stretch, dot(x): v_x, dot(z): v_z, dot(s): v_s }
    horizon 2 [s]
";

/// A carriage on a floor, with a trolley on a dry rail, held by a spring, and a pendulum in a dry hinge.
const CRANE: &str = "
    parameters {
        m_1: kg = 1, m_2: kg = 2, m_3: kg = 1, k: N/m = 200, l: m = 1, g: m/s^2 = 9.81, e = 0, mu = 0, rail: N = 1,
        pin: N m = 1, x0: m = 0, z0: m = 0, height: m = 0, stretch: m = 0, angle0 = 0, v_x: m/s = 0, v_z: m/s = 0,
        v_s: m/s = 0, spin: 1/s = 0,
    }
    coordinates { x: m, z: m, s: m, angle }
    let trolley = (x + s, z + l)
    let bob = trolley + l*(sin(angle), -cos(angle))
    lagrangian m_1/2*|dot((x, z))|^2 + m_2/2*|dot(trolley)|^2 + m_3/2*|dot(bob)|^2
        - (m_1 + m_2)*g*z - m_3*g*bob.z - k/2*s^2
    surface floor: z >= z0
    impact floor: restitution e, friction mu, sliding dot(x)
    dry friction rail: bound rail, sliding dot(s)
    dry friction hinge: bound pin*(1 + sin(angle)^2), sliding dot(angle)
    start {
        x: x0, z: z0 + height, s: stretch, angle: angle0,
        dot(x): v_x, dot(z): v_z, dot(s): v_s, dot(angle): spin,
    }
    horizon 2 [s]
";

/// A mass on waves of two lengths: rides, take-offs, landings.
const RIDE: &str = "
    parameters {
        m: kg = 1, g: m/s^2 = 9.81, a_1: m = 0.2, k_1: 1/m = 2, a_2: m = 0, k_2: 1/m = 5, e = 0, mu = 0,
        x0: m = 0, z0: m = 0, start_x: m = 0, height: m = 0, speed: m/s = 2,
    }
    coordinates { x: m, z: m }
    fn track(p) = a_1*sin(k_1*p) + a_2*sin(k_2*p)
    lagrangian m/2*|dot((x, z))|^2 - m*g*z
    surface track: z - z0 - track(x - x0) >= 0
    impact track: restitution e, friction mu
    start {
        x: x0 + start_x, z: z0 + track(start_x) + height,
        dot(x): speed, dot(z): speed*diff(track)(start_x),
    }
    horizon 2 [s]
";

/// Three balls above each other.
const STACK: &str = "
    parameters {
        m_1: kg = 1, m_2: kg = 1, m_3: kg = 1, r: m = 0.1, g: m/s^2 = 9.81, e = 0, z0: m = 0,
        gap_1: m = 0.1, gap_2: m = 0.1, gap_3: m = 0.1, v_1: m/s = 0, v_2: m/s = 0, v_3: m/s = 0,
    }
    coordinates { z_1: m, z_2: m, z_3: m }
    lagrangian m_1/2*dot(z_1)^2 + m_2/2*dot(z_2)^2 + m_3/2*dot(z_3)^2 - g*(m_1*z_1 + m_2*z_2 + m_3*z_3)
    surface floor: z_1 - r >= z0
    surface lower: z_2 - z_1 >= 2*r
    surface upper: z_3 - z_2 >= 2*r
    impact floor, lower, upper: restitution e
    start {
        z_1: z0 + r + gap_1, z_2: z0 + 3*r + gap_1 + gap_2, z_3: z0 + 5*r + gap_1 + gap_2 + gap_3,
        dot(z_1): v_1, dot(z_2): v_2, dot(z_3): v_3,
    }
    horizon 1.5 [s]
";

/// What all families draw alike: their size, place, gravity and laws of impact.
struct Setting {
    length: f64,
    mass: f64,
    g: f64,
    e: f64,
    mu: f64,
    x0: f64,
    z0: f64,
}

impl Setting {
    fn draw(draw: &mut Draw) -> Self {
        let (length, mass) = (draw.scale(), draw.scale());
        let sometimes = |draw: &mut Draw, value: f64| if draw.chance(0.5) { value } else { 0.0 };
        let (e, mu) = (draw.between(0.0, 0.9), draw.between(0.0, 0.8));
        let (e, mu) = (sometimes(draw, e), sometimes(draw, mu));
        let shift = SHIFT * length.min(1.0);
        Self {
            length,
            mass,
            g: if draw.chance(0.75) {
                9.81 * length
            } else {
                0.0
            },
            e,
            mu,
            x0: sometimes(draw, shift),
            z0: sometimes(draw, -shift),
        }
    }
}

fn rod(&Setting { length, mass, .. }: &Setting, draw: &mut Draw) -> Drawn {
    let (a, b) = (draw.between(0.2, 1.0), draw.between(0.2, 1.0));
    let angle0 = draw.between(-1.2, 1.2);
    let lowest = (a * angle0.sin()).max(-b * angle0.sin());
    let m = mass * draw.between(0.3, 3.0);
    vec![
        ("m", m),
        ("j", m * length * length * draw.between(0.1, 0.5)),
        ("a", length * a),
        ("b", length * b),
        ("height", length * (lowest + draw.between(0.0, 0.5))),
        ("angle0", angle0),
        ("v_x", length * draw.between(-2.0, 2.0)),
        ("v_z", length * draw.between(-3.0, 1.0)),
        ("spin", draw.between(-3.0, 3.0)),
    ]
}

fn crate_on_incline(&Setting { length, mass, .. }: &Setting, draw: &mut Draw) -> Drawn {
    let (a, b) = (draw.between(0.1, 0.5), draw.between(0.1, 0.5));
    let c = draw.between(-a, a);
    let m = mass * draw.between(0.3, 3.0);
    vec![
        ("m", m),
        ("j", m * length * length * (a * a + b * b) / 3.0),
        ("a", length * a),
        ("b", length * b),
        ("c", length * c),
        ("incline", draw.between(-0.6, 0.6)),
        ("height", length * (a.hypot(b) + draw.between(0.0, 0.5))),
        ("angle0", draw.between(-3.0, 3.0)),
        ("v_x", length * draw.between(-2.0, 2.0)),
        ("v_z", length * draw.between(-3.0, 0.5)),
        ("spin", draw.between(-4.0, 4.0)),
    ]
}

fn hopper(&Setting { length, mass, .. }: &Setting, draw: &mut Draw) -> Drawn {
    let m_2 = mass * draw.factor(3.0);
    let k = m_2 * draw.between(3.0, 20.0).powi(2);
    let damped = draw.chance(0.5);
    vec![
        ("m_1", mass * draw.factor(10.0)),
        ("m_2", m_2),
        ("k", k),
        ("d", if damped { 0.1 * (k * m_2).sqrt() } else { 0.0 }),
        ("l", length),
        ("stop", length * draw.between(0.2, 0.8)),
        ("height", length * draw.zero_or(0.5, 0.0, 0.5)),
        ("stretch", length * draw.between(-0.15, 0.4)),
        ("v_x", length * draw.between(-2.0, 2.0)),
        ("v_z", length * draw.zero_or(0.3, -3.0, 1.0)),
        ("v_s", length * draw.between(-2.0, 2.0)),
    ]
}

fn crane(
    &Setting {
        length, mass, g, ..
    }: &Setting,
    draw: &mut Draw,
) -> Drawn {
    let l = length * draw.between(0.3, 1.5);
    let weight = mass * g;
    // From friction that is hardly felt to joints that seldom give way.
    let mut bound = |largest: f64| match draw.chance(0.1) {
        true => 0.0,
        false => largest * 10.0_f64.powf(draw.between(-3.0, 1.0)),
    };
    let (rail, pin) = (bound(weight), bound(weight * l));
    vec![
        ("m_1", mass * draw.between(0.5, 3.0)),
        ("m_2", mass * draw.between(0.3, 2.0)),
        ("m_3", mass * draw.between(0.1, 1.0)),
        ("k", weight / length * draw.factor(30.0)),
        ("l", l),
        ("rail", rail),
        ("pin", pin),
        ("height", length * draw.zero_or(0.5, 0.0, 0.3)),
        ("stretch", length * draw.between(-0.5, 0.5)),
        ("angle0", draw.between(-3.0, 3.0)),
        ("v_x", length * draw.between(-2.0, 2.0)),
        ("v_z", 0.0),
        ("v_s", length * draw.zero_or(0.5, -2.0, 2.0)),
        ("spin", draw.between(-3.0, 3.0)),
    ]
}

fn ride(&Setting { length, mass, .. }: &Setting, draw: &mut Draw) -> Drawn {
    let two = draw.chance(0.5);
    vec![
        ("m", mass),
        ("a_1", length * draw.between(0.02, 0.8)),
        ("k_1", draw.between(0.3, 6.0) / length),
        (
            "a_2",
            length * if two { draw.between(0.0, 0.1) } else { 0.0 },
        ),
        ("k_2", draw.between(3.0, 12.0) / length),
        ("start_x", length * draw.between(-3.0, 3.0)),
        ("height", length * draw.zero_or(0.6, 0.0, 0.5)),
        ("speed", length * draw.between(-5.0, 5.0)),
    ]
}

fn stack(&Setting { length, mass, .. }: &Setting, draw: &mut Draw) -> Drawn {
    let mut mass = || mass * draw.factor(30.0);
    let masses = [mass(), mass(), mass()];
    let mut gap = || length * draw.zero_or(0.3, 0.0, 0.4);
    let gaps = [gap(), gap(), gap()];
    let mut speed = || length * draw.zero_or(0.3, -2.0, 1.0);
    let speeds = [speed(), speed(), speed()];
    vec![
        ("m_1", masses[0]),
        ("m_2", masses[1]),
        ("m_3", masses[2]),
        ("r", 0.1 * length),
        ("gap_1", gaps[0]),
        ("gap_2", gaps[1]),
        ("gap_3", gaps[2]),
        ("v_1", speeds[0]),
        ("v_2", speeds[1]),
        ("v_3", speeds[2]),
    ]
}
