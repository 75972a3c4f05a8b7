hangtime::model! {
    pub Ball {
        parameters { m: kg = 1, g: m/s^2 = 9.81, height: m = 2 }
        coordinates { z: m }
        lagrangian m/2*dot(z)^2 - m*g*z
        surface ground: height >= 0
        impact ground: inelastic
    }
}

fn main() {}
