//! The scenes of the steps.

hangtime::model! {
    /// A ball over flat ground.
    pub(crate) Ball {
        parameters { m: kg = 0.5, g: m/s^2 = 9.81 }
        coordinates { y: m, z: m }
        lagrangian m/2*(dot(y)^2 + dot(z)^2) - m*g*z
        surface ground: z >= 0
        impact ground: inelastic
    }
}

hangtime::model! {
    /// A point mass over waves.
    pub(crate) Waves {
        parameters { m: kg = 0.5, g: m/s^2 = 9.81, height: m = 0.2, k: 1/m = 1 }
        coordinates { y: m, z: m }
        lagrangian m/2*(dot(y)^2 + dot(z)^2) - m*g*z
        surface ground: z - height*sin(k*y) >= 0
        impact ground: inelastic
    }
}

hangtime::model! {
    /// A point mass in a parabolic bowl.
    pub(crate) Bowl {
        parameters { m: kg = 1, g: m/s^2 = 9.81, c: 1/m = 0.5 }
        coordinates { y: m, z: m }
        lagrangian m/2*(dot(y)^2 + dot(z)^2) - m*g*z
        surface ground: z - c*y^2 >= 0
        impact ground: inelastic
    }
}

hangtime::model! {
    /// A ski jumper: a point mass that slides off a curved table and lands on a straight slope.
    pub(crate) SkiJump {
        parameters { m: kg = 80, g: m/s^2 = 9.81 }
        coordinates { y: m, z: m }
        fn table(y) = -0.0001524[1/m^3]*y^4 - 0.002149[1/m^2]*y^3 + 0.4162[1/m]*y^2 - 9.154*y + 99.15[m]
        fn slope(y) = 45[m] - y/2
        lagrangian m/2*(dot(y)^2 + dot(z)^2) - m*g*z
        surface table: z - table(y) >= 0
        surface slope: z - slope(y) >= 0
        impact table: inelastic
        impact slope: inelastic
        start { y: 10.2759 [m], z: table(10.2759[m]) }
    }
}

hangtime::model! {
    /// A bar over flat ground, with a contact at each end.
    pub(crate) Bar {
        parameters { m: kg = 2, i: kg m^2 = 0.3, g: m/s^2 = 9.81, a: m = 0.5 }
        coordinates { x: m, z: m, phi }
        lagrangian m/2*(dot(x)^2 + dot(z)^2) + i/2*dot(phi)^2 - m*g*z
        surface front: z + a*sin(phi) >= 0
        surface rear: z - a*sin(phi) >= 0
        impact front: inelastic
        impact rear: inelastic
    }
}

hangtime::model! {
    /// Bike and rider with nothing but their weight: the steps of a ride without input.
    pub(crate) PumpTrackWithoutInput {
        parameters { m_b: kg = 15, m_r: kg = 75, g: m/s^2 = 9.81, a: m = 0.2, k: 1/m = 2 }
        coordinates { y: m, s: m, l: m }
        fn track(y) = a*(1 - cos(k*y))
        let bike = (y, track(y) + s)
        let rider = (y, track(y) + s + l)
        lagrangian m_b/2*|dot(bike)|^2 + m_r/2*|dot(rider)|^2 - m_b*g*bike.z - m_r*g*rider.z
        surface ground: s >= 0
        impact ground: inelastic, along (-diff(track)(y), 1, 0)
    }
}
