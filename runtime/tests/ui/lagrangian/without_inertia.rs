hangtime::model! {
    pub Ball {
        parameters { m: kg = 1, g: m/s^2 = 9.81 }
        coordinates { y: m, z: m }
        lagrangian m/2*dot(z)^2 - m*g*z - m*g*y
    }
}

fn main() {}
