//! Blocks, stones and wheels on rough ground.

hangtime::model! {
    /// A block on a rough floor, 3 m from rest to rest. With continuous force the least effort is
    /// `4/3 F^2 T = 16` for the friction `F = 2` and `T = sqrt(6 d/F) = 3` of the 5 s.
    pub RoughBlock {
        parameters { mu = 0.2, g = 10 }
        coordinates { y, z }
        controls { u in -20..=20 }
        lagrangian (dot(y)^2 + dot(z)^2)/2 - g*z
        forces { y: u }
        surface floor: z >= 0
        impact floor: inelastic, friction mu
        minimize integral(u^2)
        finally { y == 3, dot(y) == 0 }
        horizon 5
    }
}

hangtime::model! {
    /// A particle with two engines is to come from the air to rest on a rough floor.
    pub SoftLanding {
        parameters { mu = 0.3, g = 9.81 }
        coordinates { y, z }
        controls { push in -10..=10, lift in -10..=10 }
        lagrangian (dot(y)^2 + dot(z)^2)/2 - g*z
        forces { y: push, z: lift }
        surface floor: z >= 0
        impact floor: inelastic, friction mu
        minimize integral(push^2 + lift^2)
        finally { y == 3, z == 0, dot(y) == 0 }
        start { z: 2, dot(y): 1 }
        horizon 2
    }
}

hangtime::model! {
    /// A curling stone: it is pushed by a hand that stays behind a line, and has to come to rest in the house.
    pub CurlingStone {
        parameters { mu = 0.1, g = 9.81 }
        coordinates { hand, y, z }
        controls { u in -40..=40 }
        lagrangian dot(hand)^2/2 + 5*(dot(y)^2 + dot(z)^2) - 10*g*z
        forces { hand: u }
        surface grip: y - hand >= 0
        surface ice: z >= 0
        surface line: hand <= 1
        impact grip: inelastic
        impact ice: inelastic, friction mu, sliding dot(y)
        impact line: inelastic
        minimize integral(u^2)
        finally { y == 4 }
        start { hand: -0.2 }
        horizon 4
    }
}

hangtime::model! {
    /// Two blocks on a rough floor, joined by a spring; the one behind is driven, the one in front is to be moved.
    pub BlocksOnSpring {
        parameters { mu = 0.2, g = 10, k = 20, l = 1 }
        coordinates { y_1, z_1, y_2, z_2 }
        controls { u in -15..=15 }
        lagrangian (dot(y_1)^2 + dot(z_1)^2 + dot(y_2)^2 + dot(z_2)^2)/2 - g*(z_1 + z_2) - k/2*(y_2 - y_1 - l)^2
        forces { y_1: u }
        surface floor_1: z_1 >= 0
        surface floor_2: z_2 >= 0
        impact floor_1: inelastic, friction mu, sliding dot(y_1)
        impact floor_2: inelastic, friction mu, sliding dot(y_2)
        minimize integral(u^2)
        finally { y_2 == 2, dot(y_2) == 0, dot(y_1) == 0 }
        start { y_2: l }
        horizon 3
    }
}

hangtime::model! {
    /// A box that is carried on a driven plate: it slips when the plate is too fast, and has to end in the middle.
    pub PlateAndBox {
        parameters { mu = 0.3, g = 9.81 }
        coordinates { plate, y, z }
        controls { u in -30..=30 }
        lagrangian dot(plate)^2 + (dot(y)^2 + dot(z)^2)/2 - g*z
        forces { plate: u }
        surface top: z >= 0
        impact top: inelastic, friction mu, sliding dot(y) - dot(plate)
        minimize time + integral(1e-3*u^2)
        finally { plate == 2, dot(plate) == 0, y == 2.1, dot(y) == 0 }
        horizon 2
    }
}

hangtime::model! {
    /// A driven wheel on rough ground: too much torque spins it. 5 m from rest to rest in least time.
    pub SpinningWheel {
        parameters { r = 0.5, mu = 0.4, g = 9.81 }
        coordinates { y, z, phi }
        controls { torque in -20..=20 }
        lagrangian 2*(dot(y)^2 + dot(z)^2) + dot(phi)^2/4 - 4*g*z
        forces { phi: torque }
        surface ground: z >= r
        impact ground: inelastic, friction mu, sliding dot(y) - r*dot(phi)
        minimize time
        finally { y == 5, dot(y) == 0, dot(phi) == 0 }
        start { z: r }
        horizon 4
    }
}

hangtime::model! {
    /// A block is pushed up a rough slope onto a plateau: one curved ground, and friction that helps it to stay.
    pub UphillBlock {
        parameters { mu = 0.4, g = 9.81 }
        coordinates { y, z }
        controls { u in 0..=25 }
        fn hill(y) = 0.5 + 0.5*tanh(2*(y - 1.5))
        lagrangian (dot(y)^2 + dot(z)^2)/2 - g*z
        forces { y: u }
        surface ground: z >= hill(y)
        impact ground: inelastic, friction mu
        minimize integral(u^2)
        finally { y == 3 }
        start { z: hill(0) }
        horizon 3
    }
}
