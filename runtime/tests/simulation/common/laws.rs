//! Scenes whose contacts bounce, stick and slip. `e` is the coefficient of restitution, `mu` that of friction.

hangtime::model! {
    /// A point mass that a spring holds and a control pushes along `y`, on the side of the ground where gravity does not
    /// pull it: a plane that falls by `slope` for growing `y`, with waves and a bowl on it. The gap is `scale` times
    /// the distance from the plane.
    pub(crate) Ground {
        parameters {
            mass: kg = 1, g: m/s^2 = 9.81, stiffness: N/m = 0,
            slope = 0, offset: m = 0, height: m = 0, number: 1/m = 1, curvature: 1/m = 0, scale: 1 = 1,
            e = 0, mu = 0,
        }
        coordinates { y: m, z: m }
        controls { u: N }
        let relief = offset + height*cos(number*y) + curvature/2*y^2
        lagrangian mass/2*|dot((y, z))|^2 - mass*g*z - stiffness/2*y^2
        forces { y: u }
        surface ground: scale*((z - relief)*cos(slope) + y*sin(slope)) >= 0
        impact ground: restitution e, friction mu
    }
}

impl Ground {
    /// Height of the surface above `y`.
    pub(crate) fn height_at(&self, y: f64) -> f64 {
        let relief =
            self.offset + self.height * f64::cos(self.number * y) + 0.5 * self.curvature * y * y;
        relief - y * self.slope.tan()
    }
}

hangtime::model! {
    /// A point mass in a square room of unit side.
    pub(crate) Room {
        parameters { mass: kg = 2, gravity: m/s^2 = 9.81, e = 0, mu = 0 }
        coordinates { y: m, z: m }
        lagrangian mass/2*|dot((y, z))|^2 - mass*gravity*z
        surface floor: z >= 0
        surface left: y >= 0
        surface right: y <= 1[m]
        surface ceiling: z <= 1[m]
        impact floor, ceiling: restitution e, friction mu, sliding dot(y)
        impact left, right: restitution e, friction mu, sliding dot(z)
    }
}

hangtime::model! {
    /// A round body of unit mass on ground that falls by `slope`; the angle grows such that the lowest point moves with
    /// `v_y + radius angle'`. Its moment of inertia is `shape` times mass and radius squared.
    pub(crate) Disc {
        parameters { m: kg = 1, g: m/s^2 = 9.81, radius: m = 1, shape = 0.5, slope = 0, e = 0, mu = 0 }
        coordinates { y: m, z: m, angle }
        lagrangian m/2*|dot((y, z))|^2 + shape*m*radius^2/2*dot(angle)^2 - m*g*z
        surface ground: z*cos(slope) + y*sin(slope) >= radius
        impact ground: restitution e, friction mu, sliding dot(y)*cos(slope) - dot(z)*sin(slope) + radius*dot(angle)
        start { z: radius/cos(slope) }
    }
}

hangtime::model! {
    /// A rod of unit mass that touches the ground with its tip at `(y + arm cos angle, z + arm sin angle)`. By default
    /// slender and of length 2, the tip at the other end: `D_nn = 1 + 3 cos^2`, `D_nt = -3 sin cos`,
    /// `D_tt = 1 + 3 sin^2`.
    pub(crate) Rod {
        parameters { m: kg = 1, g: m/s^2 = 9.81, inertia: kg m^2 = 0.3333333333333333, arm: m = -1, e = 0, mu = 0 }
        coordinates { y: m, z: m, angle }
        lagrangian m/2*|dot((y, z))|^2 + inertia/2*dot(angle)^2 - m*g*z
        surface tip: z + arm*sin(angle) >= 0
        impact tip: restitution e, friction mu, sliding dot(y + arm*cos(angle))
    }
}

