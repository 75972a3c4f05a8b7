//! Scenes without friction whose impacts are inelastic.

/// Acceleration of gravity in every scene [m/s^2].
pub(crate) const GRAVITY: f64 = 9.81;

hangtime::model! {
    /// A point mass above ground `z = height cos(number y)`.
    pub(crate) OnGround {
        parameters { mass: kg = 1, g: m/s^2 = 9.81, height: m = 0, number: 1/m = 1 }
        coordinates { y: m, z: m }
        lagrangian mass/2*|dot((y, z))|^2 - mass*g*z
        surface ground: z >= height*cos(number*y)
        impact ground: inelastic
    }
}

/// A point mass above flat ground.
pub(crate) fn ball() -> OnGround {
    OnGround {
        mass: 0.5,
        ..OnGround::default()
    }
}

/// A point mass on wavy ground.
pub(crate) fn waves(height: f64, number: f64) -> OnGround {
    OnGround {
        height,
        number,
        ..OnGround::default()
    }
}

hangtime::model! {
    /// The ski jump: a point mass on the table and the slope.
    pub(crate) SkiJump {
        parameters { mass: kg = 80, g: m/s^2 = 9.81 }
        coordinates { y: m, z: m }
        fn table(y) = (((-0.0001524[1/m^3]*y - 0.002149[1/m^2])*y + 0.4162[1/m])*y - 9.154)*y + 99.15[m]
        lagrangian mass/2*|dot((y, z))|^2 - mass*g*z
        surface table_surface: z >= table(y)
        surface slope: z >= 45[m] - y/2
        impact table_surface, slope: inelastic
        start { z: 100[m] }
    }
}

/// Where the figure's ride begins at rest on the table, `(y, z)` \[m\].
pub(crate) const SKI_JUMP_START: [f64; 2] = [10.2759, 45.001_581_073_295_69];

/// Where it is after 5 s, `(y, z, v_y, v_z)`, by quadrature in two precisions.
pub(crate) const SKI_JUMP_END: [f64; 4] = [
    59.373_066_742_926_91,
    15.313_466_628_536_545,
    19.390_549_109_241_256,
    -9.695_274_554_620_628,
];

pub(crate) fn ski_jump() -> SkiJump {
    SkiJump::default()
}

hangtime::model! {
    /// A bar of unit mass with tips at distances `front` and `rear` from its centre and the radius of gyration
    /// `radius`, without friction: on flat ground, `D_12 = (1 - front rear / radius^2) / m` when it is level.
    pub(crate) Bar {
        parameters { m: kg = 1, g: m/s^2 = 9.81, front: m = 1, rear: m = 1, radius: m = 1 }
        coordinates { y: m, z: m, phi }
        lagrangian m/2*|dot((y, z))|^2 + m*radius^2/2*dot(phi)^2 - m*g*z
        surface front_tip: z + front*sin(phi) >= 0
        surface rear_tip: z - rear*sin(phi) >= 0
        impact front_tip, rear_tip: inelastic
    }
}

pub(crate) fn bar(front: f64, rear: f64, radius: f64) -> Bar {
    Bar {
        front,
        rear,
        radius,
        ..Bar::default()
    }
}

/// Stiffness of the hopper's spring [N/m].
pub(crate) const STIFFNESS: f64 = 400.0;

hangtime::model! {
    /// A foot on the ground and a body on a spring above it, which a control pulls up.
    pub(crate) Hopper {
        parameters { m: kg = 1, load: kg = 2, g: m/s^2 = 9.81, k: N/m = 400, length: m = 0.5 }
        coordinates { foot: m, body: m }
        controls { u: N }
        lagrangian m/2*dot(foot)^2 + load/2*dot(body)^2 - g*(m*foot + load*body) - k/2*(body - foot - length)^2
        forces { body: u }
        surface ground: foot >= 0
        impact ground: inelastic
    }
}

pub(crate) fn hopper() -> Hopper {
    Hopper {
        k: STIFFNESS,
        ..Hopper::default()
    }
}

hangtime::model! {
    /// A point mass on a track in the coordinates (y, height above the track), with the impulse direction `(-h', 1)`,
    /// which is not `M^-1 grad g`.
    pub(crate) Track {
        parameters { m: kg = 1, g: m/s^2 = 9.81, a: m = 0.2, k: 1/m = 2 }
        coordinates { y: m, s: m }
        fn track(y) = a*(1 - cos(k*y))
        let p = (y, track(y) + s)
        lagrangian m/2*|dot(p)|^2 - m*g*p.z
        surface ground: s >= 0
        impact ground: inelastic, along (-diff(track)(y), 1)
    }
}

pub(crate) fn track_scene() -> Track {
    Track::default()
}
