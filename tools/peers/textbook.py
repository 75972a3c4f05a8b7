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


def bouc_wen_from_rest():
    """x'' + 0.1 x' + x + 2 z = F, z' = v - 0.5 |v| z - 0.3 v |z|, from rest: F = sin(2 t), cos(2 t), and 1 from t = 1 on."""

    def end(push, times):
        y = [0.0, 0.0, 0.0]
        for times in times:
            rates = lambda t, y, after=times[0] > 0: [
                y[1],
                push(t, after) - 0.1 * y[1] - y[0] - 2 * y[2],
                y[1] - 0.5 * abs(y[1]) * y[2] - 0.3 * y[1] * abs(y[2]),
            ]
            y = solve_ivp(rates, times, y, max_step=0.01, **TOLERANCE).y[:, -1]
        return y

    whole = [(0, 10)]
    return (
        end(lambda t, after: sin(2 * t), whole),
        end(lambda t, after: cos(2 * t), whole),
        end(lambda t, after: float(after), [(0, 1), (1, 10)]),
    )


def converter():
    """A buck converter that switches off at 3 A and on at 4.8 V: its end, and the times of its switches."""
    vin, ell, c, r = 12, 1e-3, 1e-4, 3
    time, y, on, log = 0.0, np.zeros(2), 1, []
    while True:
        ends = (lambda t, y: y[0] - 3) if on else (lambda t, y: y[1] - 4.8)
        ends.terminal, ends.direction = True, 1 if on else -1
        rates = lambda t, y, on=on: [(vin * on - y[1]) / ell, (y[0] - y[1] / r) / c]
        run = solve_ivp(rates, (time, 4e-3), y, events=ends, max_step=1e-5, **TOLERANCE)
        time, y = run.t[-1], run.y[:, -1]
        if run.status == 0:
            return y, log
        log.append(float(time))
        on = 1 - on


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


def relay_feedback():
    """The third-order system of `scenes/relay-feedback.hang`: it slides where x = 0 and |y| < 1, by the part y of its relay."""

    def rates(x, side):
        sign = x[1] if side == 0 else side
        return [0.0 if side == 0 else -3.5 * x[0] + x[1] - sign, -627.5 * x[0] + x[2] + 2 * sign, -625 * x[0] - sign]

    time, x, side, log = 0.0, np.array([0.0, -0.001, -0.02]), 0, []
    while True:
        ends = (lambda t, x: abs(x[1]) - 1) if side == 0 else (lambda t, x, begun=time: x[0] if t > begun + 1e-9 else side)
        ends.terminal = True
        run = solve_ivp(lambda t, x, side=side: rates(x, side), (time, 10.0), x, events=ends, max_step=1e-3, **TOLERANCE)
        time, x = run.t[-1], run.y[:, -1]
        if run.status == 0:
            return x, log
        log.append(float(time))
        x[0] = 0.0
        side = int(copysign(1, x[1])) if abs(x[1]) >= 1 - 1e-12 else 0


if __name__ == "__main__":
    np.set_printoptions(precision=13)
    for scene in (bouc_wen, bouc_wen_from_rest, converter, voice_coil, race_car, relay_feedback):
        print(scene.__name__, scene())
