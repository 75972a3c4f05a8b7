//! Generated derivatives against independent ones.
use hangtime::model::{Model, contact_point};

hangtime::model! {
    /// A ski jumper, seen as a point mass.
    pub SkiJump {
        parameters {
            /// Mass of the jumper.
            m: kg = 80,
            g: m/s^2 = 9.81,
            /// Where the jumper starts.
            start_y: m = 10.2759,
        }
        coordinates { y: m, z: m }
        fn jump(y) = -0.0001524 [1/m^3]*y^4 - 0.002149 [1/m^2]*y^3 + 0.4162 [1/m]*y^2 - 9.154*y + 99.15 [m]
        fn land(y) = 45 [m] - y/2
        let p = (y, z)
        lagrangian m/2*|dot(p)|^2 - m*g*z
        /// The table.
        surface table: z >= jump(y)
        surface slope: z >= land(y)
        impact table, slope: inelastic
        start { y: start_y, z: jump(start_y) }
        horizon 5 [s]
    }
}

hangtime::model! {
    /// Bike and rider: two point masses on a massless link, on a track.
    pub PumpTrack {
        parameters  { m_b: kg = 15, m_r: kg = 75, g: m/s^2 = 9.81, a: m = 0.2, k: 1/m = 2 }
        coordinates { y: m, s: m, l: m in 0.27803..=0.59559 }        // s: height above the track, l: link length
        controls    { u: N in -108.25..=376.875 }

        fn track(y) = a * (1 - cos(k*y))
        let bike  = (y, track(y) + s)
        let rider = (y, track(y) + s + l)

        lagrangian  m_b/2*|dot(bike)|^2 + m_r/2*|dot(rider)|^2 - m_b*g*bike.z - m_r*g*rider.z
        forces      { l: u }                                          // generalized force on a coordinate
        surface ground: s >= 0
        impact  ground: inelastic, along (-diff(track)(y), 1, 0)
    }
}

#[test]
fn show() {
    for model in [
        Box::new(SkiJump::default()) as Box<dyn Model>,
        Box::new(PumpTrack::default()),
    ] {
        let d = model.declaration();
        println!(
            "{} {:?} {:?}",
            d.name, d.documentation, d.derivation_seconds
        );
        for k in d.kernels {
            println!("   {} ops {} out {}", k.name, k.operations, k.outputs);
        }
        for e in d.equations {
            println!("   {} = {}", e.left, e.right);
        }
        println!("{:?}\n{:?}", d.free_jacobian, d.free_hessian);
        let n = d.coordinates.len();
        let mut p = vec![0.0; contact_point::length(n)];
        model.contact(0, &[0.3; 7], &mut p);
        println!("{p:?}");
    }
}
