hangtime::model! {
    pub Ball {
        parameters { m: kg = 1, g: m/s^2 = 9.81 }
        coordinates { y: m, z: m }
        lagrangian m/2*|dot((y, z))|^2 - m*g*z
        controls { u: N }
        forces { y: u }
        finally { u == 0, y = 3 [m] }
        constraint mass: m >= 0
        constraint late: y <= 1 [m/s]*time
    }
}

fn main() {}
