//! Pendulums with weak motors, stops and dry friction.

hangtime::model! {
    /// A pendulum whose motor is too weak to lift it at once: it has to swing up.
    pub WeakPendulum {
        parameters { g = 9.81 }
        coordinates { theta }
        controls { torque in -2.5..=2.5 }
        lagrangian dot(theta)^2/2 + g*cos(theta)
        forces { theta: torque }
        minimize integral(torque^2)
        finally { theta == pi, dot(theta) == 0 }
        horizon 6
    }
}

hangtime::model! {
    /// The weak pendulum with a stop on one side, at which swings end.
    pub PendulumWithStop {
        parameters { g = 9.81 }
        coordinates { theta }
        controls { torque in -4..=4 }
        lagrangian dot(theta)^2/2 + g*cos(theta)
        forces { theta: torque }
        surface stop: theta >= -1
        impact stop: restitution 0.5
        minimize integral(torque^2)
        finally { theta == pi, dot(theta) == 0 }
        horizon 6
    }
}

hangtime::model! {
    /// A pole on a cart between two walls is swung up.
    pub CartPoleWalls {
        parameters { l = 0.6, g = 9.81 }
        coordinates { y, theta }
        controls { u in -20..=20 }
        let bob = (y + l*sin(theta), -l*cos(theta))
        lagrangian dot(y)^2/2 + 0.15*|dot(bob)|^2 - 0.3*g*bob.z
        forces { y: u }
        surface left: y >= -0.5
        surface right: y <= 0.5
        impact left, right: inelastic
        minimize integral(u^2)
        finally { y == 0, theta == pi, dot(y) == 0, dot(theta) == 0 }
        horizon 2.5
    }
}

hangtime::model! {
    /// A pole on a cart that rubs on its rail is swung up.
    pub CartPoleFriction {
        parameters { l = 0.6, g = 9.81, mu = 0.2 }
        coordinates { y, z, theta }
        controls { u in -20..=20 }
        lagrangian (dot(y)^2 + dot(z)^2)/2 + 0.15*(dot(y)^2 + 2*l*cos(theta)*dot(y)*dot(theta) + l^2*dot(theta)^2) + 0.3*g*l*cos(theta) - g*z
        forces { y: u }
        surface rail: z >= 0
        impact rail: inelastic, friction mu, sliding dot(y)
        minimize integral(u^2)
        finally { y == 0, theta == pi, dot(y) == 0, dot(theta) == 0 }
        horizon 2.5
    }
}

hangtime::model! {
    /// Two links with a motor at the elbow, which has stops: the tip is to be lifted above the shoulder.
    pub AcrobotStops {
        parameters { g = 9.81, reach = 1.4 }
        coordinates { shoulder, elbow }
        controls { torque in -20..=20 }
        let knee = (sin(shoulder), -cos(shoulder))
        let tip = (knee.y + sin(shoulder + elbow), knee.z - cos(shoulder + elbow))
        lagrangian |dot(knee)|^2/2 + |dot(tip)|^2/2 - g*(knee.z + tip.z)
        forces { elbow: torque }
        surface low: elbow >= -reach
        surface high: elbow <= reach
        impact low, high: inelastic
        minimize integral(torque^2)
        finally { tip.z == 1 }
        horizon 8
    }
}

hangtime::model! {
    /// A pendulum on a turning arm whose bearing rubs: it is swung up by the motor of the arm.
    pub FurutaFriction {
        parameters { r = 0.3, l = 0.4, g = 9.81, mu = 0.02 }
        coordinates { arm, play, theta }
        controls { torque in -1.5..=1.5 }
        let bob = (r*cos(arm) - l*sin(theta)*sin(arm), r*sin(arm) + l*sin(theta)*cos(arm), -l*cos(theta))
        lagrangian 0.01*dot(arm)^2 + dot(play)^2/2 + 0.05*|dot(bob)|^2 - 0.1*g*bob.z - g*play
        forces { arm: torque }
        surface bearing: play >= 0
        impact bearing: inelastic, friction mu, sliding dot(arm)
        minimize integral(torque^2)
        finally { theta == pi, dot(theta) == 0, dot(arm) == 0 }
        horizon 2.5
    }
}
