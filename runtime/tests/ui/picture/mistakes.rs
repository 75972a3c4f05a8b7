hangtime::model! {
    pub Ball {
        parameters { m: kg = 1, g: m/s^2 = 9.81 }
        coordinates { y: m, z: m }
        lagrangian m/2*|dot((y, z))|^2 - m*g*z
        surface floor: z >= 0
        impact floor: inelastic
        outputs { speed: m = |dot((y, z))|, push: N = force(flor) }
        picture { circle ball at (y, z) radius 0.1, link ball to hook, point nose at z }
        constraint gentle: force(floor) <= 3 [N]
    }
}

fn main() {}
