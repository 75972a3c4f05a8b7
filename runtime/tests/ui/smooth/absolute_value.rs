hangtime::model! {
    pub Ball {
        parameters { m: kg = 1, g: m/s^2 = 9.81 }
        coordinates { y: m, z: m }
        lagrangian m/2*|dot((y, z))|^2 - m*g*abs(z)
        surface wall: y >= -1 [m]
        impact wall: inelastic
    }
}

fn main() {}
