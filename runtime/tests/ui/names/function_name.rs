hangtime::model! {
    pub Ball {
        parameters { m: kg = 1, cos = 2 }
        coordinates { z: m }
        lagrangian m/2*dot(z)^2
    }
}

fn main() {
    let ball = Ball::default();
    let _ = hangtime::model::Model::declaration(&ball);
}
