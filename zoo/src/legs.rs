//! Hoppers, walkers and landers.

hangtime::model! {
    /// A body on a massive foot hops from flat ground to a height of 0.5 m.
    pub Hop {
        parameters { g = 9.81 }
        coordinates { z, leg in 0.1..=0.5 }
        controls { u in -60..=60 }
        lagrangian (dot(z) + dot(leg))^2/2 + dot(z)^2/10 - g*(1.2*z + leg)
        forces { leg: u + g }
        surface ground: z >= 0
        impact ground: inelastic
        minimize integral(u^2)
        finally { z >= 0.3 }
        start { leg: 0.3 }
        horizon 1.2
    }
}

hangtime::model! {
    /// A body on a massless spring leg with a motor hops forward over a rough floor and has to be 1 m away, as high as it
    /// began, with its speed.
    pub HopForward {
        parameters { g = 9.81, mu = 0.8 }
        coordinates { y, z, foot_y, foot_z }
        controls { push in -40..=40, swing in -10..=10 }
        lagrangian (dot(y)^2 + dot(z)^2)/2 + (dot(foot_y)^2 + dot(foot_z)^2)/10 - g*(z + foot_z/5) - 20*(z - foot_z - 0.6)^2 - 5*(y - foot_y)^2
        forces { y: swing, z: push, foot_y: -swing, foot_z: -push }
        surface ground: foot_z >= 0
        impact ground: inelastic, friction mu, sliding dot(foot_y)
        minimize integral(push^2 + swing^2)
        finally { y == 1, z == 0.8, foot_y == 1 }
        start { z: 0.8, foot_z: 0.2 }
        horizon 1.5
    }
}

hangtime::model! {
    /// A lander with a thruster and a leg with a spring touches down: its foot has to stay on the ground, at rest.
    pub Lander {
        parameters { g = 1.6 }
        coordinates { z, leg in 0.2..=1.5 }
        controls { thrust in 0..=8 }
        lagrangian dot(z)^2/10 + (dot(z) + dot(leg))^2/2 - g*(1.2*z + leg) - 10*(leg - 1)^2
        dissipation dot(leg)^2
        forces { z: thrust, leg: thrust }
        surface ground: z >= 0
        impact ground: inelastic
        minimize integral(thrust)/1
        finally { z == 0, dot(z) == 0, dot(leg) == 0 }
        start { z: 4, leg: 1, dot(z): -2 }
        horizon 4
    }
}

hangtime::model! {
    /// A body on two legs that can be made longer and swung: it walks half a metre on a rough floor.
    pub Biped {
        parameters { g = 9.81, mu = 0.7 }
        coordinates { y, z, left_y, left_z, right_y, right_z }
        controls { l_y in -30..=30, l_z in -60..=60, r_y in -30..=30, r_z in -60..=60 }
        lagrangian 2*(dot(y)^2 + dot(z)^2) + (dot(left_y)^2 + dot(left_z)^2 + dot(right_y)^2 + dot(right_z)^2)/4 - g*(4*z + left_z/2 + right_z/2)
        forces { y: l_y + r_y, z: l_z + r_z, left_y: -l_y, left_z: -l_z, right_y: -r_y, right_z: -r_z }
        surface left_foot: left_z >= 0
        surface right_foot: right_z >= 0
        impact left_foot: inelastic, friction mu, sliding dot(left_y)
        impact right_foot: inelastic, friction mu, sliding dot(right_y)
        minimize integral((l_y^2 + r_y^2)/10 + (l_z - 19.62)^2/100 + (r_z - 19.62)^2/100)
        constraint left_reach: (y - left_y)^2 + (z - left_z)^2 <= 1
        constraint right_reach: (y - right_y)^2 + (z - right_z)^2 <= 1
        finally { y == 0.5, z == 0.8, left_y == 0.4, right_y == 0.6, left_z == 0, right_z == 0 }
        start { z: 0.8, left_y: -0.1, right_y: 0.1 }
        horizon 1.5
    }
}

hangtime::model! {
    /// A hopper with a thruster: from the ground onto a step that is 0.5 m high, with little fuel.
    pub ThrustHop {
        parameters { g = 9.81 }
        coordinates { y, z }
        controls { push in -5..=5, lift in 0..=25 }
        fn ground(y) = 0.25 + 0.25*tanh(6*(y - 1))
        lagrangian (dot(y)^2 + dot(z)^2)/2 - g*z
        forces { y: push, z: lift }
        surface floor: z >= ground(y)
        impact floor: inelastic
        minimize integral(push^2 + lift^2)
        finally { y == 2, z == ground(2), dot(y) == 0 }
        start { z: ground(0) }
        horizon 2
    }
}
