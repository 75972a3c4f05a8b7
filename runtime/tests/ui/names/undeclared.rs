hangtime::model! {
    pub Pendulum {
        parameters { m: kg = 1, l: m = 1, g: m/s^2 = 9.81 }
        coordinates { theta }
        lagrangian m/2*l^2*dot(theta)^2 + m*g*l*cos(thetta)
    }
}

fn main() {
    let _ = Pendulum { m: 2.0, ..Default::default() };
}