hangtime::model! {
    /// A bar of unit mass with tips at distances `front` and `rear` from its centre.
    pub(crate) Feet {
        parameters { m: kg = 1, g: m/s^2 = 9.81, front: m = 1, rear: m = 1, gyration: m = 1, e = 0, mu = 0 }
        coordinates { y: m, z: m, angle }
        lagrangian m/2*|dot((y, z))|^2 + m*gyration^2/2*dot(angle)^2 - m*g*z
        surface front_tip: z + front*sin(angle) >= 0
        surface rear_tip: z - rear*sin(angle) >= 0
        impact front_tip: restitution e, friction mu, sliding dot(y + front*cos(angle))
        impact rear_tip: restitution e, friction mu, sliding dot(y - rear*cos(angle))
    }
}

hangtime::model! {
    /// A table of unit mass, its centre `height` above two feet at `y - 1` and `y + 1`, held by a spring at
    /// the centre's height.
    pub(crate) Table {
        parameters {
            m: kg = 1, inertia: kg m^2 = 0.5, g: m/s^2 = 9.81, half: m = 1, height: m = 1, stiffness: N/m = 0,
            e = 0, mu = 0,
        }
        coordinates { y: m, z: m, angle }
        let rear = (y - half*cos(angle) + height*sin(angle), z - half*sin(angle) - height*cos(angle))
        let front = (y + half*cos(angle) + height*sin(angle), z + half*sin(angle) - height*cos(angle))
        lagrangian m/2*|dot((y, z))|^2 + inertia/2*dot(angle)^2 - m*g*z - stiffness/2*y^2
        surface rear_foot: rear.z >= 0
        surface front_foot: front.z >= 0
        impact rear_foot: restitution e, friction mu, sliding dot(rear.y)
        impact front_foot: restitution e, friction mu, sliding dot(front.y)
        start { z: height }
    }
}

hangtime::model! {
    /// A crate of unit mass with friction at each of its four corners against floor and walls.
    pub(crate) RoughCrate {
        parameters {
            m: kg = 1, g: m/s^2 = 9.81, half_width: m = 0.3, half_height: m = 0.2, half_room: m = 1, mu = 0,
        }
        coordinates { y: m, z: m, angle }
        fn corner_y(side, end) = y + cos(angle)*side*half_width - sin(angle)*end*half_height
        fn corner_z(side, end) = z + sin(angle)*side*half_width + cos(angle)*end*half_height
        lagrangian m/2*|dot((y, z))|^2 + m*(half_width^2 + half_height^2)/6*dot(angle)^2 - m*g*z
        surface floor_1: corner_z(1, 1) >= 0
        surface floor_2: corner_z(-1, 1) >= 0
        surface floor_3: corner_z(1, -1) >= 0
        surface floor_4: corner_z(-1, -1) >= 0
        surface left_1: corner_y(1, 1) >= -half_room
        surface left_2: corner_y(-1, 1) >= -half_room
        surface left_3: corner_y(1, -1) >= -half_room
        surface left_4: corner_y(-1, -1) >= -half_room
        surface right_1: corner_y(1, 1) <= half_room
        surface right_2: corner_y(-1, 1) <= half_room
        surface right_3: corner_y(1, -1) <= half_room
        surface right_4: corner_y(-1, -1) <= half_room
        impact floor_1: inelastic, friction mu, sliding dot(corner_y(1, 1))
        impact floor_2: inelastic, friction mu, sliding dot(corner_y(-1, 1))
        impact floor_3: inelastic, friction mu, sliding dot(corner_y(1, -1))
        impact floor_4: inelastic, friction mu, sliding dot(corner_y(-1, -1))
        impact left_1, right_1: inelastic, friction mu, sliding dot(corner_z(1, 1))
        impact left_2, right_2: inelastic, friction mu, sliding dot(corner_z(-1, 1))
        impact left_3, right_3: inelastic, friction mu, sliding dot(corner_z(1, -1))
        impact left_4, right_4: inelastic, friction mu, sliding dot(corner_z(-1, -1))
        start { z: half_height }
    }
}
