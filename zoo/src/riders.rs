//! Riders on bumps, on two wheels and on skis.

hangtime::model! {
    /// Bike and rider over two bumps of different height, in least time.
    pub TwoBumps {
        parameters { g = 9.81, speed = 4 }
        coordinates { y, s, l in 0.3..=0.6 }
        controls { u in -900..=400 }
        fn track(y) = 0.3*exp(-4*(y - 2)^2) + 0.15*exp(-4*(y - 4)^2)
        let bike = (y, track(y) + s)
        let rider = (y, track(y) + s + l)
        lagrangian 7.5*|dot(bike)|^2 + 37.5*|dot(rider)|^2 - g*(15*bike.z + 75*rider.z)
        forces { l: u + 75*g }
        surface ground: s >= 0
        impact ground: inelastic, along (-diff(track)(y), 1, 0)
        minimize time
        finally { y == 6 }
        start { l: 0.45, dot(y): speed }
        horizon 2
    }
}

hangtime::model! {
    /// A rigid bike on two wheels over waves, with a rider who pushes and pitches.
    pub TwoWheels {
        parameters { g = 9.81, a = 0.5, h = 0.1 }
        coordinates { y, z, pitch in -1..=1 }
        controls { push in -200..=400, lift in -400..=1200, turn in -100..=100 }
        fn track(y) = h*(1 - cos(2*y))
        let rear = (y - a*cos(pitch), z - a*sin(pitch))
        let front = (y + a*cos(pitch), z + a*sin(pitch))
        lagrangian 40*(dot(y)^2 + dot(z)^2) + 5*dot(pitch)^2 - 80*g*z
        forces { y: push, z: lift, pitch: turn }
        surface rear_wheel: rear.z - track(rear.y) >= 0
        surface front_wheel: front.z - track(front.y) >= 0
        impact rear_wheel, front_wheel: inelastic
        minimize time
        finally { y == 5 }
        start { z: 0.3, dot(y): 3 }
        horizon 2
    }
}

hangtime::model! {
    /// A ski jumper on a table pushes off with the legs and is to land as far away as possible within 4 s.
    pub PushOff {
        parameters { g = 9.81 }
        coordinates { y, z, l in 0.3..=1 }
        controls { u in -800..=900 }
        fn slope(y) = -2*tanh((y - 6)/2) - 0.3*y
        lagrangian 5*|dot((y, z))|^2 + 30*|dot((y, z + l))|^2 - g*(10*z + 60*(z + l))
        forces { l: u + 60*g }
        surface snow: z >= slope(y)
        impact snow: inelastic, holding l
        minimize -y + integral(1e-5*u^2)
        start { z: slope(0), l: 0.5, dot(y): 4, dot(z): -1.2 }
        horizon 2.5
    }
}

hangtime::model! {
    /// A sledge with a propeller that can be tilted crosses a hollow in least time and stops.
    pub HollowSledge {
        parameters { g = 9.81, hollow = 1 }
        coordinates { y, z }
        controls { push in -200..=400, lift in 0..=700 }
        fn snow_line(y) = 0 - hollow*exp(-(y - 5)^2)
        lagrangian 50*(dot(y)^2 + dot(z)^2) - 100*g*z
        forces { y: push, z: lift }
        surface snow: z >= snow_line(y)
        impact snow: inelastic
        minimize time
        finally { y == 10, dot(y) == 0 }
        start { z: snow_line(0) }
        horizon 5
    }
}
