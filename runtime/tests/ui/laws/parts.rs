hangtime::model! {
    pub Ball {
        parameters { m: kg = 1, g: m/s^2 = 9.81 }
        coordinates { y: m, z: m }
        lagrangian m/2*|dot((y, z))|^2 - m*g*z
        surface ground: z >= 0
        surface wall: y >= 0
        surface roof: z <= 3 [m]
        impact ground: inelastic, restitution 0.5
        impact wall: inelastic, along (1, 1), friction 0.3
        impact roof: inelastic, sliding dot(y)
    }
}

fn main() {}
