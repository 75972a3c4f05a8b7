//! A four-bar linkage as rods whose loop a joint closes, and by the angle of its crank.

/// Masses and lengths of the three links, the distance of their bearings, and gravity.
pub(crate) const SIZES: &str = "
    parameters { m1: kg = 1, m2: kg = 2, m3: kg = 1.5, a: m = 1, b: m = 2.2, c: m = 1.8, d: m = 2, g: m/s^2 = 9.81 }
";

/// Three angles and a loop.
pub(crate) const RODS: &str = "
    coordinates { t1: rad, t2: rad, t3: rad }
    let crank = (a*cos(t1), a*sin(t1))
    let c2 = crank + (b*cos(t2), b*sin(t2))/2
    let c3 = (d + c/2*cos(t3), c/2*sin(t3))
    let links = m1*a^2/6*dot(t1)^2 + m2/2*|dot(c2)|^2 + m2*b^2/24*dot(t2)^2 + m3/2*|dot(c3)|^2 + m3*c^2/24*dot(t3)^2
    lagrangian links - g*(m1*crank.z/2 + m2*c2.z + m3*c3.z)
    joint loop: crank + (b*cos(t2), b*sin(t2)) == (d + c*cos(t3), c*sin(t3))
";

/// The angle of the crank, from which the others follow where two circles meet.
pub(crate) const CRANK: &str = "
    coordinates { t1: rad }
    let e1 = (a*cos(t1) - d, a*sin(t1))
    let w = c^2 - |e1|^2 - b^2
    let s = sqrt(4*b^2*|e1|^2 - w^2)
    let u2 = ((w*e1.y + s*e1.z)/(2*b*|e1|^2), (w*e1.z - s*e1.y)/(2*b*|e1|^2))
    let crank = (a*cos(t1), a*sin(t1))
    let c2 = crank + u2*b/2
    let tip = crank + u2*b
    let c3 = (d/2, 0 [m]) + tip/2
    let links = m1*a^2/6*dot(t1)^2 + m2/2*|dot(c2)|^2 + m2*b^2/24*|dot(u2)|^2 + m3/2*|dot(c3)|^2
    lagrangian links + m3/24*|dot(tip)|^2 - g*(m1*crank.z/2 + m2*c2.z + m3*c3.z)
";
