//! Scenes that several files of tests differentiate.

/// A ball that rubs on hills.
pub(crate) const HILLS: &str = "
    parameters { m: kg = 1, g: m/s^2 = 9.81, a: m = 0.2, w: 1/m = 2, e = 0.5, mu = 0.2, u0: m/s = 1, height: m = 1 }
    coordinates { x: m, z: m }
    lagrangian m/2*(dot(x)^2 + dot(z)^2) - m*g*z
    surface hills: z - a*sin(w*x) >= 0
    impact hills: restitution e, friction mu, sliding dot(x) + a*w*cos(w*x)*dot(z)
    start { x: 0 [m], z: height, dot(x): u0 }
    outputs { rubbed: N*s = friction_impulse(hills) }
    horizon 1.1 [s]
";

/// Two links that strike a wall.
pub(crate) const LINKS: &str = "
    parameters { m: kg = 1, g: m/s^2 = 9.81, l: m = 0.8, e = 0.5, a0: rad = 1, b0: rad = 0.5, wall: m = -0.1 }
    coordinates { a: rad, b: rad }
    lagrangian m/2*l^2*(2*dot(a)^2 + dot(b)^2 + 2*dot(a)*dot(b)*cos(a - b)) + m*g*l*(2*cos(a) + cos(b))
    surface wall_at: l*sin(a) + l*sin(b) - wall >= 0
    impact wall_at: restitution e
    start { a: a0, b: b0 }
    horizon 1.2 [s]
";

/// A block on a belt, held by a spring: it sticks, slips and sticks again.
pub(crate) const BELT: &str = "
    parameters { m: kg = 1, k: N/m = 20, mu = 0.3, g: m/s^2 = 9.81, belt: m/s = 0.3, x0: m = 0.02 }
    coordinates { x: m, z: m }
    lagrangian m/2*(dot(x)^2 + dot(z)^2) - m*g*z - k/2*x^2
    surface floor: z >= 0
    impact floor: inelastic, friction mu, sliding dot(x) - belt
    start { x: x0, z: 0 [m] }
    outputs { rubbing: N = friction_force(floor), load: N = force(floor) }
    horizon 3 [s]
";

/// A body that slides over a hump, leaves it and lands.
pub(crate) const HUMP: &str = "
    parameters { m: kg = 1, g: m/s^2 = 9.81, a: m = 0.5, s: m = 1, u0: m/s = 5, c: N*s/m = 0.1 }
    coordinates { x: m, z: m }
    lagrangian m/2*(dot(x)^2 + dot(z)^2) - m*g*z
    forces { x: -c*dot(x), z: -c*dot(z) }
    surface hump: z - a*exp(-(x/s)^2) >= 0
    impact hump: inelastic
    start { x: -2*s, z: a*exp(-4), dot(x): u0, dot(z): u0*4*a/s*exp(-4) }
    horizon 1.2 [s]
";

/// A ball that is thrown up to a ceiling, which it only just reaches.
pub(crate) const CEILING: &str = "
    parameters { g: m/s^2 = 8, v0: m/s = 4, top: m = 1 }
    coordinates { z: m }
    lagrangian 1[kg]*(dot(z)^2/2 - g*z)
    surface ceiling: top - z >= 0
    impact ceiling: restitution 0.5
    start { dot(z): v0 }
    horizon 1 [s]
";

/// A ball between a floor and a net, a condition that throws it back.
pub(crate) const NET: &str = "
    parameters { g: m/s^2 = 9.81, v0: m/s = 4, top: m = 0.5, share = 0.6, e = 0.7, c: N*s/m = 0.1 }
    coordinates { z: m }
    lagrangian (dot(z)^2/2 - g*z)*1 [kg]
    forces { z: -c*dot(z) }
    surface floor: z >= 0
    impact floor: restitution e
    when z >= top { dot(z) = -share*dot(z) }
    start { z: 0.1, dot(z): v0 }
    horizon 1.2 [s]
";
