//! Carts and blocks that push each other.

hangtime::model! {
    /// Three carts on a rail; only the middle one is driven, the outer ones move when they are hit.
    pub ThreeCarts {
        parameters { w = 2, weight = 0.05 }
        coordinates { left, middle, right }
        controls { u in -30..=30 }
        lagrangian (dot(left)^2 + dot(middle)^2 + dot(right)^2)/2
        forces { middle: u }
        surface left_buffer: middle - left >= w
        surface right_buffer: right - middle >= w
        impact left_buffer, right_buffer: inelastic
        minimize integral(10*(left + 5)^2 + 10*(right - 5)^2 + weight*u^2) + 100*((left + 5)^2 + (right - 5)^2)
        start { left: -3, middle: 0, right: 3 }
        horizon 4
    }
}

hangtime::model! {
    /// A cart that is to be 1 m away as soon as possible, from rest, with a horizon far from the answer of 2 s.
    pub FastCart {
        coordinates { y }
        controls { u in -1..=1 }
        lagrangian dot(y)^2/2
        forces { y: u }
        minimize time
        finally { y == 1, dot(y) == 0 }
        horizon 100
    }
}

hangtime::model! {
    /// A driven cart pushes another one, which rolls freely, to 3 m, where it has to arrive at 0.5 m/s.
    pub PushAndRoll {
        parameters { w = 1 }
        coordinates { pusher, load }
        controls { u in -5..=5 }
        lagrangian dot(pusher)^2/2 + dot(load)^2
        forces { pusher: u }
        surface buffer: load - pusher >= w
        impact buffer: inelastic
        minimize integral(u^2)
        finally { load == 3, dot(load) == 0.5 }
        start { pusher: -1, load: 1 }
        horizon 5
    }
}

hangtime::model! {
    /// A driven cart sets a second one in motion, which sets a third one in motion, elastically; that has to come to
    /// 4 m while the first one goes back to where it started.
    pub CradleOfCarts {
        parameters { w = 0.5, e = 0.8 }
        coordinates { first, second, third }
        controls { u in -10..=10 }
        lagrangian (dot(first)^2 + dot(second)^2 + dot(third)^2)/2
        forces { first: u }
        surface front: second - first >= w
        surface back: third - second >= w
        impact front, back: restitution e
        minimize integral(u^2)
        finally { third == 4, first == 0 }
        start { second: 1.2, third: 2.5 }
        horizon 3
    }
}

hangtime::model! {
    /// A driven cart between two walls swings its load, which hangs on a rope; the load is to come to rest to the right
    /// of where the cart can go.
    pub CraneBetweenWalls {
        parameters { l = 1, g = 9.81 }
        coordinates { y, theta }
        controls { u in -20..=20 }
        let hook = (y + l*sin(theta), -l*cos(theta))
        lagrangian dot(y)^2 + |dot(hook)|^2/4 - g*hook.z/2
        forces { y: u }
        surface left_wall: y >= -0.5
        surface right_wall: y <= 0.5
        impact left_wall, right_wall: inelastic
        minimize integral(u^2)
        finally { hook.y == 1.2, hook.z >= -0.8 }
        horizon 3
    }
}

hangtime::model! {
    /// A peg is pushed down along a wall by two forces: it has to reach the bottom with little effort.
    pub PegAgainstWall {
        parameters { mu = 0.3, g = 9.81 }
        coordinates { y, z }
        controls { push in -20..=20, press in -20..=20 }
        lagrangian (dot(y)^2 + dot(z)^2)/2 - g*z
        forces { y: push, z: press }
        surface wall: y >= 0
        surface bottom: z >= 0
        impact wall: inelastic, friction mu
        impact bottom: inelastic
        minimize integral(push^2 + press^2)
        finally { y == 0, z == 0, dot(z) == 0 }
        start { y: 0.2, z: 1 }
        horizon 1.5
    }
}
