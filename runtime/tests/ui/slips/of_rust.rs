hangtime::model! {
    pub Pendulum {
        parameters { m: kg = 1 kg, l: m = 1, g: m/s^2 = 9,81 }
        coordinates { theta: rad }
        lagrangian 1.0_f64*m/2*l^2*dot(theta).powi(2) + m*g*l*cos theta
        surface stop: theta <= std::f64::consts::PI
        impact stop: restitution
        start { theta: 3 dot(theta): 1 }
        horizon 2 s
    }
}

fn main() {}
