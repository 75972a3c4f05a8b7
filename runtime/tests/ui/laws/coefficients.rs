hangtime::model! {
    pub Ball {
        parameters { m: kg = 1, g: m/s^2 = 9.81, e = 1.2 }
        coordinates { y: m, z: m }
        lagrangian m/2*|dot((y, z))|^2 - m*g*z
        surface ground: z >= 0
        surface wall: y >= 0
        impact ground: restitution e
        impact wall: inelastic, friction -0.3
    }
}

fn main() {}
