"""scipy (DOP853, events located and restarted at by hand) on switched systems of the test `tests/scenes/textbook.rs`, which stores what this prints.

    python textbook.py
"""

from math import copysign, cos, sin

import numpy as np
from scipy.integrate import solve_ivp

TOLERANCE = {"method": "DOP853", "rtol": 1e-13, "atol": 1e-14}


def switched(rates, surface, side, start, horizon):
    """A motion whose rates read the sign of a function, which it passes: its end, and when it passes."""
    time, x, log = 0.0, np.array(start), []
    while True:
        passes = lambda t, x, begun=time, side=side: surface(x) if t > begun + 1e-9 else side
        passes.terminal = True
        run = solve_ivp(lambda t, x: rates(t, x, side), (time, horizon), x, events=passes, **TOLERANCE)
        time, x = run.t[-1], run.y[:, -1]
        if run.status == 0:
            return x, log
        log.append(float(time))
        side = -side


def bouc_wen():
    """x'' + 0.1 x' + x/4 + 3 z/4 = 1.3 cos(0.9 t), z' = v - 0.6 |v| z - 0.4 v |z|."""

    def rates(t, y, side):
        x, v, z = y
        return [v, 1.3 * cos(0.9 * t) - 0.1 * v - x / 4 - 3 * z / 4, v - 0.6 * abs(v) * z - 0.4 * v * abs(z)]

    # Kinks without jumps: steps become short there by themselves.
    return solve_ivp(lambda t, y: rates(t, y, 0), (0, 20), [0.0, 0.3, 0.1], **TOLERANCE).y[:, -1]


def voice_coil():
    """Two masses on a spring, the first one driven by a coil and rubbing (Kirches 2006): a voltage that turns round after 4 ms."""
    m1, m2, k, kf, rub, r, ell = 1.03, 0.56, 2.4e3, 12.0, 2.1, 2.0, 2e-3
    volt = lambda t: 5.0 * cos(400 * t)

    def rates(t, y, side):
        x1, x2, v1, v2, i = y
        pull = k * (x2 - x1)
        return np.array([v1, v2, (kf * i + pull - rub * side) / m1, -pull / m2, (volt(t) - r * i - kf * v1) / ell])

    def held(t, y):
        x1, x2, v1, v2, i = y
        force = kf * i + k * (x2 - x1)
        return rates(t, [x1, x2, 0.0, v2, i], force / rub), rub - abs(force), copysign(1.0, force)

    return stick_first(rates, lambda y: y[2], np.zeros(5), 0.04, held)


def stick_first(rates, surface, start, horizon, held):
    """The same of friction, from rest, where it sticks: `held` gives the rates then, how far the force is from its bound, and its sign."""
    time, x, side, log = 0.0, start, 0, []
    while time < horizon:
        if side == 0:
            leaves = lambda t, x: held(t, x)[1]
            leaves.terminal, leaves.direction = True, -1
            run = solve_ivp(lambda t, x: held(t, x)[0], (time, horizon), x, events=leaves, max_step=1e-4, **TOLERANCE)
        else:
            passes = lambda t, x, begun=time, side=side: surface(x) if t > begun + 1e-7 else side
            passes.terminal = True
            run = solve_ivp(lambda t, x: rates(t, x, side), (time, horizon), x, events=passes, max_step=1e-4, **TOLERANCE)
        time, x = run.t[-1], run.y[:, -1]
        if run.status == 0:
            break
        log.append((float(time), side))
        if side == 0:
            side = held(time, x)[2]
        else:
            x[2] = 0.0
            left = held(time, x)
            side = 0 if left[1] > 0 else left[2]
    return x, log


def race_car():
    """A car on a straight of half width 1, whose grass brakes three times as much (after the second example of nosnoc): it swerves onto it and
    back."""

    def rates(t, y, side):
        px, py, angle, v = y
        brake = 0.1 if side < 0 else 0.3
        return [v * cos(angle), v * sin(angle), 0.5 * cos(t) * v / 3, 2.0 - brake * v**2 / 2]

    return switched(rates, lambda y: abs(y[1]) - 1, -1.0, [0.0, 0.0, 0.0, 2.0], 8.0)


if __name__ == "__main__":
    np.set_printoptions(precision=13)
    for scene in (bouc_wen, voice_coil, race_car):
        print(scene.__name__, scene())
