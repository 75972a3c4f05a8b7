hangtime::model! {
    pub Ball {
        parameters { m: kg = 1 }
        coordinates { z: m }
        lagrangian m/2*z'a^2
    }
}

fn main() {}
