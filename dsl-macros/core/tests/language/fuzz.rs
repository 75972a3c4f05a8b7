//! Malformed declarations: never a panic, never a hang, always a message.
//!
//! The mutations are those that people and editors make: tokens dropped, doubled, exchanged, replaced,
//! whole statements moved. The seeds are fixed, so that every run is the same; `HANGTIME_FUZZ_CASES`
//! sets their number (100 000 for a thorough run in the release profile).

use std::collections::BTreeSet;
use std::sync::LazyLock;

use proc_macro2::{Delimiter, Group, Ident, Literal, Punct, Spacing, Span, TokenStream, TokenTree};

/// Declarations to start from; together they use every statement.
const SCENES: [&str; 8] = [
    "/// A ball. \n pub Ball { parameters { m: kg = 1, g: m/s^2 = 9.81 } coordinates { z: m in 0..=9 } lagrangian \
     m/2*dot(z)^2 - m*g*z surface ground: z >= 0 impact ground: inelastic start { z: 1, dot(z): 2 [m/s] } \
     horizon 5 [s] }",
    "Pump { parameters { a: m = 0.2, k: 1/m = 2, m: kg = 3 } coordinates { y: m, s: m } controls { u: N in \
     -1..=1 } fn track(y) = a*(1 - cos(k*y)) let p = (y, track(y) + s) lagrangian m/2*|dot(p)|^2 forces { s: \
     u } surface ground: s >= 0 impact ground: inelastic, along (-diff(track)(y), 1) }",
    "pub(crate) Two { parameters { c = 2 } coordinates { q, p } lagrangian dot(q)^2/2 + c*dot(p)^2*(2 + \
     sin(q)) - exp(q/3) + t*q dissipation c/2*dot(p)^2 surface wall: q <= 3 impact wall: inelastic \
     dry friction rail: bound c*exp(q/9), sliding dot(p) - q*dot(q) outputs { rub = friction_force(rail) } }",
    "V { parameters { e = 2 } coordinates { x, y, z } let p = (x, y, z) lagrangian |dot(p)|^2/2 - dot(p, p) \
     + cross((x, y), (y, z))^e + p[0]*p.z + p . p + atan2(y, 3 + x) }",
    "Top { parameters { m: kg = 2, j: kg m^2 = 1, l: m = 0.3 } coordinates { a: rad, b: rad } let r = \
     rotation_z(a)*rotation_x(b) let w = transpose(r)*dot(r) let spin = (w[2][1], w[0][2], w[1][0]) let inertia \
     = diagonal(j, j, 2*j) let p = l*(((1, 0, 0), (0, 1, 0), (0, 0, 1))*(r*(0, 0, 1))) lagrangian \
     (inertia*spin) . (spin)/2 + m/2*|dot(p)|^2 + j*dot(a)^2/2 forces { a: (rotation(b)*(0, 1))[0] * 1 [N m] } }",
    "Hop { parameters { m: kg = 2, g: m/s^2 = 9.81, e = 0.5, mu = 0.3, w: 1/N^2 = 1, haste: 1/s = 2 } coordinates { \
     y: m, z: m in 0..=9 } controls { u: N in -1..=1 } lagrangian m/2*|dot((y, z))|^2 - m*g*z forces { y: u } \
     surface ground: z >= 0.1 [m]*sin(y/1 [m]) surface wall: y <= 3 [m] impact ground: restitution e, friction mu \
     impact wall: friction 0.1, inelastic, sliding dot(z) minimize haste*(time + integral(w*u^2)/2) - \
     y/1 [m] finally { y == 2 [m], dot(z) >= 0, time <= 9 [s] } constraint top: z <= 2 [m] constraint power: \
     u*dot(y) >= -3 [W] free { z in 30..=50 [cm], dot(y) in 0..=3, dot(z) } start { z: 0.4, dot(y): 1 } }",
    "Chain { parameters { l = 1, mu = 0.5 } coordinates { a, b, c, d, f } let p = l*(sin(a) + sin(b) + sin(c) + \
     sin(d) + sin(f), cos(a) - cos(b) + cos(c) - cos(d) - cos(f)) lagrangian |dot((a, b, c, d, f))|^2 + \
     |dot(p)|^2 - p.z surface floor: p.z >= -3 impact floor: holding b, c, restitution mu/2, friction mu, sliding \
     dot(p.y) minimize integral(a^2 + dot(b)) + time }",
    "Shown { parameters { m: kg = 1, r: m = 0.1 } coordinates { y: m, z: m, a: rad } lagrangian m/2*|dot((y, z))|^2 + \
     m*r^2/4*dot(a)^2 surface floor: z >= r impact floor: inelastic, friction 0.3, sliding dot(y + r*a) start { z: 1 } outputs { speed: km/h = |dot((y, \
     z))|, push: N = force(floor), rub = friction_force(floor)/m, hit: N s = impulse(floor), far: m = max(|y|, z) } picture { circle ball at (y, z) radius r angle a, \
     point p at (y, z), rectangle box at (y, r) size (r, 2*r), polygon roof at (0, r) corners ((0, 0), (r, 0), (0, r)), \
     link ball to (0, 0), spring p to roof, curve ground: (w, r*sin(w/r)) over w, curve arc: (r*cos(s), r) over s in \
     0..=2*pi } constraint slow: speed^2 <= 9 [m^2/s^2] }",
];

