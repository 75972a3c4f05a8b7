//! Scenes for the derivatives of the program: every law, two gaps, and none.

crate::model! {
    /// A bead over a wavy floor and beside a wall that leans: two curved gaps, two directions.
    pub(crate) Bead {
        parameters { m: kg = 2, g: m/s^2 = 9.81, k: 1/m = 1.5, c: kg/s = 0.3 }
        coordinates { y: m, z: m }
        controls { u: N }
        lagrangian m/2*(dot(y)^2 + dot(z)^2) - m*g*z
        forces { y: u*cos(k*y) + u^2/10[N] - c*dot(y) }
        surface floor: z - sin(k*y)/(4*k) >= 0
        surface wall: 1[m] - y - k*z^2/8 >= 0
        impact floor: inelastic
        impact wall: inelastic
        minimize 0.7*time/1[s] + z*dot(z)/1[m^2/s]
            + integral(0.4*u^2/1[N^2] + y^2*dot(z)*u/1[N*m^3/s])/1[s]
        constraint push: 4[N] - u^2/1[N] >= 0
        constraint pace: dot(y)^2 + z*u*1[m/(N*s^2)] >= 0
        finally { y*dot(y) == 0.5[m^2/s], dot(z)^2*time <= 1[m^2/s] }
        free { z in 0..=1, dot(y) in 1..=2 }
        start { z: 0.4 [m], dot(y): 1.5 [m/s] }
    }
}

crate::model! {
    /// A bead that rubs on the floor, and bounces off the wall and rubs on it.
    pub(crate) RoughBead {
        parameters { m: kg = 2, g: m/s^2 = 9.81, k: 1/m = 1.5, c: kg/s = 0.3 }
        coordinates { y: m, z: m }
        controls { u: N }
        lagrangian m/2*(dot(y)^2 + dot(z)^2) - m*g*z
        forces { y: u*cos(k*y) + u^2/10[N] - c*dot(y) }
        surface floor: z - sin(k*y)/(4*k) >= 0
        surface wall: 1[m] - y - k*z^2/8 >= 0
        impact floor: inelastic, friction 0.4, sliding dot(y) + cos(k*y)/4*dot(z)
        impact wall: restitution 0.6, friction 0.2, sliding dot(z) - k*z/4*dot(y)
        minimize integral(0.4*u^2/1[N^2])/1[s]
        finally { y == 0.5[m] }
        free { dot(z) in -1..=1 }
    }
}

crate::model! {
    /// A bead on a dry wire, over a floor and beside a wall, so that the clock is slowed by a product.
    pub(crate) DryBead {
        parameters { m: kg = 2, g: m/s^2 = 9.81, k: 1/m = 1.5, f: N = 3 }
        coordinates { y: m, z: m }
        controls { u: N }
        lagrangian m/2*(dot(y)^2 + (2 + sin(k*y))*dot(z)^2) - m*g*z
        forces { y: u*cos(k*y) }
        surface floor: z >= 0
        surface wall: y <= 1 [m] + k*z^2/8
        impact floor, wall: inelastic
        dry friction wire: bound f*(2 + sin(k*y)*cos(k*z) + t/1[s]), sliding dot(y) - k*z*dot(z)
        minimize integral(0.4*u^2/1[N^2])/1[s]
        finally { y == 0.5[m] }
        free { dot(z) in -1..=1 }
    }
}

crate::model! {
    /// A bead on a wire that moves and bends, and beside a wall that throws it back and rubs on it.
    pub(crate) HeldBead {
        parameters { m: kg = 2, g: m/s^2 = 9.81, k: 1/m = 1.5, w: m/s = 0.2 }
        coordinates { y: m, z: m }
        controls { u: N }
        lagrangian m/2*(dot(y)^2 + (2 + sin(k*y))*dot(z)^2) - m*g*z
        forces { y: u*cos(k*y) }
        joint wire: z + y*z/4[m] == sin(k*y)/k + w*t
        surface wall: 1[m] - y - k*z^2/8 >= 0
        impact wall: restitution 0.6, friction 0.2, sliding dot(z) - k*z/4*dot(y)
        minimize integral(0.4*u^2/1[N^2])/1[s]
        finally { y == 0.5[m] }
        free { z in 0..=1, dot(y) in 1..=2 }
        start { z: 0.4 [m], dot(y): 1.5 [m/s] }
    }
}

crate::model! {
    /// A blade that may only move along itself, which turns with the place, over a floor.
    pub(crate) Blade {
        parameters { m: kg = 2, g: m/s^2 = 9.81, k: 1/m = 1.5 }
        coordinates { y: m, z: m }
        controls { u: N }
        lagrangian m/2*(dot(y)^2 + dot(z)^2) - m*g*z
        forces { y: u*cos(k*y) }
        joint edge: cos(k*y)*dot(z) == sin(k*y)*dot(y)
        surface floor: z >= 0
        impact floor: inelastic
        minimize integral(0.4*u^2/1[N^2])/1[s]
        finally { y == 0.5[m] }
        free { dot(z) in -1..=1 }
    }
}

crate::model! {
    /// A bead without contacts.
    pub(crate) Wire {
        parameters { m: kg = 2, g: m/s^2 = 9.81, k: 1/m = 1.5, f: N = 3 }
        coordinates { y: m, z: m }
        controls { u: N }
        lagrangian m/2*(dot(y)^2 + (2 + sin(k*y))*dot(z)^2) - m*g*z
        forces { y: u*cos(k*y) }
        dry friction wire: bound f*(2 + sin(k*y)*cos(k*z)), sliding dot(y) - k*z*dot(z)
        minimize integral(0.4*u^2/1[N^2])/1[s]
        finally { y == 0.5[m] }
        free { dot(z) in -1..=1 }
    }
}

crate::model! {
    /// A bead over a wavy post with an end on each side: three pieces of one edge.
    pub(crate) EdgedBead {
        parameters { m: kg = 2, g: m/s^2 = 9.81, k: 1/m = 1.5, e = 0, mu = 0 }
        coordinates { y: m, z: m }
        controls { u: N }
        lagrangian m/2*(dot(y)^2 + dot(z)^2) - m*g*z
        forces { y: u*cos(k*y) }
        surface post: max(z - sin(k*y)/(4*k), |y + k*z^2/8| - 0.5 [m]) >= 0
        impact post: restitution e, friction mu
        minimize integral(0.4*u^2/1[N^2] + y^2*dot(z)*u/1[N*m^3/s])/1[s]
        finally { y == 0.5[m] }
        free { z in 0..=1, dot(y) in 1..=2 }
        start { z: 0.4 [m], dot(y): 1.5 [m/s] }
    }
}
