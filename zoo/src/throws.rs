//! Balls that are thrown, caught and juggled.

hangtime::model! {
    /// A ball that bounces with little loss is thrown over 4 m by a weak force.
    pub WeakThrow {
        parameters { e = 0.9, g = 9.81 }
        coordinates { y, z }
        controls { push in -2..=2, lift in -2..=2 }
        lagrangian (dot(y)^2 + dot(z)^2)/2 - g*z
        forces { y: push, z: lift }
        surface ground: z >= 0
        impact ground: restitution e
        minimize integral(push^2 + lift^2)
        finally { y == 4, z == 1 }
        start { z: 1 }
        horizon 2.5
    }
}

hangtime::model! {
    /// A plate throws a ball to a height of 1.5 m and has to be at rest where it began.
    pub ThrowFromPlate {
        parameters { g = 9.81 }
        coordinates { plate in -0.5..=0.5, ball }
        controls { u in -60..=60 }
        lagrangian dot(plate)^2/2 + dot(ball)^2/4 - g*(plate + ball/2)
        forces { plate: u + g }
        surface contact: ball - plate >= 0
        impact contact: inelastic
        minimize integral(u^2)
        finally { ball == 1.5, plate == 0, dot(plate) == 0 }
        horizon 1.5
    }
}

hangtime::model! {
    /// A hand catches a falling ball and brings it to rest at the height of the waist.
    pub CatchBall {
        parameters { g = 9.81 }
        coordinates { hand in -1..=1, ball }
        controls { u in -80..=80 }
        lagrangian dot(hand)^2 + dot(ball)^2/4 - g*(2*hand + ball/2)
        forces { hand: u + 2*g }
        surface palm: ball - hand >= 0
        impact palm: inelastic
        minimize integral(u^2) + 100*dot(ball)^2
        finally { ball == 0, hand == 0, dot(hand) == 0 }
        start { ball: 2 }
        horizon 1.2
    }
}

hangtime::model! {
    /// A paddle keeps an elastic ball in the air: after 2 s both have to be as at the start.
    pub Juggler {
        parameters { e = 0.7, g = 9.81 }
        coordinates { paddle in -0.5..=0.5, ball }
        controls { u in -50..=50 }
        lagrangian dot(paddle)^2/2 + dot(ball)^2/20 - g*(paddle + ball/10)
        forces { paddle: u + g }
        surface face: ball - paddle >= 0
        impact face: restitution e
        minimize integral(u^2)
        finally { ball == 1, dot(ball) == 0, paddle == 0, dot(paddle) == 0 }
        start { ball: 1 }
        horizon 2
    }
}

hangtime::model! {
    /// A ball is played off a wall behind a net: over the net, against the wall, back to the hand.
    pub WallBall {
        parameters { e = 0.8, g = 9.81 }
        coordinates { y, z }
        controls { push in -15..=15, lift in -15..=15 }
        lagrangian (dot(y)^2 + dot(z)^2)/2 - g*z
        forces { y: push, z: lift }
        surface wall: y <= 2
        surface ground: z >= 0
        impact wall, ground: restitution e
        minimize integral(push^2 + lift^2)
        finally { y == 0, z == 1, dot(y) <= -1.5 }
        start { z: 1 }
        horizon 2
    }
}
