hangtime::model! {
    pub Ball {
        parameters { m: kg = 1, g: m/s^2 = 9.81 }
        coordinates { y: m, z: m }
        lagrangian m/2*|dot((y, z))|^2 - m*g*z
        controls { u: N }
        forces { y: u }
        minimize u^2/1 [N^2 s] + integral(1) - sqrt(integral(u))
    }
}

fn main() {}
