hangtime::model! {
    pub Rod {
        parameters { m: kg = 1, l: m = 1, mu = 0.3 }
        coordinates { y: m, z: m, theta: rad }
        lagrangian m/2*|dot((y, z))|^2 + m*l^2/24*dot(theta)^2
        surface ground: z >= l/2*cos(theta)
        impact ground: inelastic, friction mu
        start { z: l }
    }
}

fn main() {}