struct Random(u64);

impl Random {
    fn below(&mut self, n: usize) -> usize {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        ((self.0 >> 33) as usize) % n.max(1)
    }
}

/// Words of the language, of the scenes, and of neither.
static WORDS: LazyLock<Vec<&str>> = LazyLock::new(|| {
    let others = "self _x sqrt abs min clamp if friction_impulse within misfit huber".split(' ');
    let of_scenes = SCENES
        .iter()
        .flat_map(|scene| scene.split(|c: char| !c.is_alphanumeric() && c != '_'));
    let of_scenes = of_scenes.filter(|word| word.starts_with(|c: char| c.is_alphabetic()));
    let words: BTreeSet<&str> = others
        .chain(of_scenes)
        .chain(hangtime_dsl::words())
        .collect();
    words.into_iter().collect()
});
const SYMBOLS: [char; 22] = [
    '+', '-', '*', '/', '^', '|', '=', ',', ':', ';', '.', '>', '<', '!', '#', '$', '?', '@', '&',
    '%', '~', '=',
];

/// A token out of thin air.
fn invented(random: &mut Random) -> TokenTree {
    match random.below(8) {
        0..=2 => {
            let word = WORDS[random.below(WORDS.len())];
            TokenTree::Ident(Ident::new(word, Span::call_site()))
        }
        3 | 4 => TokenTree::Punct(Punct::new(
            SYMBOLS[random.below(SYMBOLS.len())],
            if random.below(2) == 0 {
                Spacing::Joint
            } else {
                Spacing::Alone
            },
        )),
        5 => TokenTree::Literal(match random.below(6) {
            0 => Literal::f64_unsuffixed(1e300),
            1 => Literal::string("text"),
            2 => Literal::character('c'),
            3 => Literal::f32_suffixed(1.5),
            4 => Literal::u64_unsuffixed(u64::MAX),
            _ => Literal::usize_unsuffixed(random.below(4)),
        }),
        _ => {
            let delimiter = [
                Delimiter::Parenthesis,
                Delimiter::Brace,
                Delimiter::Bracket,
                Delimiter::None,
            ][random.below(4)];
            let inside = (0..random.below(3)).map(|_| invented(random)).collect();
            TokenTree::Group(Group::new(delimiter, inside))
        }
    }
}

/// The stream with one change, somewhere.
fn mutated(stream: TokenStream, random: &mut Random) -> TokenStream {
    let mut tokens: Vec<TokenTree> = stream.into_iter().collect();
    if tokens.is_empty() {
        return invented(random).into();
    }
    let at = random.below(tokens.len());
    if let TokenTree::Group(group) = &tokens[at]
        && random.below(8) != 0
    {
        let inside = mutated(group.stream(), random);
        tokens[at] = TokenTree::Group(Group::new(group.delimiter(), inside));
        return tokens.into_iter().collect();
    }
    let other = random.below(tokens.len());
    match random.below(6) {
        0 => {
            tokens.remove(at);
        }
        1 => {
            let copy = tokens[at].clone();
            tokens.insert(at, copy);
        }
        2 => tokens.swap(at, other),
        3 => tokens[at] = invented(random),
        4 => tokens.insert(at, invented(random)),
        _ => {
            let moved = tokens.remove(at);
            tokens.insert(other.min(tokens.len()), moved);
        }
    }
    tokens.into_iter().collect()
}

#[test]
fn malformed_declarations_are_answered_by_messages() {
    let cases: u64 = std::env::var("HANGTIME_FUZZ_CASES")
        .ok()
        .and_then(|text| text.parse().ok())
        .unwrap_or(1500);
    let scenes: Vec<TokenStream> = SCENES.iter().map(|text| text.parse().unwrap()).collect();
    for scene in SCENES {
        assert_eq!(crate::mistakes_in(scene), ["accepted"]);
    }
    let mut refused = 0;
    for seed in 0..cases {
        let mut random = Random(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15).wrapping_add(1));
        let mut stream = scenes[random.below(scenes.len())].clone();
        for _ in 0..=random.below(3) {
            stream = mutated(stream, &mut random);
        }
        let text = stream.to_string();
        if let Err(mistakes) = hangtime_dsl::try_expand(stream.clone()) {
            refused += 1;
            assert!(!mistakes.is_empty(), "refused without a message: {text}");
            for mistake in &mistakes {
                assert!(!mistake.message.trim().is_empty(), "empty message: {text}");
                assert!(
                    !mistake.message.contains('\n'),
                    "a message is one line: {:?}",
                    mistake.message
                );
            }
        }
        // The whole expansion must be made of tokens too, stub included.
        assert!(
            !hangtime_dsl::expand(stream).is_empty(),
            "nothing emitted: {text}"
        );
    }
    // Most single changes break a declaration; if hardly any did, the test would test nothing.
    assert!(refused > cases / 2, "{refused} of {cases}");
}

#[test]
fn same_scene_expands_to_the_same_code() {
    // Maps that hash with keys of their own iterate in another order each time, and a clock shows another one.
    for scene in SCENES {
        let stream: TokenStream = scene.parse().expect("tokens");
        let code = hangtime_dsl::expand(stream.clone()).to_string();
        assert_eq!(code, hangtime_dsl::expand(stream).to_string());
    }
}
