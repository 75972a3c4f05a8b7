hangtime::model! {
    pub Ball {
        parameters { m: kg = 1, g: m/s^2 = 9.81 }
        coordinates { z: m }
        lagrangian -m*g*z
    }
}

fn main() {}
