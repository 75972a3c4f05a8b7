hangtime::model! {
    pub Ball {
        parameters { m: kg = 1, g: meter/s^2 = 9.81, t: s = 1 }
        coordinates { y: m in 2..=1, z: m }
        controls { u: N }
        let p = (y, z, 0)
        lagrangian m/2*|dot(p)|^2 - m g*p.w
        force { y: u }
        surface ground: sign(z) >= 0
        impact ground: inelastic
        start { x: 1 }
    }
}

fn main() {
    let ball = Ball::default().with_m(2.0);
    let _: &dyn hangtime::model::Model = &ball;
}
