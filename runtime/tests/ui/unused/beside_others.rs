hangtime::model! {
    pub Ball {
        parameters { m: kg = 1, g: m/s^2 = 9.81, drag: kg/s = 0.1 }
        coordinates { z: m }
        lagrangian m/2*dot(z)^2 - m*g*z
        horizon 2 [kg]
    }
}

fn main() {}
