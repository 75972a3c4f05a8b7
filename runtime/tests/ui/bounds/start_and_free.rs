hangtime::model! {
    pub Ball {
        parameters { m: kg = 1, g: m/s^2 = 9.81 }
        coordinates { y: m, z: m }
        lagrangian m/2*|dot((y, z))|^2 - m*g*z
        constraint top: z <= 3 [m]
        free { dot(y) in 1..=3, z in 2..=1 }
        start { dot(y): 4 }
    }
}

fn main() {}
