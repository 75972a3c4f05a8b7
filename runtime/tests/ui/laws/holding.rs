hangtime::model! {
    pub Ball {
        parameters { m: kg = 1, g: m/s^2 = 9.81 }
        coordinates { y: m, z: m }
        lagrangian m/2*|dot((y, z))|^2 - m*g*z
        surface ground: z >= 0
        surface wall: y >= 0
        impact ground: inelastic, holding z
        impact wall: inelastic, holding x
    }
}

fn main() {}
