hangtime::model! {
    pub Ball {
        parameters { m: kg = 1, g: m/s^2 = 9.81 }
        coordinates { y: m, z: m }
        lagrangian m/2*|dot((y, z))|^2 - m*g*z
        controls { u: N }
        forces { y: u }
        minimize time + integral(u^2)
        finally { y == 1 }
    }
}

fn main() {}
